"""Residuals, Jacobian and right-hand side gamma of the constraint rows, as compiled kernels.

Every joint is one to three rows of a few kinds. The residual of a row is the distance (m) between a point of a first
and a point of a second body along a direction that depends on the kind, less the value that a drive prescribes. Bodies
are indices into poses (bodies, 3), or GROUND_INDEX. Where the rows of a mechanism contain the angle of a third body,
all arrays by the bodies of a row have three sides instead of two.
"""

import math
from typing import NamedTuple

from governor_mechanism.mechanics.curves.outline_kernels import (
    NO_FEATURE,
    Circle,
    EdgePoint,
    NearestPoint,
    PointOffset,
    distance_from_feature,
    distance_from_pieces,
    distance_from_polar_curve,
    extent_of_feature,
    find_feature,
    find_nearest_point,
    next_feature,
)
from governor_mechanism.mechanics.curves.profile_kernels import (
    ConvexCurve,
    ProfileDistance,
    distance_of_curve_from_feature,
    distance_of_profiles,
    touched_point,
)
from governor_mechanism.mechanics.curves.segments import evaluate_curve, evaluate_polar_curve
from governor_mechanism.mechanics.kinematics.constraint_rows import ANY_USE, NO_POINT, ConstraintRows, RowColumn, rotate_vector
from governor_mechanism.mechanics.kinematics.time_functions import evaluate_motion
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.numerics.jit import jit_in_place, jit_inlined
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, RecordArray

MIN_DROP_SQUARED = 1e-300
"""Lower bound (m2) of the squared height of a follower's link, which avoids a division by zero for a horizontal link."""

rotate_vector_jit = jit_in_place(rotate_vector)


@jit_in_place
def evaluate_drives(rows: ConstraintRows, input_cubics: FloatArray, local_time: float, row_values: FloatArray) -> None:
    """Fill the prescribed motion into row_values (rows, 5) from the local cubics and harmonics of the inputs."""
    for i in range(rows.table.size):
        drive, drive_scale = rows.table[i].drive, rows.table[i].drive_scale
        if drive != NO_INDEX:
            value, rate, acceleration = evaluate_motion(input_cubics, drive, local_time)
            row_values[i, RowColumn.DRIVE_VALUE] = drive_scale * value
            row_values[i, RowColumn.DRIVE_RATE] = drive_scale * rate
            row_values[i, RowColumn.DRIVE_ACCELERATION] = drive_scale * acceleration


class PointMotion(NamedTuple):
    """A point of a body: position (m), lever from the origin (m), velocity (m/s), and angle (rad) and rate (rad/s) of the body."""

    x: float
    y: float
    lever_x: float
    lever_y: float
    u: float
    v: float
    angle: float
    angular_velocity: float


class RowGeometry(NamedTuple):
    """Value of a constraint row and its derivatives by the second point and by the angles of both bodies.

    The quadratic term is the second time derivative of the value without accelerations and without centripetal ones.
    """

    value: float
    normal_x: float
    normal_y: float
    first_angle_derivative: float
    second_angle_derivative: float
    quadratic_term: float


@jit_in_place
def _move_point(poses: FloatArray, velocities: FloatArray, body: int, x: float, y: float) -> PointMotion:
    """Return the motion of a point (m) in the axes of a body, or on the ground."""
    if body == GROUND_INDEX:
        return PointMotion(x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    lever_x, lever_y = 0.0, 0.0
    angle, angular_velocity = poses[body, 2], velocities[body, 2]
    if x != 0.0 or y != 0.0:
        lever_x, lever_y = rotate_vector_jit(angle, x, y)
    u = velocities[body, 0] - lever_y * angular_velocity
    v = velocities[body, 1] + lever_x * angular_velocity
    return PointMotion(poses[body, 0] + lever_x, poses[body, 1] + lever_y, lever_x, lever_y, u, v, angle, angular_velocity)


@jit_in_place
def _scale_point(point: PointMotion, weight: float) -> PointMotion:
    """Return the motion of a point with a weighted position."""
    lever_x, lever_y = weight * point.lever_x, weight * point.lever_y
    u, v = weight * point.u, weight * point.v
    return PointMotion(weight * point.x, weight * point.y, lever_x, lever_y, u, v, point.angle, point.angular_velocity)


@jit_in_place
def _distance_row(dx: float, dy: float, du: float, dv: float) -> RowGeometry:
    length = math.sqrt(dx * dx + dy * dy)  # half the time of hypot, which guards against overflow
    nx, ny = dx / length, dy / length
    radial_velocity = nx * du + ny * dv
    return RowGeometry(length, nx, ny, 0.0, 0.0, (du * du + dv * dv - radial_velocity * radial_velocity) / length)


@jit_in_place
def _fixed_direction_row(
    row: RecordArray, dx: float, dy: float, first_angle: float, second_angle: float, third_angle: float
) -> RowGeometry:
    nx = row.direction_x
    ny = row.direction_y
    first_factor = row.first_angle_factor
    second_factor = row.second_angle_factor
    value = nx * dx + ny * dy + first_factor * first_angle + second_factor * second_angle + row.third_angle_factor * third_angle
    return RowGeometry(value, nx, ny, first_factor, second_factor, 0.0)


@jit_in_place
def _line_angle_row(dx: float, dy: float, du: float, dv: float) -> RowGeometry:
    length_squared = dx * dx + dy * dy
    nx, ny = -dy / length_squared, dx / length_squared
    quadratic_term = -2.0 * (nx * du + ny * dv) * (dx * du + dy * dv) / length_squared
    return RowGeometry(math.atan2(dx, -dy), nx, ny, 0.0, 0.0, quadratic_term)


@jit_in_place
def _arc_position_row(row: RecordArray, dx: float, dy: float, du: float, dv: float, first_angle: float) -> RowGeometry:
    angle, scale = row.angle + first_angle, row.radius / (dx * dx + dy * dy)
    ux, uy = math.cos(angle), math.sin(angle)
    nx, ny = -scale * dy, scale * dx
    value = row.radius * math.atan2(ux * dy - uy * dx, ux * dx + uy * dy)
    quadratic_term = -2.0 * (nx * du + ny * dv) * (dx * du + dy * dv) / (dx * dx + dy * dy)
    return RowGeometry(value, nx, ny, -row.radius, 0.0, quadratic_term)


@jit_in_place
def _follower_height_row(row: RecordArray, first: PointMotion, second: PointMotion) -> RowGeometry:
    """Return the height of a follower; its derivative by the first point is 1 in y."""
    horizontal_offset = row.rod_x + row.rod_weight * second.x
    weighted_ratio = row.follower_sign * row.rod_weight
    vertical_drop = math.sqrt(max(row.link_length * row.link_length - horizontal_offset * horizontal_offset, MIN_DROP_SQUARED))
    rod_slope = horizontal_offset / vertical_drop
    nx, ny = weighted_ratio * rod_slope, weighted_ratio
    value = row.follower_sign * (row.rod_y + row.rod_weight * second.y - vertical_drop) + first.y
    w1 = first.angular_velocity
    quadratic_term = weighted_ratio * row.rod_weight * (1.0 + rod_slope * rod_slope) / vertical_drop * second.u * second.u - w1 * w1 * (
        nx * first.lever_x + (ny + 1.0) * first.lever_y
    )
    return RowGeometry(value, nx, ny, 0.0, 0.0, quadratic_term)


@jit_in_place
def _body_normal_row(row: RecordArray, curve_segments: FloatArray, first: PointMotion, second: PointMotion) -> RowGeometry:
    dx = second.x - first.x
    dy = second.y - first.y
    du = second.u - first.u
    dv = second.v - first.v
    w1 = first.angular_velocity
    angle = row.angle + first.angle
    ux, uy = math.cos(angle), math.sin(angle)
    nx, ny = -uy, ux
    normal_offset, axial_offset = nx * dx + ny * dy, ux * dx + uy * dy
    normal_velocity, axial_velocity = nx * du + ny * dv, ux * du + uy * dv
    value = normal_offset
    angle_derivative = -axial_offset  # the line rotates with its body
    quadratic_term = -2.0 * w1 * axial_velocity - w1 * w1 * normal_offset
    if row.n_segments > 0:
        curve_value, curve_derivative, curve_second_derivative = evaluate_curve(
            curve_segments, row.first_segment, row.n_segments, axial_offset
        )
        value -= curve_value
        angle_derivative -= curve_derivative * normal_offset
        slot_velocity = axial_velocity + w1 * normal_offset
        quadratic_term -= (
            curve_derivative * (2.0 * w1 * normal_velocity - w1 * w1 * axial_offset)
            + curve_second_derivative * slot_velocity * slot_velocity
        )
        nx, ny = nx - curve_derivative * ux, ny - curve_derivative * uy
    return RowGeometry(value, nx, ny, angle_derivative, 0.0, quadratic_term)


@jit_in_place
def _polar_curve_row(row: RecordArray, curve_segments: FloatArray, first: PointMotion, second: PointMotion) -> RowGeometry:
    """Return how far the second point lies outside a closed curve about the first, along the line through both."""
    dx = second.x - first.x
    dy = second.y - first.y
    du = second.u - first.u
    dv = second.v - first.v
    distance = math.hypot(dx, dy)
    ux, uy = dx / distance, dy / distance
    radial_velocity = ux * du + uy * dv
    direction_rate = (ux * dv - uy * du) / distance
    radius, slope, second_derivative = evaluate_polar_curve(
        curve_segments, row.first_segment, row.n_segments, math.atan2(dy, dx) - row.angle - first.angle
    )
    curve_rate = direction_rate - first.angular_velocity
    quadratic_term = (distance * direction_rate + 2.0 * slope * radial_velocity / distance) * direction_rate
    quadratic_term -= second_derivative * curve_rate * curve_rate
    nx, ny = ux + slope * uy / distance, uy - slope * ux / distance
    return RowGeometry(distance - radius, nx, ny, slope, 0.0, quadratic_term)


@jit_in_place
def _outline_distance_row(row: RecordArray, curve_segments: FloatArray, first: PointMotion, second: PointMotion) -> RowGeometry:
    """Return the distance of the second point from an outline of the first body, or its slip along the outline."""
    dx = second.x - first.x
    dy = second.y - first.y
    du = second.u - first.u
    dv = second.v - first.v
    w1 = first.angular_velocity
    cosine, sine = math.cos(first.angle), math.sin(first.angle)
    x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
    if row.kept_feature != NO_FEATURE:
        distance = distance_from_feature(curve_segments, row.kept_feature, x, y)
    elif row.kind == RowKind.PIECES_DISTANCE or row.kind == RowKind.PIECES_SLIP:
        distance = distance_from_pieces(curve_segments, row.first_segment, row.n_segments, x, y, math.inf)
    else:
        distance = distance_from_polar_curve(curve_segments, row.first_segment, row.n_segments, x, y)
    nx = cosine * distance.normal_x - sine * distance.normal_y
    ny = sine * distance.normal_x + cosine * distance.normal_y
    # velocity of the point as seen from the body, in directions fixed in the plane
    u, v = du + w1 * dy, dv - w1 * dx
    sliding_velocity = nx * v - ny * u
    if row.kind == RowKind.CURVE_SLIP or row.kind == RowKind.PIECES_SLIP:
        # The tangent (-ny, nx) turns with the body and as the point goes along the line; the roller turns with the second body.
        turning = -(w1 + distance.curvature * sliding_velocity) * (nx * u + ny * v) - w1 * (nx * du + ny * dv)
        return RowGeometry(0.0, -ny, nx, row.radius - nx * dx - ny * dy, -row.radius, turning)
    quadratic_term = 2.0 * w1 * (nx * v - ny * u) + w1 * w1 * (nx * dx + ny * dy)
    quadratic_term += distance.curvature * sliding_velocity * sliding_velocity
    return RowGeometry(distance.value, nx, ny, nx * dy - ny * dx, 0.0, quadratic_term)


@jit_in_place
def _find_nearest_pair(row: RecordArray, curve_segments: FloatArray, first: PointMotion, second: PointMotion) -> ProfileDistance:
    """Return how near a curve about the second point is to the outline of the first body, or to the feature that is kept."""
    dx = second.x - first.x
    dy = second.y - first.y
    turn = second.angle - first.angle
    cosine, sine = math.cos(first.angle), math.sin(first.angle)
    x = cosine * dx + sine * dy
    y = cosine * dy - sine * dx
    first_curve_segment = row.first_segment + row.n_segments
    inset = row.radius - row.constant  # one of both is 0
    curve = ConvexCurve(curve_segments, first_curve_segment, row.n_curve_segments, x, y, math.cos(turn), math.sin(turn), inset)
    if row.kept_feature != NO_FEATURE:
        return distance_of_curve_from_feature(curve_segments, row.kept_feature, curve)
    return distance_of_profiles(curve_segments, row.first_segment, row.n_segments, curve)


@jit_in_place
def _profile_row(row: RecordArray, curve_segments: FloatArray, first: PointMotion, second: PointMotion) -> RowGeometry:
    """Return the distance of a curve about the second point from lines and arcs of the first body, or its slip along them."""
    # As both roll and slide on each other, the normal turns back at the rate q k1 by the curvature k1
    # of the edge; a corner has q = rate, as the nearest point does not move on it.
    dx = second.x - first.x
    dy = second.y - first.y
    w1 = first.angular_velocity
    w2 = second.angular_velocity
    cosine, sine = math.cos(first.angle), math.sin(first.angle)
    x = cosine * dx + sine * dy
    y = cosine * dy - sine * dx
    pair = _find_nearest_pair(row, curve_segments, first, second)
    nx = cosine * pair.normal_x - sine * pair.normal_y
    ny = sine * pair.normal_x + cosine * pair.normal_y
    # the point of the curve from the second point and from the first one, in directions fixed in the plane
    fx = cosine * (pair.x - x) - sine * (pair.y - y)
    fy = sine * (pair.x - x) + cosine * (pair.y - y)
    ex, ey = dx + fx, dy + fy
    # its velocity as seen from the first body, and the rates at which the nearest points move along edge and curve
    u = second.u - first.u - w2 * fy + w1 * ey
    v = second.v - first.v + w2 * fx - w1 * ex
    sliding_velocity = ny * u - nx * v
    stiffness = pair.edge_curvature * (1.0 + pair.value * pair.curvature) + pair.edge_share * pair.curvature
    edge_rate = (pair.curvature * sliding_velocity - w2 + w1) / stiffness
    normal_rate = pair.edge_curvature * edge_rate
    if row.kind == RowKind.PROFILE_SLIP:
        # The tangent (-ny, nx) turns with the normal; the levers are those of the point of the profile, inside of the curve.
        turning = w1 - normal_rate
        approach = nx * (second.u - first.u) + ny * (second.v - first.v)
        first_lever = nx * ex + ny * ey + row.radius
        second_lever = nx * fx + ny * fy + row.radius
        quadratic_term = w2 * (turning - w2) * (nx * fy - ny * fx) - (turning + w1) * approach
        quadratic_term -= w1 * (turning * (nx * ey - ny * ex) - w2 * (nx * fy - ny * fx))
        return RowGeometry(0.0, -ny, nx, -first_lever, second_lever, quadratic_term)
    curve_rate = pair.edge_share * edge_rate + pair.value * normal_rate - sliding_velocity
    quadratic_term = 2.0 * w1 * (nx * v - ny * u) - w2 * w2 * (nx * fx + ny * fy) + w1 * w1 * (nx * ex + ny * ey)
    quadratic_term += (w2 - w1) * curve_rate + normal_rate * sliding_velocity
    return RowGeometry(pair.value, nx, ny, nx * ey - ny * ex, ny * fx - nx * fy, quadratic_term)


@jit_in_place
def _find_nearest_point(
    row: RecordArray, curve_segments: FloatArray, poses: FloatArray, first: PointMotion, excluded_point: int
) -> NearestPoint:
    """Return that of the points of the second body which is nearest to the outline of the first one, where one point is left out."""
    dx, dy = poses[row.second, 0] - first.x, poses[row.second, 1] - first.y
    cosine = math.cos(first.angle)
    sine = math.sin(first.angle)
    turn = poses[row.second, 2] - first.angle
    offset = PointOffset(cosine * dx + sine * dy, cosine * dy - sine * dx, math.cos(turn), math.sin(turn))
    bound = Circle(row.bound_x, row.bound_y, row.bound_radius)
    return find_nearest_point(curve_segments, row.first_segment, row.n_segments, row.n_points, excluded_point, offset, bound)


@jit_in_place
def _move_second_point(
    row: RecordArray, curve_segments: FloatArray, poses: FloatArray, velocities: FloatArray, first: PointMotion
) -> PointMotion:
    """Return the motion of the second point of a row: of several the one that is kept, or else the nearest one."""
    x, y = row.x2, row.y2
    if row.n_points > 0:
        k, c = row.kept_point, curve_segments.shape[1] - 2
        if k == NO_POINT:
            k = _find_nearest_point(row, curve_segments, poses, first, NO_POINT).row
        x, y = curve_segments[k, c], curve_segments[k, c + 1]
    return _move_point(poses, velocities, row.second, x, y)


@jit_inlined
def _evaluate_row(row: RecordArray, curve_segments: FloatArray, first: PointMotion, second: PointMotion, third_angle: float) -> RowGeometry:
    """Return the value of a row of any kind, and its derivatives."""
    dx = second.x - first.x
    dy = second.y - first.y
    du = second.u - first.u
    dv = second.v - first.v
    if row.kind == RowKind.DISTANCE:
        return _distance_row(dx, dy, du, dv)
    if row.kind == RowKind.FIXED_DIRECTION:
        return _fixed_direction_row(row, dx, dy, first.angle, second.angle, third_angle)
    if row.kind == RowKind.LINE_ANGLE:
        return _line_angle_row(dx, dy, du, dv)
    if row.kind == RowKind.ARC_POSITION:
        return _arc_position_row(row, dx, dy, du, dv, first.angle)
    if row.kind == RowKind.FOLLOWER_HEIGHT:
        return _follower_height_row(row, first, second)
    if row.kind == RowKind.POLAR_CURVE:
        return _polar_curve_row(row, curve_segments, first, second)
    if row.kind >= RowKind.PROFILE_DISTANCE:
        return _profile_row(row, curve_segments, first, second)
    if row.kind >= RowKind.CURVE_DISTANCE:
        return _outline_distance_row(row, curve_segments, first, second)
    return _body_normal_row(row, curve_segments, first, second)


@jit_in_place
def evaluate_rows_for(
    use: int, rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, row_values: FloatArray, jacobian: FloatArray
) -> None:
    """Fill what `evaluate_rows` fills for the rows of a use, FOR_FORCES or FOR_EVENTS, alone."""
    for i in range(rows.table.size):
        row = rows.table[i]
        if use != ANY_USE and not row.use & use:
            continue
        first = _move_point(poses, velocities, row.first, row.x1, row.y1)
        second = _move_second_point(row, rows.curve_segments, poses, velocities, first)
        weight = row.first_point_weight
        if weight != 1.0:
            first = _scale_point(first, weight)
        third_angle = 0.0
        if row.third != GROUND_INDEX:
            third_angle = poses[row.third, 2]
            jacobian[i, 2, 0], jacobian[i, 2, 1], jacobian[i, 2, 2] = 0.0, 0.0, row.third_angle_factor
        geometry = _evaluate_row(row, rows.curve_segments, first, second, third_angle)
        nx = geometry.normal_x
        ny = geometry.normal_y
        w1 = first.angular_velocity
        w2 = second.angular_velocity
        row_values[i, RowColumn.RESIDUAL] = geometry.value - row.constant - row_values[i, RowColumn.DRIVE_VALUE]
        jacobian[i, 0, 0], jacobian[i, 0, 1] = -weight * nx, -weight * ny
        jacobian[i, 0, 2] = nx * first.lever_y - ny * first.lever_x + geometry.first_angle_derivative
        jacobian[i, 1, 0], jacobian[i, 1, 1] = nx, ny
        jacobian[i, 1, 2] = ny * second.lever_x - nx * second.lever_y + geometry.second_angle_derivative
        if row.kind == RowKind.FOLLOWER_HEIGHT:
            jacobian[i, 0, 0], jacobian[i, 0, 1], jacobian[i, 0, 2] = 0.0, 1.0, first.lever_x
        centripetal_x = w1 * w1 * first.lever_x - w2 * w2 * second.lever_x
        centripetal_y = w1 * w1 * first.lever_y - w2 * w2 * second.lever_y
        row_values[i, RowColumn.GAMMA] = row_values[i, RowColumn.DRIVE_ACCELERATION] - (
            nx * centripetal_x + ny * centripetal_y + geometry.quadratic_term
        )


@jit_inlined
def evaluate_rows(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray, row_values: FloatArray, jacobian: FloatArray) -> None:
    """Fill residual and gamma of row_values (rows, 5), and the Jacobian (rows, sides, 3) with respect to the poses of the bodies."""
    # The prescribed motion is in row_values already. J * accelerations = gamma keeps the joints closed
    # and follows the drives.
    evaluate_rows_for(ANY_USE, rows, poses, velocities, row_values, jacobian)


@jit_in_place
def _locate_touch(row: RecordArray, curve_segments: FloatArray, poses: FloatArray, velocities: FloatArray) -> EdgePoint:
    """Return the point of an outline that is touched, and in which sense it moves along the outline."""
    first = _move_point(poses, velocities, row.first, row.x1, row.y1)
    second = _move_second_point(row, curve_segments, poses, velocities, first)
    geometry = _evaluate_row(row, curve_segments, first, second, 0.0)
    dx = second.x - first.x
    dy = second.y - first.y
    w1 = first.angular_velocity
    cosine, sine = math.cos(first.angle), math.sin(first.angle)
    if row.kind >= RowKind.PROFILE_DISTANCE:
        touched = touched_point(_find_nearest_pair(row, curve_segments, first, second))
        ex = cosine * touched.x - sine * touched.y
        ey = sine * touched.x + cosine * touched.y
    else:
        # The normal of a row of slip is its direction turned.
        is_slip = row.kind == RowKind.PIECES_SLIP
        nx, ny = (geometry.normal_y, -geometry.normal_x) if is_slip else (geometry.normal_x, geometry.normal_y)
        reach = row.radius if is_slip else geometry.value
        ex, ey = dx - nx * reach, dy - ny * reach
        touched = EdgePoint(cosine * ex + sine * ey, cosine * ey - sine * ex, cosine * nx + sine * ny, cosine * ny - sine * nx, 0.0)
    nx = cosine * touched.normal_x - sine * touched.normal_y
    ny = sine * touched.normal_x + cosine * touched.normal_y
    u, v = second.u - first.u + w1 * ey, second.v - first.v - w1 * ex
    return EdgePoint(touched.x, touched.y, touched.normal_x, touched.normal_y, nx * v - ny * u)


@jit_in_place
def evaluate_join(rows: ConstraintRows, i: int, poses: FloatArray, velocities: FloatArray) -> float:
    """Return how far what touches an outline is beyond the feature that row i keeps, negative within it; -1 if none is kept."""
    row = rows.table[i]
    if row.kept_feature == NO_FEATURE:
        return -1.0
    extent = extent_of_feature(rows.curve_segments, row.kept_feature, _locate_touch(row, rows.curve_segments, poses, velocities))
    return max(extent.beyond_start, extent.beyond_end)


@jit_in_place
def evaluate_ends(rows: ConstraintRows, i: int, poses: FloatArray, velocities: FloatArray) -> tuple[float, float]:
    """Return how far what touches an outline is beyond both ends of the feature that row i keeps."""
    row = rows.table[i]
    extent = extent_of_feature(rows.curve_segments, row.kept_feature, _locate_touch(row, rows.curve_segments, poses, velocities))
    return extent.beyond_start, extent.beyond_end


@jit_in_place
def evaluate_other_gap(rows: ConstraintRows, i: int, poses: FloatArray, velocities: FloatArray) -> float:
    """Return the gap of row i for the nearest one of its points that is not kept."""
    row = rows.table[i]
    first = _move_point(poses, velocities, row.first, row.x1, row.y1)
    return float(_find_nearest_point(row, rows.curve_segments, poses, first, row.kept_point).distance - row.constant)


@jit_in_place
def keep_feature(rows: ConstraintRows, i: int, poses: FloatArray, velocities: FloatArray) -> None:
    """Keep the feature that row i touches, and of several points the one that does; behind an end of that kept before, the next one."""
    row, pieces = rows.table[i], rows.curve_segments
    is_slip = row.kind == RowKind.PIECES_SLIP
    is_profile = row.kind >= RowKind.PROFILE_DISTANCE
    is_roller = is_slip or row.kind == RowKind.PIECES_DISTANCE
    if not (is_roller and (row.radius if is_slip else row.constant) > 0.0) and not is_profile:
        return  # a point has no way round a corner
    if row.n_points > 0 and row.kept_point == NO_POINT:
        first = _move_point(poses, velocities, row.first, row.x1, row.y1)
        row.kept_point = _find_nearest_point(row, pieces, poses, first, NO_POINT).row
    point, kept = _locate_touch(row, pieces, poses, velocities), row.kept_feature
    if kept == NO_FEATURE:
        row.kept_feature = find_feature(pieces, row.first_segment, row.n_segments, point)
        return
    extent = extent_of_feature(pieces, kept, point)
    if max(extent.beyond_start, extent.beyond_end) > 0.0:
        is_at_end = extent.beyond_end > extent.beyond_start
        row.kept_feature = next_feature(pieces, row.first_segment, row.n_segments, kept, is_at_end)


@jit_in_place
def release_feature(rows: ConstraintRows, i: int) -> None:
    """Let row i find what it touches again."""
    row = rows.table[i]
    row.kept_feature, row.kept_point = NO_FEATURE, NO_POINT


@jit_in_place
def keep_features(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray) -> None:
    """Keep the feature that each row touches; see `keep_feature`."""
    for i in range(rows.table.size):
        keep_feature(rows, i, poses, velocities)


@jit_in_place
def release_features(rows: ConstraintRows) -> None:
    """Let all rows find what they touch again."""
    for i in range(rows.table.size):
        release_feature(rows, i)
