"""Generic drawing of what guides a point: straight guides, slots, blocks in them, and the feet of ground pins."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from governor_mechanism.model.curves import Curve, Polynomial, Table
from governor_mechanism.model.force_elements import Damper, Spring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    DrivenSlide,
    Joint,
    Pin,
    Prismatic,
    Slider,
    Weld,
)
from governor_mechanism.model.scene import TURNING, Part
from governor_mechanism.render.geometry.body_points import axes_at, distinct, put, where
from governor_mechanism.render.geometry.outlines import band, wall
from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Polygon, Pose, Shape, hatching
from governor_mechanism.render.machines.generic.gears import rack_bodies
from governor_mechanism.render.run_extents import Stage
from governor_mechanism.types import FloatArray

SLOT, RIM = 0.046, 0.100
"""Widths of a slot and of the strip it is cut into."""
BLOCK, MASS = (0.15, 0.08), (0.16, 0.22)
"""Sides, along the guide and across, of a sliding block and of a mass that springs hold in its guide."""
BEYOND = 0.12
"""What a guide is longer than the way at each end. All as fractions of the stage's unit."""
PIECES = 48
"""A slot is drawn in."""


def slot_chain(joint: Joint, stage: Stage) -> list[Pair]:
    """The middle line of what guides the joint's second point (m, in the axes of the joint's first point)."""
    low, high = stage.ways[joint.name]
    more = BEYOND * stage.unit
    match joint:
        case ArcSlot(radius=radius):
            more = min(0.6 * more / radius, 0.2)
            angles = np.linspace(low - more, max(high + more, low + more), PIECES + 1)
            return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
        case CurveSlot(curve=curve):
            first, last = low - 0.6 * more, high + 0.6 * more
            if isinstance(curve, Table):
                # It ends at its first and last point, and is shown whole unless the run uses little of it.
                spare = 0.5 * (high - low) + more
                first, last = max(low - spare, min(curve.x[0], low)), min(high + spare, max(curve.x[-1], high))
            xs = np.linspace(first, last, PIECES + 1)
            return list(zip(xs.tolist(), _heights(curve, xs).tolist(), strict=True))
        case _:
            return [(low - more, 0.0), (high + more, 0.0)]


def _heights(curve: Curve, xs: FloatArray) -> FloatArray:
    match curve:
        case Polynomial(coefficients=coefficients):
            return np.asarray(np.polynomial.polynomial.polyval(xs, coefficients), dtype=np.float64)
        case Table(x=x, y=y):
            return np.asarray(CubicSpline(x, y)(xs))
    raise NotImplementedError(f"a curve of kind {type(curve).__name__} has no drawing")


def guide_axes(part: Part, poses: Sequence[Pose], joint: Joint) -> Pose:
    """The axes of a guide: origin in the joint's first point, x along the guide where it is straight."""
    angle = joint.angle if isinstance(joint, Slider | CurveSlot | DrivenSlide) else 0.0
    return axes_at(part.mechanism, poses, joint.first, angle)


def guides(part: Part, poses: Sequence[Pose], stage: Stage, *, fixed: bool) -> list[Shape]:
    """What guides points, on the ground (`fixed`) or on bodies; a body's own plate is drawn elsewhere."""
    shapes: list[Shape] = []
    for joint in part.mechanism.joints:
        if joint.name not in stage.ways or (joint.first.body == GROUND) != fixed:
            continue
        axes = guide_axes(part, poses, joint)
        match joint:
            case Slider() if not (fixed and joint.second.body in rack_bodies(part)):
                shapes += _straight(part, stage, joint, axes, fixed=fixed)
            case ArcSlot() | CurveSlot():
                shapes += _slot(joint, stage, axes, fixed=fixed)
            case DrivenSlide() if fixed and not _led(part, joint):
                shapes.append(Lines("guide", (tuple(put(axes, *spot) for spot in slot_chain(joint, stage)),)))
    return shapes


def block_sides(part: Part, joint: Slider) -> Pair:
    """How large the block of a slider is: that of a mass on springs has room for them beside each other."""
    body = joint.second.body
    alone = all(body not in (other.first.body, other.second.body) or other is joint for other in part.mechanism.joints)
    held = any(isinstance(load, Spring | Damper) and body in load.bodies for load in part.mechanism.loads)
    return MASS if alone and held and body != GROUND else BLOCK


def _straight(part: Part, stage: Stage, joint: Slider, axes: Pose, *, fixed: bool) -> list[Shape]:
    u = stage.unit
    (low, _), (high, _) = slot_chain(joint, stage)
    half = 0.5 * block_sides(part, joint)[1] * u
    if not fixed:
        return [_box("slot", axes, ((low + high) / 2, 0.0), (high - low, 2 * half))]
    start, end = put(axes, low, 0.0), put(axes, high, 0.0)
    if part.plane == TURNING and max(abs(start[0]), abs(end[0])) < 1e-6 * u:
        return [Lines("guide", ((start, end),))]
    rails: list[Shape] = []
    for side in (1, -1):
        middle = put(axes, (low + high) / 2, side * half)
        rails.append(wall(middle, axes[2] - side * math.pi / 2, (high - low) / 2, 0.035 * u))
    return rails


def _led(part: Part, drive: DrivenSlide) -> bool:
    """Whether the drive's body runs in a guide, so that its way needs no line of its own."""
    bodies = {drive.first.body, drive.second.body}
    return any(
        isinstance(joint, Slider) and {joint.first.body, joint.second.body} == bodies for joint in part.mechanism.joints
    )


def _slot(joint: ArcSlot | CurveSlot, stage: Stage, axes: Pose, *, fixed: bool) -> list[Shape]:
    u = stage.unit
    low, high = stage.ways[joint.name]
    rim = "frame plate" if fixed else "plate"
    if isinstance(joint, ArcSlot) and high - low > 2 * math.pi - 0.4:
        edges = (("", RIM), ("slot", SLOT), (rim, -SLOT))
        return [Circle(role or rim, axes[0], axes[1], joint.radius + w * u / 2) for role, w in edges]
    chain = [put(axes, *spot) for spot in slot_chain(joint, stage)]
    return [*([band(rim, chain, RIM * u)] if fixed else []), band("slot", chain, SLOT * u)]


def blocks(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """The blocks that slide in straight guides; a rack slides by itself."""
    u = stage.unit
    shapes: list[Shape] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, Slider) and joint.second.body not in rack_bodies(part):
            axes = guide_axes(part, poses, joint)
            spot = where(part.mechanism, poses, joint.second)
            along, across = block_sides(part, joint)
            shapes.append(_box("block", (*spot, axes[2]), (0.0, 0.0), (along * u, across * u)))
    return shapes


def pins(part: Part, poses: Sequence[Pose]) -> list[Pair]:
    """Where a pin is seen: at pins, ends of links, and what runs in a slot or turns on a sliding block.

    A bead, which does not turn and is held in one point, needs none.
    """
    spots: list[Pair] = []
    beads = bead_bodies(part)
    turning = {body.name for body in part.mechanism.bodies if body.turns}
    for joint in part.mechanism.joints:
        second = where(part.mechanism, poses, joint.second)
        match joint:
            case Distance():
                ends = (joint.first, joint.second)
                spots += [where(part.mechanism, poses, end) for end in ends if end.body not in beads]
            case Pin():
                spots.append(second)
            case ArcSlot() | CurveSlot() if joint.second.body not in beads:
                spots.append(second)
            case Slider() if not isinstance(joint, Prismatic) and ({joint.first.body, joint.second.body} & turning):
                spots.append(second)
    return spots


def bead_bodies(part: Part) -> set[str]:
    """Bodies that do not turn and are held in their mass centre alone, in slots or by links."""
    held: dict[str, set[bool]] = {}
    for joint in part.mechanism.joints:
        for point in (joint.first, joint.second):
            bare = isinstance(joint, Distance | ArcSlot | CurveSlot) and not (point.x or point.y)
            held.setdefault(point.body, set()).add(bare)
    return {body.name for body in part.mechanism.bodies if not body.turns and held.get(body.name) == {True}}


def feet(part: Part, stage: Stage) -> list[Shape]:
    """A hatched foot under every pin, link, block or weld on the ground; above it where the mechanism hangs."""
    u = stage.unit
    spots = [
        (mine.x, mine.y)
        for joint in part.mechanism.joints
        for mine in (joint.first, joint.second)
        if mine.body == GROUND and (isinstance(joint, Pin | Distance | Weld) or _guided(joint, mine is joint.second))
    ]
    return [shape for spot in distinct(spots, 0.01 * u) for shape in _foot(spot, u, above=spot[1] > stage.middle)]


def _guided(joint: Joint, second: bool) -> bool:
    return second and isinstance(joint, Slider | ArcSlot | CurveSlot)


def _foot(spot: Pair, u: float, *, above: bool) -> tuple[Shape, ...]:
    x, y = spot
    w, h, ground = 0.06 * u, 0.09 * u, 0.04 * u
    base = y + h if above else y - h
    box = (x - 1.5 * w, x + 1.5 * w, *((base, base + ground) if above else (base - ground, base)))
    line = Lines("wall", (((box[0], base), (box[1], base)),))
    return Polygon("frame", ((x, y), (x - w, base), (x + w, base))), hatching("hatching", box, 0.034 * u), line


def _box(role: str, axes: Pose, middle: Pair, sides: Pair) -> Polygon:
    a, b = sides[0] / 2, sides[1] / 2
    corners = ((a, b), (-a, b), (-a, -b), (a, -b))
    return Polygon(role, tuple(put(axes, middle[0] + f, middle[1] + g) for f, g in corners))
