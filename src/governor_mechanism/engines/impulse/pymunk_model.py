"""A scene's mechanism as a pymunk space: its joints as constraints, how it starts, steps and reads its state.

A Chipmunk step moves positions with the old velocities, then applies the forces, then solves the joints. Velocities therefore live at
half steps. If each step removes the joint errors completely and takes the loads at the pose that the step is about to reach, this is a
second-order SHAKE/Verlet scheme. With pymunk's defaults it is first order.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from governor_mechanism.engines.impulse.applied_forces import AppliedForces, AttachedPoint, Poses, StepInputs, make_body_proxy, to_body_axes
from governor_mechanism.engines.impulse.pymunk_contact import FrictionStopConstraint
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.mechanics.curves.segments import evaluate_curve, evaluate_polar_curve, make_curve_segments
from governor_mechanism.mechanics.dynamics.arrays import to_mass_centres
from governor_mechanism.mechanics.dynamics.contacts import Contact, output_forces_of
from governor_mechanism.model.curves import Curve, PolarCurve
from governor_mechanism.model.force_elements import Damper, TorsionDamper
from governor_mechanism.model.joints import GROUND, Joint, Pin, Point, RotationalDriver, TranslationalDriver, base
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray

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

    centre = 0.0  # to read the ends of the groove takes longer than to step it

    def update(poses: Poses, inputs: StepInputs) -> None:
        """Move the groove along where the point is in its outer half."""
        nonlocal centre
        x1, y1, _ = first.locate(poses)
        x2, y2, _ = second.locate(poses)
        travel = ux * (x2 - x1) + uy * (y2 - y1)
        if abs(travel - centre) > half_length / 2:
            centre = travel
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
    fixed_point = (first.x, first.y, 0.0) if first.index == GROUND_INDEX else None

    def update(poses: Poses, inputs: StepInputs) -> None:
        """Re-anchor the pin at the predicted pose."""
        x1, y1, body_angle = fixed_point or first.locate(poses)
        x2, y2, _ = second.locate(poses)
        if segments is None:
            nx, ny = -math.sin(angle + body_angle), math.cos(angle + body_angle)
            residual = nx * (x2 - x1) + ny * (y2 - y1)
        else:
            residual, nx, ny = offset_from_curve(segments, angle + body_angle, x2 - x1, y2 - y1)
        if drive != NO_INDEX:
            residual = (residual - inputs.values[drive]) * inputs.h / inputs.next_h
        length = length_scale + residual
        start = x2 - length * nx, y2 - length * ny
        pin.anchor_a = start if fixed_point else to_body_axes(poses, first.index, start)

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
    ux, uy = dx / distance, dy / distance
    slope = derivative / distance
    normal_length = math.hypot(1.0, slope)
    return (distance - radius) / normal_length, (ux + slope * uy) / normal_length, (uy - slope * ux) / normal_length


BODY_STATE = BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
"""Pose and velocity of a body."""

GROUND_POSE = (0.0, 0.0, 0.0)
"""Pose of the ground."""

BODY_FORCE = BodyFields.FORCE | BodyFields.TORQUE
"""Force and torque on a body."""


class PymunkModel:
    """A scene's mechanism in a pymunk space.

    `plain` keeps pymunk's own joint correction, force evaluation and start. `count_step` takes the solver iterations of every step.
    """

    def __init__(
        self, scene: Scene, *, iterations: int, plain: bool = False, count_step: Callable[[int], None] = lambda iterations: None
    ) -> None:
        self.is_plain = plain
        self._iterations = iterations
        self._present_iterations = iterations
        self._count_step = count_step
        self._mechanism = scene.part.mechanism
        self._space = pymunk.Space()
        self._space.iterations = iterations
        self._proxies = [make_body_proxy(self._mechanism, body) for body in self._mechanism.bodies]
        self._bodies = [proxy.body for proxy in self._proxies]
        self._ground = pymunk.Body(body_type=pymunk.Body.STATIC)
        self._space.add(*self._bodies)
        self._state_buffer, self._start_buffer, self._force_buffer = Buffer(), Buffer(), Buffer()
        self._start_values, self._force_values = np.zeros((len(self._bodies), 2, 3)), np.zeros((len(self._bodies), 3))
        self._start_buffer.set_float_buf(self._start_values)
        self._force_buffer.set_float_buf(self._force_values)
        get_space_bodies(self._space, BODY_STATE, self._state_buffer)
        self._state_values = np.frombuffer(self._state_buffer.float_buf()).reshape(-1, 2, 3)
        """View of the memory of the buffer, which `state` fills again; shape (bodies, 2, 3)."""
        self._centres = self.state()[0]
        self.pinned_mask = np.array([[proxy.is_pinned, proxy.is_pinned, False] for proxy in self._proxies])
        """(bodies, 3) coordinates that are fixed because a body is reduced to its pin on the ground."""
        elements, effects = self._mechanism.force_elements, output_forces_of(scene)
        has_damping = any(isinstance(one, Damper | TorsionDamper) for one in elements) or any(one.dissipates for one in effects)
        self._extrapolates_velocities = has_damping and not plain
        self._previous_velocities, self._velocity_interval = np.zeros(self.pinned_mask.shape), math.inf
        origins = {body.name: proxy.origin for body, proxy in zip(self._mechanism.bodies, self._proxies, strict=True)}
        self.forces = AppliedForces(scene, origins)
        self._contact_constraints: list[FrictionStopConstraint] = []
        self._joint_updates = self._add_joints()

    def start(self, poses: FloatArray, velocities: FloatArray, inputs: StepInputs) -> None:
        """Set poses (bodies, 3) and velocities half a step ahead of them; a plain model takes the velocities as they are."""
        # `inputs` are those of the start time, as if a half step had just ended: `inputs.h` is half
        # of the following step.
        self.forces.reset()
        velocities = self.to_proxy_velocities(velocities)
        earlier_poses = poses if self.is_plain else poses - inputs.h * velocities
        self._set_state(np.where(self.pinned_mask, self._centres, earlier_poses), velocities)
        if self.is_plain:
            self.forces.evaluate_outputs(poses)
        else:
            self._step(inputs, 0.0)

    def make_contact_constraint(self, contact: Contact, output: int, friction_input: int) -> FrictionStopConstraint:
        """Return what can hold a contact on an output at the poses of a start; raise UnsupportedEffect if no pymunk joint can."""
        bodies, length_scale = [*self._bodies, self._ground], self._mechanism.length_scale
        constraint = FrictionStopConstraint(self._space, bodies, output, friction_input, length_scale)
        constraint.check_line_of_action(self.state()[0], self.forces.output_jacobian[output], contact)
        self._contact_constraints.append(constraint)
        return constraint

    def step(self, inputs: StepInputs) -> FloatArray:
        """Take one pymunk step with all forces applied; return the velocities (bodies, 3) before it."""
        return self._step(inputs, 0.5 * inputs.h)

    def _step(self, inputs: StepInputs, half_step: float) -> FloatArray:
        """Apply the forces, `half_step` seconds after the last velocities, and step the space."""
        force_velocities = velocities = self._state_values[:, 1].copy()
        if self._extrapolates_velocities:  # from the last two half steps to the kick that ends the step
            previous, self._previous_velocities = self._previous_velocities, velocities
            force_velocities = velocities + half_step / self._velocity_interval * (velocities - previous)
            self._velocity_interval = half_step + 0.5 * inputs.next_h
        lead = 0.0 if self.is_plain else inputs.h
        self.forces.evaluate_kick(self._state_values, lead, force_velocities, inputs, self._force_values)
        set_space_bodies(self._space, BODY_FORCE, self._force_buffer)
        joint_poses = self._predict_poses(inputs.h) if self._joint_updates or self._contact_constraints else []
        for update in self._joint_updates:
            update(joint_poses, inputs)
        for constraint in self._contact_constraints:
            constraint.update(joint_poses, self.forces.output_values, self.forces.output_gammas, self.forces.output_jacobian, inputs)
        self._count_step(self._present_iterations)
        self._space.step(inputs.h)
        self._read_state()
        return velocities

    def set_iteration_factor(self, factor: int) -> None:
        """Multiply the number of solver iterations by `factor` from now on."""
        self._space.iterations = self._present_iterations = factor * self._iterations

    def zero_velocities(self) -> None:
        """Set all velocities to zero."""
        self._set_state(self.state()[0], np.zeros(self.pinned_mask.shape))

    def kinetic_energy(self) -> float:
        """Return the kinetic energy in the plane (J), half a step ahead of the poses."""
        return 0.5 * sum(body.kinetic_energy for body in self._bodies)

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return poses (bodies, 3) of the pymunk bodies and velocities half a step ahead of them; see `to_mass_centres`."""
        return self._state_values[:, 0].copy(), self._state_values[:, 1].copy()

    def _read_state(self) -> None:
        """Read poses and velocities of the pymunk bodies, which have changed, into the buffer."""
        self._state_buffer.clear()
        get_space_bodies(self._space, BODY_STATE, self._state_buffer)

    def _predict_poses(self, lead: float) -> Poses:
        """Return the poses to which those in the buffer move in `lead` seconds, and that of the ground."""
        # Only in a plain model do forces not act there.
        poses = self._state_values[:, 0] + lead * self._state_values[:, 1] if self.is_plain else self.forces.kick_poses
        return [*poses.tolist(), GROUND_POSE]

    def _set_state(self, poses: FloatArray, velocities: FloatArray) -> None:
        """Set poses and velocities (bodies, 3) of the pymunk bodies."""
        self._start_values[:, 0], self._start_values[:, 1] = poses, velocities
        set_space_bodies(self._space, BODY_STATE, self._start_buffer)
        self._read_state()

    def to_proxy_velocities(self, velocities: FloatArray) -> FloatArray:
        """Convert velocities (bodies, 3) of the mass centres to those of the pymunk bodies; a pin on the ground does not move."""
        return np.where(self.pinned_mask, 0.0, velocities)

    def to_mass_centres(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Convert poses and velocities (bodies, 3) of the pymunk bodies to those of the mass centres."""
        return to_mass_centres(self.forces.system, poses, velocities)

    def predict_spindle_inertia(self, lead: float) -> float:
        """Return the moment of inertia about the spindle (kg m2) at the pose predicted `lead` seconds ahead."""
        poses, velocities = self.state()
        return self.forces.spindle_inertia(poses + lead * velocities)

    def _add_joints(self) -> list[PreStepUpdate]:
        """Add the constraints of all joints; return their updates before every step."""
        drives = [joint for joint in self._mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
        updates = list[PreStepUpdate]()
        for joint in self._mechanism.joints:
            if self._is_replaced_by_pin(joint):
                continue
            drive = self.forces.input_layout.drives.start + drives.index(joint) if joint in drives else NO_INDEX
            points = self._attach_point(joint.first), self._attach_point(joint.second)
            joint_constraints = make_joint_constraints(joint, *points, self._mechanism.length_scale, drive)
            updates += joint_constraints.updates
            for constraint in joint_constraints.constraints:
                constraint.collide_bodies = False
                if not self.is_plain:
                    constraint.error_bias, constraint.max_bias = 0.0, math.inf
                self._space.add(constraint)
        return updates

    def _is_replaced_by_pin(self, joint: Joint) -> bool:
        """Return whether a pin needs no joint: a body reduced to its ground pin rotates about a pymunk body that cannot translate."""
        others = {joint.first.body, joint.second.body} - {GROUND}
        return isinstance(joint, Pin) and len(others) == 1 and self._proxies[self._mechanism.body_index(*others)].is_pinned

    def _attach_point(self, point: Point) -> AttachedPoint:
        """Return a point of the mechanism as one of the pymunk bodies."""
        if point.body == GROUND:
            return AttachedPoint(self._ground, GROUND_INDEX, point.x, point.y)
        index = self._mechanism.body_index(point.body)
        x, y = self._proxies[index].origin
        return AttachedPoint(self._bodies[index], index, point.x - x, point.y - y)
