"""Joints as rows of numbers for the compiled equations, and questions about whole trajectories."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_kernels import (
    BODY_NORMAL,
    CONSTRAINT_ROW_DTYPE,
    DISTANCE,
    FIXED_DIRECTION,
    N_ROW_PARAMETERS,
    ConstraintRows,
    evaluate_gamma,
    evaluate_jacobian,
    evaluate_residuals,
)
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import (
    ArcSlot,
    CurveSlot,
    Distance,
    Gear,
    Joint,
    Pin,
    Point,
    Prismatic,
    ProportionalDisplacement,
    RackAndPinion,
    RotationalDriver,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.types import FloatArray, IntArray, RecordArray


@dataclass(frozen=True)
class ConstraintRow:
    """One equation of a joint: kind and parameters as in `rows`, the motion that drives it, the curve it follows."""

    kind: int
    parameters: tuple[float, ...]
    motion: PrescribedMotion | None = None
    drive_scale: float = 1.0
    curve: Curve | None = None


@singledispatch
def _constraint_rows(joint: Joint, length_scale: float) -> list[ConstraintRow]:
    """Equations of a joint; `size` (m) makes angles into openings."""
    raise TypeError(f"no equation is written for joints of type {type(joint).__name__}")


def _relative_angle_row(angle: float, length_scale: float, motion: PrescribedMotion | None = None) -> ConstraintRow:
    return ConstraintRow(FIXED_DIRECTION, (0.0, 0.0, -length_scale, length_scale, length_scale * angle), motion, length_scale)


@_constraint_rows.register
def _(joint: Pin, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(FIXED_DIRECTION, (1.0, 0.0)), ConstraintRow(FIXED_DIRECTION, (0.0, 1.0))]


@_constraint_rows.register
def _(joint: Weld, length_scale: float) -> list[ConstraintRow]:
    return [
        ConstraintRow(FIXED_DIRECTION, (1.0, 0.0)),
        ConstraintRow(FIXED_DIRECTION, (0.0, 1.0)),
        _relative_angle_row(joint.relative_angle, length_scale),
    ]


@_constraint_rows.register
def _(joint: Distance, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(DISTANCE, (joint.length,))]


@_constraint_rows.register
def _(joint: ArcSlot, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(DISTANCE, (joint.radius,))]


@_constraint_rows.register
def _(joint: Slider, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(BODY_NORMAL, (joint.angle,))]


@_constraint_rows.register
def _(joint: Prismatic, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(BODY_NORMAL, (joint.angle,)), _relative_angle_row(joint.relative_angle, length_scale)]


@_constraint_rows.register
def _(joint: CurveSlot, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(BODY_NORMAL, (joint.angle,), curve=joint.curve)]


@_constraint_rows.register
def _(joint: Gear, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(FIXED_DIRECTION, (0.0, 0.0, -length_scale * joint.ratio, length_scale, length_scale * joint.offset))]


@_constraint_rows.register
def _(joint: RackAndPinion, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(FIXED_DIRECTION, (math.cos(joint.angle), math.sin(joint.angle), -joint.radius, 0.0, joint.offset))]


@_constraint_rows.register
def _(joint: ProportionalDisplacement, length_scale: float) -> list[ConstraintRow]:
    direction = math.cos(joint.angle), math.sin(joint.angle)
    return [ConstraintRow(FIXED_DIRECTION, (*direction, 0.0, 0.0, joint.offset, 1.0 - joint.ratio))]


@_constraint_rows.register
def _(joint: RotationalDriver, length_scale: float) -> list[ConstraintRow]:
    return [_relative_angle_row(0.0, length_scale, joint.motion)]


@_constraint_rows.register
def _(joint: TranslationalDriver, length_scale: float) -> list[ConstraintRow]:
    return [ConstraintRow(BODY_NORMAL, (joint.angle - math.pi / 2,), joint.motion)]


@dataclass(frozen=True)
class ConstraintTable:
    """All joints of a mechanism as rows; `owner` (rows,) is the joint each row belongs to.

    motions are what the rows' drives refer to, by position.
    """

    rows: ConstraintRows
    joint_indices: IntArray
    motions: tuple[PrescribedMotion, ...]


def make_constraint_table(mechanism: Mechanism, origins: Mapping[str, tuple[float, float]] | None = None) -> ConstraintTable:
    """The rows of a mechanism; its bodies' coordinates are counted from `origins` (body axes, m), or mass centres."""
    entries = [
        (index, joint, row)
        for index, joint in enumerate(mechanism.joints)
        for row in _constraint_rows(joint, mechanism.length_scale)
        if not _is_trivially_satisfied(mechanism, joint, row)
    ]

    def anchor(point: Point) -> tuple[float, float]:
        x, y = (origins or {}).get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    table, curve_segments, motions, n_segments = (
        np.zeros(len(entries), dtype=CONSTRAINT_ROW_DTYPE),
        [np.zeros((0, 5))],
        list[PrescribedMotion](),
        0,
    )
    for i, (_, joint, row) in enumerate(entries):
        segments = np.zeros((0, 5)) if row.curve is None else make_curve_segments(row.curve)
        drive = -1 if row.motion is None else len(motions)
        bodies = [mechanism.body_index(point.body) for point in (joint.first, joint.second)]
        parameters = row.parameters + (0.0,) * (N_ROW_PARAMETERS - len(row.parameters))
        points = (*anchor(joint.first), *anchor(joint.second))
        table[i] = (row.kind, *bodies, *points, *parameters, row.drive_scale, drive, n_segments, len(segments))
        curve_segments.append(segments)
        n_segments += len(segments)
        motions += [] if row.motion is None else [row.motion]
    joint_indices = np.array([index for index, _, _ in entries], dtype=np.int64)
    return ConstraintTable(ConstraintRows(table, bodies_of_rows(table), np.concatenate(curve_segments)), joint_indices, tuple(motions))


def bodies_of_rows(table: RecordArray) -> IntArray:
    """The bodies (n, 2) of records with a first and a second one."""
    return np.stack([table["first"], table["second"]], axis=-1)


def _is_trivially_satisfied(mechanism: Mechanism, joint: Joint, row: ConstraintRow) -> bool:
    """Whether a row only speaks of the turning of bodies that do not turn; refuses it where it contradicts that."""
    if row.kind != FIXED_DIRECTION or row.parameters[:2] != (0.0, 0.0):
        return False
    bodies = [mechanism.body_index(point.body) for point in (joint.first, joint.second)]
    if any(index >= 0 and mechanism.bodies[index].can_rotate for index in bodies):
        return False
    if row.motion is not None or row.parameters[4] != 0.0:
        raise MechanismError(f"joint {joint.name!r} asks two bodies that do not turn to turn against each other")
    return True


def make_curve_segments(curve: Curve) -> FloatArray:
    """A curve as cubics (pieces, 5): where each starts (m), and its coefficients, highest power first."""
    if isinstance(curve, PolynomialCurve):
        coefficients = np.zeros(4)
        coefficients[: len(curve.coefficients)] = curve.coefficients
        return np.array([[0.0, *coefficients[::-1]]])
    if isinstance(curve, SplineCurve):
        spline = CubicSpline(curve.x, curve.y)
        return np.column_stack([spline.x[:-1], spline.c.T])
    raise TypeError(f"no equation is written for curves of type {type(curve).__name__}")


class ConstraintEquations:
    """All joints of a mechanism as one set of equations, for poses (..., bodies, 3) at times (...) s."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.joints = mechanism.joints
        table = make_constraint_table(mechanism)
        self._rows, self.joint_indices = table.rows, table.joint_indices
        self._drive_functions = [CubicTimeFunction(motion) for motion in table.motions]

    @property
    def is_driven(self) -> NDArray[np.bool_]:
        """(equations,) which ones a drive moves."""
        is_driven: NDArray[np.bool_] = self._rows.table["drive"] >= 0
        return is_driven

    def prescribed_motion(self, times: FloatArray) -> FloatArray:
        """(..., equations, 3): what drives want of each opening at times (...) s, in m, m/s, m/s2."""
        flat_times = np.atleast_1d(np.asarray(times, dtype=np.float64)).ravel()
        result = np.zeros((flat_times.size, len(self.joint_indices), 3))
        for row in np.flatnonzero(self.is_driven):
            time_function, drive_scale = (self._drive_functions[self._rows.table[row]["drive"]], self._rows.table[row]["drive_scale"])
            result[:, row] = drive_scale * np.stack(
                [time_function(flat_times), time_function.derivative(flat_times), time_function.second_derivative(flat_times)], axis=-1
            )
        return result.reshape(*np.shape(times), len(self.joint_indices), 3)

    def residuals(self, poses: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """(..., equations) m, signed."""
        result = evaluate_residuals(self._rows, _flatten_poses(poses), self._prescribed_motion_per_pose(poses, times))
        return result.reshape(*poses.shape[:-2], len(self.joint_indices))

    def jacobian(self, poses: FloatArray) -> FloatArray:
        """(..., equations, bodies, 3): m per m, and m per rad."""
        result = evaluate_jacobian(self._rows, _flatten_poses(poses))
        return result.reshape(*poses.shape[:-2], len(self.joint_indices), *poses.shape[-2:])

    def gamma(self, poses: FloatArray, velocities: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """(..., equations): what gradients . accelerations must be (m/s2)."""
        result = evaluate_gamma(
            self._rows, _flatten_poses(poses), _flatten_poses(velocities), self._prescribed_motion_per_pose(poses, times)
        )
        return result.reshape(*poses.shape[:-2], len(self.joint_indices))

    def gap(self, poses: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """(...) m: the widest opening of any joint."""
        largest: FloatArray = np.max(np.abs(self.residuals(poses, times)), axis=-1, initial=0.0)
        return largest

    def largest_gap(self, poses: FloatArray, time: float = 0.0) -> tuple[Joint, float]:
        """The joint that is open widest at one set of poses, and its opening (m; signed where it has one equation)."""
        residuals = self.residuals(poses, time)
        gaps = [residuals[self.joint_indices == index] for index in range(len(self.joints))]
        worst = max(range(len(gaps)), key=lambda index: math.hypot(*gaps[index]))
        return self.joints[worst], float(gaps[worst][0]) if len(gaps[worst]) == 1 else math.hypot(*gaps[worst])

    def _prescribed_motion_per_pose(self, poses: FloatArray, times: FloatArray | float) -> FloatArray:
        all_times = np.broadcast_to(np.asarray(times, dtype=np.float64), poses.shape[:-2])
        return self.prescribed_motion(all_times).reshape(all_times.size, len(self.joint_indices), 3)


def _flatten_poses(poses: FloatArray) -> FloatArray:
    return np.ascontiguousarray(poses, dtype=np.float64).reshape(-1, *poses.shape[-2:])
