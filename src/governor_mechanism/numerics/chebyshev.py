"""Piecewise polynomials of degree eleven, by values at CHEBYSHEV_NODES and coefficients of powers from -1 to 1; compiled kernels."""

from collections.abc import Callable

import numpy as np

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
