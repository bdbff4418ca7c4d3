"""Settling time of a governor after a change of load, against the strength of its dashpot."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.results.result import Result
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.regression import SLEEVE_READING, run_uncertified
from governor_mechanism.types import FloatArray

DAMPING_COEFFICIENTS = np.geomspace(35.0, 1200.0, 60)
"""Damping coefficients, N s/m, for a curve of the settling time."""

SETTLING_TOLERANCE = 0.02
"""Half-width of the settling band about the new equilibrium, relative to the whole change."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SettlingStudy(Result):
    """Settling time after a change of load, against the damping of the sleeve.

    Attributes
    ----------
    title
        Title of the scene.
    damping_coefficients
        Linear dashpot on the sleeve, N s/m; shape (n,).
    settling_times
        Time from the change of load until the arms stay within the settling band, s; shape (n,); infinite if they do not settle in the run.
    best
        Damping coefficient with the shortest settling time, N s/m, and that time, s.
    """

    title: str
    damping_coefficients: FloatArray
    settling_times: FloatArray
    best: tuple[float, float]

    figure = "render.figures.regulation.settling_figure"

    @property
    def conclusion(self) -> str:
        """One sentence on the best damping."""
        return f"shortest settling time {self.best[1]:.4g} s with a dashpot of {self.best[0]:.4g} N s/m"


def study_settling(
    scene: Scene,  # scene with a free spindle and a torque that changes
    damping_coefficients: Sequence[float] | FloatArray,  # linear dashpots on the sleeve, N s/m; shape (n,)
) -> SettlingStudy:
    """Run a scene whose load changes with several dashpots on the sleeve, and find the best one.

    The new equilibrium is the one of the angular momentum at the end. Time counts from the first jump of the torque.

    Result: settling times and the best damping. Raises MechanismError if the scene has no such spindle, or if
    no dashpot makes it settle within its run.
    """
    spindle = scene.spindle
    if not isinstance(spindle, FreeSpindle) or spindle.torque.is_constant:
        raise MechanismError("the settling study needs a free spindle with a torque that changes; give spindle.torque over time")
    times, values = spindle.torque.times, spindle.torque.values
    load_change_time = times[next(k for k, (before, value) in enumerate(pairwise(values)) if value != before)]
    other_effects = tuple(effect for effect in scene.effects if not isinstance(effect, Dashpot))

    def settling_time_of(damping_coefficient: float) -> float:
        dashpot = Dashpot(reading=SLEEVE_READING, linear=damping_coefficient)
        return _compute_settling_time(run_uncertified(scene.with_changes(effects=(*other_effects, dashpot)))) - load_change_time

    requested_coefficients = np.asarray(damping_coefficients, dtype=np.float64)
    settling_times = np.array([settling_time_of(coefficient) for coefficient in requested_coefficients.tolist()])
    if not np.any(np.isfinite(settling_times)):
        raise MechanismError(f"with no dashpot does the governor settle within {scene.run.duration:g} s; increase run.duration")
    k = int(np.argmin(settling_times))
    bounds = (requested_coefficients[max(k - 1, 0)], requested_coefficients[min(k + 1, len(requested_coefficients) - 1)])
    options = {"xatol": 1e-3 * requested_coefficients[k]}
    refined = minimize_scalar(
        lambda one: min(settling_time_of(one), 1e3 * scene.run.duration), bounds=bounds, method="bounded", options=options
    )
    best_time, best_coefficient = min((float(settling_times[k]), float(requested_coefficients[k])), (float(refined.fun), float(refined.x)))
    return SettlingStudy(
        title=scene.title, damping_coefficients=requested_coefficients, settling_times=settling_times, best=(best_coefficient, best_time)
    )


def _compute_settling_time(run: Trajectory) -> float:
    """Return the time, s, from which the coordinate stays in the settling band about its new equilibrium, or infinity."""
    name = run.scene.part.mechanism.coordinate
    deviation = run.readings[name] - _find_equilibrium_of_momentum(run)
    band_width = SETTLING_TOLERANCE * abs(float(deviation[0]))
    curve = CubicHermiteSpline(run.times, deviation, run.rates[name])
    band_crossings = np.concatenate([curve.solve(side * band_width, extrapolate=False) for side in (-1.0, 1.0)])
    if band_crossings.size == 0 or np.max(np.abs(deviation[run.times > 0.8 * run.times[-1]])) > band_width:
        return math.inf
    return float(band_crossings.max())


def _find_equilibrium_of_momentum(run: Trajectory) -> float:
    """Return the equilibrium on the free spindle at the angular momentum of the end of the run."""
    mechanism = run.scene.part.mechanism
    reduction, last_value = SingleDofReduction(run.scene), float(run.readings[mechanism.coordinate][-1])
    last_poses = run.poses[-1, : len(mechanism.bodies)]
    angular_momentum = 2 * run.energy.rotation[-1] / run.readings["spindle_speed"][-1]

    def generalised_force(value: float) -> float:
        coefficients = reduction.evaluate([value], last_poses)
        speed = angular_momentum / (reduction.free_spindle_inertia + coefficients.spindle_inertia[0])
        return float(coefficients.force_terms(speed**2).sum())

    width = 1e-3
    while generalised_force(last_value - width) * generalised_force(last_value + width) > 0:
        width *= 2
    return float(brentq(generalised_force, last_value - width, last_value + width, xtol=1e-13))
