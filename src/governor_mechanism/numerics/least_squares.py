"""Linear equations of an assembly: the smallest change that meets them, and how many of them are independent.

A few are solved as they stand, by singular values. Of many each speaks of two bodies only and leaves most of a matrix
empty: they are factorised as a sparse matrix, whose cost grows as the mechanism does, unless a pivot says that
equations depend on each other.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from governor_mechanism.types import FloatArray

MANY = 48
"""Equations from which on a sparse factorisation pays."""

INDEPENDENT = 1e-9
"""Singular values of scaled equations below this fraction of the largest one belong to dependent ones."""

CLEAR = 1e-9
"""Pivots above this fraction of their diagonal, the square of a sine, leave no doubt that equations are independent.

Rounding makes 1e-16 of it; a chain of pivots loses some digits more.
"""


def smallest_change(rows: FloatArray, right: FloatArray) -> FloatArray:
    """The shortest x of those that come nearest to rows . x = right; rows (equations, unknowns)."""
    if len(rows) >= MANY:
        factor = _factor(rows)
        if factor is not None:
            matrix, solve = factor
            found: FloatArray = matrix.T @ solve(right)
            found += matrix.T @ solve(right - matrix @ found)  # products square the condition; this mends it
            return found
    return np.asarray(np.linalg.lstsq(rows, right, rcond=None)[0], dtype=np.float64)


def rank(rows: FloatArray) -> int:
    """How many of these scaled equations are independent."""
    if not rows.size:
        return 0
    if len(rows) >= MANY and _factor(rows) is not None:
        return len(rows)
    values = np.linalg.svd(rows, compute_uv=False)
    return int(np.sum(values > INDEPENDENT * values[0]))


def lightest_change(rows: FloatArray, masses: FloatArray, wanted: FloatArray) -> FloatArray | None:
    """The x of least sum(masses x^2) with rows . x = wanted, of many equations; None where they depend on each other.

    Masses (unknowns,) may be 0 where the equations settle what they belong to.
    """
    from scipy.sparse import block_array, csr_array, diags_array
    from scipy.sparse.linalg import splu

    matrix = csr_array(rows)
    system = block_array([[diags_array(masses), matrix.T], [matrix, None]], format="csc")
    right = np.concatenate([np.zeros(len(masses)), wanted])
    try:
        found = splu(system).solve(right)
    except RuntimeError:  # singular
        return None
    change: FloatArray = found[: len(masses)]
    scale = float(np.max(np.abs(rows) @ np.abs(change), initial=0.0))
    met = np.max(np.abs(matrix @ change - wanted), initial=0.0) <= INDEPENDENT * scale
    return change if met and np.all(np.isfinite(found)) else None


def _factor(rows: FloatArray) -> tuple[Any, Any] | None:
    """The rows as a sparse matrix, and what solves rows . rows^T; None where they are not clearly independent."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    matrix = csr_array(rows)
    products = (matrix @ matrix.T).tocsc()
    diagonal = products.diagonal()
    if not (np.all(np.isfinite(products.data)) and np.all(diagonal > 0)):
        return None
    try:
        factor = splu(products, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is nothing at all
        return None
    pivots = factor.U.diagonal() / diagonal[np.argsort(factor.perm_c)]
    return (matrix, factor.solve) if np.min(pivots) > CLEAR else None
