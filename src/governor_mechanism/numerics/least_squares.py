"""Least-norm solutions and numerical rank of underdetermined linear equations.

Small systems are solved by singular values. In large systems each equation concerns two bodies only and most of the
matrix is zero: they are solved by a sparse factorisation, whose cost grows in proportion to the mechanism, unless a
pivot shows that equations may be linearly dependent.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from governor_mechanism.types import FloatArray

MIN_SPARSE_ROWS = 48
"""Number of equations from which a sparse factorisation is faster."""

MIN_SPARSE_SPECTRUM_ROWS = 200
"""Number of equations from which their extreme singular values are found faster without the others."""

AUGMENTATION_SCALE = 1e-3
"""Scale of the first search for the smallest singular value, relative to the largest, and how much less than its scale it may be."""

LARGEST_TOLERANCE = 1e-4
"""Tolerance of the vector of the largest singular value, whose own error is smaller: it is only the scale of the smallest one."""

RANK_TOLERANCE = 1e-9
"""Singular value of scaled equations, relative to the largest, below which it counts as zero."""

# Rounding alone gives 1e-16; a chain of pivots loses a few digits more.
MIN_SPARSE_PIVOT_RATIO = 1e-9
"""Pivot relative to its diagonal entry (the square of a sine) above which equations are certainly independent."""


def least_norm_solution(
    rows: Any,  # coefficients, an array or a sparse one; shape (equations, unknowns)
    rhs: FloatArray,  # right-hand side; shape (equations,)
) -> FloatArray:
    """Return the shortest (unknowns,) of the least-squares solutions of rows * x = rhs."""
    if rows.shape[0] >= MIN_SPARSE_ROWS:
        factorisation = _factorise_normal_matrix(rows)
        if factorisation is not None:
            matrix, solve = factorisation
            solution: FloatArray = matrix.T @ solve(rhs)
            solution += matrix.T @ solve(
                rhs - matrix @ solution
            )  # rows * rows^T squares the condition number; one refinement restores the digits
            return solution
    return np.asarray(np.linalg.lstsq(_dense(rows), rhs, rcond=None)[0], dtype=np.float64)


def numerical_rank(
    rows: Any,  # coefficients of scaled equations, an array or a sparse one; shape (equations, unknowns)
) -> int:
    """Return the number of linearly independent equations."""
    n_rows: int = rows.shape[0]
    if not rows.size:
        return 0
    if n_rows >= MIN_SPARSE_ROWS and _factorise_normal_matrix(rows) is not None:
        return n_rows
    singular_values = np.linalg.svd(_dense(rows), compute_uv=False)
    return int(np.sum(singular_values > RANK_TOLERANCE * singular_values[0]))


def singular_value_ratio(
    rows: FloatArray,  # coefficients of scaled equations; shape (equations, unknowns)
) -> float:
    """Return the smallest singular value over the largest."""
    if MIN_SPARSE_SPECTRUM_ROWS <= len(rows) <= rows.shape[1]:
        with suppress(RuntimeError):  # a pivot is exactly 0, or the iteration does not converge
            return _sparse_singular_value_ratio(rows)
    singular_values = np.linalg.svd(rows, compute_uv=False)
    return float(singular_values[-1] / singular_values[0])


def _sparse_singular_value_ratio(rows: FloatArray) -> float:
    """Return the smallest singular value over the largest, by Lanczos' iteration with rows * rows^T and with its inverse."""
    from scipy.sparse import csr_array  # slow to import

    matrix, transposed = csr_array(rows), csr_array(rows.T)
    largest = math.sqrt(_largest_eigenvalue(lambda vector: matrix @ (transposed @ vector), len(rows), LARGEST_TOLERANCE))
    scale = smallest = AUGMENTATION_SCALE * largest
    for _ in range(2):
        smallest = _smallest_singular_value(matrix, scale)
        if smallest > AUGMENTATION_SCALE * scale:
            break
        scale = smallest
    return smallest / largest


def _smallest_singular_value(matrix: Any, scale: float) -> float:
    """Return the smallest singular value of a sparse matrix, to most digits if it is not much less than the scale."""
    # Its product with its transpose would lose half of them. Augmented equations, with the scale on
    # their diagonal, have the same solution.
    from scipy.sparse import block_array, eye_array
    from scipy.sparse.linalg import splu

    n_rows, n_unknowns = matrix.shape
    factorisation = splu(block_array([[scale * eye_array(n_unknowns), matrix.T], [matrix, None]]).tocsc())

    def divide(vector: FloatArray) -> FloatArray:
        solution: FloatArray = factorisation.solve(np.concatenate([np.zeros(n_unknowns), vector]))
        return -solution[n_unknowns:] / scale

    return 1.0 / math.sqrt(_largest_eigenvalue(divide, n_rows, 0.0))


def _largest_eigenvalue(multiply: Callable[[FloatArray], FloatArray], n_rows: int, tolerance: float) -> float:
    """Return the largest eigenvalue of a symmetric matrix that multiplies vectors (n_rows,); 0 as a tolerance means rounding."""
    from scipy.sparse.linalg import LinearOperator, eigsh

    operator = LinearOperator((n_rows, n_rows), matvec=multiply, dtype=np.float64)
    first = np.ones(n_rows)  # a random one would give other digits each time
    return float(eigsh(operator, k=1, which="LA", v0=first, tol=tolerance, return_eigenvectors=False)[0])


def find_single_free_direction(
    rows: FloatArray,  # coefficients of scaled equations; shape (equations, unknowns)
) -> FloatArray | None:
    """Return the unit vector (unknowns,) along which rows * x = 0 if there is only one such direction, else None."""
    n_unknowns = rows.shape[1]
    if n_unknowns - len(rows) > 1 or (len(rows) >= MIN_SPARSE_ROWS and n_unknowns - numerical_rank(rows) != 1):
        return None
    _, singular_values, directions = np.linalg.svd(rows)
    rank = int(np.sum(singular_values > RANK_TOLERANCE * np.max(singular_values, initial=0.0)))
    return directions[-1] if n_unknowns - rank == 1 else None


def _dense(rows: Any) -> FloatArray:
    """Return rows, which may be a sparse array, as an array."""
    array: FloatArray = rows if isinstance(rows, np.ndarray) else rows.toarray()
    return array


def _factorise_normal_matrix(rows: Any) -> tuple[Any, Any] | None:
    """Return rows as a sparse matrix, and a solver for rows * rows^T; None if they are not certainly independent."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    matrix = csr_array(rows)
    normal_matrix = (matrix @ matrix.T).tocsc()
    diagonal = normal_matrix.diagonal()
    if not (np.all(np.isfinite(normal_matrix.data)) and np.all(diagonal > 0)):
        return None
    try:
        factorisation = splu(normal_matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is exactly 0
        return None
    pivots = factorisation.U.diagonal() / diagonal[np.argsort(factorisation.perm_c)]
    return (matrix, factorisation.solve) if np.min(pivots) > MIN_SPARSE_PIVOT_RATIO else None
