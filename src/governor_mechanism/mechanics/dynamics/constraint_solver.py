"""Joint forces and projection from the equations J M^-1 J^T, factorised in the band that the mechanism's joints leave.

Rows that share a body are neighbours; ordered well, a long chain has a narrow band and costs no more per link than a
short one. Where joints are redundant, or a mechanism stands at a change point, the band factorisation meets a vanishing
pivot and a rank-revealing least-squares solution takes its place.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, IntArray

SINGULAR = 1e-12
"""A pivot below this fraction of its diagonal has vanished: the rows depend on each other."""

SWEEPS = 60
"""Of rotations, at most; some ten suffice."""


def neighbours(body: IntArray) -> IntArray:
    """Pairs (row, earlier or same row, side of the first, side of the second) of rows (rows, 2) that share a body."""
    sharing: dict[int, list[tuple[int, int]]] = {}
    pairs: list[tuple[int, int, int, int]] = []
    for row, held in enumerate(body.tolist()):
        ends = [(side, index) for side, index in enumerate(held) if index >= 0]
        for side, index in ends:
            sharing.setdefault(index, []).append((row, side))
        pairs += sorted((row, other, side, end) for side, index in ends for other, end in sharing[index])
    return np.array(pairs, dtype=np.int64).reshape(-1, 4)


def narrow_order(body: IntArray) -> IntArray:
    """An order of the rows that keeps neighbours together (reverse Cuthill-McKee)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    pairs, count = neighbours(body), len(body)
    if count == 0:  # bodies on springs alone
        return np.zeros(0, dtype=np.int64)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count)).tocsr()
    return np.asarray(reverse_cuthill_mckee((graph + graph.T).tocsr(), symmetric_mode=True), dtype=np.int64)


@kernel
def assemble(body: IntArray, pairs: IntArray, gradient: FloatArray, inverse_mass: FloatArray, band: FloatArray) -> None:
    """Fill band (rows, width + 1) with J M^-1 J^T: entry (i, i - k) stands at [i, width - k]."""
    band[:] = 0.0
    width = band.shape[1] - 1
    for p in range(pairs.shape[0]):
        i, j, side, other = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
        k = body[i, side]
        total = 0.0
        for c in range(3):
            total += gradient[i, side, c] * inverse_mass[k, c] * gradient[j, other, c]
        band[i, width - (i - j)] += total


@kernel
def factorise(band: FloatArray, factor: FloatArray) -> float:
    """Cholesky within the band, its diagonal inverted; the smallest pivot as a fraction of its diagonal.

    0 where a pivot vanishes.
    """
    width, least = band.shape[1] - 1, 1.0
    for i in range(band.shape[0]):
        first = max(0, i - width)
        for j in range(first, i + 1):
            total = band[i, width - (i - j)]
            for k in range(max(first, j - width), j):
                total -= factor[i, width - (i - k)] * factor[j, width - (j - k)]
            if i > j:
                factor[i, width - (i - j)] = total * factor[j, width]
            elif total > SINGULAR * band[i, width]:
                factor[i, width] = 1.0 / math.sqrt(total)
                least = min(least, total / band[i, width])
            else:
                return 0.0
    return least


@kernel
def substitute(factor: FloatArray, vector: FloatArray) -> None:
    """Solve in place with the factor of the band."""
    width, count = factor.shape[1] - 1, vector.size
    for i in range(count):
        total = vector[i]
        for k in range(max(0, i - width), i):
            total -= factor[i, width - (i - k)] * vector[k]
        vector[i] = total * factor[i, width]
    for i in range(count - 1, -1, -1):
        total = vector[i]
        for k in range(i + 1, min(count, i + width + 1)):
            total -= factor[k, width - (k - i)] * vector[k]
        vector[i] = total * factor[i, width]


@kernel
def solve(band: FloatArray, factor: FloatArray, vector: FloatArray) -> float:
    """Solve J M^-1 J^T x = vector in place, by the shortest solution where rows depend on each other.

    How independent they are: the square, about, of the angle (rad) by which the nearest to depending fails to; 0 there.
    """
    least = factorise(band, factor)
    if least > 0.0:
        substitute(factor, vector)
        return least
    _solve_shortest(band, vector)
    return 0.0


@kernel
def _solve_shortest(band: FloatArray, vector: FloatArray) -> None:
    """The shortest solution, in place, where rows depend on each other."""
    count, width = band.shape[0], band.shape[1] - 1
    dense = np.zeros((count, count))
    for i in range(count):
        for k in range(max(0, i - width), i + 1):
            dense[i, k] = dense[k, i] = band[i, width - (i - k)]
    vectors = _diagonalise(dense)
    largest = 0.0
    for k in range(count):
        largest = max(largest, dense[k, k])
    answer = np.zeros(count)
    for k in range(count):
        if dense[k, k] > SINGULAR * largest:
            part = 0.0
            for i in range(count):
                part += vectors[i, k] * vector[i]
            for i in range(count):
                answer[i] += vectors[i, k] * part / dense[k, k]
    for i in range(count):
        vector[i] = answer[i]


@kernel
def _diagonalise(matrix: FloatArray) -> FloatArray:
    """Turn a symmetric matrix into a diagonal one in place, by Jacobi's rotations; its eigenvectors, as columns.

    numpy's own would take three seconds to compile, for what is rarely called.
    """
    count = matrix.shape[0]
    vectors = np.eye(count)
    for _ in range(SWEEPS):
        beside = whole = 0.0
        for i in range(count):
            whole += matrix[i, i] ** 2
            for j in range(i):
                beside += matrix[i, j] ** 2
        if not beside > 1e-32 * whole:
            break
        for p in range(count - 1):
            for q in range(p + 1, count):
                if matrix[p, q] != 0.0:
                    _rotate(matrix, vectors, p, q)
    return vectors


@kernel
def _rotate(matrix: FloatArray, vectors: FloatArray, p: int, q: int) -> None:
    """One rotation, that makes entry (p, q) vanish."""
    half = 0.5 * (matrix[q, q] - matrix[p, p]) / matrix[p, q]
    tangent = 1.0 / (half + math.copysign(math.hypot(1.0, half), half))
    cosine = 1.0 / math.hypot(1.0, tangent)
    sine = tangent * cosine
    for k in range(matrix.shape[0]):
        first, second = matrix[k, p], matrix[k, q]
        matrix[k, p], matrix[k, q] = cosine * first - sine * second, sine * first + cosine * second
    for k in range(matrix.shape[0]):
        first, second = matrix[p, k], matrix[q, k]
        matrix[p, k], matrix[q, k] = cosine * first - sine * second, sine * first + cosine * second
        first, second = vectors[k, p], vectors[k, q]
        vectors[k, p], vectors[k, q] = cosine * first - sine * second, sine * first + cosine * second


@kernel
def give_back(
    body: IntArray, gradient: FloatArray, inverse_mass: FloatArray, vector: FloatArray, target: FloatArray
) -> None:
    """Subtract M^-1 J^T vector from target (bodies, 3)."""
    for i in range(vector.size):
        for side in range(2):
            k = body[i, side]
            if k >= 0:
                for c in range(3):
                    target[k, c] -= inverse_mass[k, c] * gradient[i, side, c] * vector[i]


@kernel
def along(body: IntArray, gradient: FloatArray, motion: FloatArray, result: FloatArray) -> None:
    """Fill result (rows,) with J motion."""
    for i in range(result.size):
        total = 0.0
        for side in range(2):
            k = body[i, side]
            if k >= 0:
                for c in range(3):
                    total += gradient[i, side, c] * motion[k, c]
        result[i] = total
