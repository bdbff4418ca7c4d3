"""Equilibrium of a mechanism by kinetic damping of a simulation; uses no equilibrium equation."""

from __future__ import annotations

import numpy as np

from governor_mechanism.engines.impulse.pymunk import PymunkModel
from governor_mechanism.engines.impulse.run import relax
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.errors import RunFailed
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

RELAXATION_SOLVER_ITERATIONS = 60
"""Number of iterations of the joint solver."""
RELAXATION_STEP_RATIO = 0.05
"""Step relative to the time scale. The step causes no error at rest, so it only has to be stable."""

MAX_REST_SPEED_RATIO = 1e-12
"""Largest speed of the whole mass that counts as rest, in length scales per time scale."""

MAX_RELAXATION_STEPS = 400_000
"""Largest number of steps."""


def relax_to_equilibrium(scene: Scene, start: float) -> float:
    """Return the equilibrium that a mechanism reaches from rest with its kinetic energy removed at each maximum.

    The spindle keeps its start speed. Friction and stops do not act.

    Parameters
    ----------
    scene
        Scene of one part.
    start
        Leading coordinate at which the mechanism is released, SI.

    Returns
    -------
    float
        Leading coordinate at rest, SI.

    Raises
    ------
    RunFailed
        If the mechanism leaves its range or does not come to rest.
    """
    mechanism, scale = scene.part.mechanism, time_scale(scene)
    name = mechanism.coordinate
    mass = sum(body.mass for body in mechanism.bodies)

    def is_within_limits(poses: FloatArray) -> bool:
        return all(limit.low < float(evaluate_output_value(mechanism, limit.reading, poses)) < limit.high for limit in mechanism.limits)

    result = relax(
        PymunkModel(scene, iterations=RELAXATION_SOLVER_ITERATIONS),
        RELAXATION_STEP_RATIO * scale,
        TimeInputs(scene),
        PositionSolver(mechanism).solve_at_coordinate(start),
        max_rest_energy=0.5 * mass * (MAX_REST_SPEED_RATIO * mechanism.length_scale / scale) ** 2,
        is_within_limits=is_within_limits,
        max_steps=MAX_RELAXATION_STEPS,
    )
    value = float(evaluate_output_value(mechanism, name, result.poses))
    if not (result.at_rest and np.isfinite(value)):
        raise RunFailed(f"released at {name} = {start:.6g}, the mechanism did not come to rest; its last value is {value:.6g}")
    return value
