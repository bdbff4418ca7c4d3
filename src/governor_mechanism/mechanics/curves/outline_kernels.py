"""Distance of a point from an outline, with its gradient and curvature, and the joins of its edges, as compiled kernels.

The distance d of a point from a smooth line has the normal n as its gradient, and changes along the tangent t as d'' = k (t . q')^2 with
the curvature k of the line at that distance. From a corner the line is a circle.

What touches an outline is on one of its features at a time: on an edge, or round the corner at its end. In a step the feature is kept,
and goes on beyond its ends, so that the equations stay smooth; the step ends where the next feature takes over. Features are numbered
1 + 2 i for edge i and 2 + 2 i for the corner at its end; 0 is none.
"""

import math
from typing import NamedTuple

from governor_mechanism.mechanics.curves.segments import evaluate_polar_curve
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

N_PIECE_VALUES = 6
"""Number of values of a piece of an outline."""

N_CURVE_SAMPLES = 64
"""Points of a closed curve at equal angles, from the nearest of which its nearest point is found."""

MAX_FOOT_ITERATIONS = 60
"""Bound on the iterations to the nearest point of a curve. Newton's take 3 to 6; halving takes the others to rounding."""

FINAL_FOOT_STEP = 1e-8
"""Step of the angle (rad) after which the next of Newton's, which would be its square, is rounding."""


class PointOffset(NamedTuple):
    """Place of a body in the axes of an outline: its origin (m), and the cosine and the sine of its angle."""

    x: float
    y: float
    cosine: float
    sine: float


class Circle(NamedTuple):
    """A circle: centre and radius, m."""

    x: float
    y: float
    radius: float


class NearestPoint(NamedTuple):
    """The row of a point, and its distance, m."""

    row: int
    distance: float


class OutlineDistance(NamedTuple):
    """Distance of a point from an outline (m), the unit normal toward the point, and the curvature of the line at that distance, 1/m.

    The side of the nearest piece is 1 to its right, outside, -1 to its left, and 0 where a corner is nearest that stands out.
    """

    value: float
    normal_x: float
    normal_y: float
    curvature: float
    side: float


@jit_in_place
def _distance_from_end(dx: float, dy: float, ux: float, uy: float, goes_on: bool) -> OutlineDistance:
    """Return the distance from an end of a piece, for the vector from there and the direction of the piece.

    Behind a hollow corner, where the chain does not go on, what is to the left of the piece is inside.
    """
    distance = math.hypot(dx, dy)
    is_inside = not goes_on and ux * dy - uy * dx > 0.0
    return OutlineDistance(distance, dx / distance, dy / distance, 1.0 / distance, -1.0 if is_inside else 0.0)


@jit_in_place
def _goes_on_before(pieces: FloatArray, i: int) -> bool:
    """Return whether the chain goes on before the start of a piece."""
    c = pieces.shape[1] - N_PIECE_VALUES
    return bool(pieces[i, c - 4] != 0.0 or pieces[i, c - 3] != 0.0)


@jit_in_place
def _goes_on_behind(pieces: FloatArray, i: int) -> bool:
    """Return whether the chain goes on behind the end of a piece."""
    c = pieces.shape[1] - N_PIECE_VALUES
    return bool(pieces[i, c - 2] != 0.0 or pieces[i, c - 1] != 0.0)


@jit_in_place
def _distance_from_line(pieces: FloatArray, i: int, x: float, y: float) -> OutlineDistance:
    """Return the distance from a straight piece."""
    c = pieces.shape[1] - N_PIECE_VALUES
    dx = x - pieces[i, c]
    dy = y - pieces[i, c + 1]
    ux = pieces[i, c + 2]
    uy = pieces[i, c + 3]
    length = pieces[i, c + 4]
    along, across = dx * ux + dy * uy, ux * dy - uy * dx
    if along <= 0.0:
        return _distance_from_end(dx, dy, ux, uy, _goes_on_before(pieces, i))
    if along >= length:
        return _distance_from_end(dx - length * ux, dy - length * uy, ux, uy, _goes_on_behind(pieces, i))
    side = 1.0 if across > 0.0 else -1.0
    return OutlineDistance(abs(across), -side * uy, side * ux, 0.0, -side)


@jit_in_place
def _distance_from_arc(pieces: FloatArray, i: int, x: float, y: float) -> OutlineDistance:
    """Return the distance from an arc, which turns left for a positive curvature."""
    c = pieces.shape[1] - N_PIECE_VALUES
    dx = x - pieces[i, c]
    dy = y - pieces[i, c + 1]
    ux = pieces[i, c + 2]
    uy = pieces[i, c + 3]
    radius, span = 1.0 / pieces[i, c + 5], pieces[i, c + 4] * abs(pieces[i, c + 5])
    start_x, start_y = radius * uy, -radius * ux  # from the centre to the start
    ex, ey = dx + start_x, dy + start_y
    angle = math.atan2(start_x * ey - start_y * ex, start_x * ex + start_y * ey) * math.copysign(1.0, radius)
    if angle < 0.0:
        angle += 2.0 * math.pi
    if angle > span:
        if angle - span > 2.0 * math.pi - angle:
            return _distance_from_end(dx, dy, ux, uy, _goes_on_before(pieces, i))
        cosine, sine = math.cos(span), math.copysign(1.0, radius) * math.sin(span)
        dx = ex - (cosine * start_x - sine * start_y)
        dy = ey - (sine * start_x + cosine * start_y)
        return _distance_from_end(dx, dy, cosine * ux - sine * uy, sine * ux + cosine * uy, _goes_on_behind(pieces, i))
    from_centre = math.hypot(ex, ey)
    side = 1.0 if from_centre > abs(radius) else -1.0
    value = side * (from_centre - abs(radius))
    normal_x = side * ex / from_centre
    normal_y = side * ey / from_centre
    return OutlineDistance(value, normal_x, normal_y, side / from_centre, side * math.copysign(1.0, radius))


@jit_in_place
def distance_from_pieces(
    # lines and arcs, see `make_pieces`; the last columns count; shape (pieces, columns)
    pieces: FloatArray,
    first_piece: int,
    n_pieces: int,
    x: float,  # the point, m
    y: float,
    bound: float,  # distance up to which pieces are looked at, m
) -> OutlineDistance:
    """Return the distance of a point from lines and arcs, and the normal, which points toward the point.

    To their left they have an inside up to the depth in the first column, infinity for a closed outline without hollow corners; there
    the distance is negative and the normal points outward. Deeper there may be an outside again.
    """
    c = pieces.shape[1] - N_PIECE_VALUES
    nearest = OutlineDistance(bound, 0.0, 0.0, 0.0, 0.0)
    depth = 0.0
    for i in range(first_piece, first_piece + n_pieces):
        dx = x - pieces[i, c]
        dy = y - pieces[i, c + 1]
        reach = nearest.value + pieces[i, c + 4]
        if dx * dx + dy * dy > reach * reach:
            continue  # a piece is no farther from its start than its length
        is_straight = pieces[i, c + 5] == 0.0
        distance = _distance_from_line(pieces, i, x, y) if is_straight else _distance_from_arc(pieces, i, x, y)
        if distance.value < nearest.value:
            nearest = distance
            depth = pieces[i, 0]
    if nearest.side < 0.0 and nearest.value < depth:
        return OutlineDistance(-nearest.value, -nearest.normal_x, -nearest.normal_y, -nearest.curvature, nearest.side)
    return nearest


@jit_in_place
def least_depth(pieces: FloatArray, points: FloatArray) -> float:
    """Return the least distance of points (points, 2) to the left of pieces whose first column is 0, or infinity."""
    least = math.inf
    for k in range(points.shape[0]):
        distance = distance_from_pieces(pieces, 0, pieces.shape[0], points[k, 0], points[k, 1], least)
        if distance.side < 0.0:
            least = min(least, distance.value)
    return least


@jit_in_place
def find_nearest_point(
    pieces: FloatArray,  # lines and arcs, and behind them the points [x, y], in the last columns; shape (rows, columns)
    first_piece: int,
    n_pieces: int,
    n_points: int,
    excluded_point: int,  # row of a point that is left out, or any other number
    offset: PointOffset,
    bound: Circle,
) -> NearestPoint:
    """Return the nearest point of lines and arcs, of which none lies deeper inside than another is away, by their circle."""
    c = pieces.shape[1] - 2
    first_point = first_piece + n_pieces
    nearest = first_piece + n_pieces
    least = math.inf
    for k in range(first_point, first_point + n_points):
        x = offset.x + offset.cosine * pieces[k, c] - offset.sine * pieces[k, c + 1]
        y = offset.y + offset.sine * pieces[k, c] + offset.cosine * pieces[k, c + 1]
        dx = x - bound.x
        dy = y - bound.y
        reach = bound.radius + max(least, 0.0)
        if k != excluded_point and dx * dx + dy * dy < reach * reach:
            value = distance_from_pieces(pieces, first_piece, n_pieces, x, y, least if least > 0.0 else math.inf).value
            if value < least:
                nearest, least = k, value
    return NearestPoint(nearest, least)


@jit_in_place
def distance_from_polar_curve(
    # polynomial segments of one turn, as for `evaluate_polar_curve`, and then points [x, y] of the curve at
    # equal angles, in the last columns; shape (segments, columns)
    curve_segments: FloatArray,
    first_segment: int,
    n_segments: int,
    x: float,  # the point, m
    y: float,
) -> OutlineDistance:
    """Return the distance of a point from a closed curve, negative inside."""
    c = curve_segments.shape[1] - 2
    first_sample = first_segment + n_segments
    nearest = 0
    least = math.inf
    for i in range(N_CURVE_SAMPLES):
        dx = x - curve_segments[first_sample + i, c]
        dy = y - curve_segments[first_sample + i, c + 1]
        if dx * dx + dy * dy < least:
            nearest, least = i, dx * dx + dy * dy
    spacing = 2.0 * math.pi / N_CURVE_SAMPLES
    angle = nearest * spacing
    low = (nearest - 1) * spacing
    high = (nearest + 1) * spacing
    distance, is_final = OutlineDistance(0.0, 0.0, 0.0, 0.0, 0.0), False
    for _ in range(MAX_FOOT_ITERATIONS):
        radius, slope, second_derivative = evaluate_polar_curve(curve_segments, first_segment, n_segments, angle)
        ux, uy = math.cos(angle), math.sin(angle)
        radial, tangential = x * ux + y * uy, y * ux - x * uy  # the point along the direction and across it
        speed_squared = slope * slope + radius * radius
        # The vector to the point is normal to the curve where `excess` is 0; its derivative is -speed^2 (1 + k d).
        excess = (radial - radius) * slope + tangential * radius
        bending = (radial - radius) * (second_derivative - radius) + 2.0 * tangential * slope
        speed = math.sqrt(speed_squared)
        curvature = (radius * (radius - second_derivative) + 2.0 * slope * slope) / (speed * speed_squared)
        # The normal is the tangent (slope, radius) turned clockwise.
        normal_radial, normal_tangential = radius / speed, -slope / speed
        value = (radial - radius) * normal_radial + tangential * normal_tangential
        nx = normal_radial * ux - normal_tangential * uy
        ny = normal_radial * uy + normal_tangential * ux
        distance = OutlineDistance(value, nx, ny, curvature / (1.0 + curvature * value), 0.0)
        if is_final:
            break
        if excess > 0.0:
            low = angle
        else:
            high = angle
        step = excess / (speed_squared - bending)
        is_final = abs(step) <= FINAL_FOOT_STEP
        angle = angle + step if is_final or low < angle + step < high else 0.5 * (low + high)
    return distance


NO_FEATURE = 0
"""Feature where none is kept."""

SMOOTH_JOIN = 1e-9
"""Sine of the angle between two edges below which there is no corner between them."""

SMOOTH_TURN = 1e-7
"""Sine of the angle between two normals below which they are the same."""

ON_FEATURE = 1e-9
"""Distance from a feature, relative to the length of its edge, within which a point is on it."""


class EdgePoint(NamedTuple):
    """A point of an outline that is touched (m), the normal outward, and the sense in which it moves along the outline, in its axes."""

    x: float
    y: float
    normal_x: float
    normal_y: float
    rate: float


class Extent(NamedTuple):
    """How far a point is beyond the start and beyond the end of a feature: m, or sines of angles at a corner. Negative within."""

    beyond_start: float
    beyond_end: float


class PieceEnd(NamedTuple):
    """End of a piece, m, and the direction of the piece there."""

    x: float
    y: float
    direction_x: float
    direction_y: float


@jit_in_place
def end_of_piece(pieces: FloatArray, i: int) -> PieceEnd:
    """Return where a piece ends."""
    c = pieces.shape[1] - N_PIECE_VALUES
    ux = pieces[i, c + 2]
    uy = pieces[i, c + 3]
    length = pieces[i, c + 4]
    curvature = pieces[i, c + 5]
    turn = curvature * length
    chord = length if turn == 0.0 else 2.0 * math.sin(0.5 * turn) / curvature
    cosine, sine = math.cos(0.5 * turn), math.sin(0.5 * turn)
    x = pieces[i, c] + chord * (cosine * ux - sine * uy)
    y = pieces[i, c + 1] + chord * (sine * ux + cosine * uy)
    return PieceEnd(x, y, math.cos(turn) * ux - math.sin(turn) * uy, math.sin(turn) * ux + math.cos(turn) * uy)


@jit_in_place
def distance_from_feature(pieces: FloatArray, feature: int, x: float, y: float) -> OutlineDistance:
    """Return the distance of a point outside from a feature, whose edge goes on beyond its ends."""
    i, c = (feature - 1) // 2, pieces.shape[1] - N_PIECE_VALUES
    dx = x - pieces[i, c]
    dy = y - pieces[i, c + 1]
    ux = pieces[i, c + 2]
    uy = pieces[i, c + 3]
    curvature = pieces[i, c + 5]
    if feature % 2 == 0:
        corner = end_of_piece(pieces, i)
        ex, ey = x - corner.x, y - corner.y
        reach = math.hypot(ex, ey)
        return OutlineDistance(reach, ex / reach, ey / reach, 1.0 / reach, 0.0)
    if curvature == 0.0:
        return OutlineDistance(dx * uy - dy * ux, uy, -ux, 0.0, 1.0)
    radius, side = 1.0 / curvature, math.copysign(1.0, curvature)
    ex, ey = dx + radius * uy, dy - radius * ux
    reach = math.hypot(ex, ey)
    return OutlineDistance(side * reach - radius, side * ex / reach, side * ey / reach, side / reach, 1.0)


@jit_in_place
def extent_of_feature(pieces: FloatArray, feature: int, point: EdgePoint) -> Extent:
    """Return how far a point that is touched is beyond the ends of a feature."""
    i, c = (feature - 1) // 2, pieces.shape[1] - N_PIECE_VALUES
    dx = point.x - pieces[i, c]
    dy = point.y - pieces[i, c + 1]
    ux = pieces[i, c + 2]
    uy = pieces[i, c + 3]
    length = pieces[i, c + 4]
    curvature = pieces[i, c + 5]
    if feature % 2 == 0:
        end = end_of_piece(pieces, i)
        before = point.normal_x * end.direction_x + point.normal_y * end.direction_y
        return Extent(-before, point.normal_x * pieces[i, c - 2] + point.normal_y * pieces[i, c - 1])
    if curvature == 0.0:
        along = dx * ux + dy * uy
        return Extent(-along, along - length)
    radius, half = 1.0 / curvature, 0.5 * length * abs(curvature)
    start_x, start_y = radius * uy, -radius * ux
    ex, ey = dx + start_x, dy + start_y
    angle = math.atan2(start_x * ey - start_y * ex, start_x * ex + start_y * ey) * math.copysign(1.0, curvature) - half
    if angle < -math.pi:
        angle += 2.0 * math.pi
    return Extent((-angle - half) * abs(radius), (angle - half) * abs(radius))


@jit_in_place
def next_feature(pieces: FloatArray, first_piece: int, n_pieces: int, feature: int, is_at_end: bool) -> int:
    """Return the feature behind an end of a feature, or the same one if the outline has none there that is touched."""
    i, c = (feature - 1) // 2, pieces.shape[1] - N_PIECE_VALUES
    following = i + 1 if i + 1 < first_piece + n_pieces else first_piece
    if feature % 2 == 0:
        return 2 * following + 1 if is_at_end else feature - 1
    if is_at_end:
        end = end_of_piece(pieces, i)
        behind_x = pieces[i, c - 2]
        behind_y = pieces[i, c - 1]
        if behind_x == 0.0 and behind_y == 0.0:
            return feature
        is_smooth = abs(end.direction_x * behind_y - end.direction_y * behind_x) <= SMOOTH_JOIN
        return 2 * following + 1 if is_smooth else feature + 1
    preceding = (i if i > first_piece else first_piece + n_pieces) - 1
    before_x = pieces[i, c - 4]
    before_y = pieces[i, c - 3]
    if before_x == 0.0 and before_y == 0.0:
        return feature
    is_smooth = abs(before_x * pieces[i, c + 3] - before_y * pieces[i, c + 2]) <= SMOOTH_JOIN
    return 2 * preceding + 1 if is_smooth else 2 * preceding + 2


@jit_in_place
def find_feature(pieces: FloatArray, first_piece: int, n_pieces: int, point: EdgePoint) -> int:
    """Return the feature that a point is on; at a join the one that it moves onto."""
    found = NO_FEATURE
    room = -math.inf
    c = pieces.shape[1] - N_PIECE_VALUES
    for i in range(first_piece, first_piece + n_pieces):
        tolerance = ON_FEATURE * pieces[i, c + 4]
        for feature in range(2 * i + 1, 2 * i + 3):
            extent = extent_of_feature(pieces, feature, point)
            if feature % 2 == 1:
                distance = distance_from_feature(pieces, feature, point.x, point.y)
                turn = distance.normal_x * point.normal_y - distance.normal_y * point.normal_x
                is_on = abs(distance.value) <= tolerance and abs(turn) <= SMOOTH_TURN
            else:
                end = end_of_piece(pieces, i)
                has_corner = next_feature(pieces, first_piece, n_pieces, feature - 1, True) == feature
                is_on = has_corner and math.hypot(point.x - end.x, point.y - end.y) <= tolerance
            beyond = max(extent.beyond_start, extent.beyond_end)
            ahead = -extent.beyond_end if point.rate > 0.0 else -extent.beyond_start
            if is_on and beyond <= tolerance and ahead > room:
                found, room = feature, ahead
    return found
