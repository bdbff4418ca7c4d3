"""A scene's mechanism as a pymunk space: start it, step it, read its state."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pymunk

from governor_mechanism.engines.impulse.pymunk.bodies import AttachedPoint, make_body_proxy
from governor_mechanism.engines.impulse.pymunk.force_elements import (
    ForceCallback,
    VelocityExtrapolator,
    make_body_force,
    make_element_force,
)
from governor_mechanism.engines.impulse.pymunk.friction_stop_constraint import FrictionStopConstraint
from governor_mechanism.engines.impulse.pymunk.joints import make_joint_constraints
from governor_mechanism.engines.impulse.pymunk.output_forces import OutputForces
from governor_mechanism.engines.impulse.pymunk.step_inputs import StepInputs
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.dynamics.force_laws import spindle_inertia
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper
from governor_mechanism.model.joints import GROUND, Joint, Pin, Point, RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


class PymunkModel:
    """A scene's mechanism in a pymunk space.

    `plain` keeps pymunk's own joint correction, force evaluation and start.
    """

    def __init__(self, scene: Scene, *, iterations: int, plain: bool = False) -> None:
        self.is_plain = plain
        self._mechanism: Mechanism = scene.part.mechanism
        self._space = pymunk.Space()
        self._iterations = self._space.iterations = iterations
        self._proxies = [make_body_proxy(self._mechanism, body) for body in self._mechanism.bodies]
        self._space.add(*(proxy.pymunk_body for proxy in self._proxies))
        drives = [joint for joint in self._mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
        joint_constraints = [
            make_joint_constraints(
                joint, *self._joint_points(joint), self._mechanism.length_scale, drives.index(joint) if joint in drives else -1
            )
            for joint in self._mechanism.joints
            if not self._is_replaced_by_pin(joint)
        ]
        for constraint in [constraint for constraints in joint_constraints for constraint in constraints.constraints]:
            self._add_constraint(constraint)
        self._pre_step_updates = [update for constraints in joint_constraints for update in constraints.updates]
        has_damping = any(isinstance(element, Damper | TorsionDamper) for element in self._mechanism.force_elements)
        has_damping = has_damping or any(effect.dissipates for effect in output_forces_of(scene))
        self._velocity_extrapolator = VelocityExtrapolator([proxy.pymunk_body for proxy in self._proxies] if has_damping else [])
        self._has_damping = has_damping
        body_forces = [make_body_force(scene, proxy) for proxy in self._proxies]
        self._force_callbacks = [force_callback for force_callback, _ in body_forces] + self._make_element_forces()
        self.evaluation_counts = Counter(law for _, laws in body_forces for law in laws)
        """Number of evaluations of each force law per step."""
        self.evaluation_counts.update(
            {"springs, dampers, forces": len(self._mechanism.force_elements)} if self._mechanism.force_elements else {}
        )
        self.output_forces = OutputForces(scene, self._proxies, self._velocity_extrapolator)
        self.pinned_mask = np.array([[proxy.is_pinned, proxy.is_pinned, False] for proxy in self._proxies])
        """(bodies, 3) coordinates that are fixed because a body is reduced to its pin on the ground."""
        if scene.output_effects:
            self._force_callbacks.append(self.output_forces.apply)
            self.evaluation_counts.update(self.output_forces.evaluation_counts)

    def start(self, poses: FloatArray, velocities: FloatArray, inputs: StepInputs) -> None:
        """Set poses (bodies, 3) and velocities half a step ahead of them; a plain model takes the velocities as they are.

        `inputs` are those of the start time, as if a half step had just ended: `inputs.h` is half of the following step.
        """
        self.output_forces.reset()
        lag = 0.0 if self.is_plain else inputs.h
        for proxy, pose, velocity in zip(self._proxies, poses, velocities, strict=True):
            proxy.set_state(pose, velocity, lag)
        if not self.is_plain:
            self._step(inputs, 0.0)

    def make_contact_constraint(self, contact: int, output: int, effect: str, reading: str) -> FrictionStopConstraint:
        """Return the constraints that can hold joint contact; `contact` and `output` are its indices among contacts and outputs.

        Raises UnsupportedEffect if no pymunk joint can hold the output variable. The poses must be those of a start.
        """
        constraint = FrictionStopConstraint(
            self._space, [proxy.pymunk_body for proxy in self._proxies], output, contact, self._mechanism.length_scale
        )
        constraint.check_line_of_action(self.poses(), self.output_forces.output_jacobian[output], effect, reading)
        self.output_forces.contact_updates.append(constraint.update)
        return constraint

    def step(self, inputs: StepInputs) -> None:
        """Take joint pymunk step with all forces applied."""
        self._step(inputs, 0.5 * inputs.h)

    def _step(self, inputs: StepInputs, half_step: float) -> None:
        """Apply the forces, `half_step` seconds after the last velocities, and step the space."""
        lead = 0.0 if self.is_plain else inputs.h
        if self._has_damping:
            self._velocity_extrapolator.predict(0.0 if self.is_plain else half_step)
            self._velocity_extrapolator.set_interval(half_step + 0.5 * inputs.next_h)
        for update in self._pre_step_updates:
            update(inputs)
        for force_callback in self._force_callbacks:
            force_callback(lead, inputs)
        self._space.step(inputs.h)

    def set_iteration_factor(self, factor: int) -> None:
        """Multiply the number of solver iterations by `factor` from now on."""
        self._space.iterations = factor * self._iterations

    def zero_velocities(self) -> None:
        """Set all velocities to zero."""
        for proxy in self._proxies:
            proxy.pymunk_body.velocity = (0.0, 0.0)
            proxy.pymunk_body.angular_velocity = 0.0

    def kinetic_energy(self) -> float:
        """Return the kinetic energy in the plane (J), half a step ahead of the poses."""
        return 0.5 * sum(proxy.pymunk_body.kinetic_energy for proxy in self._proxies)

    def poses(self) -> FloatArray:
        """Return the poses (bodies, 3) of the pymunk bodies; see `to_mass_centres`."""
        return np.array([(*proxy.pymunk_body.position, proxy.pymunk_body.angle) for proxy in self._proxies])

    def velocities(self) -> FloatArray:
        """Return the velocities (bodies, 3) of the pymunk bodies, half a step ahead of their poses."""
        return np.array([(*proxy.pymunk_body.velocity, proxy.pymunk_body.angular_velocity) for proxy in self._proxies])

    def to_proxy_velocities(self, velocities: FloatArray) -> FloatArray:
        """Convert velocities (bodies, 3) of the mass centres to those of the pymunk bodies; a pin on the ground does not move."""
        return np.where(self.pinned_mask, 0.0, velocities)

    def to_mass_centres(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Convert poses and velocities (..., bodies, 3) of the pymunk bodies to those of the mass centres."""
        poses, velocities = poses.copy(), velocities.copy()
        for index, proxy in enumerate(self._proxies):
            if proxy.is_pinned:
                angle, rate = poses[..., index, 2], velocities[..., index, 2]
                x, y = -proxy.origin[0], -proxy.origin[1]
                arm_x, arm_y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
                poses[..., index, 0] += arm_x
                poses[..., index, 1] += arm_y
                velocities[..., index, 0] = -arm_y * rate
                velocities[..., index, 1] = arm_x * rate
        return poses, velocities

    def predict_spindle_inertia(self, lead: float) -> float:
        """Return the moment of inertia about the spindle (kg m2) at the pose predicted `lead` seconds ahead."""
        poses, velocities = self.poses(), self.velocities()
        poses, _ = self.to_mass_centres(poses + lead * velocities, velocities)
        return float(
            sum(
                spindle_inertia(proxy.body.mass, *proxy.body.second_moments.in_plane, proxy.body.second_moments.zz, pose[0], pose[2])
                for proxy, pose in zip(self._proxies, poses, strict=True)
            )
        )

    def _add_constraint(self, constraint: pymunk.Constraint) -> None:
        constraint.collide_bodies = False
        if not self.is_plain:
            constraint.error_bias = 0.0
            constraint.max_bias = math.inf
        self._space.add(constraint)

    def _is_replaced_by_pin(self, joint: Joint) -> bool:
        """Return whether a pin needs no joint: a body reduced to its ground pin rotates about a pymunk body that cannot translate."""
        joined = {joint.first.body, joint.second.body}
        return isinstance(joint, Pin) and any(proxy.is_pinned and joined == {GROUND, proxy.body.name} for proxy in self._proxies)

    def _joint_points(self, joint: Joint) -> tuple[AttachedPoint, AttachedPoint]:
        return self._attach_point(joint.first), self._attach_point(joint.second)

    def _attach_point(self, point: Point) -> AttachedPoint:
        if point.body == GROUND:
            return AttachedPoint(self._space.static_body, point.x, point.y)
        proxy = self._proxies[self._mechanism.body_index(point.body)]
        return AttachedPoint(proxy.pymunk_body, *proxy.anchor(point))

    def _make_element_forces(self) -> list[ForceCallback]:
        n_assigned, force_callbacks = 0, list[ForceCallback]()
        for element in self._mechanism.force_elements:
            count = 2 if isinstance(element, Force) else 1 if isinstance(element, Torque) else 0
            program_indices = tuple(range(n_assigned, n_assigned + count))
            n_assigned += count
            force_callbacks.append(make_element_force(element, self._element_points(element), self._velocity_extrapolator, program_indices))
        return force_callbacks

    def _element_points(self, element: ForceElement) -> tuple[AttachedPoint, AttachedPoint]:
        if isinstance(element, Force):
            return self._attach_point(Point(body=GROUND)), self._attach_point(element.point)
        if isinstance(element, Spring | Damper):
            return self._attach_point(element.first), self._attach_point(element.second)
        first, second = element.bodies
        return self._attach_point(Point(body=first)), self._attach_point(Point(body=second))
