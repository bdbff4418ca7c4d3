"""Cholesky factorisation of a symmetric band matrix, with a least-norm solution for singular matrices, as compiled kernels."""

import math

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

MIN_BAND_PIVOT_RATIO = 1e-12
"""Pivot relative to its diagonal entry below which it counts as zero: the matrix is singular."""

MAX_JACOBI_SWEEPS = 30
"""Largest number of sweeps of the Jacobi method; six to ten diagonalise a matrix."""

JACOBI_TOLERANCE = 1e-17
"""Entry relative to the geometric mean of its diagonal entries that counts as zero."""


@jit_in_place
def factorise_band(band: FloatArray, factor: FloatArray) -> float:
    """Factorise a band matrix by Cholesky, with the inverse of the diagonal, and return the smallest pivot ratio.

    The pivot ratio is a pivot relative to its diagonal entry; 0 if a pivot vanishes.
    """
    bandwidth, min_pivot_ratio = band.shape[1] - 1, 1.0
    for i in range(band.shape[0]):
        first = max(0, i - bandwidth)
        for j in range(first, i + 1):
            total = band[i, bandwidth - (i - j)]
            for k in range(max(first, j - bandwidth), j):
                total -= factor[i, bandwidth - (i - k)] * factor[j, bandwidth - (j - k)]
            if i > j:
                factor[i, bandwidth - (i - j)] = total * factor[j, bandwidth]
            elif total > MIN_BAND_PIVOT_RATIO * band[i, bandwidth]:
                factor[i, bandwidth] = 1.0 / math.sqrt(total)
                min_pivot_ratio = min(min_pivot_ratio, total / band[i, bandwidth])
            else:
                return 0.0
    return min_pivot_ratio


@jit_in_place
def solve_factorised_band(factor: FloatArray, vector: FloatArray) -> None:
    """Solve in place with the band Cholesky factor."""
    bandwidth, n_rows = factor.shape[1] - 1, vector.size
    for i in range(n_rows):
        total = vector[i]
        for k in range(max(0, i - bandwidth), i):
            total -= factor[i, bandwidth - (i - k)] * vector[k]
        vector[i] = total * factor[i, bandwidth]
    for i in range(n_rows - 1, -1, -1):
        total = vector[i]
        for k in range(i + 1, min(n_rows, i + bandwidth + 1)):
            total -= factor[k, bandwidth - (k - i)] * vector[k]
        vector[i] = total * factor[i, bandwidth]


@jit_in_place
def solve_band_system(
    band: FloatArray,  # lower band: entry (i, i - k) is at [i, bandwidth - k]; shape (rows, bandwidth + 1)
    factor: FloatArray,  # workspace for the Cholesky factor, with the shape of `band`
    eigen: FloatArray,  # workspace for the eigenproblem of a singular matrix; shape (2, rows, rows)
    vector: FloatArray,  # right-hand side; replaced by the solution; shape (rows,)
) -> float:
    """Solve a symmetric, positive semidefinite band system in place; with the least-norm solution if it is singular.

    Result: smallest pivot relative to its diagonal entry; 0 if a pivot vanishes. For J M^-1 J^T it is about
    the square of the angle (rad) of a row of J to the span of the others.
    """
    min_pivot_ratio = factorise_band(band, factor)
    if min_pivot_ratio > 0.0:
        solve_factorised_band(factor, vector)
        return min_pivot_ratio
    _solve_least_norm(band, eigen, vector)
    return 0.0


@jit_in_place
def _solve_least_norm(band: FloatArray, eigen: FloatArray, vector: FloatArray) -> None:
    """Replace vector by the least-norm solution of a singular band system."""
    n_rows, bandwidth = band.shape[0], band.shape[1] - 1
    matrix, eigenvectors = eigen[0], eigen[1]
    matrix[:] = 0.0
    for i in range(n_rows):
        for k in range(max(0, i - bandwidth), i + 1):
            matrix[i, k] = matrix[k, i] = band[i, bandwidth - (i - k)]
            if not math.isfinite(matrix[i, k]):  # callers check for NaN
                vector[:] = math.nan
                return
    diagonalise(matrix, eigenvectors)
    largest = 0.0
    for k in range(n_rows):
        largest = max(largest, matrix[k, k])
    for k in range(n_rows):
        projection = 0.0
        for i in range(n_rows):
            projection += eigenvectors[i, k] * vector[i]
        # The component of the solution along each eigenvector takes the place of the eigenvalue.
        matrix[k, k] = projection / matrix[k, k] if matrix[k, k] > MIN_BAND_PIVOT_RATIO * largest else 0.0
    vector[:] = 0.0
    for k in range(n_rows):
        for i in range(n_rows):
            vector[i] += eigenvectors[i, k] * matrix[k, k]


@jit_in_place
def diagonalise(matrix: FloatArray, eigenvectors: FloatArray) -> None:
    """Diagonalise a symmetric matrix in place by the cyclic Jacobi method; its eigenvectors become columns.

    G. H. Golub, C. F. Van Loan, Matrix Computations, 3rd edition 1996, section 8.4.
    """
    n_rows = matrix.shape[0]
    for i in range(n_rows):
        for k in range(n_rows):
            eigenvectors[i, k] = 1.0 if i == k else 0.0
    for _ in range(MAX_JACOBI_SWEEPS):
        n_rotations = 0
        for p in range(n_rows - 1):
            for q in range(p + 1, n_rows):
                if abs(matrix[p, q]) > JACOBI_TOLERANCE * math.sqrt(abs(matrix[p, p] * matrix[q, q])):
                    _rotate(matrix, eigenvectors, p, q)
                    n_rotations += 1
        if n_rotations == 0:
            return


@jit_in_place
def _rotate(matrix: FloatArray, eigenvectors: FloatArray, p: int, q: int) -> None:
    """Rotate rows and columns p and q of a symmetric matrix so that the entry at both vanishes."""
    ratio = (matrix[q, q] - matrix[p, p]) / (2.0 * matrix[p, q])
    tangent = (1.0 if ratio >= 0.0 else -1.0) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = tangent * cosine
    for i in range(matrix.shape[0]):
        at_p, at_q = matrix[i, p], matrix[i, q]
        matrix[i, p], matrix[i, q] = cosine * at_p - sine * at_q, sine * at_p + cosine * at_q
    for i in range(matrix.shape[0]):
        at_p, at_q = matrix[p, i], matrix[q, i]
        matrix[p, i], matrix[q, i] = cosine * at_p - sine * at_q, sine * at_p + cosine * at_q
        vector_p, vector_q = eigenvectors[i, p], eigenvectors[i, q]
        eigenvectors[i, p], eigenvectors[i, q] = cosine * vector_p - sine * vector_q, sine * vector_p + cosine * vector_q
    matrix[p, q] = matrix[q, p] = 0.0
