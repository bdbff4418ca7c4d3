"""Joints as pymunk constraints; joints that pymunk lacks become pins that are re-anchored before every step."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import pymunk

from governor_mechanism.engines.impulse.pymunk.applied_forces import StepInputs
from governor_mechanism.engines.impulse.pymunk.bodies import AttachedPoint, Poses, to_body_axes
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.curves.curve_kernels import evaluate_curve, evaluate_polar_curve
from governor_mechanism.mechanics.curves.segments import make_curve_segments
from governor_mechanism.model.curves import Curve, PolarCurve
from governor_mechanism.model.joints import Joint, base
from governor_mechanism.types import NO_INDEX, FloatArray

GROOVE_HALF_LENGTH_RATIO = 1e3
"""Half length of a groove relative to the length scale of the mechanism.

A pymunk groove has ends, a guide has none: the groove moves along before the point comes near to them.
"""

PreStepUpdate = Callable[[Poses, StepInputs], None]
"""Update a constraint for the poses that the step is about to reach."""


@dataclass(frozen=True)
class JointConstraints:
    """pymunk constraints of one joint, and their updates before every step."""

    constraints: tuple[pymunk.Constraint, ...]
    updates: tuple[PreStepUpdate, ...] = ()


def make_joint_constraints(joint: Joint, first: AttachedPoint, second: AttachedPoint, length_scale: float, drive: int) -> JointConstraints:
    """Return the pymunk constraints of a joint between two points; `drive` is the index of the input of a driver.

    Raises UnsupportedEffect for a joint that pymunk cannot represent.
    """
    parts = joint.impulse_parts()
    if not parts:
        raise UnsupportedEffect(f"engine 'impulse' has no joint of type {type(joint).__name__} ({joint.name!r}); use engine 'multibody'")
    made = [_make_part(part, first, second, length_scale, drive) for part in parts]
    constraints, updates = (tuple(chain.from_iterable(getattr(one, name) for one in made)) for name in ("constraints", "updates"))
    return JointConstraints(constraints, updates)


def _make_part(part: base.ImpulsePart, first: AttachedPoint, second: AttachedPoint, length_scale: float, drive: int) -> JointConstraints:
    """Return the pymunk constraints of one part of a joint."""
    match part:
        case base.Pivot():
            return JointConstraints((_make_pivot(first, second),))
        case base.FixedDistance():
            return JointConstraints((_make_pin(first, second, part.distance),))
        case base.FixedAngle():
            return JointConstraints(_make_rotation_lock(first, second, part.angle))
        case base.AngleRatio():
            return JointConstraints((pymunk.GearJoint(second.body, first.body, -part.offset, part.ratio),))
        case base.Guide(curve=None):
            return _make_slider(part.angle, first, second, length_scale)
        case base.Guide():
            return _make_reanchored_pin(first, second, part.angle, length_scale, curve=part.curve)
        case base.DrivenOffset():
            return _make_reanchored_pin(first, second, part.angle, length_scale, drive=drive)
        case base.DrivenAngle():
            return _make_driven_turn(first, second, drive)
    raise TypeError(f"no pymunk constraint is defined for {type(part).__name__}")


def _make_pivot(first: AttachedPoint, second: AttachedPoint) -> pymunk.Constraint:
    return pymunk.PivotJoint(first.body, second.body, (first.x, first.y), (second.x, second.y))


def _make_pin(first: AttachedPoint, second: AttachedPoint, length: float) -> pymunk.PinJoint:
    """Return the constraint that keeps the distance (m) of two points."""
    pin = pymunk.PinJoint(first.body, second.body, (first.x, first.y), (second.x, second.y))
    pin.distance = length
    return pin


def _make_rotation_lock(first: AttachedPoint, second: AttachedPoint, angle: float) -> tuple[pymunk.Constraint, ...]:
    """Return the constraint that keeps the relative angle (rad) of two bodies; none for two bodies that cannot rotate."""
    if first.body.moment == math.inf and second.body.moment == math.inf:
        return ()
    return (pymunk.GearJoint(first.body, second.body, angle, 1.0),)


def _make_slider(angle: float, first: AttachedPoint, second: AttachedPoint, length_scale: float) -> JointConstraints:
    """Return the constraint of a slider: a groove only between bodies that cannot rotate, where it is of second order."""
    if first.body.moment != math.inf or second.body.moment != math.inf:
        return _make_reanchored_pin(first, second, angle, length_scale)
    half_length = GROOVE_HALF_LENGTH_RATIO * length_scale
    ux, uy = math.cos(angle), math.sin(angle)

    def locate_end(travel: float) -> tuple[float, float]:
        return first.x + travel * ux, first.y + travel * uy

    ends = locate_end(-half_length), locate_end(half_length)
    groove = pymunk.GrooveJoint(first.body, second.body, *ends, (second.x, second.y))

    def update(poses: Poses, inputs: StepInputs) -> None:
        """Move the groove along where the point is in its outer half."""
        x1, y1, _ = first.locate(poses)
        x2, y2, _ = second.locate(poses)
        travel = ux * (x2 - x1) + uy * (y2 - y1)
        centre = ux * (groove.groove_a[0] - first.x) + uy * (groove.groove_a[1] - first.y) + half_length
        if abs(travel - centre) > half_length / 2:
            groove.groove_a, groove.groove_b = locate_end(travel - half_length), locate_end(travel + half_length)

    return JointConstraints((groove,), (update,))


def _make_driven_turn(first: AttachedPoint, second: AttachedPoint, drive: int) -> JointConstraints:
    """Return a gear joint whose phase follows a prescribed relative angle."""
    gear = pymunk.GearJoint(first.body, second.body, 0.0, 1.0)

    def update(poses: Poses, inputs: StepInputs) -> None:
        angle = second.locate(poses)[2] - first.locate(poses)[2]
        gear.phase = angle - (angle - inputs.values[drive]) * inputs.h / inputs.next_h

    return JointConstraints((gear,), (update,))


def _make_reanchored_pin(
    first: AttachedPoint, second: AttachedPoint, angle: float, length_scale: float, curve: Curve | None = None, drive: int = NO_INDEX
) -> JointConstraints:
    """Return a pin across a line or curve of the first body that guides the second point, or drives it across the line.

    The pin starts on the first body at the predicted second point, offset across the line by `length_scale` plus the residual. Its force
    then acts through the second point, whatever its length.
    """
    pin = _make_pin(first, second, length_scale)
    segments = make_curve_segments(curve) if curve else None
    offset_from_curve = _offset_from_polar_curve if isinstance(curve, PolarCurve) else _offset_from_curve

    def update(poses: Poses, inputs: StepInputs) -> None:
        """Re-anchor the pin at the predicted pose."""
        x1, y1, body_angle = first.locate(poses)
        x2, y2, _ = second.locate(poses)
        if segments is None:
            nx, ny = -math.sin(angle + body_angle), math.cos(angle + body_angle)
            residual = nx * (x2 - x1) + ny * (y2 - y1)
        else:
            residual, nx, ny = offset_from_curve(segments, angle + body_angle, x2 - x1, y2 - y1)
        if drive != NO_INDEX:
            residual = (residual - inputs.values[drive]) * inputs.h / inputs.next_h
        length = length_scale + residual
        pin.anchor_a = to_body_axes(poses, first.index, (x2 - length * nx, y2 - length * ny))

    return JointConstraints((pin,), (update,))


def _offset_from_curve(segments: FloatArray, angle: float, dx: float, dy: float) -> tuple[float, float, float]:
    """Return the distance (m) of a point from a curve in axes at an angle (rad), and the normal of the curve there."""
    ux, uy = math.cos(angle), math.sin(angle)
    height, derivative, _ = evaluate_curve(segments, 0, len(segments), ux * dx + uy * dy)
    normal_length = math.hypot(1.0, derivative)
    offset = (ux * dy - uy * dx - height) / normal_length
    return offset, (-uy - derivative * ux) / normal_length, (ux - derivative * uy) / normal_length


def _offset_from_polar_curve(segments: FloatArray, angle: float, dx: float, dy: float) -> tuple[float, float, float]:
    """Return the distance (m) of a point from a closed curve about the origin in axes at an angle (rad), and its normal there."""
    distance = math.hypot(dx, dy)
    radius, derivative, _ = evaluate_polar_curve(segments, 0, len(segments), math.atan2(dy, dx) - angle)
    ux, uy, slope = dx / distance, dy / distance, derivative / distance
    normal_length = math.hypot(1.0, slope)
    return (distance - radius) / normal_length, (ux + slope * uy) / normal_length, (uy - slope * ux) / normal_length
