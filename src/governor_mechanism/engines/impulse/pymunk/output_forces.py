"""Forces along output variables in pymunk, with the energy that they dissipate."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator

import numpy as np

from governor_mechanism.engines.impulse.pymunk.bodies import BodyProxy
from governor_mechanism.engines.impulse.pymunk.force_elements import VelocityExtrapolator
from governor_mechanism.engines.impulse.pymunk.step_inputs import StepInputs
from governor_mechanism.mechanics.dynamics.contacts import FRICTION_LAW_NAME, contacts_of, output_forces_of
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_jacobian, evaluate_residuals
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

ContactConstraintUpdate = Callable[[FloatArray, FloatArray, FloatArray, StepInputs], None]
"""Update the constraints of one contact before a step.

Arguments: predicted poses (bodies, 3), output values (outputs,), output Jacobian (outputs, bodies, 3) at these poses, step inputs.
"""


class OutputForces:
    """Forces along the output variables of a scene, at the pose that the next step is about to reach.

    `output_values` (outputs,) and `output_jacobian` (outputs, bodies, 3) belong to the last step and to the poses of the body proxies.
    `sliding_directions` is the sign of the motion that the friction of each contact opposes, 0 if it does not slide. `is_taut` states for
    each one-sided spring whether it pulls; an empty list derives it from the length. `dissipated_energy` (J) is the loss in dashpots and
    friction.
    """

    def __init__(self, scene: Scene, proxies: list[BodyProxy], velocity_extrapolator: VelocityExtrapolator) -> None:
        names = forced_output_names(scene)
        self._proxies, self._velocity_extrapolator = proxies, velocity_extrapolator
        origins = {proxy.body.name: proxy.origin for proxy in proxies}
        self._rows = make_output_rows(scene.part.mechanism, names, origins)
        self._zero_drive_values = np.zeros((1, len(names), 3))
        self._forces = [(names.index(effect.reading), effect) for effect in output_forces_of(scene)]
        contacts = contacts_of(scene)
        self._n_frictions = sum(contact.friction is not None for contact in contacts)
        self._contact_outputs = [names.index(contact.output_name) for contact in contacts]
        self.sliding_directions = [0] * len(contacts)
        self.is_taut: list[bool] = []
        self.contact_updates: list[ContactConstraintUpdate] = []
        self.output_values, self.output_jacobian = np.zeros(len(names)), np.zeros((len(names), len(proxies), 3))
        self.dissipated_energy = 0.0
        self._previous_step: tuple[FloatArray, tuple[float, ...]] | None = None

    @property
    def evaluation_counts(self) -> dict[str, int]:
        """Return how often one step evaluates each force law."""
        counts = Counter(effect.law_name for _, effect in self._forces)
        return dict(counts + Counter({FRICTION_LAW_NAME: self._n_frictions}))

    def reset(self) -> None:
        """Forget the previous step: the next one is the half step that starts a motion."""
        self._previous_step = None

    def apply(self, lead: float, inputs: StepInputs) -> None:
        """Add all forces to the body proxies and update the contact constraints, at the pose `lead` seconds ahead."""
        poses = np.array([_predict_pose(proxy, lead) for proxy in self._proxies])
        self.evaluate_outputs(poses)
        self._add_dissipation(inputs)
        forces = np.zeros(len(self.output_values))
        for output, effect, value in self._active_forces():
            rate = self._predicted_rate(output) if effect.dissipates else 0.0
            forces[output] += effect.force(effect.coefficients, value, rate)
        for output, sign, friction in zip(self._contact_outputs, self.sliding_directions, inputs.friction_limits, strict=True):
            forces[output] -= sign * friction
        generalised_forces = (forces @ self.output_jacobian.reshape(len(forces), -1)).reshape(-1, 3) * inputs.kick_scale
        for proxy, (force_x, force_y, torque) in zip(self._proxies, generalised_forces.tolist(), strict=True):
            body = proxy.pymunk_body
            if force_x or force_y:
                previous_force = body.force
                body.force = (previous_force.x + force_x, previous_force.y + force_y)
            if torque:
                body.torque += torque
        for update in self.contact_updates:
            update(poses, self.output_values, self.output_jacobian, inputs)

    def evaluate_outputs(self, poses: FloatArray) -> None:
        """Evaluate the output values and their Jacobian at poses (bodies, 3) of the body proxies."""
        self.output_values = evaluate_residuals(self._rows, poses[np.newaxis], self._zero_drive_values)[0]
        self.output_jacobian = evaluate_jacobian(self._rows, poses[np.newaxis])[0]

    def output_rates(self, velocities: FloatArray) -> FloatArray:
        """Return the rates (outputs,) of all output variables for proxy velocities (bodies, 3)."""
        rates: FloatArray = self.output_jacobian.reshape(len(self.output_jacobian), -1) @ velocities.ravel()
        return rates

    def dissipated_power(self, rates: FloatArray, friction_limits: tuple[float, ...]) -> float:
        """Return the power (W) that dashpots and sliding friction dissipate at output rates (outputs,) and friction limits."""
        power = 0.0
        for output, effect, value in self._active_forces():
            if effect.dissipates:
                power -= effect.force(effect.coefficients, value, float(rates[output])) * float(rates[output])
        for output, sign, friction in zip(self._contact_outputs, self.sliding_directions, friction_limits, strict=True):
            power += sign * friction * float(rates[output])
        return power

    def _active_forces(self) -> Iterator[tuple[int, OutputForce, float]]:
        """Yield output, effect and value of the output of each force that is not slack."""
        taut_flags = iter(self.is_taut)
        for output, effect in self._forces:
            value = float(self.output_values[output])
            if effect.slack_below == -math.inf or next(taut_flags, value > effect.slack_below):
                yield output, effect, value

    def _predicted_rate(self, output: int) -> float:
        """Return the rate of an output variable extrapolated to the end of the coming step."""
        rate = 0.0
        for proxy, (x, y, angle) in zip(self._proxies, self.output_jacobian[output].tolist(), strict=True):
            u, v, w = self._velocity_extrapolator.predicted[proxy.pymunk_body]
            rate += x * u + y * v + angle * w
        return rate

    def _add_dissipation(self, inputs: StepInputs) -> None:
        """Add the energy dissipated in the last step, whose displacement and length are known, by the midpoint rule."""
        if self._previous_step is not None:
            previous_values, previous_limits = self._previous_step
            displacements = self.output_values - previous_values
            for output, effect, value in self._active_forces():
                if effect.dissipates:
                    displacement = float(displacements[output])
                    force = effect.force(effect.coefficients, value - 0.5 * displacement, displacement / inputs.h)
                    self.dissipated_energy -= force * displacement
            for output, sign, previous_limit, limit in zip(
                self._contact_outputs, self.sliding_directions, previous_limits, inputs.friction_limits, strict=True
            ):
                self.dissipated_energy += sign * 0.5 * (previous_limit + limit) * float(displacements[output])
        self._previous_step = self.output_values, inputs.friction_limits


def _predict_pose(proxy: BodyProxy, lead: float) -> tuple[float, float, float]:
    """Return the pose (x, y, angle) of a body proxy `lead` seconds ahead."""
    body = proxy.pymunk_body
    position, velocity = body.position, body.velocity
    x, y = position.x + velocity.x * lead, position.y + velocity.y * lead
    return x, y, body.angle + body.angular_velocity * lead
