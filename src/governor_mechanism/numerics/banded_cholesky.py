"""Cholesky factorisation of a symmetric band matrix, with a least-norm solution for singular matrices, as compiled kernels."""

import math

import numpy as np

from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import FloatArray

MIN_BAND_PIVOT_RATIO = 1e-12
"""Pivot relative to its diagonal entry below which it counts as zero: the matrix is singular."""


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
def solve_band_system(band: FloatArray, factor: FloatArray, vector: FloatArray) -> float:
    """Solve a symmetric, positive semidefinite band system in place; with the least-norm solution if it is singular.

    Parameters
    ----------
    band
        Lower band: entry (i, i - k) is at [i, bandwidth - k]; shape (rows, bandwidth + 1).
    factor
        Workspace for the Cholesky factor, with the shape of `band`.
    vector
        Right-hand side; replaced by the solution; shape (rows,).

    Returns
    -------
    float
        Smallest pivot relative to its diagonal entry; 0 if a pivot vanishes. For J M^-1 J^T it is about the square of the
        angle (rad) of a row of J to the span of the others.
    """
    min_pivot_ratio = factorise_band(band, factor)
    if min_pivot_ratio > 0.0:
        solve_factorised_band(factor, vector)
        return min_pivot_ratio
    _solve_least_norm(band, vector)
    return 0.0


@jit
def _solve_least_norm(band: FloatArray, vector: FloatArray) -> None:
    """Replace vector by the least-norm solution of a singular band system."""
    n_rows, bandwidth = band.shape[0], band.shape[1] - 1
    dense = np.zeros((n_rows, n_rows))
    for i in range(n_rows):
        for k in range(max(0, i - bandwidth), i + 1):
            dense[i, k] = dense[k, i] = band[i, bandwidth - (i - k)]
            if not math.isfinite(dense[i, k]):  # eigh raises an exception, but callers check for NaN
                vector[:] = np.nan
                return
    eigenvalues, eigenvectors = np.linalg.eigh(dense)
    right_hand_side = vector.copy()
    vector[:] = 0.0
    for k in range(n_rows):
        if eigenvalues[k] > MIN_BAND_PIVOT_RATIO * eigenvalues[n_rows - 1]:
            projection = 0.0
            for i in range(n_rows):
                projection += eigenvectors[i, k] * right_hand_side[i]
            for i in range(n_rows):
                vector[i] += eigenvectors[i, k] * (projection / eigenvalues[k])
