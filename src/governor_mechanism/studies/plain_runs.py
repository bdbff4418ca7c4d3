"""Errors of a run against a reference run or a known solution, in units of the scales, away from contact events."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines import select_engine
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.error_scales import name_of_rate
from governor_mechanism.types import BoolArray, FloatArray

SLEEVE_READING = "sleeve_lift"
"""Name of the reading that measures the lift of a governor's sleeve."""


@dataclass(frozen=True, kw_only=True)
class FittedParameter:
    """A fitted parameter."""

    value: float  # least-squares estimate
    standard_error: float  # standard error of the estimate, from the residuals of the fit

    def __str__(self) -> str:
        """Return value and standard error."""
        return f"{self.value:.4g} ± {self.standard_error:.1g}"


def run_uncertified(scene: Scene) -> Trajectory:
    """Run a scene without certificate at the tolerance of its accuracy, for studies that compare many runs."""
    engine, reason = select_engine(scene.run.engine, scene)
    run = engine.run(scene, certify=False, reason=reason)
    run.raise_if_failed()
    return run


def fit_slope(x: FloatArray, y: FloatArray) -> FittedParameter:
    """Return the slope of a least-squares line y(x), shape (n,) each."""
    design_matrix = np.column_stack([x, np.ones_like(x)])
    degrees_of_freedom = len(x) - design_matrix.shape[1]
    if degrees_of_freedom < 1:
        return FittedParameter(value=math.nan, standard_error=math.nan)
    coefficients = np.linalg.lstsq(design_matrix, y, rcond=None)[0]
    residual_variance = float(np.sum((y - design_matrix @ coefficients) ** 2)) / degrees_of_freedom
    slope_variance = residual_variance * np.linalg.inv(design_matrix.T @ design_matrix)[0, 0]
    return FittedParameter(value=float(coefficients[0]), standard_error=math.sqrt(slope_variance))


MAX_EVENT_EXCLUSION = 0.1
"""Upper bound of the interval around an event that is not compared, in time scales; the interval is the error of the event times."""

MIN_EVENT_EXCLUSION = 1e-9
"""Lower bound of that interval, in time scales."""

Motions = Mapping[str, tuple[FloatArray, FloatArray]]
"""Values and rates (n,) of readings; a reading without a rate has an empty array."""


def compare_runs(
    run: Trajectory,
    reference: Trajectory,  # a run of the same scene at the same times
) -> tuple[Mapping[str, float], float | None]:
    """Return the largest error of each reading and rate away from events, in its scale, and of event times (s), if a scene has contacts."""
    n_shared = min(len(reference.times), len(run.times))
    times = run.times[:n_shared]
    is_compared = np.ones(n_shared, dtype=np.bool_)
    event_time_error = None
    if has_contacts(run.scene):
        unit = time_scale(run.scene)
        event_time_error, _ = compare_event_logs(reference.events, run.events, times, 0.0)
        exclusion_time = max(min(event_time_error, MAX_EVENT_EXCLUSION * unit), MIN_EVENT_EXCLUSION * unit) * (1 + MIN_EVENT_EXCLUSION)
        is_compared = ~compare_event_logs(reference.events, run.events, times, exclusion_time)[1]
    motions = {name: (values, reference.rates.get(name, np.empty(0))) for name, values in reference.readings.items()}
    return compare_motions(run, motions, is_compared), event_time_error


def compare_motions(
    run: Trajectory,
    motions: Motions,  # known values and rates of readings at the times of the run, or at more
    is_compared: BoolArray,  # which of the first m times are compared; shape (m,)
) -> Mapping[str, float]:
    """Return the largest error of each reading and rate against known motions, in units of the scales."""
    indices, scales = np.flatnonzero(is_compared), run.scales

    def largest_difference(values: FloatArray, known_values: FloatArray) -> float:
        return float(np.max(np.abs(known_values[indices] - values[indices]), initial=0.0))

    errors = {name: largest_difference(run.readings[name], values) / scales[name] for name, (values, _) in motions.items()}
    rate_errors = {
        f"rate of {name}": largest_difference(run.rates[name], rates) / scales[name_of_rate(name)]
        for name, (_, rates) in motions.items()
        if rates.size
    }
    return errors | rate_errors
