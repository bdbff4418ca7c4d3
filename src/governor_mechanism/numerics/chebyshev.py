"""Functions of one number as polynomials of degree eleven, piece by piece: fitted at Chebyshev's nodes, compiled.

A piece is known by its values at NODES, where they were reckoned, and by its coefficients in powers of the way from the
piece's middle (-1 to 1), which are quicker.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from governor_mechanism.numerics.jit import jit_inline, jit_internal
from governor_mechanism.types import FloatArray

N_CHEBYSHEV_NODES = 12
"""Nodes, and coefficients, of a piece."""

CHEBYSHEV_NODES = -np.cos(np.pi * (np.arange(N_CHEBYSHEV_NODES) + 0.5) / N_CHEBYSHEV_NODES)
"""(COUNT,) ascending, from -1 to 1: zeros of a Chebyshev polynomial, so none is an end."""

BARYCENTRIC_WEIGHTS = (-1.0) ** np.arange(N_CHEBYSHEV_NODES) * np.sin(np.pi * (np.arange(N_CHEBYSHEV_NODES) + 0.5) / N_CHEBYSHEV_NODES)
"""(COUNT,) of the barycentric formula for these nodes."""

STAGNATION_RATIO = 0.1
"""A fit whose last two terms are no smaller than this part of the three before them has stopped falling."""

_CHEBYSHEV_TRANSFORM = chebyshev.chebvander(CHEBYSHEV_NODES, N_CHEBYSHEV_NODES - 1).T * (2.0 / N_CHEBYSHEV_NODES)
_CHEBYSHEV_TRANSFORM[0] *= 0.5
VALUES_TO_CHEBYSHEV = np.ascontiguousarray(_CHEBYSHEV_TRANSFORM)
"""Values at the nodes to coefficients of Chebyshev polynomials."""

CHEBYSHEV_TO_POWERS = np.ascontiguousarray(
    np.array([np.pad(chebyshev.cheb2poly(one), (0, N_CHEBYSHEV_NODES))[:N_CHEBYSHEV_NODES] for one in np.eye(N_CHEBYSHEV_NODES)]).T
)
"""Those to coefficients of powers, lowest first. Rounding stays small because the high ones of a good fit are."""


@jit_internal
def fit_piece(values: FloatArray, coefficients: FloatArray) -> tuple[float, bool]:
    """Fill coefficients (COUNT,) of powers from values (COUNT,) at the nodes.

    The size of what the fit leaves out, and whether it has stopped falling from term to term: then it is rounding.
    """
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


def _evaluate_piece(table: FloatArray, piece: int, column: int, t: float) -> float:
    """The polynomial table[piece, column] at t, summed in a tree: a chain would wait for each of its sums."""
    t2 = t * t
    t4 = t2 * t2
    low = (table[piece, column, 0] + table[piece, column, 1] * t) + (table[piece, column, 2] + table[piece, column, 3] * t) * t2
    middle = (table[piece, column, 4] + table[piece, column, 5] * t) + (table[piece, column, 6] + table[piece, column, 7] * t) * t2
    high = (table[piece, column, 8] + table[piece, column, 9] * t) + (table[piece, column, 10] + table[piece, column, 11] * t) * t2
    return float(low + (middle + high * t4) * t4)


evaluate_piece = jit_internal(_evaluate_piece)
evaluate_piece_inline = jit_inline(_evaluate_piece)
"""The same for the innermost loop, where even a call costs."""


@jit_internal
def barycentric_weights(t: float, weights: FloatArray) -> None:
    """Fill weights (COUNT,) so that their sum with values at the nodes is the fit's value at t."""
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
