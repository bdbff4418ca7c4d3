"""Settling: how soon a governor comes to its new rest after a change of load, against the strength of its dashpot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.scene import FreeSpindle, Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.studies.regression import SLEEVE_READING, run_uncertified
from governor_mechanism.types import FloatArray

SETTLING_TOLERANCE = 0.02
"""Of the way between two rests: nearer than that to the new one it has settled."""


@dataclass(frozen=True, kw_only=True)
class SettlingStudy:
    """How long it takes to settle after a change of load, against the strength of the dashpot on the sleeve.

    brakes (n,) N s/m; times (n,) s, from when the load changes until the arms leave, for the last time, a band of
    `within` (part of their whole change) about the new rest; infinite where they do not settle in the run. best: the
    brake with the shortest time, and that time.
    """

    title: str
    damping_coefficients: FloatArray
    settling_times: FloatArray
    tolerance: float
    best: tuple[float, float]


def study_settling(
    scene: Scene, damping_coefficients: Sequence[float] | FloatArray, tolerance: float = SETTLING_TOLERANCE
) -> SettlingStudy:
    """Run a scene of a free spindle whose torque changes with dashpots of these strengths (n,) N s/m on the sleeve.

    The new rest is the one that belongs to the angular momentum at the end. Time counts from the first jump of the
    torque. Raises MechanismError for a scene without such a spindle, and where no brake settles it in its run.
    """
    spindle = scene.spindle
    if not isinstance(spindle, FreeSpindle) or spindle.torque.is_constant:
        raise MechanismError("settling is that of a free spindle whose torque changes; give spindle.torque in time")
    times, values = spindle.torque.times, spindle.torque.values
    load_change_time = times[next(k for k, (before, value) in enumerate(pairwise(values)) if value != before)]
    other_effects = tuple(effect for effect in scene.effects if not isinstance(effect, Dashpot))

    def settling_time_of(damping_coefficient: float) -> float:
        dashpot = Dashpot(reading=SLEEVE_READING, linear=damping_coefficient)
        return _compute_settling_time(run_uncertified(replace(scene, effects=(*other_effects, dashpot))), tolerance) - load_change_time

    requested_coefficients = np.asarray(damping_coefficients, dtype=np.float64)
    settling_times = np.array([settling_time_of(brake) for brake in requested_coefficients.tolist()])
    if not np.any(np.isfinite(settling_times)):
        raise MechanismError(f"no brake settles it within {scene.run.duration:g} s; run it longer")
    k = int(np.argmin(settling_times))
    bounds = (requested_coefficients[max(k - 1, 0)], requested_coefficients[min(k + 1, len(requested_coefficients) - 1)])
    refined = minimize_scalar(
        lambda brake: min(settling_time_of(brake), 1e3 * scene.run.duration),
        bounds=bounds,
        method="bounded",
        options={"xatol": 1e-3 * requested_coefficients[k]},
    )
    best = min((float(settling_times[k]), float(requested_coefficients[k])), (float(refined.fun), float(refined.x)))
    return SettlingStudy(
        title=scene.title,
        damping_coefficients=requested_coefficients,
        settling_times=settling_times,
        tolerance=tolerance,
        best=(best[1], best[0]),
    )


def _compute_settling_time(run: Trajectory, tolerance: float) -> float:
    """When (s) the coordinate comes for good to within a part of its whole change of its new rest, or infinity."""
    scene = run.scene
    name = scene.part.mechanism.coordinate
    values = run.readings[name]
    equilibrium = _find_equilibrium_of_momentum(run)
    band_width = tolerance * abs(equilibrium - float(values[0]))
    deviation = values - equilibrium
    curve = CubicHermiteSpline(run.times, deviation, run.rates[name])
    band_crossings = np.concatenate([curve.solve(side * band_width, extrapolate=False) for side in (-1.0, 1.0)])
    is_late = run.times > 0.8 * run.times[-1]
    if band_crossings.size == 0 or np.max(np.abs(deviation[is_late])) > band_width:
        return math.inf
    return float(band_crossings.max())


def _find_equilibrium_of_momentum(run: Trajectory) -> float:
    """Where the governor rests on its free spindle with the angular momentum that it has at the end."""
    reduction, last_value = SingleDofReduction(run.scene), float(run.readings[run.scene.part.mechanism.coordinate][-1])
    angular_momentum = 2 * run.energy.rotation[-1] / run.readings["spindle_speed"][-1]

    def generalised_force(value: float) -> float:
        coefficients = reduction.evaluate([value], run.poses[-1])
        speed = angular_momentum / (reduction.free_spindle_inertia + coefficients.spindle_inertia[0])
        return float(coefficients.potential_derivative[0] - 0.5 * speed**2 * coefficients.spindle_inertia_derivative[0])

    width = 1e-3
    while generalised_force(last_value - width) * generalised_force(last_value + width) > 0:
        width *= 2
    return float(brentq(generalised_force, last_value - width, last_value + width, xtol=1e-13))
