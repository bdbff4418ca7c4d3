"""The equations J M^-1 J^T x = b of the Lagrange multipliers as a band matrix, and products with J and M^-1 J^T; compiled.

Rows that share a body are coupled. Ordered well, a long chain has a narrow band and costs no more per link than a short
one. `banded_cholesky` solves the equations. They are singular where joints are redundant or a mechanism is at a change
point.
"""

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray


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
def subtract_minv_jt(
    row_bodies: IntArray,  # first and second body of each row; shape (rows, 2)
    jacobian: FloatArray,  # Jacobian of each row with respect to both poses; shape (rows, 2, 3)
    inverse_mass: FloatArray,  # inverse masses and moments of inertia; shape (bodies, 3)
    vector: FloatArray,  # multipliers of the rows; shape (rows,)
    target: FloatArray,  # accelerations, velocities or poses; shape (bodies, 3)
) -> None:
    """Subtract M^-1 J^T vector from target, in place."""
    for i in range(vector.size):
        for side in range(2):
            k = row_bodies[i, side]
            if k >= 0:
                for c in range(3):
                    target[k, c] -= inverse_mass[k, c] * jacobian[i, side, c] * vector[i]


@jit_in_place
def apply_jacobian(
    row_bodies: IntArray,  # first and second body of each row; shape (rows, 2)
    jacobian: FloatArray,  # Jacobian of each row with respect to both poses; shape (rows, 2, 3)
    body_vectors: FloatArray,  # accelerations or velocities of the body origins; shape (bodies, 3)
    result: FloatArray,  # result: the product; shape (rows,)
) -> None:
    """Evaluate the product of the Jacobian and a vector."""
    for i in range(result.size):
        total = 0.0
        for side in range(2):
            k = row_bodies[i, side]
            if k >= 0:
                for c in range(3):
                    total += jacobian[i, side, c] * body_vectors[k, c]
        result[i] = total
