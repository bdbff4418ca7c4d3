"""Joints as pymunk constraints, re-anchored pins where pymunk lacks one, and constraints that hold an output: stiction and stops."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import pymunk

from governor_mechanism.engines.impulse.pymunk.applied_forces import AttachedPoint, Poses, StepInputs, to_body_axes
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.curves.segments import evaluate_curve, evaluate_polar_curve, make_curve_segments
from governor_mechanism.mechanics.dynamics.contacts import Contact
from governor_mechanism.model.curves import Curve, PolarCurve
from governor_mechanism.model.joints import Joint, base
from governor_mechanism.types import NO_INDEX, FloatArray

# A pymunk groove has ends, a guide has none: the groove moves along before the point comes near to them.
GROOVE_HALF_LENGTH_RATIO = 1e3
"""Half length of a groove relative to the length scale of the mechanism."""

PreStepUpdate = Callable[[Poses, StepInputs], None]
"""Update a constraint for the poses that the step is about to reach."""


@dataclass(frozen=True)
class JointConstraints:
    """pymunk constraints of one joint, and their updates before every step."""

    constraints: tuple[pymunk.Constraint, ...]
    updates: tuple[PreStepUpdate, ...] = ()


def make_joint_constraints(joint: Joint, first: AttachedPoint, second: AttachedPoint, length_scale: float, drive: int) -> JointConstraints:
    """Return the pymunk constraints of a joint, with the input of a driver; raise UnsupportedEffect where pymunk has none."""
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
    """Return a pin across a line or curve of the first body that guides the second point, or drives it across the line."""
    # The pin starts on the first body at the predicted second point, offset across the line by
    # `length_scale` plus the residual. Its force then acts through the second point, whatever its
    # length.
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


LINE_OF_ACTION_TOLERANCE = 1e-9
"""Largest force or moment imbalance, relative to the force, of a pair of forces with one line of action."""

STOP_ENGAGEMENT_RATIO = 1e-3
"""Amount by which a stop constraint is set past its limit, relative to its length (rad for a rotation): rounding cannot disengage it."""

MIN_BIAS_SPEED = 1e-30
"""Smallest correction speed (m/s, rad/s); pymunk treats a limit without any correction speed as not reached."""


class FrictionStopConstraint:
    """Constraints that can hold one contact: one bears friction, the other only pushes away from a stop.

    Both act along the gradient of the output variable and are updated before every step for the predicted pose. `held_value` (m or rad) is
    the value at which friction holds the contact, None if it does not. `stop_side` is 1 at the high stop, -1 at the low stop, 0 at neither.
    The last of `bodies` is the ground. `is_force_limited` states whether friction bears no more than its limit, which is an input.
    """

    def __init__(self, space: pymunk.Space, bodies: list[pymunk.Body], output: int, friction_input: int, length_scale: float) -> None:
        self._space, self._bodies, self._output, self._length_scale = space, bodies, output, length_scale
        self.friction_input = friction_input
        self._constraints: tuple[pymunk.Constraint, pymunk.Constraint] | None = None
        self._active: list[pymunk.Constraint] = []
        self.held_value: float | None = None
        self.stop_value, self.stop_side, self.is_force_limited = 0.0, 0, True
        self._step, self._kick_duration, self._gradient_norm = 1.0, 1.0, 1.0

    def check_line_of_action(self, poses: FloatArray, gradient: FloatArray, contact: Contact) -> None:
        """Raise UnsupportedEffect if the forces of an output variable have no single line of action, as every pymunk joint needs."""
        bodies = _moving_bodies(gradient.tolist())
        if len(bodies) == 2:
            (fx, fy, fm), (gx, gy, gm) = gradient[bodies[0]], gradient[bodies[1]]
            dx, dy = poses[bodies[1], 0] - poses[bodies[0], 0], poses[bodies[1], 1] - poses[bodies[0], 1]
            imbalance = max(abs(fx + gx), abs(fy + gy), abs(fm + gm + dx * gy - dy * gx) / self._length_scale)
            if imbalance < LINE_OF_ACTION_TOLERANCE * max(math.hypot(fx, fy), abs(fm) / self._length_scale):
                return
        elif len(bodies) == 1:
            return
        effect = "dry friction" if contact.friction else "stops"
        raise UnsupportedEffect(
            f"engine 'impulse' cannot model {effect} on {contact.output_name!r}: the holding force does not act along one line between "
            "two bodies; use engine 'multibody', or a reading between two bodies or from fixed points"
        )

    def update(self, poses: Poses, values: FloatArray, output_jacobian: FloatArray, inputs: StepInputs) -> None:
        """Update the constraints for the predicted poses, and outputs there, and remove those that are not needed."""
        self._step, self._kick_duration = inputs.h, inputs.h * inputs.kick_scale
        if not self.is_needed:
            self._activate([])
            self._constraints = None  # new constraints start without accumulated impulses
            return
        gradient, value = output_jacobian[self._output].tolist(), float(values[self._output])
        if not math.isfinite(value):
            raise ValueError("a body has no finite position")  # pymunk would abort the process
        first, second = [-1, *_moving_bodies(gradient)][-2:]
        x, y, rotation = gradient[second]
        translation_norm = math.hypot(x, y)
        is_rotational = translation_norm * self._length_scale < LINE_OF_ACTION_TOLERANCE * abs(rotation)
        self._gradient_norm = abs(rotation) if is_rotational else translation_norm
        if self._constraints is None:
            self._constraints = self._make_constraints(first, second, is_rotational)
        friction, stop = self._constraints
        active = [friction] * (self.held_value is not None) + [stop] * (self.stop_side != 0)
        step_ratio = inputs.h / inputs.next_h
        residual = 0.0 if self.held_value is None else (value - self.held_value) * step_ratio
        penetration = max(self.stop_side * (value - self.stop_value), 0.0) * step_ratio if self.stop_side else 0.0
        if is_rotational:
            # A motor keeps the relative angular velocity (second body minus first) at minus its rate.
            friction.rate = residual * rotation / self._gradient_norm / self._gradient_norm / inputs.h
            relative_angle, is_upper = poses[second][2] - poses[first][2], self.stop_side * rotation > 0.0
            stop.min = -math.inf if is_upper else relative_angle + STOP_ENGAGEMENT_RATIO
            stop.max = relative_angle - STOP_ENGAGEMENT_RATIO if is_upper else math.inf
        else:
            normal, arm = (x / translation_norm, y / translation_norm), rotation / translation_norm
            contact_point = poses[second][0] + arm * normal[1], poses[second][1] - arm * normal[0]
            friction_length, stop_length = self._length_scale + residual / translation_norm, self.stop_side * self._length_scale
            contact_anchor = to_body_axes(poses, second, contact_point)
            for joint, length in ((friction, friction_length), (stop, stop_length)):
                if joint in active:
                    # The joint begins that far behind the contact point, along the normal.
                    start_point = contact_point[0] - length * normal[0], contact_point[1] - length * normal[1]
                    joint.anchor_a, joint.anchor_b = to_body_axes(poses, first, start_point), contact_anchor
        if self.stop_side:
            stop.max_bias = max(penetration / self._gradient_norm / inputs.h, MIN_BIAS_SPEED)
        limit = float(inputs.values[self.friction_input]) if self.is_force_limited and self.held_value is not None else math.inf
        friction.max_force = limit * self._gradient_norm * inputs.kick_scale
        self._activate(active)

    @property
    def is_needed(self) -> bool:
        """Return whether friction or a stop holds the contact."""
        return self.held_value is not None or self.stop_side != 0

    @property
    def friction_force(self) -> float:
        """Return the force (N, or N m) along the output variable with which friction held it in the last step."""
        return 0.0 if self.held_value is None else self._force(0)

    @property
    def stop_force(self) -> float:
        """Return the force (N, or N m) along the output variable with which the stop pushed in the last step."""
        return self._force(1) if self.stop_side else 0.0

    @property
    def is_saturated(self) -> bool:
        """Return whether the friction force reached its limit in the last step."""
        if self._constraints is None or self.held_value is None or not self.is_force_limited:
            return False
        joint = self._constraints[0]
        return bool(joint.impulse >= joint.max_force * self._step * (1 - 1e-12))

    def _force(self, index: int) -> float:
        """Return the force (N, or N m) along the output variable that a constraint exerted in the last step."""
        return self._constraints[index].impulse / self._kick_duration / self._gradient_norm if self._constraints else 0.0

    def _make_constraints(self, first: int, second: int, is_rotational: bool) -> tuple[pymunk.Constraint, pymunk.Constraint]:
        first_body, second_body = self._bodies[first], self._bodies[second]
        if is_rotational:
            friction: pymunk.Constraint = pymunk.SimpleMotor(first_body, second_body, 0.0)
            stop: pymunk.Constraint = pymunk.RotaryLimitJoint(first_body, second_body, 0.0, 0.0)
        else:
            friction = pymunk.PinJoint(first_body, second_body)
            friction.distance = self._length_scale
            stop = pymunk.SlideJoint(first_body, second_body, (0, 0), (0, 0), 0.0, self._length_scale * (1 - STOP_ENGAGEMENT_RATIO))
        for joint in (friction, stop):
            joint.collide_bodies, joint.error_bias = False, 0.0
        friction.max_bias = math.inf
        return friction, stop

    def _activate(self, wanted: list[pymunk.Constraint]) -> None:
        """Keep exactly the wanted constraints in the space; a constraint that enters has no accumulated impulse."""
        self._space.remove(*(joint for joint in self._active if joint not in wanted))
        self._space.add(*(joint for joint in wanted if joint not in self._active))
        self._active = wanted


def _moving_bodies(gradient: Poses) -> list[int]:
    """Return the indices of the bodies on which a gradient (bodies, 3) depends."""
    return [index for index, row in enumerate(gradient) if any(row)]
