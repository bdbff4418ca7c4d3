"""Adaptive grid of coordinate values over a range of motion, on which forces can be interpolated.

The range is divided into intervals. An interval is bisected where cubic Hermite interpolation of V' and J' (potential, inertia
about the spindle) between its ends does not match them at its midpoint. A feature narrower than an interval of the initial
division is missed unless it reaches an end or a midpoint, or changes the curve there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.numerics.interpolation import cubic_hermite, cubic_hermite_derivative
from governor_mechanism.types import BoolArray, FloatArray, IntArray

N_INITIAL_INTERVALS = 160
"""Number of intervals of the initial division."""

INTERPOLATION_TOLERANCE = 1e-4
"""Error at a midpoint, relative to the largest value in the interval, above which the interval is bisected."""

MIN_INTERVAL_RATIO = 2.0**-24
"""Smallest width of an interval relative to the range."""

MAX_GRID_VALUES = 20_000
"""Number of grid values at which refinement stops."""

ASTATIC_TOLERANCE = 1e-11
"""Force or stiffness relative to its terms below which it counts as zero (astatic): rounding, and dimensions given to twelve digits."""


@dataclass(frozen=True, eq=False)
class AdaptiveGrid:
    """Coefficients at grid values in any order, and intervals (p, 3): indices of low end, midpoint and high end."""

    reduction: SingleDofReduction
    coefficients: PathCoefficients
    intervals: IntArray

    @property
    def sorted_coefficients(self) -> PathCoefficients:
        """The coefficients in ascending order of the coordinate."""
        return self.coefficients.select(np.argsort(self.coefficients.coordinate, kind="stable"))

    def refine(self, needs_refinement: Callable[[PathCoefficients, IntArray], BoolArray]) -> AdaptiveGrid:
        """Return the grid with intervals bisected until none needs refinement."""
        coefficients = self.coefficients
        settled = [np.zeros((0, 3), dtype=np.int64)]
        pending = self.intervals
        min_width = MIN_INTERVAL_RATIO * float(np.ptp(coefficients.coordinate))
        while pending.size:
            width = coefficients.coordinate[pending[:, 2]] - coefficients.coordinate[pending[:, 0]]
            chosen = needs_refinement(coefficients, pending) & (width > min_width) & (len(coefficients.coordinate) < MAX_GRID_VALUES)
            settled.append(pending[~chosen])
            coefficients, pending = _bisect_intervals(self.reduction, coefficients, pending[chosen])
        return replace(self, coefficients=coefficients, intervals=np.concatenate(settled))

    def bisect_ranges(self, ranges: list[tuple[float, float]]) -> AdaptiveGrid:
        """Return the grid with all intervals bisected that overlap some of these ranges of the coordinate."""
        low, high = (self.coefficients.coordinate[self.intervals[:, k]] for k in (0, 2))
        chosen = np.zeros(len(self.intervals), dtype=np.bool_)
        for start, end in ranges:
            chosen |= (low < end) & (high > start)
        coefficients, new_intervals = _bisect_intervals(self.reduction, self.coefficients, self.intervals[chosen])
        return replace(self, coefficients=coefficients, intervals=np.concatenate([self.intervals[~chosen], new_intervals]))


def sample_range_of_motion(reduction: SingleDofReduction) -> AdaptiveGrid:
    """Return the grid over a range of motion on which V' and J' are resolved; a closed motion goes on at both ends, beyond its seam."""
    range_of_motion = reduction.range_of_motion
    low = range_of_motion.low
    high = range_of_motion.high
    n_extra = 1 if range_of_motion.period else 0
    width = (high - low) / N_INITIAL_INTERVALS
    values = np.linspace(low - n_extra * width, high + n_extra * width, 2 * (N_INITIAL_INTERVALS + 2 * n_extra) + 1)
    starts = np.arange(0, len(values) - 1, 2)
    return AdaptiveGrid(reduction, reduction.evaluate(values), np.stack([starts, starts + 1, starts + 2], axis=-1)).refine(_is_unresolved)


def interpolation_error_exceeds(
    coefficients: PathCoefficients, intervals: IntArray, value: FloatArray, derivative: FloatArray, floor: FloatArray | float
) -> BoolArray:
    """Return where Hermite interpolation between the ends of an interval misses a quantity (n,) at the midpoint by more than a floor."""
    # An error of the derivative counts by its effect on the value.
    predicted, predicted_derivative = _hermite_midpoint(coefficients, intervals, value, derivative)
    low, middle, high = intervals.T
    width = coefficients.coordinate[high] - coefficients.coordinate[low]
    error = np.abs(predicted - value[middle]) + 0.125 * width * np.abs(predicted_derivative - derivative[middle])
    exceeds: BoolArray = error > np.maximum(INTERPOLATION_TOLERANCE * np.max(np.abs(value[intervals]), axis=1), floor)
    return exceeds


def _is_unresolved(coefficients: PathCoefficients, intervals: IntArray) -> BoolArray:
    """Return where V', J' or V'' J' - V' J'' (its sign says whether the equilibrium speed rises) is not interpolated accurately."""
    potential = coefficients.potential_derivative, coefficients.potential_second_derivative
    spindle = coefficients.spindle_inertia_derivative, coefficients.spindle_inertia_second_derivative
    unresolved = np.zeros(len(intervals), dtype=np.bool_)
    for value, derivative in (potential, spindle):
        floor = 1e-12 * np.max(np.abs(value), initial=0.0)
        unresolved |= interpolation_error_exceeds(coefficients, intervals, value, derivative, floor)
    potential_middle, potential_second = _hermite_midpoint(coefficients, intervals, *potential)
    spindle_middle, spindle_second = _hermite_midpoint(coefficients, intervals, *spindle)
    numerator, magnitude = equilibrium_speed_slope_numerator(coefficients)
    error = np.abs(potential_second * spindle_middle - potential_middle * spindle_second - numerator[intervals[:, 1]])
    tolerance = 100 * INTERPOLATION_TOLERANCE * np.max(np.abs(numerator[intervals]), axis=1)
    unresolved |= error > np.maximum(tolerance, ASTATIC_TOLERANCE * np.max(magnitude[intervals], axis=1))
    return unresolved


def equilibrium_speed_slope_numerator(coefficients: PathCoefficients) -> tuple[FloatArray, FloatArray]:
    """Return V'' J' - V' J'' (n,), which has the sign of d(w^2)/dq in equilibrium, and the sum of its terms' magnitudes."""
    first_product = coefficients.potential_second_derivative * coefficients.spindle_inertia_derivative
    second_product = coefficients.potential_derivative * coefficients.spindle_inertia_second_derivative
    return first_product - second_product, np.abs(first_product) + np.abs(second_product)


def _hermite_midpoint(
    coefficients: PathCoefficients, intervals: IntArray, value: FloatArray, derivative: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return value and derivative at the midpoint of the cubic Hermite interpolant on each interval."""
    low, _, high = intervals.T
    ends = (value[low], value[high], derivative[low], derivative[high], coefficients.coordinate[high] - coefficients.coordinate[low], 0.5)
    return cubic_hermite(*ends), cubic_hermite_derivative(*ends)


def _bisect_intervals(
    reduction: SingleDofReduction, coefficients: PathCoefficients, intervals: IntArray
) -> tuple[PathCoefficients, IntArray]:
    """Return coefficients with the new midpoints appended, and the halves of the intervals."""
    if not intervals.size:
        return coefficients, intervals
    low, middle, high = intervals.T
    q, count = coefficients.coordinate, len(intervals)
    new_coefficients = reduction.evaluate(np.concatenate([0.5 * (q[low] + q[middle]), 0.5 * (q[middle] + q[high])]))
    first_new = len(q) + np.arange(count)
    halves = [np.stack([low, first_new, middle], axis=-1), np.stack([middle, first_new + count, high], axis=-1)]
    return coefficients.concatenate(new_coefficients), np.concatenate(halves)
