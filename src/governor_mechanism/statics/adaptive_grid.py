"""Values along a travel, denser where the forces curve: what lies between two of them is known from both.

The travel is taken in parts. Where cubics through the slopes of the potential and of the spindle's inertia at both ends
of a part do not say what they are in its middle, the part is halved. A feature shows if it reaches an end or a middle
of some part, or bends what is there; one narrower than a part of PARTS, of which nothing is felt farther away, does
not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.types import FloatArray

Which = NDArray[np.bool_]
Parts = NDArray[np.int64]

N_INITIAL_INTERVALS = 160
"""The travel is first taken in so many parts."""

INTERPOLATION_TOLERANCE = 1e-4
"""A middle off by this fraction of what is largest there makes a part be halved."""

MIN_INTERVAL_RATIO = 2.0**-24
"""Parts narrower than this fraction of the travel are not halved."""

MAX_GRID_VALUES = 20_000
"""So many values are enough."""

ASTATIC_TOLERANCE = 1e-11
"""A force, or a stiffness, below this fraction of its parts is rounding and dimensions of twelve digits: astatic."""


@dataclass(frozen=True, eq=False)
class AdaptiveGrid:
    """Values along a travel in any order, and the parts (p, 3) that they make: low end, middle and high end of each."""

    reduction: SingleDofReduction
    coefficients: PathCoefficients
    intervals: Parts

    @property
    def sorted_coefficients(self) -> PathCoefficients:
        """All values in ascending order."""
        return self.coefficients.select(np.argsort(self.coefficients.coordinate, kind="stable"))

    def refine(self, needs_refinement: Callable[[PathCoefficients, Parts], Which]) -> AdaptiveGrid:
        """With the parts halved in which something bends, and their halves, until nothing does."""
        coefficients, settled, pending = self.coefficients, [np.zeros((0, 3), dtype=np.int64)], self.intervals
        min_width = MIN_INTERVAL_RATIO * float(np.ptp(coefficients.coordinate))
        while pending.size:
            width = coefficients.coordinate[pending[:, 2]] - coefficients.coordinate[pending[:, 0]]
            chosen = needs_refinement(coefficients, pending) & (width > min_width) & (len(coefficients.coordinate) < MAX_GRID_VALUES)
            settled.append(pending[~chosen])
            coefficients, pending = _bisect_intervals(self.reduction, coefficients, pending[chosen])
        return replace(self, coefficients=coefficients, intervals=np.concatenate(settled))

    def bisect_ranges(self, ranges: list[tuple[float, float]]) -> AdaptiveGrid:
        """With all parts halved that lie in some of these ranges of the coordinate."""
        low, high = (self.coefficients.coordinate[self.intervals[:, k]] for k in (0, 2))
        chosen = np.zeros(len(self.intervals), dtype=np.bool_)
        for start, end in ranges:
            chosen |= (low < end) & (high > start)
        coefficients, new_intervals = _bisect_intervals(self.reduction, self.coefficients, self.intervals[chosen])
        return replace(self, coefficients=coefficients, intervals=np.concatenate([self.intervals[~chosen], new_intervals]))


def sample_range_of_motion(reduction: SingleDofReduction) -> AdaptiveGrid:
    """A travel in parts in which potential and spindle's inertia are known from their ends.

    Of a motion that comes round one part more is taken at each end: what lies at the seam lies within.
    """
    range_of_motion = reduction.range_of_motion
    n_extra = 1 if range_of_motion.period else 0
    width = (range_of_motion.high - range_of_motion.low) / N_INITIAL_INTERVALS
    values = np.linspace(
        range_of_motion.low - n_extra * width, range_of_motion.high + n_extra * width, 2 * (N_INITIAL_INTERVALS + 2 * n_extra) + 1
    )
    starts = np.arange(0, len(values) - 1, 2)
    intervals = np.stack([starts, starts + 1, starts + 2], axis=-1)
    return AdaptiveGrid(reduction, reduction.evaluate(values), intervals).refine(_is_unresolved)


def interpolation_error_exceeds(
    coefficients: PathCoefficients, intervals: Parts, value: FloatArray, derivative: FloatArray, floor: FloatArray | float
) -> Which:
    """Where a quantity (n,) with this slope is not in the middle what the ends of parts say, by more than a floor.

    A slope that is not what they say counts by what it makes of the value.
    """
    predicted, predicted_derivative = _hermite_midpoint(coefficients, intervals, value, derivative)
    low, middle, high = intervals.T
    width = coefficients.coordinate[high] - coefficients.coordinate[low]
    error = np.abs(predicted - value[middle]) + 0.125 * width * np.abs(predicted_derivative - derivative[middle])
    exceeds: Which = error > np.maximum(INTERPOLATION_TOLERANCE * np.max(np.abs(value[intervals]), axis=1), floor)
    return exceeds


def _is_unresolved(coefficients: PathCoefficients, intervals: Parts) -> Which:
    """Where V', J', or V'' J' - V' J'' (what says whether the equilibrium speed rises), are not what the ends say."""
    potential, spindle = (
        (coefficients.potential_derivative, coefficients.potential_second_derivative),
        (coefficients.spindle_inertia_derivative, coefficients.spindle_inertia_second_derivative),
    )
    floors = [1e-12 * np.max(np.abs(quantity[0]), initial=0.0) for quantity in (potential, spindle)]
    unresolved = interpolation_error_exceeds(coefficients, intervals, *potential, floors[0]) | interpolation_error_exceeds(
        coefficients, intervals, *spindle, floors[1]
    )
    (potential_middle, potential_second), (spindle_middle, spindle_second) = (
        _hermite_midpoint(coefficients, intervals, *quantity) for quantity in (potential, spindle)
    )
    numerator, magnitude = equilibrium_speed_slope_numerator(coefficients)
    largest = np.max(np.abs(numerator[intervals]), axis=1)
    floor = ASTATIC_TOLERANCE * np.max(magnitude[intervals], axis=1)
    unresolved |= np.abs(potential_second * spindle_middle - potential_middle * spindle_second - numerator[intervals[:, 1]]) > np.maximum(
        100 * INTERPOLATION_TOLERANCE * largest, floor
    )
    return unresolved


def equilibrium_speed_slope_numerator(coefficients: PathCoefficients) -> tuple[FloatArray, FloatArray]:
    """V'' J' - V' J'' (n,), which has the sign of d(w^2)/dq at rest, and the sum of its parts without their signs."""
    first_product, second_product = (
        coefficients.potential_second_derivative * coefficients.spindle_inertia_derivative,
        coefficients.potential_derivative * coefficients.spindle_inertia_second_derivative,
    )
    return first_product - second_product, np.abs(first_product) + np.abs(second_product)


def _hermite_midpoint(
    coefficients: PathCoefficients, intervals: Parts, value: FloatArray, derivative: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Value and slope in the middle of parts, by the cubics through both at their ends."""
    low, _, high = intervals.T
    width = coefficients.coordinate[high] - coefficients.coordinate[low]
    middle = 0.5 * (value[low] + value[high]) + 0.125 * width * (derivative[low] - derivative[high])
    return middle, 1.5 * (value[high] - value[low]) / width - 0.25 * (derivative[low] + derivative[high])


def _bisect_intervals(reduction: SingleDofReduction, coefficients: PathCoefficients, intervals: Parts) -> tuple[PathCoefficients, Parts]:
    """With the halves of parts in place of them, and the values in the middles of these."""
    if not intervals.size:
        return coefficients, intervals
    low, middle, high = intervals.T
    q, count = coefficients.coordinate, len(intervals)
    new_coefficients = reduction.evaluate(np.concatenate([0.5 * (q[low] + q[middle]), 0.5 * (q[middle] + q[high])]))
    first_new = len(q) + np.arange(count)
    halves = [np.stack([low, first_new, middle], axis=-1), np.stack([middle, first_new + count, high], axis=-1)]
    return coefficients.concatenate(new_coefficients), np.concatenate(halves)
