"""Functions of one number as polynomials of degree eleven, piece by piece: fitted at Chebyshev's nodes, compiled.

A piece is known by its values at NODES, where they were reckoned, and by its coefficients in powers of the way from the
piece's middle (-1 to 1), which are quicker.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from governor_mechanism.numerics.jit import inlined, kernel
from governor_mechanism.types import FloatArray

COUNT = 12
"""Nodes, and coefficients, of a piece."""

NODES = -np.cos(np.pi * (np.arange(COUNT) + 0.5) / COUNT)
"""(COUNT,) ascending, from -1 to 1: zeros of a Chebyshev polynomial, so none is an end."""

WEIGHTS = (-1.0) ** np.arange(COUNT) * np.sin(np.pi * (np.arange(COUNT) + 0.5) / COUNT)
"""(COUNT,) of the barycentric formula for these nodes."""

LEVEL = 0.1
"""A fit whose last two terms are no smaller than this part of the three before them has stopped falling."""

_TERMS = chebyshev.chebvander(NODES, COUNT - 1).T * (2.0 / COUNT)
_TERMS[0] *= 0.5
TO_CHEBYSHEV = np.ascontiguousarray(_TERMS)
"""Values at the nodes to coefficients of Chebyshev polynomials."""

TO_POWERS = np.ascontiguousarray(
    np.array([np.pad(chebyshev.cheb2poly(one), (0, COUNT))[:COUNT] for one in np.eye(COUNT)]).T
)
"""Those to coefficients of powers, lowest first. Rounding stays small because the high ones of a good fit are."""


@kernel
def fitted(values: FloatArray, coefficients: FloatArray) -> tuple[float, bool]:
    """Fill coefficients (COUNT,) of powers from values (COUNT,) at the nodes.

    The size of what the fit leaves out, and whether it has stopped falling from term to term: then it is rounding.
    """
    found = np.empty(COUNT)
    for k in range(COUNT):
        total = 0.0
        for j in range(COUNT):
            total += TO_CHEBYSHEV[k, j] * values[j]
        found[k] = total
    for k in range(COUNT):
        total = 0.0
        for j in range(k, COUNT):
            total += TO_POWERS[k, j] * found[j]
        coefficients[k] = total
    left = max(abs(found[COUNT - 2]), abs(found[COUNT - 1]))
    before = max(abs(found[COUNT - 5]), abs(found[COUNT - 4]), abs(found[COUNT - 3]))
    return left, left > LEVEL * before


def _powers(table: FloatArray, piece: int, column: int, t: float) -> float:
    """The polynomial table[piece, column] at t, summed in a tree: a chain would wait for each of its sums."""
    t2 = t * t
    t4 = t2 * t2
    low = (table[piece, column, 0] + table[piece, column, 1] * t) + (
        table[piece, column, 2] + table[piece, column, 3] * t
    ) * t2
    middle = (table[piece, column, 4] + table[piece, column, 5] * t) + (
        table[piece, column, 6] + table[piece, column, 7] * t
    ) * t2
    high = (table[piece, column, 8] + table[piece, column, 9] * t) + (
        table[piece, column, 10] + table[piece, column, 11] * t
    ) * t2
    return float(low + (middle + high * t4) * t4)


powers = kernel(_powers)
powers_inlined = inlined(_powers)
"""The same for the innermost loop, where even a call costs."""


@kernel
def weighed(t: float, weights: FloatArray) -> None:
    """Fill weights (COUNT,) so that their sum with values at the nodes is the fit's value at t."""
    total = 0.0
    for k in range(COUNT):
        apart = t - NODES[k]
        if apart == 0.0:
            weights[:] = 0.0
            weights[k] = 1.0
            return
        weights[k] = WEIGHTS[k] / apart
        total += weights[k]
    for k in range(COUNT):
        weights[k] /= total
