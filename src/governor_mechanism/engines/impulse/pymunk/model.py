"""A scene's mechanism as a pymunk space: start it, step it, read its state."""

import math
from collections.abc import Callable

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from governor_mechanism.engines.impulse.pymunk.applied_forces import AppliedForces, AttachedPoint, StepInputs, make_body_proxy
from governor_mechanism.engines.impulse.pymunk.constraints import FrictionStopConstraint, PreStepUpdate, make_joint_constraints
from governor_mechanism.mechanics.dynamics.arrays import to_mass_centres
from governor_mechanism.mechanics.dynamics.contacts import Contact, output_forces_of
from governor_mechanism.model.force_elements import Damper, TorsionDamper
from governor_mechanism.model.joints import GROUND, Joint, Pin, Point, RotationalDriver, TranslationalDriver
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray

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
        self.is_plain, self._iterations, self._present_iterations, self._count_step = plain, iterations, iterations, count_step
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
        poses, velocities = self.state()
        force_velocities = velocities
        next_poses = poses + inputs.h * velocities
        joint_poses = [*next_poses.tolist(), GROUND_POSE] if self._joint_updates or self._contact_constraints else []
        for update in self._joint_updates:
            update(joint_poses, inputs)
        if self._extrapolates_velocities:  # from the last two half steps to the kick that ends the step
            previous, self._previous_velocities = self._previous_velocities, velocities
            force_velocities = velocities + half_step / self._velocity_interval * (velocities - previous)
            self._velocity_interval = half_step + 0.5 * inputs.next_h
        forces = self.forces.evaluate(poses if self.is_plain else next_poses, force_velocities, inputs)
        np.multiply(forces, inputs.kick_scale, out=self._force_values)
        set_space_bodies(self._space, BODY_FORCE, self._force_buffer)
        for constraint in self._contact_constraints:
            constraint.update(joint_poses, self.forces.output_values, self.forces.output_jacobian, inputs)
        self._count_step(self._present_iterations)
        self._space.step(inputs.h)
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
        self._state_buffer.clear()
        get_space_bodies(self._space, BODY_STATE, self._state_buffer)
        return self._state_values[:, 0].copy(), self._state_values[:, 1].copy()

    def _set_state(self, poses: FloatArray, velocities: FloatArray) -> None:
        """Set poses and velocities (bodies, 3) of the pymunk bodies."""
        self._start_values[:, 0], self._start_values[:, 1] = poses, velocities
        set_space_bodies(self._space, BODY_STATE, self._start_buffer)

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
