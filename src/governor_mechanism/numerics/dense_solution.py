"""Solution of a few linear equations without symmetry, as a compiled kernel."""

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

MIN_PIVOT = 1e-11
"""Pivot below which an unknown is not determined; coefficients are of order 1."""


@jit_in_place
def solve_dense(matrix: FloatArray, vector: FloatArray) -> float:
    """Solve matrix (n, n) * x = vector (n,) in place, x for the vector; return the determinant, 0 if some unknowns are open, and 0 then."""
    n, row, determinant = vector.size, 0, 1.0
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
