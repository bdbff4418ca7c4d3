"""Our joints as pymunk constraints; those that pymunk lacks as pins that are anchored anew before every step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import pymunk

from governor_mechanism.engines.impulse.pymunk.bodies import Marked
from governor_mechanism.engines.impulse.pymunk.step_inputs import Moment
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.kinematics.constraint_equations import curve_pieces
from governor_mechanism.mechanics.kinematics.constraint_kernels import curve_at
from governor_mechanism.model.joints import (
    ArcSlot,
    CurveSlot,
    Distance,
    DrivenSlide,
    DrivenTurn,
    Gear,
    Joint,
    Pin,
    Prismatic,
    Slider,
    Weld,
)

GROOVE_REACH = 1e3
"""Half length of a groove in machine sizes: grooves end, a guide does not."""

Fit = Callable[[Moment], None]
"""Make a constraint ready for the pose that the step is about to reach."""


@dataclass(frozen=True)
class Made:
    """The constraints of one joint, and what has to be done to them before every step."""

    constraints: tuple[pymunk.Constraint, ...]
    fits: tuple[Fit, ...] = ()


def make(joint: Joint, first: Marked, second: Marked, size: float, drive: int) -> Made:
    """The constraints of a joint between two points; `drive` is where its motion stands among those of a Moment."""
    pins = pymunk.PivotJoint(first.body, second.body, (first.x, first.y), (second.x, second.y))
    if isinstance(joint, Distance | ArcSlot):
        link = pymunk.PinJoint(first.body, second.body, (first.x, first.y), (second.x, second.y))
        link.distance = joint.length if isinstance(joint, Distance) else joint.radius
        return Made((link,))
    if isinstance(joint, Pin):
        return Made((pins,))
    if isinstance(joint, Weld):
        return Made((pins, *_turn(first, second, joint.turn)))
    if isinstance(joint, Prismatic):
        line = _line(joint, first, second, size)
        return Made((*line.constraints, *_turn(first, second, joint.turn)), line.fits)
    if isinstance(joint, Slider):
        return _line(joint, first, second, size)
    if isinstance(joint, CurveSlot):
        return _refitted(first, second, joint.angle, size, curve=joint)
    if isinstance(joint, DrivenSlide):
        return _refitted(first, second, joint.angle - math.pi / 2, size, drive=drive)
    if isinstance(joint, Gear):
        return Made((pymunk.GearJoint(second.body, first.body, -joint.offset, joint.ratio),))
    if isinstance(joint, DrivenTurn):
        return _driven_turn(first, second, drive)
    raise UnsupportedEffect(
        f"engine 'impulse' has no joint of type {type(joint).__name__}, as {joint.name!r} is; take engine multibody"
    )


def _turn(first: Marked, second: Marked, turn: float) -> tuple[pymunk.Constraint, ...]:
    """Keeps the second body's angle less the first's; nothing to do between two that do not turn."""
    if first.body.moment == math.inf and second.body.moment == math.inf:
        return ()
    return (pymunk.GearJoint(first.body, second.body, turn, 1.0),)


def _line(joint: Slider, first: Marked, second: Marked, size: float) -> Made:
    """A groove is second order only between bodies that do not turn."""
    if first.body.moment != math.inf or second.body.moment != math.inf:
        return _refitted(first, second, joint.angle, size)
    reach = GROOVE_REACH * size
    dx, dy = reach * math.cos(joint.angle), reach * math.sin(joint.angle)
    ends = (first.x - dx, first.y - dy), (first.x + dx, first.y + dy)
    return Made((pymunk.GrooveJoint(first.body, second.body, *ends, (second.x, second.y)),))


def _driven_turn(first: Marked, second: Marked, drive: int) -> Made:
    gear = pymunk.GearJoint(first.body, second.body, 0.0, 1.0)

    def fit(moment: Moment) -> None:
        turn = second.place(moment.h)[4] - first.place(moment.h)[4]
        gear.phase = turn - (turn - moment.motions[drive]) * moment.h / moment.following

    return Made((gear,), (fit,))


def _refitted(
    first: Marked,
    second: Marked,
    angle: float,
    size: float,
    *,
    curve: CurveSlot | None = None,
    drive: int | None = None,
) -> Made:
    """Holds the second point's way across a line (or curve) of the first body, or drives it, by a pin across the line.

    The pin starts on the first body where the second point will be, moved across by `size` and by what is open: its
    force then goes through the second point, whatever its length.
    """
    pin = pymunk.PinJoint(first.body, second.body, (first.x, first.y), (second.x, second.y))
    pin.distance = size
    pieces = curve_pieces(curve.curve) if curve else None

    def fit(moment: Moment) -> None:
        x1, y1, arm_x, arm_y, turned = first.place(moment.h)
        x2, y2, _, _, _ = second.place(moment.h)
        ux, uy = math.cos(angle + turned), math.sin(angle + turned)
        nx, ny = -uy, ux
        opening = nx * (x2 - x1) + ny * (y2 - y1)
        if pieces is not None:
            height, slope, _ = curve_at(pieces, 0, len(pieces), ux * (x2 - x1) + uy * (y2 - y1))
            steep = math.hypot(1.0, slope)
            opening, nx, ny = (opening - height) / steep, (nx - slope * ux) / steep, (ny - slope * uy) / steep
        if drive is not None:
            opening = (opening - moment.motions[drive]) * moment.h / moment.following
        reach = size + opening
        dx, dy = x2 - reach * nx - (x1 - arm_x), y2 - reach * ny - (y1 - arm_y)
        c, s = math.cos(turned), math.sin(turned)
        if first.body.body_type == pymunk.Body.STATIC:
            pin.anchor_a = (x2 - reach * nx, y2 - reach * ny)
        else:
            pin.anchor_a = (c * dx + s * dy, c * dy - s * dx)

    return Made((pin,), (fit,))
