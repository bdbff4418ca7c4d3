"""Joints as constraint rows, and the constraint equations of a mechanism over whole trajectories."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.curves.segments import concatenate_segments, make_curve_segments
from governor_mechanism.mechanics.kinematics.constraint_kernels import CONSTRAINT_ROW_DTYPE, FOR_EVENTS, FOR_FORCES, ConstraintRows
from governor_mechanism.mechanics.kinematics.points import Origins, attachment_fields
from governor_mechanism.mechanics.kinematics.row_evaluation import RowEvaluation, evaluate_row_motions
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.joints.base import ConstraintRow, RowKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, IntArray, RecordArray


def make_row_table(n_rows: int) -> RecordArray:
    """Return rows without parameters and drives."""
    table = np.zeros(n_rows, dtype=CONSTRAINT_ROW_DTYPE)
    table["first_point_weight"], table["drive_scale"], table["drive"], table["third"] = 1.0, 1.0, NO_INDEX, GROUND_INDEX
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
    table, curve_segments, n_segments = make_row_table(len(entries)), list[FloatArray](), 0
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
            motion, drive_scale = self._drive_functions[self.rows.table[row]["drive"]], self.rows.table[row]["drive_scale"]
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
