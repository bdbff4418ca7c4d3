"""A curve through samples with two derivatives: polynomials over two to four samples in Newton's form, and their roots and extremes."""

from typing import NamedTuple

import numpy as np

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray

N_CONDITIONS = 3
"""Conditions at each sample: value, first and second derivative."""

MAX_SAMPLES = 4
"""Largest number of samples of a polynomial."""

MAX_NEWTON_STEPS = 60
"""Largest number of safeguarded Newton steps; about five are usual, and bisection alone needs about 50."""


class CurveSamples(NamedTuple):
    """Values and two derivatives of a curve at places in ascending or descending order; shape (n,) each."""

    places: FloatArray
    values: FloatArray
    rates: FloatArray
    accelerations: FloatArray


class HermiteCurve:
    """A curve through values and two derivatives at places, (n,) each; polynomials of degree 3 k - 1 over k samples are its pieces."""

    def __init__(self, places: FloatArray, values: FloatArray, rates: FloatArray, accelerations: FloatArray) -> None:
        self._samples = CurveSamples(*(np.ascontiguousarray(one, dtype=np.float64) for one in (places, values, rates, accelerations)))
        self._coefficients = np.empty(N_CONDITIONS * MAX_SAMPLES)

    def evaluate(self, first: IntArray, n_samples: int, places: FloatArray) -> FloatArray:
        """Return value and two derivatives (3, m) at places (m,) of the pieces over a number of samples from the first ones (m,) on."""
        found = np.empty((N_CONDITIONS, len(places)))
        _evaluate_pieces(self._samples, first.astype(np.int64), n_samples, places, self._coefficients, found)
        return found

    def find_crossings(
        self, level: float, first: IntArray, n_samples: int, low: FloatArray, high: FloatArray, tolerance: float
    ) -> FloatArray:
        """Return where the pieces pass a level, in brackets (m,); a Newton step shorter than the tolerance is the last."""
        return self._find_roots(0, level, first, n_samples, low, high, tolerance)

    def find_extremes(self, first: IntArray, n_samples: int, low: FloatArray, high: FloatArray, tolerance: float) -> FloatArray:
        """Return where the rates of the pieces change their sign, in brackets (m,), as `find_crossings` does."""
        return self._find_roots(1, 0.0, first, n_samples, low, high, tolerance)

    def _find_roots(
        self, derivative: int, level: float, first: IntArray, n_samples: int, low: FloatArray, high: FloatArray, tolerance: float
    ) -> FloatArray:
        roots = np.empty(len(low))
        brackets = np.column_stack([low, high])
        _find_roots_of_pieces(
            self._samples, first.astype(np.int64), n_samples, brackets, (derivative, level, tolerance), self._coefficients, roots
        )
        return roots


@jit_in_place
def _divide_differences(samples: CurveSamples, first: int, n_samples: int, coefficients: FloatArray) -> None:
    """Evaluate the coefficients of Newton's form of the polynomial over some samples from the first one on."""
    n = N_CONDITIONS * n_samples
    for i in range(n):
        coefficients[i] = samples.values[first + i // N_CONDITIONS]
    for order in range(1, n):
        for i in range(n - 1, order - 1, -1):
            last = first + i // N_CONDITIONS
            before = first + (i - order) // N_CONDITIONS
            if last != before:
                coefficients[i] = (coefficients[i] - coefficients[i - 1]) / (samples.places[last] - samples.places[before])
            elif order == 1:  # differences over one sample alone are derivatives there
                coefficients[i] = samples.rates[last]
            else:
                coefficients[i] = 0.5 * samples.accelerations[last]


@jit_in_place
def _evaluate_piece(
    samples: CurveSamples, first: int, n_samples: int, coefficients: FloatArray, place: float
) -> tuple[float, float, float]:
    """Return value, rate and acceleration of a polynomial in Newton's form."""
    n = N_CONDITIONS * n_samples
    value = float(coefficients[n - 1])
    rate = 0.0
    acceleration = 0.0
    for order in range(n - 2, -1, -1):
        distance = place - samples.places[first + order // N_CONDITIONS]
        acceleration = acceleration * distance + 2.0 * rate
        rate = rate * distance + value
        value = value * distance + float(coefficients[order])
    return value, rate, acceleration


@jit_in_place
def _evaluate_pieces(
    samples: CurveSamples, first: IntArray, n_samples: int, places: FloatArray, coefficients: FloatArray, found: FloatArray
) -> None:
    """Evaluate value and two derivatives (3, m) of the pieces from samples (m,) on, at a place each."""
    for i in range(len(places)):
        _divide_differences(samples, first[i], n_samples, coefficients)
        found[0, i], found[1, i], found[2, i] = _evaluate_piece(samples, first[i], n_samples, coefficients, places[i])


@jit_in_place
def _find_roots_of_pieces(
    samples: CurveSamples,
    first: IntArray,  # first samples of the pieces; shape (m,)
    n_samples: int,
    brackets: FloatArray,  # both ends of each bracket; shape (m, 2)
    search: tuple[int, float, float],  # 0 for values and 1 for rates, the level that they pass, and the longest last step
    coefficients: FloatArray,  # memory of the coefficients of one piece; shape (N_CONDITIONS * MAX_SAMPLES,)
    roots: FloatArray,  # result: shape (m,)
) -> None:
    """Find where pieces or their rates pass a level, by Newton's method, safeguarded by bisection."""
    derivative, level, tolerance = search
    for i in range(len(roots)):
        _divide_differences(samples, first[i], n_samples, coefficients)
        low = brackets[i, 0]
        high = brackets[i, 1]
        at_high = _evaluate_piece(samples, first[i], n_samples, coefficients, high)
        is_rising = (at_high[1] if derivative else at_high[0]) > level
        root = 0.5 * (low + high)
        for _ in range(MAX_NEWTON_STEPS):
            value, rate, acceleration = _evaluate_piece(samples, first[i], n_samples, coefficients, root)
            deviation = (rate if derivative else value) - level
            slope = acceleration if derivative else rate
            if (deviation > 0.0) == is_rising:
                high = root
            else:
                low = root
            step = -deviation / slope if slope != 0.0 else np.inf
            if abs(step) < tolerance:
                root = min(max(root + step, brackets[i, 0]), brackets[i, 1])
                break
            root = root + step if low < root + step < high else 0.5 * (low + high)
        roots[i] = root
