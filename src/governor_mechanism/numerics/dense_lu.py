"""LU factorisation of small dense matrices, real or complex, with row pivoting, as compiled kernels."""

from typing import Any

from numpy.typing import NDArray

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import IntArray


@jit_in_place
def factorise_lu(
    matrix: NDArray[Any],  # matrix; becomes the unit lower and the upper triangle; shape (n, n)
    pivots: IntArray,  # result: the row with which each row was exchanged; shape (n,)
) -> bool:
    """Replace a square matrix by its factors, and return whether it is regular.

    Result: whether no pivot is 0 or not a number.
    """
    n = pivots.size
    for k in range(n):
        pivots[k] = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivots[k], k]):
                pivots[k] = i
        if not abs(matrix[pivots[k], k]) > 0.0:
            return False
        if pivots[k] != k:
            for j in range(n):
                matrix[k, j], matrix[pivots[k], j] = matrix[pivots[k], j], matrix[k, j]
        inverse_pivot = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            if matrix[i, k] != 0.0:
                factor = matrix[i, k] * inverse_pivot
                matrix[i, k] = factor
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@jit_in_place
def solve_lu(factors: NDArray[Any], pivots: IntArray, vector: NDArray[Any]) -> None:
    """Solve in place with the factors and pivots of `factorise_lu`, for the leading components of a vector."""
    n = pivots.size
    for k in range(n):
        vector[k], vector[pivots[k]] = vector[pivots[k]], vector[k]
    for k in range(n):
        for i in range(k + 1, n):
            vector[i] -= factors[i, k] * vector[k]
    for k in range(n - 1, -1, -1):
        total = vector[k]
        for j in range(k + 1, n):
            total -= factors[k, j] * vector[j]
        vector[k] = total / factors[k, k]
