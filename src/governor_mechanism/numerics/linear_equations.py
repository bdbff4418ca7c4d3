"""Linear equations in kernels: a symmetric band by Cholesky, with a least-norm solution if it is singular, and a few dense ones."""

import math

from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place, jit_inlined
from governor_mechanism.types import FloatArray

MIN_BAND_PIVOT_RATIO = 1e-12
"""Pivot relative to its diagonal entry below which it counts as zero: the matrix is singular."""

MAX_JACOBI_SWEEPS = 30
"""Largest number of sweeps of the Jacobi method; six to ten diagonalise a matrix."""

JACOBI_TOLERANCE = 1e-17
"""Entry relative to the geometric mean of its diagonal entries that counts as zero."""


@jit_inlined
def factorise_band(band: FloatArray, factor: FloatArray) -> float:
    """Factorise a band matrix by Cholesky, with inverse diagonal; return the smallest pivot relative to its entry, 0 if one vanishes."""
    # The entries of a column are next to each other.
    (n_rows, width), min_pivot_ratio = band.shape, 1.0
    copy_array(factor, band)
    for j in range(n_rows):
        pivot = factor[j, 0]
        if not pivot > MIN_BAND_PIVOT_RATIO * band[j, 0]:
            return 0.0
        min_pivot_ratio = min(min_pivot_ratio, pivot / band[j, 0])
        inverse, n_entries = 1.0 / math.sqrt(pivot), min(width, n_rows - j)
        factor[j, 0] = inverse
        for k in range(1, n_entries):
            factor[j, k] *= inverse
        for i in range(1, n_entries):
            multiplier = factor[j, i]
            if multiplier != 0.0:  # few rows of a mechanism are coupled with all their neighbours
                for k in range(n_entries - i):
                    factor[j + i, k] -= multiplier * factor[j, i + k]
    return min_pivot_ratio


@jit_in_place
def solve_factorised_band(factor: FloatArray, vector: FloatArray) -> None:
    """Solve in place with the band Cholesky factor."""
    n_rows, width = factor.shape
    for j in range(n_rows):
        vector[j] *= factor[j, 0]
        for k in range(1, min(width, n_rows - j)):
            vector[j + k] -= factor[j, k] * vector[j]
    for j in range(n_rows - 1, -1, -1):
        total = vector[j]
        for k in range(1, min(width, n_rows - j)):
            total -= factor[j, k] * vector[j + k]
        vector[j] = total * factor[j, 0]


@jit_inlined
def solve_band_system(
    band: FloatArray,  # lower band by columns: entry (j + k, j) is at [j, k]; shape (rows, bandwidth + 1)
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
    n_rows, width = band.shape
    matrix, eigenvectors = eigen[0], eigen[1]
    matrix[:] = 0.0
    for j in range(n_rows):
        for k in range(min(width, n_rows - j)):
            matrix[j + k, j] = matrix[j, j + k] = band[j, k]
            if not math.isfinite(band[j, k]):  # callers check for NaN
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
        matrix[i, p] = cosine * at_p - sine * at_q
        matrix[i, q] = sine * at_p + cosine * at_q
    for i in range(matrix.shape[0]):
        at_p, at_q = matrix[p, i], matrix[q, i]
        matrix[p, i] = cosine * at_p - sine * at_q
        matrix[q, i] = sine * at_p + cosine * at_q
        vector_p, vector_q = eigenvectors[i, p], eigenvectors[i, q]
        eigenvectors[i, p] = cosine * vector_p - sine * vector_q
        eigenvectors[i, q] = sine * vector_p + cosine * vector_q
    matrix[p, q] = matrix[q, p] = 0.0


MIN_PIVOT = 1e-11
"""Pivot below which an unknown is not determined; coefficients are of order 1."""


@jit_in_place
def solve_dense(matrix: FloatArray, vector: FloatArray) -> float:
    """Solve matrix (n, n) * x = vector (n,) in place, x for the vector; return the determinant, 0 if some unknowns are open, and 0 then."""
    n = vector.size
    row = 0
    determinant = 1.0
    for column in range(n):
        pivot = row
        for i in range(row + 1, n):
            if abs(matrix[i, column]) > abs(matrix[pivot, column]):
                pivot = i
        if abs(matrix[pivot, column]) <= MIN_PIVOT:
            determinant = 0.0
            matrix[row:, column] = 0.0
            continue
        if pivot != row:
            determinant = -determinant
            _swap_rows(matrix, vector, row, pivot)
        determinant *= matrix[row, column]
        for i in range(n):
            if i != row:
                factor = matrix[i, column] / matrix[row, column]
                vector[i] -= factor * vector[row]
                for j in range(column, n):
                    matrix[i, j] -= factor * matrix[row, j]
                matrix[i, column] = 0.0
        row += 1
    vector[row:] = 0.0
    for i in range(row - 1, -1, -1):
        column = i
        while matrix[i, column] == 0.0:
            column += 1
        value = vector[i] / matrix[i, column]
        vector[i] = 0.0
        vector[column] = value
    return determinant


@jit_in_place
def _swap_rows(matrix: FloatArray, vector: FloatArray, first: int, second: int) -> None:
    for j in range(vector.size):
        matrix[first, j], matrix[second, j] = matrix[second, j], matrix[first, j]
    vector[first], vector[second] = vector[second], vector[first]
