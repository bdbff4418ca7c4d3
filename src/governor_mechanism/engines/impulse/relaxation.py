"""Equilibrium of a mechanism by kinetic damping of a simulation; uses no equilibrium equation."""

from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.engines.impulse.pymunk.model import PymunkModel
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.errors import RunFailed
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.forces.contact_modes import initial_mode
from governor_mechanism.mechanics.dynamics.forces.contacts import one_sided_forces_of
from governor_mechanism.mechanics.dynamics.system.lowering import make_system
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

N_JOINT_RECOVERY_STEPS = 3
"""Number of steps after a stop in which the joints recover from it; the kinetic energy there is not that of the oscillation."""


@dataclass(frozen=True, kw_only=True)
class RelaxationSettings:
    """Settings of a relaxation to equilibrium.

    `iterations` is the number of iterations of the joint solver. `step_ratio` is the step in time scales: it causes no error at rest, so
    it only has to be stable. `max_rest_speed_ratio` is the largest speed of the whole mass that counts as rest, in length scales per time
    scale. `max_steps` is the largest number of steps.
    """

    iterations: int = 60
    step_ratio: float = 0.05
    max_rest_speed_ratio: float = 1e-12
    max_steps: int = 400_000


def relax_to_equilibrium(
    scene: Scene,
    start: float,  # leading coordinate at which the mechanism is released, SI
    # step, solver iterations and what counts as rest; None takes the defaults
    settings: RelaxationSettings | None = None,
) -> float:
    """Return the equilibrium that a mechanism reaches from rest with its kinetic energy removed at each maximum.

    From one maximum to the next it swings from rest toward the equilibrium, which reduces the distance about a hundredfold. The spindle
    keeps its start speed. Friction and stops do not act.

    Raises RunFailed if the mechanism leaves its range or does not come to rest.
    """
    settings = settings or RelaxationSettings()
    mechanism, scale = scene.part.mechanism, time_scale(scene)
    mass = sum(body.mass for body in mechanism.bodies)
    max_rest_energy = 0.5 * mass * (settings.max_rest_speed_ratio * mechanism.length_scale / scale) ** 2
    model, time_inputs, h = PymunkModel(scene, iterations=settings.iterations), TimeInputs(scene), settings.step_ratio * scale
    one_sided, mode = one_sided_forces_of(scene), initial_mode(scene)

    def present_poses() -> FloatArray:
        return model.to_mass_centres(*model.state())[0]

    def present_value(reading: str) -> float:
        return float(evaluate_output_value(mechanism, reading, present_poses()))

    def follow_springs(poses: FloatArray) -> None:
        """Let the one-sided springs act that are taut at the poses."""
        nonlocal mode
        taut = tuple(float(evaluate_output_value(mechanism, spring.reading, poses)) > spring.slack_below for spring in one_sided)
        if taut != mode.taut:
            mode = replace(mode, taut=taut)
            model.forces.output_forces = make_system(scene, mode)[0].output_forces

    poses = PositionSolver(mechanism).solve_at_coordinate(start)
    follow_springs(poses)
    model.start(poses, np.zeros_like(poses), time_inputs.start_inputs(h))
    inputs, max_energy, steps_since_stop = time_inputs.constant_inputs(h), 0.0, 0
    for _ in range(settings.max_steps):
        energy = model.kinetic_energy()
        if steps_since_stop > N_JOINT_RECOVERY_STEPS and energy < max_energy:  # just past the maximum, which is at the equilibrium
            value = present_value(mechanism.coordinate)
            if max_energy < max_rest_energy and np.isfinite(value):
                return value
            model.zero_velocities()
            max_energy, steps_since_stop = 0.0, 0
            if not all(limit.low < present_value(limit.reading) < limit.high for limit in mechanism.limits):
                break
        if steps_since_stop >= N_JOINT_RECOVERY_STEPS:
            max_energy = max(max_energy, energy)
        steps_since_stop += 1
        if one_sided:
            follow_springs(present_poses())
        model.step(inputs)
    raise RunFailed(
        f"released at {mechanism.coordinate} = {start:.6g}, the mechanism did not come to rest; "
        f"its last value is {present_value(mechanism.coordinate):.6g}"
    )
