"""Constraint rows at many states: residuals, derivatives and rates, each by one call of a kernel."""

from functools import cached_property
from typing import Any

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_kernels import N_ROW_COLUMNS, ConstraintRows, RowColumn, evaluate_rows
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import GROUND_INDEX, FloatArray, IntArray


class RowEvaluation:
    """Constraint rows at one state or at many, all of whose values come from one call of the kernel.

    Parameters
    ----------
    rows
        Constraint rows.
    poses
        Poses of the body origins, m and rad; shape (..., bodies, 3).
    velocities
        Their derivatives; same shape. Default: zero.
    drive_values
        Prescribed value, rate and acceleration of each row; shape (..., rows, 3). Default: zero.

    Attributes
    ----------
    residuals
        Residuals of the rows, m or rad; shape (..., rows).
    gamma
        Right-hand side of J * accelerations = gamma, in the units of the residuals per s2; shape (..., rows).
    """

    def __init__(
        self, rows: ConstraintRows, poses: FloatArray, velocities: FloatArray | None = None, drive_values: FloatArray | None = None
    ) -> None:
        self._row_bodies, self._poses_shape = rows.row_bodies, poses.shape
        flat_poses = _flatten_states(poses)
        row_values = np.zeros((len(flat_poses), len(rows.table), N_ROW_COLUMNS))
        self._row_jacobians = np.zeros((len(flat_poses), *rows.row_bodies.shape, 3))
        if drive_values is not None:
            row_values[:, :, : RowColumn.DRIVE_ACCELERATION + 1] = _flatten_states(drive_values)
        motion = np.zeros(flat_poses.shape) if velocities is None else _flatten_states(velocities)
        evaluate_rows_at_states(rows, flat_poses, motion, row_values, self._row_jacobians)
        self._shape = *poses.shape[:-2], len(rows.table)
        self.residuals: FloatArray = row_values[:, :, RowColumn.RESIDUAL].reshape(self._shape)
        self.gamma: FloatArray = row_values[:, :, RowColumn.GAMMA].reshape(self._shape)

    @cached_property
    def jacobian(self) -> FloatArray:
        """Derivatives of the residuals by all poses, m/m and m/rad; shape (..., rows, bodies, 3)."""
        jacobian = np.zeros((*self._row_jacobians.shape[:2], *self._poses_shape[-2:]))
        add_row_jacobians(self._row_bodies, self._row_jacobians, jacobian)
        return jacobian.reshape(*self._shape, *self._poses_shape[-2:])

    def sparse_jacobian(self) -> Any:
        """Return the derivatives of the residuals at one state by all poses, m/m and m/rad, as a sparse array (rows, 3 bodies)."""
        from scipy.sparse import csr_array  # slow to import

        rows, sides = np.nonzero(self._row_bodies != GROUND_INDEX)
        columns = 3 * self._row_bodies[rows, sides][:, np.newaxis] + np.arange(3)
        places, values = (np.repeat(rows, 3), columns.ravel()), self._row_jacobians[0, rows, sides].ravel()
        jacobian = csr_array((values, places), shape=(len(self._row_bodies), 3 * self._poses_shape[-2]))
        jacobian.eliminate_zeros()
        return jacobian

    @property
    def is_differentiable(self) -> bool:
        """Whether all derivatives of the residuals are finite."""
        return bool(np.isfinite(self._row_jacobians[:, self._row_bodies != GROUND_INDEX]).all())

    def derivatives_along(self, directions: FloatArray) -> FloatArray:
        """Return the derivatives (..., rows) of the residuals along directions (..., bodies, 3) of the poses."""
        result = np.zeros(self._row_jacobians.shape[:2])
        add_directional_derivatives(self._row_bodies, self._row_jacobians, _flatten_states(directions), result)
        return result.reshape(self._shape)


def _flatten_states(values: FloatArray) -> FloatArray:
    """Return values (..., n, 3) of states as a contiguous array of shape (states, n, 3)."""
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1, *values.shape[-2:])


@jit_in_place
def add_row_jacobians(
    row_bodies: IntArray,  # bodies of each row, or GROUND_INDEX; shape (rows, sides)
    # derivatives of each residual by the poses of its bodies; shape (n, rows, sides, 3)
    row_jacobians: FloatArray,
    jacobian: FloatArray,  # sums of derivatives by all poses; shape (n, rows, bodies, 3)
) -> None:
    """Add the derivatives of residuals where the bodies of their rows stand."""
    for k in range(jacobian.shape[0]):
        for i in range(jacobian.shape[1]):
            for side in range(row_bodies.shape[1]):
                body = row_bodies[i, side]
                if body != GROUND_INDEX:
                    for c in range(3):
                        jacobian[k, i, body, c] += row_jacobians[k, i, side, c]


@jit_in_place
def add_directional_derivatives(
    row_bodies: IntArray,  # bodies of each row, or GROUND_INDEX; shape (rows, sides)
    # derivatives of each residual by the poses of its bodies; shape (n, rows, sides, 3)
    row_jacobians: FloatArray,
    directions: FloatArray,  # changes of the poses; shape (n, bodies, 3)
    result: FloatArray,  # sums of derivatives; shape (n, rows)
) -> None:
    """Add the derivatives of residuals along directions of the poses."""
    for k in range(result.shape[0]):
        for i in range(result.shape[1]):
            for side in range(row_bodies.shape[1]):
                body = row_bodies[i, side]
                if body != GROUND_INDEX:
                    for c in range(3):
                        result[k, i] += row_jacobians[k, i, side, c] * directions[k, body, c]


@jit_in_place
def evaluate_rows_at_states(
    rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, row_values: FloatArray, row_jacobians: FloatArray
) -> None:
    """Fill row values (n, rows, columns), which contain the prescribed motion, and Jacobians (n, rows, sides, 3) at n states."""
    for k in range(poses.shape[0]):
        evaluate_rows(rows, poses[k], velocities[k], row_values[k], row_jacobians[k])


def evaluate_row_motions(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the residuals of rows without drives and their rates (rows, n) at poses and velocities (n, bodies, 3)."""
    n_rows, n_sides = rows.row_bodies.shape
    values, rates = np.empty((2, n_rows, len(poses)))
    row_values, row_jacobians = np.zeros((n_rows, N_ROW_COLUMNS)), np.zeros((n_rows, n_sides, 3))
    fill_row_motions(rows, _flatten_states(poses), _flatten_states(velocities), row_values, row_jacobians, values, rates)
    return values, rates


@jit_in_place
def fill_row_motions(
    rows: ConstraintRows,
    poses: FloatArray,
    velocities: FloatArray,
    row_values: FloatArray,  # buffer with a prescribed motion of zero; shape (rows, columns)
    row_jacobians: FloatArray,  # buffer; shape (rows, sides, 3)
    values: FloatArray,  # result: residuals; shape (rows, n)
    rates: FloatArray,  # result: their rates; same shape
) -> None:
    """Fill the residuals of rows and their rates at poses and velocities (n, bodies, 3)."""
    for k in range(poses.shape[0]):
        evaluate_rows(rows, poses[k], velocities[k], row_values, row_jacobians)
        for i in range(values.shape[0]):
            rate = 0.0
            for side in range(rows.row_bodies.shape[1]):
                body = rows.row_bodies[i, side]
                if body != GROUND_INDEX:
                    for c in range(3):
                        rate += row_jacobians[i, side, c] * velocities[k, body, c]
            values[i, k] = row_values[i, RowColumn.RESIDUAL]
            rates[i, k] = rate
