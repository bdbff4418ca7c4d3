"""Solution of J M^-1 J^T x = b for the Lagrange multipliers, by a band Cholesky factorisation.

Rows that share a body are coupled. Ordered well, a long chain has a narrow band and costs no more per link than a short
one. Where joints are redundant or a mechanism is at a change point, a pivot of the factorisation vanishes, and a
rank-revealing least-norm solution takes its place.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, IntArray

MIN_BAND_PIVOT_RATIO = 1e-12
"""Pivot relative to its diagonal entry below which it counts as zero: the rows are linearly dependent."""

MAX_JACOBI_SWEEPS = 60
"""Maximum number of sweeps of Jacobi rotations; about ten suffice."""


def find_coupled_rows(row_bodies: IntArray) -> IntArray:
    """Return the pairs of rows that share a body, from the bodies of all rows (rows, 2).

    Each pair is (row, earlier or same row, side of the body in the first, side in the second); shape (pairs, 4).
    """
    rows_of_body: dict[int, list[tuple[int, int]]] = {}
    pairs: list[tuple[int, int, int, int]] = []
    for row, bodies in enumerate(row_bodies.tolist()):
        sides = [(side, body_index) for side, body_index in enumerate(bodies) if body_index >= 0]
        for side, body_index in sides:
            rows_of_body.setdefault(body_index, []).append((row, side))
        pairs += sorted(
            (row, other_row, side, other_side) for side, body_index in sides for other_row, other_side in rows_of_body[body_index]
        )
    return np.array(pairs, dtype=np.int64).reshape(-1, 4)


def bandwidth_reducing_order(row_bodies: IntArray) -> IntArray:
    """Return an order of the rows that keeps coupled rows together (reverse Cuthill-McKee)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    pairs, n_rows = find_coupled_rows(row_bodies), len(row_bodies)
    if n_rows == 0:  # bodies on springs alone
        return np.zeros(0, dtype=np.int64)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n_rows, n_rows)).tocsr()
    return np.asarray(reverse_cuthill_mckee((graph + graph.T).tocsr(), symmetric_mode=True), dtype=np.int64)


@jit_internal
def assemble_schur_band(
    row_bodies: IntArray, row_pairs: IntArray, jacobian: FloatArray, inverse_mass: FloatArray, band: FloatArray
) -> None:
    """Fill band (rows, bandwidth + 1) with J M^-1 J^T: entry (i, i - k) is at [i, bandwidth - k]."""
    band[:] = 0.0
    bandwidth = band.shape[1] - 1
    for p in range(row_pairs.shape[0]):
        i, j, side, other_side = row_pairs[p, 0], row_pairs[p, 1], row_pairs[p, 2], row_pairs[p, 3]
        k = row_bodies[i, side]
        total = 0.0
        for c in range(3):
            total += jacobian[i, side, c] * inverse_mass[k, c] * jacobian[j, other_side, c]
        band[i, bandwidth - (i - j)] += total


@jit_internal
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


@jit_internal
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


@jit_internal
def solve_schur_band(band: FloatArray, factor: FloatArray, vector: FloatArray) -> float:
    """Solve J M^-1 J^T x = vector in place; with the least-norm solution where rows are linearly dependent.

    Parameters
    ----------
    band
        Band of J M^-1 J^T; shape (rows, bandwidth + 1).
    factor
        Workspace for the Cholesky factor, with the shape of `band`.
    vector
        Right-hand side; replaced by the solution; shape (rows,).

    Returns
    -------
    float
        Smallest pivot ratio: about the square of the angle (rad) of a row to the span of the others; 0 where rows are
        linearly dependent.
    """
    min_pivot_ratio = factorise_band(band, factor)
    if min_pivot_ratio > 0.0:
        solve_factorised_band(factor, vector)
        return min_pivot_ratio
    _solve_least_norm(band, vector)
    return 0.0


@jit_internal
def _solve_least_norm(band: FloatArray, vector: FloatArray) -> None:
    """Replace vector by the least-norm solution where rows are linearly dependent."""
    n_rows, bandwidth = band.shape[0], band.shape[1] - 1
    dense = np.zeros((n_rows, n_rows))
    for i in range(n_rows):
        for k in range(max(0, i - bandwidth), i + 1):
            dense[i, k] = dense[k, i] = band[i, bandwidth - (i - k)]
    eigenvectors = _diagonalise_symmetric(dense)
    max_eigenvalue = 0.0
    for k in range(n_rows):
        max_eigenvalue = max(max_eigenvalue, dense[k, k])
    solution = np.zeros(n_rows)
    for k in range(n_rows):
        if dense[k, k] > MIN_BAND_PIVOT_RATIO * max_eigenvalue:
            projection = 0.0
            for i in range(n_rows):
                projection += eigenvectors[i, k] * vector[i]
            for i in range(n_rows):
                solution[i] += eigenvectors[i, k] * projection / dense[k, k]
    for i in range(n_rows):
        vector[i] = solution[i]


@jit_internal
def _diagonalise_symmetric(matrix: FloatArray) -> FloatArray:
    """Diagonalise a symmetric matrix in place by Jacobi rotations, and return the eigenvectors as columns.

    numpy.linalg.eigh takes three seconds to compile, and this is rarely called.
    """
    order = matrix.shape[0]
    eigenvectors = np.eye(order)
    for _ in range(MAX_JACOBI_SWEEPS):
        off_diagonal_sum = diagonal_sum = 0.0
        for i in range(order):
            diagonal_sum += matrix[i, i] ** 2
            for j in range(i):
                off_diagonal_sum += matrix[i, j] ** 2
        if not off_diagonal_sum > 1e-32 * diagonal_sum:
            break
        for p in range(order - 1):
            for q in range(p + 1, order):
                if matrix[p, q] != 0.0:
                    _apply_jacobi_rotation(matrix, eigenvectors, p, q)
    return eigenvectors


@jit_internal
def _apply_jacobi_rotation(matrix: FloatArray, eigenvectors: FloatArray, p: int, q: int) -> None:
    """Apply the rotation that makes entry (p, q) vanish."""
    cot_double_angle = 0.5 * (matrix[q, q] - matrix[p, p]) / matrix[p, q]
    tangent = 1.0 / (cot_double_angle + math.copysign(math.hypot(1.0, cot_double_angle), cot_double_angle))
    cosine = 1.0 / math.hypot(1.0, tangent)
    sine = tangent * cosine
    for k in range(matrix.shape[0]):
        first, second = matrix[k, p], matrix[k, q]
        matrix[k, p], matrix[k, q] = cosine * first - sine * second, sine * first + cosine * second
    for k in range(matrix.shape[0]):
        first, second = matrix[p, k], matrix[q, k]
        matrix[p, k], matrix[q, k] = cosine * first - sine * second, sine * first + cosine * second
        first, second = eigenvectors[k, p], eigenvectors[k, q]
        eigenvectors[k, p], eigenvectors[k, q] = cosine * first - sine * second, sine * first + cosine * second


@jit_internal
def subtract_minv_jt(row_bodies: IntArray, jacobian: FloatArray, inverse_mass: FloatArray, vector: FloatArray, target: FloatArray) -> None:
    """Subtract M^-1 J^T vector from target, in place.

    Parameters
    ----------
    row_bodies
        First and second body of each row; shape (rows, 2).
    jacobian
        Jacobian of each row with respect to both poses; shape (rows, 2, 3).
    inverse_mass
        Inverse masses and moments of inertia; shape (bodies, 3).
    vector
        Multipliers of the rows; shape (rows,).
    target
        Accelerations, velocities or poses; shape (bodies, 3).
    """
    for i in range(vector.size):
        for side in range(2):
            k = row_bodies[i, side]
            if k >= 0:
                for c in range(3):
                    target[k, c] -= inverse_mass[k, c] * jacobian[i, side, c] * vector[i]


@jit_internal
def apply_jacobian(row_bodies: IntArray, jacobian: FloatArray, body_vectors: FloatArray, result: FloatArray) -> None:
    """Evaluate the product of the Jacobian and a vector.

    Parameters
    ----------
    row_bodies
        First and second body of each row; shape (rows, 2).
    jacobian
        Jacobian of each row with respect to both poses; shape (rows, 2, 3).
    body_vectors
        Accelerations or velocities of the body origins; shape (bodies, 3).
    result
        Result: the product; shape (rows,).
    """
    for i in range(result.size):
        total = 0.0
        for side in range(2):
            k = row_bodies[i, side]
            if k >= 0:
                for c in range(3):
                    total += jacobian[i, side, c] * body_vectors[k, c]
        result[i] = total
