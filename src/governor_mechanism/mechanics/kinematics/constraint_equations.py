"""Joints as constraint rows, and residuals, derivatives and rates of rows at many states."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.curves.segments import concatenate_segments, make_curve_segments
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import (
    CONSTRAINT_ROW_DTYPE,
    FOR_EVENTS,
    FOR_FORCES,
    N_ROW_COLUMNS,
    ConstraintRows,
    Origins,
    RowColumn,
    attachment_fields,
)
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.joints.base import ConstraintRow, RowKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, IntArray, RecordArray


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
        places = (np.repeat(rows, 3), columns.ravel())
        values = self._row_jacobians[0, rows, sides].ravel()
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
    row_values = np.zeros((n_rows, N_ROW_COLUMNS))
    row_jacobians = np.zeros((n_rows, n_sides, 3))
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


def make_row_table(n_rows: int) -> RecordArray:
    """Return rows without parameters and drives."""
    table = np.zeros(n_rows, dtype=CONSTRAINT_ROW_DTYPE)
    table["first_point_weight"] = 1.0
    table["drive_scale"] = 1.0
    table["drive"] = NO_INDEX
    table["third"] = GROUND_INDEX
    table["use"] = FOR_FORCES | FOR_EVENTS
    return table


def set_fields(record: RecordArray, values: Mapping[str, float]) -> None:
    """Set some fields of a record."""
    for name, value in values.items():
        record[name] = value


@dataclass(frozen=True)
class ConstraintTable:
    """All joints of a mechanism as constraint rows."""

    rows: ConstraintRows  # constraint rows
    joint_indices: IntArray  # index of the joint to which each row belongs; shape (rows,)
    motions: tuple[PrescribedMotion, ...]  # prescribed motions; the field `drive` of a row is an index into them


def make_constraint_table(
    mechanism: Mechanism,
    # origin of each body by name, in body axes (m), to which the poses refer; the mass centre if left out
    origins: Origins | None = None,
) -> ConstraintTable:
    """Return the constraint rows of all joints that are not trivially satisfied, their joints and the prescribed motions."""
    entries = [
        (index, joint, row)
        for index, joint in enumerate(mechanism.joints)
        for row in joint.constraint_rows(mechanism.length_scale)
        if not _is_trivially_satisfied(mechanism, joint, row)
    ]
    table = make_row_table(len(entries))
    curve_segments = list[FloatArray]()
    n_segments = 0
    motions: list[PrescribedMotion] = []
    for i, (_, joint, row) in enumerate(entries):
        segments = [] if row.curve is None else [make_curve_segments(row.curve)]
        n_own_segments = sum(map(len, segments))
        set_fields(table[i], attachment_fields(mechanism, joint.first, joint.second, origins or {}))
        set_fields(table[i], row.parameters)
        table[i]["kind"], table[i]["drive_scale"] = row.kind, row.drive_scale
        table[i]["third"] = GROUND_INDEX if row.third is None else mechanism.body_index(row.third)
        table[i]["drive"] = NO_INDEX if row.motion is None else len(motions)
        table[i]["first_segment"], table[i]["n_segments"] = n_segments, n_own_segments
        curve_segments += segments
        n_segments += n_own_segments
        motions += [] if row.motion is None else [row.motion]
    joint_indices = np.array([index for index, _, _ in entries], dtype=np.int64)
    rows = ConstraintRows(table, bodies_of_rows(table), concatenate_segments(curve_segments))
    return ConstraintTable(rows, joint_indices, tuple(motions))


def bodies_of_rows(table: RecordArray) -> IntArray:
    """Return the first and second body of each row, and the third one if any row has it; shape (n, 2 or 3)."""
    sides = ("first", "second", "third") if (table["third"] != GROUND_INDEX).any() else ("first", "second")
    bodies = np.empty((len(table), len(sides)), dtype=table.dtype["first"])
    for side, name in enumerate(sides):
        bodies[:, side] = table[name]
    return bodies


def _is_trivially_satisfied(mechanism: Mechanism, joint: Joint, row: ConstraintRow) -> bool:
    """Return whether a row concerns only angles of bodies that cannot rotate; MechanismError if it demands that they do."""
    if row.kind != RowKind.FIXED_DIRECTION or {"direction_x", "direction_y"} & set(row.parameters):
        return False
    bodies = [mechanism.body_index(name) for name in joint.bodies]
    if any(index != GROUND_INDEX and mechanism.bodies[index].can_rotate for index in bodies):
        return False
    if row.motion is not None or row.parameters["constant"] != 0.0:
        raise MechanismError(
            f"joint {joint.name!r} prescribes a relative angle of two bodies that cannot rotate; "
            "make one of them rotate, or remove the relative angle from the joint"
        )
    return True


class ConstraintEquations:
    """Constraint equations of all joints of a mechanism, evaluated at many poses at once.

    Poses (..., bodies, 3) are those of the mass centres, in m and rad; times have shape (...) and are in s. Residuals of
    angles are multiplied by the length scale of the mechanism and are in m.

    Parameters
    ----------
    mechanism
        Mechanism with its bodies and joints.

    Attributes
    ----------
    joints
        Joints of the mechanism.
    rows
        The rows as the kernels read them.
    joint_indices
        Index of the joint to which each row belongs; shape (rows,).
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.joints = mechanism.joints
        table = make_constraint_table(mechanism)
        self.rows, self.joint_indices = table.rows, table.joint_indices
        self._drive_functions = [CubicTimeFunction(motion) for motion in table.motions]

    @property
    def is_driven(self) -> NDArray[np.bool_]:
        """Whether each row is driven; shape (rows,)."""
        is_driven: NDArray[np.bool_] = self.rows.table["drive"] != NO_INDEX
        return is_driven

    def prescribed_motion(self, times: FloatArray) -> FloatArray:
        """Return the prescribed value (m), rate (m/s) and acceleration (m/s2) of each row; shape (..., rows, 3)."""
        flat_times = np.asarray(times, dtype=np.float64).ravel()
        result = np.zeros((flat_times.size, len(self.joint_indices), 3))
        for row in np.flatnonzero(self.is_driven):
            motion = self._drive_functions[self.rows.table[row]["drive"]]
            drive_scale = self.rows.table[row]["drive_scale"]
            values = [motion(flat_times), motion.derivative(flat_times), motion.second_derivative(flat_times)]
            result[:, row] = drive_scale * np.stack(values, axis=-1)
        return result.reshape(*np.shape(times), *result.shape[1:])

    def evaluate(self, poses: FloatArray, times: FloatArray | float = 0.0, velocities: FloatArray | None = None) -> RowEvaluation:
        """Return the rows at poses (..., bodies, 3) and, if they are given, velocities."""
        drive_values = self.prescribed_motion(np.broadcast_to(times, poses.shape[:-2])) if self._drive_functions else None
        return RowEvaluation(self.rows, poses, velocities, drive_values)

    def residuals(self, poses: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """Return the signed residuals (m); shape (..., rows)."""
        return self.evaluate(poses, times).residuals

    def residuals_along(self, poses: FloatArray, times: FloatArray) -> FloatArray:
        """Return the signed residuals (m) along a motion with poses (n, bodies, 3) at times (n,) s; shape (rows, n)."""
        residuals, _ = evaluate_row_motions(self.rows, poses, poses)  # the rates are not needed
        if self._drive_functions:
            residuals -= self.prescribed_motion(times)[:, :, 0].T
        return residuals

    def jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals with respect to the poses, m/m and m/rad; shape (..., rows, bodies, 3)."""
        return RowEvaluation(self.rows, poses).jacobian

    def gamma(self, poses: FloatArray, velocities: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """Return the right-hand side of J * accelerations = gamma (m/s2); shape (..., rows)."""
        return self.evaluate(poses, times, velocities).gamma

    def largest_gap(self, poses: FloatArray, time: float = 0.0) -> tuple[Joint, float]:
        """Return the joint with the largest gap at one set of poses, and the gap (m), signed if the joint has a single row."""
        residuals = self.residuals(poses, time)
        gaps = [residuals[self.joint_indices == index] for index in range(len(self.joints))]
        worst = max(range(len(gaps)), key=lambda index: math.hypot(*gaps[index]))
        return self.joints[worst], float(gaps[worst][0]) if len(gaps[worst]) == 1 else math.hypot(*gaps[worst])


@once_per_object
def constraint_equations_of(mechanism: Mechanism) -> ConstraintEquations:
    """Return the constraint equations of a mechanism, which are made once."""
    return ConstraintEquations(mechanism)
