"""The equations J M^-1 J^T x = b of the Lagrange multipliers as a band matrix, and products with J and M^-1 J^T.

Rows that share a body are coupled. Ordered well, a long chain has a narrow band and costs no more per link than a short
one. `banded_cholesky` solves the equations. They are singular where joints are redundant or a mechanism is at a change
point.
"""

import numpy as np

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray


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


@jit_in_place
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


@jit_in_place
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


@jit_in_place
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
