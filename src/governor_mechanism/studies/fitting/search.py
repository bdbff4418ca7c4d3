"""Search for the values of unknowns that fit measured readings best, and what the data say of their errors."""

import math
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np

from governor_mechanism.engines.selection import select_engine
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.fitting.results import CONFIDENCE, Fit, FittedValue, Measurement, root_mean_square
from governor_mechanism.studies.sweep.workers import RowComputer, compute_all, compute_alone
from governor_mechanism.studies.unknowns import Unknown, scene_with, spread_places
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity

SEARCH_ACCURACY: Final = 1e-8
"""Accuracy of the runs of a search: their differences are divided by small steps."""

DERIVATIVE_STEP: Final = 1e-3
"""Step of the differences, relative to the width of the bounds."""

SEARCH_STEP: Final = 1e-5
"""Step of the differences to one side, relative to the width of the bounds."""

RANK_TOLERANCE: Final = 1e-8
"""Effect of a combination of unknowns on the data, relative to the largest, below which it has none but the errors of the differences."""

NAMED_SHARE: Final = 0.05
"""Share of an unknown in a combination, relative to the largest, from which the combination names it."""

MAX_EVALUATIONS: Final = 60
"""Largest number of steps of the search from one start."""

MAX_UNBOUNDED_EVALUATIONS: Final = 20
"""Largest number of steps of a search that may leave the bounds."""

BOUND_MARGIN: Final = 1e-6
"""Distance from a bound, relative to the width of the bounds, within which a value lies at it."""

NOISE_MARGIN: Final = 0.1
"""Error of the solver relative to the noise above which a note says so."""

FOREIGN_RATIO: Final = 20.0
"""Residual relative to the largest value of the run above which a note asks for the unit of the data."""

MISSING_PENALTY: Final = 3.0
"""Residual of a time that a run does not reach, in spans of the data."""


@dataclass(frozen=True, kw_only=True)
class FitQuestion:
    """What is fitted: unknowns of a scene, measured readings, and how runs are made."""

    scene: Scene
    unknowns: tuple[Unknown, ...]
    measurements: tuple[Measurement, ...]
    engine: str
    n_starts: int
    seed: int
    profiled: tuple[str, ...]

    def __post_init__(self) -> None:
        n_values = sum(len(one.values) for one in self.measurements)
        n_unknowns = len(self.unknowns)
        problems = [f"data: {one.reading} has no value that counts" for one in self.measurements if not len(one.values)]
        if n_values <= n_unknowns:
            problems.append(f"{n_values} values do not determine {n_unknowns} unknowns; give more data, or fewer unknowns")
        keys = [one.key for one in self.unknowns]
        problems += [f"profile: {key} is no unknown; unknowns are {', '.join(keys)}" for key in self.profiled if key not in keys]
        if problems:
            raise MechanismError(*problems)


class Misfit:
    """Residuals of the data, relative to their noise, as a function of the unknowns between their bounds, from 0 to 1."""

    def __init__(self, question: FitQuestion) -> None:
        self.question = question
        self.low = np.array([one.low for one in question.unknowns])
        self.width = np.array([one.high for one in question.unknowns]) - self.low
        self.times = np.unique(np.concatenate([one.times for one in question.measurements]))
        self._places = [np.searchsorted(self.times, one.times) for one in question.measurements]
        # Without a given noise the residuals are relative to the span of the data at first.
        self.noise = [one.noise or float(np.ptp(one.values)) or 1.0 for one in question.measurements]
        self.n_runs = 0
        self.best: tuple[float, FloatArray] | None = None
        self._last: tuple[bytes, FloatArray] | None = None

    def values_at(self, place: FloatArray) -> FloatArray:
        """Return the values of the unknowns, SI."""
        values: FloatArray = self.low + self.width * place
        return values

    def run(self, place: FloatArray, *, certify: bool = False) -> Trajectory:
        """Return the run with these values; raise MechanismError if there is none."""
        self.n_runs += 1
        scene = scene_with(self.question.scene, self.question.unknowns, self.values_at(place))
        name = scene.run.engine if self.question.engine == "auto" else self.question.engine
        engine, reason = select_engine(name, scene, SEARCH_ACCURACY)
        return engine.run(scene, times=self.times, accuracy=SEARCH_ACCURACY, certify=certify, reason=reason)

    def computed(self, place: FloatArray) -> list[FloatArray]:
        """Return what a run shows in the place of each measurement; NaN at times that it does not reach."""
        try:
            return self.values_of(self.run(place))
        except GovernorMechanismError:  # an impossible geometry lies outside
            return [np.full(len(one.times), np.nan) for one in self.question.measurements]

    def values_of(self, run: Trajectory) -> list[FloatArray]:
        """Return the values of a run in the place of each measurement; NaN at times that it does not reach."""
        shown = []
        for one, places in zip(self.question.measurements, self._places, strict=True):
            values = np.full(len(self.times), np.nan)
            values[: len(run.times)] = run.readings[one.reading]
            shown.append(values[places])
        return shown

    def residuals(self, place: FloatArray) -> FloatArray:
        """Return the residuals relative to the noise, computed once for the same place in succession; shape (values,)."""
        if self._last is not None and self._last[0] == place.tobytes():
            return self._last[1]
        residuals = []
        for one, noise, values in zip(self.question.measurements, self.noise, self.computed(place), strict=True):
            penalty = MISSING_PENALTY * max(float(np.ptp(one.values)), noise)
            residuals.append(np.where(np.isnan(values), penalty, values - one.values) / noise)
        result: FloatArray = np.concatenate(residuals)
        cost = float(np.sum(result**2))
        if _is_within_bounds(place) and (self.best is None or cost < self.best[0]):
            self.best = cost, np.array(place)
        self._last = place.tobytes(), result
        return result

    def jacobian(self, place: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals by the unknowns, by central differences; shape (values, unknowns)."""
        columns = []
        for k in range(len(place)):
            ends = [np.array(place), np.array(place)]
            ends[0][k], ends[1][k] = max(0.0, place[k] - DERIVATIVE_STEP), min(1.0, place[k] + DERIVATIVE_STEP)
            before, after = map(self.residuals, ends)
            columns.append((after - before) / (ends[1][k] - ends[0][k]))
        return np.stack(columns, axis=-1)

    def rough_jacobian(self, place: FloatArray) -> FloatArray:
        """Return the derivatives by differences to one side, which cost half and lead a search as well; shape (values, unknowns)."""
        here, columns = self.residuals(place), []
        for k in range(len(place)):
            step = SEARCH_STEP if place[k] < 0.5 else -SEARCH_STEP
            beside = np.array(place)
            beside[k] += step
            columns.append((self.residuals(beside) - here) / step)
        return np.stack(columns, axis=-1)

    def estimate_noise(self, place: FloatArray) -> None:
        """Take the noise that is not given from the residuals."""
        computed, n_unknowns = self.computed(place), len(place)
        for k, (one, values) in enumerate(zip(self.question.measurements, computed, strict=True)):
            if one.noise is None and not np.isnan(values).any():
                n = len(values)
                level = root_mean_square(values - one.values) * math.sqrt(n / max(n - n_unknowns / len(computed), 1.0))
                self.noise[k] = level or self.noise[k]
        self.best = self._last = None  # in other units


def _is_within_bounds(place: FloatArray) -> bool:
    return bool(np.all((place >= 0.0) & (place <= 1.0)))


def fit_measurements(question: FitQuestion, compute: RowComputer[Any]) -> Fit:
    """Return the values of the unknowns that fit best; an interrupted search returns the best so far."""
    misfit = Misfit(question)
    start = np.array([(one.start - one.low) / (one.high - one.low) for one in question.unknowns])
    is_noise_unknown = any(one.noise is None for one in question.measurements)
    try:
        place, converged, outcome = _search(misfit, start, compute)
        if is_noise_unknown and len(question.measurements) > 1:
            misfit.estimate_noise(place)
            place, converged, outcome = _descend(misfit, place)  # the readings now have their weights
    except KeyboardInterrupt:
        if misfit.best is None:
            raise
        place = misfit.best[1]
        converged = False
        outcome = "interrupted; these are the best values so far"
    if is_noise_unknown:
        misfit.estimate_noise(place)
    return _describe(misfit, place, converged, outcome)


_End = tuple[FloatArray, bool, str]
"""Where a search ended, whether that is a minimum, and how it ended."""


def _search(misfit: Misfit, start: FloatArray, compute: RowComputer[Any]) -> _End:
    """Return the best minimum that is found from the scene's own values and from the best of random points."""
    n_further = misfit.question.n_starts - 1
    starts = [start]
    if n_further:
        points = spread_places(len(start), n_further, misfit.question.seed)
        costs = [float(np.sum(misfit.residuals(point) ** 2)) for point in points]
        starts += [points[k] for k in np.argsort(costs)[:n_further]]
    if compute is compute_alone or len(starts) == 1:
        found = [_descend(misfit, one) for one in starts]
    else:
        ends = compute_all(compute, partial(_descend_elsewhere, misfit, starts), len(starts))
        found = [end for end, _ in ends]
        misfit.n_runs += sum(n_runs for _, n_runs in ends)
    return min(found, key=lambda one: float(np.sum(misfit.residuals(one[0]) ** 2)))


def _descend_elsewhere(misfit: Misfit, starts: Sequence[FloatArray], index: int) -> tuple[_End, int]:
    """Return where the search from a start ends, and its number of runs."""
    own = copy(misfit)
    end = _descend(own, starts[index])
    return end, own.n_runs - misfit.n_runs


def _descend(misfit: Misfit, start: FloatArray) -> _End:
    """Return a minimum near a start, whether it is one, and how the search ended."""
    from scipy.optimize import least_squares  # slow to import

    inside = np.clip(start, 1e-9, 1.0 - 1e-9)
    options: dict[str, Any] = {"jac": misfit.rough_jacobian, "xtol": 1e-9, "ftol": 1e-10, "gtol": 1e-10}
    # Levenberg and Marquardt's method needs half the steps, but knows no bounds, and does not end where the data determine too little.
    found = least_squares(misfit.residuals, inside, method="lm", max_nfev=MAX_UNBOUNDED_EVALUATIONS, **options)
    if not _is_within_bounds(found.x) or found.status <= 0:
        first = found.x if _is_within_bounds(found.x) else inside
        found = least_squares(misfit.residuals, first, method="trf", bounds=(0.0, 1.0), max_nfev=MAX_EVALUATIONS, **options)
    outcome = (
        "the search converged" if found.status > 0 else f"no convergence within {MAX_EVALUATIONS} steps; the values are the best so far"
    )
    return found.x, bool(found.status > 0), outcome


def _describe(misfit: Misfit, place: FloatArray, converged: bool, outcome: str) -> Fit:
    """Return the result of a search that ended at a place."""
    question, unknowns = misfit.question, misfit.question.unknowns
    jacobian = misfit.jacobian(place)
    values = misfit.values_at(place)
    relative = np.maximum(np.abs(values), 1e-3 * misfit.width) / misfit.width  # a relative change of a value, in widths of its bounds
    covariance, undetermined = _analyse(jacobian * relative, relative)
    errors = [
        None if k in undetermined.indices else math.sqrt(covariance[k, k]) * relative[k] * misfit.width[k] for k in range(len(unknowns))
    ]
    factor = _interval_factor(jacobian)
    rows = [_make_row(one, value, error, factor) for one, value, error in zip(unknowns, values.tolist(), errors, strict=True)]
    rows = [_with_profile(misfit, place, row, k) if row.key in question.profiled else row for k, row in enumerate(rows)]
    deviations = np.sqrt(np.where(np.diag(covariance) > 0.0, np.diag(covariance), 1.0))
    run = misfit.run(place, certify=True)
    names = [one.reading for one in question.measurements]
    residuals = {}
    for one, values in zip(question.measurements, misfit.values_of(run), strict=True):
        is_reached = np.isfinite(values)
        residuals[one.reading] = (one.values - values)[is_reached]
        if not is_reached.all():
            converged = False
            outcome = f"no values were found with which the run reaches all times of the data: {run.message}"
    return Fit(
        title=question.scene.title,
        rows=tuple(rows),
        correlation_matrix=covariance / np.outer(deviations, deviations),
        not_identifiable=tuple(_name_combination(question.unknowns, one) for one in undetermined.directions),
        measurements=question.measurements,
        noise=dict(zip(names, misfit.noise, strict=True)),
        is_noise_given=all(one.noise is not None for one in question.measurements),
        residuals=residuals,
        scene=run.scene,
        run=run,
        n_runs=misfit.n_runs,
        n_starts=question.n_starts,
        seed=question.seed,
        converged=converged,
        outcome=outcome,
        notes=tuple(_find_notes(misfit, run, residuals)),
    )


@dataclass(frozen=True)
class _Undetermined:
    """Combinations of unknowns that data do not determine: unit vectors of relative changes, and the unknowns that they contain."""

    directions: tuple[FloatArray, ...]
    indices: frozenset[int]


def _analyse(jacobian: FloatArray, relative: FloatArray) -> tuple[FloatArray, _Undetermined]:
    """Return the covariance (unknowns, unknowns) of relative changes and the combinations that are not determined."""
    # The residuals are in units of the noise, so that the covariance is the inverse of J^T J, and a
    # singular value is the inverse of a standard error. Where that exceeds the width of the bounds,
    # these determine the combination, and not the data.
    _, singular_values, directions = np.linalg.svd(jacobian, full_matrices=False)
    widths_per_change = np.max(np.abs(directions * relative), axis=1)
    is_determined = singular_values > np.maximum(RANK_TOLERANCE * singular_values[0], widths_per_change)
    kept = directions[is_determined] / singular_values[is_determined, np.newaxis]
    missing = tuple(directions[~is_determined])
    indices = frozenset(k for one in missing for k in _named(one))
    return kept.T @ kept, _Undetermined(missing, indices)


def _named(direction: FloatArray) -> list[int]:
    """Return the unknowns that a combination contains."""
    return np.flatnonzero(np.abs(direction) > NAMED_SHARE * np.max(np.abs(direction))).tolist()


def _name_combination(unknowns: Sequence[Unknown], direction: FloatArray) -> str:
    """Return a combination of unknowns in a sentence."""
    indices = _named(direction)
    shares = direction[indices] / direction[max(indices, key=lambda k: abs(direction[k]))]
    parts = [f"{unknowns[k].key} by {share:+.2f} %" for k, share in zip(indices, shares.tolist(), strict=True)]
    if len(indices) == 1:
        return f"not identifiable: {unknowns[indices[0]].key}; the data do not depend on it"
    text = ", ".join(parts[:-1]) + f" and {parts[-1]}"
    return f"not identifiable: the data do not determine a common change of {text}; give one of these values"


def _interval_factor(jacobian: FloatArray) -> float:
    """Return the half width of an interval in standard errors."""
    from scipy.stats import t  # slow to import

    return float(t.ppf(0.5 * (1.0 + CONFIDENCE), jacobian.shape[0] - jacobian.shape[1]))


def _make_row(unknown: Unknown, value: float, error: float | None, factor: float) -> FittedValue:
    width = unknown.high - unknown.low
    return FittedValue(
        key=unknown.key,
        value=value,
        unit=unknown.unit,
        standard_error=error,
        low=None if error is None else value - factor * error,
        high=None if error is None else value + factor * error,
        bounds=(unknown.low, unknown.high),
        at_bound=min(value - unknown.low, unknown.high - value) < BOUND_MARGIN * width,
    )


def _with_profile(misfit: Misfit, place: FloatArray, row: FittedValue, k: int) -> FittedValue:
    """Return a row with the interval in which the misfit, minimised over all other unknowns, stays below the limit of the probability."""
    from scipy.optimize import brentq, least_squares  # slow to import
    from scipy.stats import f as fisher

    least = float(np.sum(misfit.residuals(place) ** 2))
    n_free = sum(len(one.values) for one in misfit.question.measurements) - len(place)
    limit = float(fisher.ppf(CONFIDENCE, 1, n_free))
    others = np.arange(len(place)) != k

    def excess(coordinate: float) -> float:
        def residuals(free: FloatArray) -> FloatArray:
            whole = np.insert(free, k, coordinate)
            return misfit.residuals(whole)

        if not others.any():
            return float(np.sum(residuals(np.empty(0)) ** 2)) - least - limit
        found = least_squares(residuals, np.clip(place[others], 1e-9, 1 - 1e-9), bounds=(0.0, 1.0), diff_step=DERIVATIVE_STEP, max_nfev=12)
        return 2.0 * float(found.cost) - least - limit

    step = 3.0 * (row.standard_error or 0.1 * misfit.width[k]) / misfit.width[k]
    ends = [_find_profile_end(excess, float(place[k]), sign * step, brentq) for sign in (-1.0, 1.0)]
    low, high = (misfit.low[k] + misfit.width[k] * end for end in ends)
    return replace(row, low=float(low), high=float(high), by_profile=True)


def _find_profile_end(excess: Callable[[float], float], place: float, step: float, find_root: Callable[..., float]) -> float:
    """Return where a profile crosses its limit on one side, or the bound if it does not."""
    far = place
    while 0.0 < far < 1.0:
        far = min(max(far + step, 0.0), 1.0)
        if excess(far) > 0.0:
            return find_root(excess, place, far, xtol=1e-3 * abs(far - place))
    return far


def _find_notes(misfit: Misfit, run: Trajectory, residuals: dict[str, FloatArray]) -> list[str]:
    """Return sentences on a solver that is not far more accurate than the data, and on a scene that does not explain them."""
    notes = list[str]()
    for one, noise in zip(misfit.question.measurements, misfit.noise, strict=True):
        error = run.reading_errors.get(one.reading)
        if error is None or error > NOISE_MARGIN * noise:
            stated = "unknown" if error is None else format_quantity(error, one.unit)
            notes.append(
                f"the error of the solver in {one.reading} is {stated}, not far below the noise, {format_quantity(noise, one.unit)}"
            )
        level = root_mean_square(residuals[one.reading]) if len(residuals[one.reading]) else 0.0
        largest = [float(np.max(np.abs(values))) for values in (one.values, run.readings[one.reading])]
        if level > FOREIGN_RATIO * largest[1]:
            measured, shown = (format_quantity(value, one.unit) for value in largest)
            cure = f'a bare number is SI; write another unit in the heading, as "{one.reading} [mm]"'
            notes.append(f"the data of {one.reading} reach {measured}, and those of the run {shown}: {cure}")
        if one.noise is not None and level > 1.5 * noise:
            shown = format_quantity(level, one.unit)
            notes.append(
                f"the residuals of {one.reading} are {shown}, more than the noise that is given: the scene does not explain the data"
            )
    return notes
