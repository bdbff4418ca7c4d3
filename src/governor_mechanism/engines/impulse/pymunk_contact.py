"""pymunk constraints that hold a contact: friction that sticks, and a stop that only pushes."""

import math

import pymunk

from governor_mechanism.engines.impulse.applied_forces import Poses, StepInputs, to_body_axes
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.dynamics.contacts import Contact
from governor_mechanism.types import FloatArray

LINE_OF_ACTION_TOLERANCE = 1e-9
"""Largest force or moment imbalance, relative to the force, of a pair of forces with one line of action."""

STOP_ENGAGEMENT_RATIO = 1e-3
"""Amount by which a stop constraint is set past its limit, relative to its length (rad for a rotation): rounding cannot disengage it."""

MIN_BIAS_SPEED = 1e-30
"""Smallest correction speed (m/s, rad/s); pymunk treats a limit without any correction speed as not reached."""

ALLOW_APPROACH = math.inf
"""Error bias with which the correction speed of a pymunk limit is one toward the limit, which it allows, instead of away from it."""


class FrictionStopConstraint:
    """Constraints that can hold one contact: one bears friction, the other only pushes away from a stop.

    Both act along the gradient of the output variable and are updated before every step for the predicted pose. `held_value` (m or rad) is
    the value at which friction holds the contact, None if it does not. `stop_side` is 1 at the high stop, -1 at the low stop, 0 at neither.
    The last of `bodies` is the ground. `is_force_limited` states whether friction bears no more than its limit, which is an input.
    `closing_rate` (m/s) is the rate toward the stop that it allows in a step in which a gap would open, else 0.
    """

    def __init__(self, space: pymunk.Space, bodies: list[pymunk.Body], output: int, friction_input: int, length_scale: float) -> None:
        self._space, self._bodies = space, bodies
        self._output = output
        self._length_scale = length_scale
        self.friction_input = friction_input
        self._constraints: tuple[pymunk.Constraint, pymunk.Constraint] | None = None
        self._active: list[pymunk.Constraint] = []
        self.held_value: float | None = None
        self.stop_value = 0.0
        self.stop_side = 0
        self.is_force_limited = True
        self._step, self._kick_duration = 1.0, 1.0
        self._gradient_norm = 1.0
        self.closing_rate = 0.0

    def check_line_of_action(self, poses: FloatArray, gradient: FloatArray, contact: Contact) -> None:
        """Raise UnsupportedEffect if the forces of an output variable have no single line of action, as every pymunk joint needs."""
        bodies = _moving_bodies(gradient.tolist())
        if len(bodies) == 2:
            (fx, fy, fm), (gx, gy, gm) = gradient[bodies[0]], gradient[bodies[1]]
            dx = poses[bodies[1], 0] - poses[bodies[0], 0]
            dy = poses[bodies[1], 1] - poses[bodies[0], 1]
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

    def update(self, poses: Poses, values: FloatArray, gammas: FloatArray, output_jacobian: FloatArray, inputs: StepInputs) -> None:
        """Update the constraints for the predicted poses, and outputs there, and remove those that are not needed."""
        self._step, self._kick_duration = inputs.h, inputs.h * inputs.kick_scale
        if not self.is_needed:
            self._activate([])
            self._constraints = None  # new constraints start without accumulated impulses
            return
        gradient = output_jacobian[self._output].tolist()
        value = float(values[self._output])
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
        # At a constant velocity the output bends by half of c'' h h in the next step, so that a roller would leave its curve.
        bend = -0.5 * inputs.next_h**2 * float(gammas[self._output])
        penetration = self.stop_side * (value + bend - self.stop_value) * step_ratio
        if is_rotational:
            # A motor keeps the relative angular velocity (second body minus first) at minus its rate.
            friction.rate = residual * rotation / self._gradient_norm / self._gradient_norm / inputs.h
            relative_angle, is_upper = poses[second][2] - poses[first][2], self.stop_side * rotation > 0.0
            stop.min = -math.inf if is_upper else relative_angle + STOP_ENGAGEMENT_RATIO
            stop.max = relative_angle - STOP_ENGAGEMENT_RATIO if is_upper else math.inf
        else:
            normal, arm = (x / translation_norm, y / translation_norm), rotation / translation_norm
            contact_point = poses[second][0] + arm * normal[1], poses[second][1] - arm * normal[0]
            friction_length = self._length_scale + residual / translation_norm
            stop_length = self.stop_side * self._length_scale
            contact_anchor = to_body_axes(poses, second, contact_point)
            for joint, length in ((friction, friction_length), (stop, stop_length)):
                if joint in active:
                    # The joint begins that far behind the contact point, along the normal.
                    start_point = contact_point[0] - length * normal[0], contact_point[1] - length * normal[1]
                    joint.anchor_a, joint.anchor_b = to_body_axes(poses, first, start_point), contact_anchor
        if self.stop_side:
            # An angle is linear in the poses, and opens no gap.
            closes_gap = penetration < 0.0 and not is_rotational
            self.closing_rate = -penetration / inputs.h if closes_gap else 0.0
            stop.max_bias = max(self.closing_rate, penetration / inputs.h, MIN_BIAS_SPEED) / self._gradient_norm
            stop.error_bias = ALLOW_APPROACH if closes_gap else 0.0
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
