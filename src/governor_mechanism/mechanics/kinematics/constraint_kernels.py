"""Residuals, Jacobian and right-hand side gamma of the constraint rows, as compiled kernels.

Every joint is one to three rows of a few kinds. The residual of a row is the distance (m) between a point of a first
and a point of a second body along a direction that depends on the kind, less the value that a drive prescribes. Bodies
are indices into poses (bodies, 3); -1 is the ground.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_motion
from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import FloatArray, IntArray, RecordArray, record_dtype


class RowKind(IntEnum):
    """Kind of a constraint row; d is the vector from the point of the first body to that of the second.

    DISTANCE: |d|. FIXED_DIRECTION: the component of d along a direction fixed in the plane, plus multiples of both body
    angles. BODY_NORMAL: the component of d normal to a line of the first body, or the distance from a curve on that line.
    LINE_ANGLE: the angle of d from the downward vertical (rad). FOLLOWER_HEIGHT: the height of a follower that hangs by a
    link from a rod through the second point, plus the height of the first point. ARC_POSITION: the angle of d in the axes
    of the first body, times a radius. The last three serve as outputs only.

    Parameters p0 to p5: DISTANCE: length. FIXED_DIRECTION: direction x and y, m per rad of the first and of the second
    angle, constant, and 1 minus the weight of the first point. BODY_NORMAL: angle of the line, -, -, -, constant.
    LINE_ANGLE: -, -, -, -, constant. FOLLOWER_HEIGHT: x (from the guide of the follower) and y of the other end of the
    rod, both weighted, weight of the second point, length of the link, constant, sign. ARC_POSITION: direction of zero,
    radius, -, -, constant.
    """

    DISTANCE = 0
    FIXED_DIRECTION = 1
    BODY_NORMAL = 2
    LINE_ANGLE = 3
    FOLLOWER_HEIGHT = 4
    ARC_POSITION = 5


N_ROW_PARAMETERS = 6
"""Number of parameters of a row, p0 to p5."""

CONSTRAINT_ROW_DTYPE = record_dtype(
    "i8 kind first second", "f8 x1 y1 x2 y2 p0 p1 p2 p3 p4 p5 drive_scale", "i8 drive first_segment n_segments"
)
"""One constraint row.

Kind, both bodies, a point on each (m, in body axes), the parameters, the scale (m per unit of the drive), the input
that drives it or -1, and first index and number of the segments of its guide curve.
"""


class RowColumn(IntEnum):
    """Column of the row values: prescribed value (m), rate (m/s) and acceleration (m/s2), residual (m), gamma (m/s2)."""

    DRIVE_VALUE = 0
    DRIVE_RATE = 1
    DRIVE_ACCELERATION = 2
    RESIDUAL = 3
    GAMMA = 4


N_ROW_COLUMNS = len(RowColumn)
"""Number of columns of the row values."""


MIN_DROP_SQUARED = 1e-300
"""Lower bound (m2) of the squared height of a follower's link, which avoids a division by zero for a horizontal link."""

rotate_vector_jit = jit_in_place(rotate_vector)


class ConstraintRows(NamedTuple):
    """All constraint rows of a mechanism.

    They are few arrays, because each array costs time in every call.

    Attributes
    ----------
    table
        Records of `CONSTRAINT_ROW_DTYPE`; shape (rows,).
    row_bodies
        First and second body of each row, as in `table`; shape (rows, 2).
    curve_segments
        Polynomial segments of all guide curves: start (m), then coefficients, highest power first; shape (segments, columns).
    """

    table: RecordArray
    row_bodies: IntArray
    curve_segments: FloatArray


@jit_in_place
def evaluate_drives(rows: ConstraintRows, input_cubics: FloatArray, local_time: float, row_values: FloatArray) -> None:
    """Fill the prescribed motion into row_values (rows, 5) from the local cubics and harmonics of the inputs."""
    for i in range(rows.table.size):
        drive, drive_scale = rows.table[i].drive, rows.table[i].drive_scale
        if drive >= 0:
            value, rate, acceleration = evaluate_motion(input_cubics, drive, local_time)
            row_values[i, RowColumn.DRIVE_VALUE] = drive_scale * value
            row_values[i, RowColumn.DRIVE_RATE] = drive_scale * rate
            row_values[i, RowColumn.DRIVE_ACCELERATION] = drive_scale * acceleration


@jit
def evaluate_curve(curve_segments: FloatArray, first_segment: int, n_segments: int, x: float) -> tuple[float, float, float]:
    """Return the value of a guide curve and its first two derivatives.

    Parameters
    ----------
    curve_segments
        Polynomial segments: start (m), then coefficients, highest power first; shape (segments, columns).
    first_segment
        Index of the first segment of the curve.
    n_segments
        Number of segments of the curve.
    x
        Abscissa, m.

    Returns
    -------
    tuple[float, float, float]
        Value, m, first derivative, and second derivative, 1/m.
    """
    k = first_segment
    while k + 1 < first_segment + n_segments and x >= curve_segments[k + 1, 0]:
        k += 1
    local_x, value, derivative, half_second_derivative = x - curve_segments[k, 0], 0.0, 0.0, 0.0
    for column in range(1, curve_segments.shape[1]):
        half_second_derivative = half_second_derivative * local_x + derivative
        derivative = derivative * local_x + value
        value = value * local_x + curve_segments[k, column]
    return value, derivative, 2.0 * half_second_derivative


@jit_in_place
def evaluate_rows(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, row_values: FloatArray, jacobian: FloatArray) -> None:
    """Fill residual and gamma of row_values (rows, 5), and the Jacobian (rows, 2, 3) with respect to both bodies' poses.

    The prescribed motion is in row_values already. J * accelerations = gamma keeps the joints closed and follows the
    drives.
    """
    for i in range(rows.table.size):
        row = rows.table[i]
        first, second = row.first, row.second
        x1, y1, rx1, ry1, u1, v1, w1, angle1 = row.x1, row.y1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if first >= 0:
            angle1, w1 = poses[first, 2], velocities[first, 2]
            if x1 != 0.0 or y1 != 0.0:
                rx1, ry1 = rotate_vector_jit(angle1, x1, y1)
            x1, y1 = poses[first, 0] + rx1, poses[first, 1] + ry1
            u1, v1 = velocities[first, 0] - ry1 * w1, velocities[first, 1] + rx1 * w1
        x2, y2, rx2, ry2, u2, v2, w2, angle2 = row.x2, row.y2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if second >= 0:
            angle2, w2 = poses[second, 2], velocities[second, 2]
            if x2 != 0.0 or y2 != 0.0:
                rx2, ry2 = rotate_vector_jit(angle2, x2, y2)
            x2, y2 = poses[second, 0] + rx2, poses[second, 1] + ry2
            u2, v2 = velocities[second, 0] - ry2 * w2, velocities[second, 1] + rx2 * w2
        first_point_weight = 1.0 - row.p5 if row.kind == RowKind.FIXED_DIRECTION else 1.0
        if first_point_weight != 1.0:
            x1, y1 = first_point_weight * x1, first_point_weight * y1
            rx1, ry1 = first_point_weight * rx1, first_point_weight * ry1
            u1, v1 = first_point_weight * u1, first_point_weight * v1
        dx, dy, du, dv = x2 - x1, y2 - y1, u2 - u1, v2 - v1
        angle_derivative1 = angle_derivative2 = quadratic_term = 0.0
        if row.kind == RowKind.DISTANCE:
            length = math.hypot(dx, dy)
            nx, ny = dx / length, dy / length
            residual = length - row.p0
            radial_velocity = nx * du + ny * dv
            quadratic_term = (du * du + dv * dv - radial_velocity * radial_velocity) / length
        elif row.kind == RowKind.FIXED_DIRECTION:
            nx, ny, angle_derivative1, angle_derivative2 = row.p0, row.p1, row.p2, row.p3
            residual = nx * dx + ny * dy + angle_derivative1 * angle1 + angle_derivative2 * angle2 - row.p4
        elif row.kind == RowKind.LINE_ANGLE:
            length_squared = dx * dx + dy * dy
            nx, ny = -dy / length_squared, dx / length_squared
            residual = math.atan2(dx, -dy) - row.p4
            quadratic_term = -2.0 * (nx * du + ny * dv) * (dx * du + dy * dv) / length_squared
        elif row.kind == RowKind.ARC_POSITION:
            angle, scale = row.p0 + angle1, row.p1 / (dx * dx + dy * dy)
            ux, uy = math.cos(angle), math.sin(angle)
            nx, ny, angle_derivative1 = -scale * dy, scale * dx, -row.p1
            residual = row.p1 * math.atan2(ux * dy - uy * dx, ux * dx + uy * dy) - row.p4
            quadratic_term = -2.0 * (nx * du + ny * dv) * (dx * du + dy * dv) / (dx * dx + dy * dy)
        elif row.kind == RowKind.FOLLOWER_HEIGHT:
            horizontal_offset, weighted_ratio = row.p0 + row.p2 * x2, row.p5 * row.p2
            vertical_drop = math.sqrt(max(row.p3 * row.p3 - horizontal_offset * horizontal_offset, MIN_DROP_SQUARED))
            rod_slope = horizontal_offset / vertical_drop
            nx, ny = weighted_ratio * rod_slope, weighted_ratio
            residual = row.p5 * (row.p1 + row.p2 * y2 - vertical_drop) + y1 - row.p4
            quadratic_term = weighted_ratio * row.p2 * (1.0 + rod_slope * rod_slope) / vertical_drop * u2 * u2 - w1 * w1 * (
                nx * rx1 + (ny + 1.0) * ry1
            )
        else:
            angle = row.p0 + angle1
            ux, uy = math.cos(angle), math.sin(angle)
            nx, ny = -uy, ux
            normal_offset, axial_offset = nx * dx + ny * dy, ux * dx + uy * dy
            normal_velocity, axial_velocity = nx * du + ny * dv, ux * du + uy * dv
            residual = normal_offset - row.p4
            angle_derivative1 = -axial_offset  # the line rotates with its body
            quadratic_term = -2.0 * w1 * axial_velocity - w1 * w1 * normal_offset
            if row.n_segments > 0:
                curve_value, curve_derivative, curve_second_derivative = evaluate_curve(
                    rows.curve_segments, row.first_segment, row.n_segments, axial_offset
                )
                residual -= curve_value
                angle_derivative1 -= curve_derivative * normal_offset
                slot_velocity = axial_velocity + w1 * normal_offset
                quadratic_term -= (
                    curve_derivative * (2.0 * w1 * normal_velocity - w1 * w1 * axial_offset)
                    + curve_second_derivative * slot_velocity * slot_velocity
                )
                nx, ny = nx - curve_derivative * ux, ny - curve_derivative * uy
        row_values[i, RowColumn.RESIDUAL] = residual - row_values[i, RowColumn.DRIVE_VALUE]
        jacobian[i, 0, 0], jacobian[i, 0, 1] = -first_point_weight * nx, -first_point_weight * ny
        jacobian[i, 0, 2] = nx * ry1 - ny * rx1 + angle_derivative1
        jacobian[i, 1, 0], jacobian[i, 1, 1], jacobian[i, 1, 2] = nx, ny, ny * rx2 - nx * ry2 + angle_derivative2
        if row.kind == RowKind.FOLLOWER_HEIGHT:
            jacobian[i, 0, 0], jacobian[i, 0, 1], jacobian[i, 0, 2] = 0.0, 1.0, rx1
        centripetal_x, centripetal_y = w1 * w1 * rx1 - w2 * w2 * rx2, w1 * w1 * ry1 - w2 * w2 * ry2
        row_values[i, RowColumn.GAMMA] = row_values[i, RowColumn.DRIVE_ACCELERATION] - (
            nx * centripetal_x + ny * centripetal_y + quadratic_term
        )


def evaluate_residuals(rows: ConstraintRows, poses: FloatArray, drive_values: FloatArray) -> FloatArray:
    """Return the residuals of constraint rows at many poses.

    Parameters
    ----------
    rows
        Constraint rows.
    poses
        Poses of the body origins, m and rad; shape (n, bodies, 3).
    drive_values
        Prescribed value, rate and acceleration of each row; shape (n, rows, 3).

    Returns
    -------
    FloatArray
        Residuals, m; shape (n, rows).
    """
    return _evaluate_rows_at_states(rows, poses, np.zeros(poses.shape), drive_values)[0][:, :, RowColumn.RESIDUAL]


def evaluate_gamma(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, drive_values: FloatArray) -> FloatArray:
    """Return the right-hand side of J * accelerations = gamma at many states.

    Parameters
    ----------
    rows
        Constraint rows.
    poses
        Poses of the body origins, m and rad; shape (n, bodies, 3).
    velocities
        Their time derivatives; shape (n, bodies, 3).
    drive_values
        Prescribed value, rate and acceleration of each row; shape (n, rows, 3).

    Returns
    -------
    FloatArray
        Gamma, m/s2; shape (n, rows).
    """
    return _evaluate_rows_at_states(rows, poses, velocities, drive_values)[0][:, :, RowColumn.GAMMA]


def evaluate_jacobian(rows: ConstraintRows, poses: FloatArray) -> FloatArray:
    """Return the Jacobian of the residuals at many poses.

    Parameters
    ----------
    rows
        Constraint rows.
    poses
        Poses of the body origins, m and rad; shape (n, bodies, 3).

    Returns
    -------
    FloatArray
        Derivatives with respect to all poses, m/m and m/rad; shape (n, rows, bodies, 3).
    """
    drive_values = np.zeros((len(poses), len(rows.table), 3))
    row_jacobians = _evaluate_rows_at_states(rows, poses, np.zeros(poses.shape), drive_values)[1]
    n_states, n_bodies, _ = poses.shape
    jacobian = np.zeros((n_states, len(rows.table), n_bodies + 1, 3))  # the ground, of index -1, is the last body
    indices = np.arange(len(rows.table))
    for side in range(2):
        jacobian[:, indices, rows.row_bodies[:, side]] += row_jacobians[:, :, side]
    return np.ascontiguousarray(jacobian[:, :, :n_bodies])


def evaluate_values_and_rates(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the residuals of rows without prescribed motion, and their rates, at many states.

    Parameters
    ----------
    rows
        Rows, as those of output variables.
    poses
        Poses of the body origins, m and rad; shape (n, bodies, 3).
    velocities
        Their time derivatives; shape (n, bodies, 3).

    Returns
    -------
    values : FloatArray
        Residuals, m or rad; shape (n, rows).
    rates : FloatArray
        Their time derivatives; shape (n, rows).
    """
    row_values, row_jacobians = _evaluate_rows_at_states(rows, poses, velocities, np.zeros((len(poses), len(rows.table), 3)))
    return row_values[:, :, RowColumn.RESIDUAL], _directional_derivatives(rows, row_jacobians, velocities)


def evaluate_values_and_derivatives(
    rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, accelerations: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the residuals of rows without prescribed motion, and their first two derivatives, at many states.

    Parameters
    ----------
    rows
        Rows, as those of output variables.
    poses
        Poses of the body origins, m and rad; shape (n, bodies, 3).
    velocities
        Their derivatives; shape (n, bodies, 3).
    accelerations
        Their second derivatives; shape (n, bodies, 3).

    Returns
    -------
    values : FloatArray
        Residuals, m or rad; shape (n, rows).
    rates : FloatArray
        Their derivatives; shape (n, rows).
    second_derivatives : FloatArray
        Their second derivatives; shape (n, rows).
    """
    row_values, row_jacobians = _evaluate_rows_at_states(rows, poses, velocities, np.zeros((len(poses), len(rows.table), 3)))
    linear, rates = (_directional_derivatives(rows, row_jacobians, motion) for motion in (accelerations, velocities))
    return row_values[:, :, RowColumn.RESIDUAL], rates, linear - row_values[:, :, RowColumn.GAMMA]


def _directional_derivatives(rows: ConstraintRows, row_jacobians: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the derivatives (n, rows) of residuals along directions (n, bodies, 3) of the poses."""
    result = np.zeros(row_jacobians.shape[:2])
    add_directional_derivatives(rows.row_bodies, row_jacobians, np.ascontiguousarray(directions), result)
    return result


@jit
def add_directional_derivatives(row_bodies: IntArray, row_jacobians: FloatArray, directions: FloatArray, result: FloatArray) -> None:
    """Add the derivatives of residuals along directions of the poses.

    Parameters
    ----------
    row_bodies
        First and second body of each row; -1 for the ground; shape (rows, 2).
    row_jacobians
        Derivatives of each residual by the poses of both bodies; shape (n, rows, 2, 3).
    directions
        Changes of the poses; shape (n, bodies, 3).
    result
        Sums of derivatives; shape (n, rows).
    """
    for k in range(result.shape[0]):
        for i in range(result.shape[1]):
            for side in range(2):
                body = row_bodies[i, side]
                if body >= 0:
                    for c in range(3):
                        result[k, i] += row_jacobians[k, i, side, c] * directions[k, body, c]


def _evaluate_rows_at_states(
    rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, drive_values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return row values (n, rows, columns) and Jacobians (n, rows, 2, 3) at many states."""
    n_states, n_rows = len(poses), len(rows.table)
    row_values, row_jacobians = np.empty((n_states, n_rows, N_ROW_COLUMNS)), np.empty((n_states, n_rows, 2, 3))
    row_values[:, :, :3] = drive_values
    evaluate_rows_at_states(rows, np.ascontiguousarray(poses), np.ascontiguousarray(velocities), row_values, row_jacobians)
    return row_values, row_jacobians


@jit_in_place
def evaluate_rows_at_states(
    rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, row_values: FloatArray, row_jacobians: FloatArray
) -> None:
    """Fill row values (n, rows, columns), which contain the prescribed motion, and Jacobians (n, rows, 2, 3) at n states."""
    for k in range(poses.shape[0]):
        evaluate_rows(rows, poses[k], velocities[k], row_values[k], row_jacobians[k])
