"""Interpolation: Chebyshev pieces, cubic and quintic Hermite polynomials, integrals of straight lines."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import FloatArray

N_CHEBYSHEV_NODES = 12
"""Number of nodes, and of coefficients, of a piece."""

CHEBYSHEV_NODES = -np.cos(np.pi * (np.arange(N_CHEBYSHEV_NODES) + 0.5) / N_CHEBYSHEV_NODES)
"""Nodes, ascending in (-1, 1): zeros of a Chebyshev polynomial, so that no node is at an end; shape (N_CHEBYSHEV_NODES,)."""

BARYCENTRIC_WEIGHTS = (-1.0) ** np.arange(N_CHEBYSHEV_NODES) * np.sin(np.pi * (np.arange(N_CHEBYSHEV_NODES) + 0.5) / N_CHEBYSHEV_NODES)
"""Weights of the barycentric formula for these nodes; shape (N_CHEBYSHEV_NODES,)."""

STAGNATION_RATIO = 0.1
"""Ratio of the last two coefficients to the three before them above which a fit no longer converges."""


def _chebyshev_polynomials(one: FloatArray, multiply_by_coordinate: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Return Chebyshev polynomials as rows, of ascending degree, in a form in which the first is `one`."""
    rows = [one, multiply_by_coordinate(one)]
    while len(rows) < N_CHEBYSHEV_NODES:
        rows.append(2.0 * multiply_by_coordinate(rows[-1]) - rows[-2])
    return np.array(rows)


_CHEBYSHEV_TRANSFORM = _chebyshev_polynomials(np.ones(N_CHEBYSHEV_NODES), lambda row: CHEBYSHEV_NODES * row) * (2.0 / N_CHEBYSHEV_NODES)
_CHEBYSHEV_TRANSFORM[0] *= 0.5
VALUES_TO_CHEBYSHEV = np.ascontiguousarray(_CHEBYSHEV_TRANSFORM)
"""Matrix that maps values at the nodes to Chebyshev coefficients."""

# Its rounding error stays small, because the high Chebyshev coefficients of a good fit are small.
CHEBYSHEV_TO_POWERS = np.ascontiguousarray(_chebyshev_polynomials(np.eye(N_CHEBYSHEV_NODES)[0], lambda row: np.roll(row, 1)).T)
"""Matrix that maps Chebyshev coefficients to those of powers, lowest first."""


@jit
def fit_piece(
    values: FloatArray,  # values at the nodes; shape (N_CHEBYSHEV_NODES,)
    coefficients: FloatArray,  # result: coefficients of powers, lowest first; shape (N_CHEBYSHEV_NODES,)
) -> tuple[float, bool]:
    """Fit a polynomial to values at nodes; return the larger of its last two coefficients, its error, and whether that is rounding."""
    chebyshev_coefficients = np.empty(N_CHEBYSHEV_NODES)
    for k in range(N_CHEBYSHEV_NODES):
        total = 0.0
        for j in range(N_CHEBYSHEV_NODES):
            total += VALUES_TO_CHEBYSHEV[k, j] * values[j]
        chebyshev_coefficients[k] = total
    for k in range(N_CHEBYSHEV_NODES):
        total = 0.0
        for j in range(k, N_CHEBYSHEV_NODES):
            total += CHEBYSHEV_TO_POWERS[k, j] * chebyshev_coefficients[j]
        coefficients[k] = total
    truncation_error = max(abs(chebyshev_coefficients[N_CHEBYSHEV_NODES - 2]), abs(chebyshev_coefficients[N_CHEBYSHEV_NODES - 1]))
    preceding_terms = max(
        abs(chebyshev_coefficients[N_CHEBYSHEV_NODES - 5]),
        abs(chebyshev_coefficients[N_CHEBYSHEV_NODES - 4]),
        abs(chebyshev_coefficients[N_CHEBYSHEV_NODES - 3]),
    )
    return truncation_error, truncation_error > STAGNATION_RATIO * preceding_terms


@jit_in_place
def evaluate_piece(table: FloatArray, piece: int, column: int, t: float) -> float:
    """Return the polynomial table[piece, column] at t, -1 to 1."""
    # The sum is a tree, because each sum of Horner's scheme would wait for the one before it.
    t2 = t * t
    t4 = t2 * t2
    low = (table[piece, column, 0] + table[piece, column, 1] * t) + (table[piece, column, 2] + table[piece, column, 3] * t) * t2
    middle = (table[piece, column, 4] + table[piece, column, 5] * t) + (table[piece, column, 6] + table[piece, column, 7] * t) * t2
    high = (table[piece, column, 8] + table[piece, column, 9] * t) + (table[piece, column, 10] + table[piece, column, 11] * t) * t2
    return float(low + (middle + high * t4) * t4)


@jit_in_place
def evaluate_piece_derivative(table: FloatArray, piece: int, column: int, t: float) -> float:
    """Return the derivative of the polynomial table[piece, column] at t, -1 to 1."""
    total = 0.0
    for power in range(N_CHEBYSHEV_NODES - 1, 0, -1):
        total = total * t + power * table[piece, column, power]
    return float(total)


@jit_in_place
def barycentric_weights(
    t: float,
    weights: FloatArray,  # result: the weights; shape (N_CHEBYSHEV_NODES,)
) -> None:
    """Evaluate the weights with which the values at the nodes sum to the polynomial's value at t."""
    total = 0.0
    for k in range(N_CHEBYSHEV_NODES):
        difference = t - CHEBYSHEV_NODES[k]
        if difference == 0.0:
            weights[:] = 0.0
            weights[k] = 1.0
            return
        weights[k] = BARYCENTRIC_WEIGHTS[k] / difference
        total += weights[k]
    for k in range(N_CHEBYSHEV_NODES):
        weights[k] /= total


def cubic_hermite(start: Any, end: Any, start_derivative: Any, end_derivative: Any, length: Any, fraction: Any) -> Any:
    """Interpolate by the cubic through values and derivatives at both ends; arguments broadcast."""
    d0 = length * start_derivative
    d1 = length * end_derivative
    change = end - start
    return start + fraction * (d0 + fraction * (3 * change - 2 * d0 - d1 + fraction * (d0 + d1 - 2 * change)))


cubic_hermite_jit = jit_in_place(cubic_hermite)


def interpolate_samples(positions: FloatArray, values: FloatArray, derivatives: FloatArray, at: ArrayLike) -> FloatArray:
    """Return values (m, ...) at positions (m,) by cubics through values and derivatives (n, ...) at positions (n,), beyond them too."""
    points = np.asarray(at, dtype=float)
    start = np.clip(np.searchsorted(positions, points, side="right") - 1, 0, len(positions) - 2)
    end = start + 1
    lengths = positions[end] - positions[start]
    fractions = (points - positions[start]) / lengths
    shape = (*points.shape, *[1] * (values.ndim - 1))
    interpolated: FloatArray = cubic_hermite(
        values[start], values[end], derivatives[start], derivatives[end], lengths.reshape(shape), fractions.reshape(shape)
    )
    return interpolated


def integrate_samples(positions: FloatArray, values: FloatArray) -> FloatArray:
    """Return the integrals (n,) from the first position (n,) to each of the straight lines between values (n,)."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(positions))])


def cubic_hermite_derivative(start: Any, end: Any, start_derivative: Any, end_derivative: Any, length: Any, fraction: Any) -> Any:
    """Return the derivative of `cubic_hermite` by the position, for the same arguments."""
    d0 = length * start_derivative
    d1 = length * end_derivative
    change = end - start
    return (d0 + fraction * (2 * (3 * change - 2 * d0 - d1) + fraction * 3 * (d0 + d1 - 2 * change))) / length


def quintic_hermite(
    start: Any,
    start_rate: Any,
    start_acceleration: Any,
    end: Any,
    end_rate: Any,
    end_acceleration: Any,
    h: Any,  # length of the interval, s
    fraction: Any,
) -> tuple[Any, Any]:
    """Return value and rate of the quintic through values, rates and accelerations at both ends; arguments broadcast."""
    c1 = h * start_rate
    c2 = h * h * start_acceleration
    p = fraction
    value_residual = end - start - c1 - 0.5 * c2
    rate_residual = h * end_rate - c1 - c2
    acceleration_residual = h * h * end_acceleration - c2
    c3 = 10 * value_residual - 4 * rate_residual + 0.5 * acceleration_residual
    c4 = -15 * value_residual + 7 * rate_residual - acceleration_residual
    c5 = 6 * value_residual - 3 * rate_residual + 0.5 * acceleration_residual
    value = start + p * (c1 + p * (0.5 * c2 + p * (c3 + p * (c4 + p * c5))))
    return value, (c1 + p * (c2 + p * (3 * c3 + p * (4 * c4 + p * 5 * c5)))) / h


quintic_hermite_jit = jit_in_place(quintic_hermite)
