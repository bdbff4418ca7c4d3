"""Linear equations of an assembly: the smallest change that meets them, and how many of them are independent.

A few are solved as they stand, by singular values. Of many each speaks of two bodies only and leaves most of a matrix
empty: they are factorised as a sparse matrix, whose cost grows as the mechanism does, unless a pivot says that
equations depend on each other.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from governor_mechanism.types import FloatArray

MIN_SPARSE_ROWS = 48
"""Equations from which on a sparse factorisation pays."""

RANK_TOLERANCE = 1e-9
"""Singular values of scaled equations below this fraction of the largest one belong to dependent ones."""

MIN_SPARSE_PIVOT_RATIO = 1e-9
"""Pivots above this fraction of their diagonal, the square of a sine, leave no doubt that equations are independent.

Rounding makes 1e-16 of it; a chain of pivots loses some digits more.
"""


def least_norm_solution(rows: FloatArray, rhs: FloatArray) -> FloatArray:
    """The shortest x of those that come nearest to rows . x = right; rows (equations, unknowns)."""
    if len(rows) >= MIN_SPARSE_ROWS:
        factorisation = _factorise_normal_matrix(rows)
        if factorisation is not None:
            matrix, solve = factorisation
            solution: FloatArray = matrix.T @ solve(rhs)
            solution += matrix.T @ solve(rhs - matrix @ solution)  # products square the condition; this mends it
            return solution
    return np.asarray(np.linalg.lstsq(rows, rhs, rcond=None)[0], dtype=np.float64)


def numerical_rank(rows: FloatArray) -> int:
    """How many of these scaled equations are independent."""
    if not rows.size:
        return 0
    if len(rows) >= MIN_SPARSE_ROWS and _factorise_normal_matrix(rows) is not None:
        return len(rows)
    singular_values = np.linalg.svd(rows, compute_uv=False)
    return int(np.sum(singular_values > RANK_TOLERANCE * singular_values[0]))


def mass_weighted_least_norm(rows: FloatArray, masses: FloatArray, rhs: FloatArray) -> FloatArray | None:
    """The x of least sum(masses x^2) with rows . x = wanted, of many equations; None where they depend on each other.

    Masses (unknowns,) may be 0 where the equations settle what they belong to.
    """
    from scipy.sparse import block_array, csr_array, diags_array
    from scipy.sparse.linalg import splu

    matrix = csr_array(rows)
    kkt_matrix = block_array([[diags_array(masses), matrix.T], [matrix, None]], format="csc")
    kkt_rhs = np.concatenate([np.zeros(len(masses)), rhs])
    try:
        kkt_solution = splu(kkt_matrix).solve(kkt_rhs)
    except RuntimeError:  # singular
        return None
    solution: FloatArray = kkt_solution[: len(masses)]
    residual_scale = float(np.max(np.abs(rows) @ np.abs(solution), initial=0.0))
    is_satisfied = np.max(np.abs(matrix @ solution - rhs), initial=0.0) <= RANK_TOLERANCE * residual_scale
    return solution if is_satisfied and np.all(np.isfinite(kkt_solution)) else None


def _factorise_normal_matrix(rows: FloatArray) -> tuple[Any, Any] | None:
    """The rows as a sparse matrix, and what solves rows . rows^T; None where they are not clearly independent."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    matrix = csr_array(rows)
    normal_matrix = (matrix @ matrix.T).tocsc()
    diagonal = normal_matrix.diagonal()
    if not (np.all(np.isfinite(normal_matrix.data)) and np.all(diagonal > 0)):
        return None
    try:
        factorisation = splu(normal_matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is nothing at all
        return None
    pivots = factorisation.U.diagonal() / diagonal[np.argsort(factorisation.perm_c)]
    return (matrix, factorisation.solve) if np.min(pivots) > MIN_SPARSE_PIVOT_RATIO else None
