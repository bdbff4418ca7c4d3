"""Distance of a closed convex curve from lines and arcs, each on a body of its own, as compiled kernels.

Both come nearest to each other where their normals are opposite: the curve to a straight edge where its own normal is that of the edge, to
an arc on the line through its centre, and to a corner as to a point. Signed distances and points are those along that common normal.
"""

import math
from typing import NamedTuple

from governor_mechanism.mechanics.curves.outline_kernels import (
    FINAL_FOOT_STEP,
    MAX_FOOT_ITERATIONS,
    N_CURVE_SAMPLES,
    N_PIECE_VALUES,
    EdgePoint,
    PieceEnd,
    distance_from_polar_curve,
    end_of_piece,
    extent_of_feature,
)
from governor_mechanism.mechanics.curves.segments import evaluate_polar_curve
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

CORNER_SLACK = 1e-9
"""Cosine within which a normal at a corner counts as one between those of both edges: there they are equally near."""

BESIDE_CORNER = 1e6
"""Distance (m) that is added where the common normal is none of a corner's, so that any other pair is nearer."""


class ProfileDistance(NamedTuple):
    """Distance of a curve from an edge or a corner (m), in the axes of the edges.

    The unit normal points from the edge toward the curve, and (x, y) is the point of the curve, m. `curvature` is that of the curve (1/m,
    positive where it is convex); `edge_curvature` and `edge_share` that of the edge (1/m) and 1, for a corner 1 and 0. `rank` is the
    distance by which the nearest pair is chosen.
    """

    value: float
    normal_x: float
    normal_y: float
    x: float
    y: float
    curvature: float
    edge_curvature: float
    edge_share: float
    rank: float


class ConvexCurve(NamedTuple):
    """A closed convex curve in the axes of the edges: its polynomial segments, its origin (m), cosine and sine of its angle, its inset (m).

    Distances are those of the curve itself; the profile is inside of it by the inset.
    """

    segments: FloatArray
    first_segment: int
    n_segments: int
    x: float
    y: float
    cosine: float
    sine: float
    inset: float


class CurvePoint(NamedTuple):
    """A point of a curve (m), in the axes of the edges, and the curvature there, 1/m."""

    x: float
    y: float
    curvature: float


@jit_in_place
def _place_point(curve: ConvexCurve, angle: float) -> CurvePoint:
    """Return the point of a curve in a direction of its own axes."""
    radius, slope, second_derivative = evaluate_polar_curve(curve.segments, curve.first_segment, curve.n_segments, angle)
    x = radius * math.cos(angle)
    y = radius * math.sin(angle)
    speed_squared = radius * radius + slope * slope
    curvature = (radius * (radius - second_derivative) + 2.0 * slope * slope) / (speed_squared * math.sqrt(speed_squared))
    return CurvePoint(curve.x + curve.cosine * x - curve.sine * y, curve.y + curve.sine * x + curve.cosine * y, curvature)


@jit_in_place
def _find_support(curve: ConvexCurve, normal_x: float, normal_y: float) -> CurvePoint:
    """Return the point of a curve with a given outward normal, by Newton's method."""
    target = math.atan2(curve.cosine * normal_y - curve.sine * normal_x, curve.cosine * normal_x + curve.sine * normal_y)
    angle = target
    low = target - 0.5 * math.pi
    high = target + 0.5 * math.pi
    for _ in range(MAX_FOOT_ITERATIONS):
        radius, slope, second_derivative = evaluate_polar_curve(curve.segments, curve.first_segment, curve.n_segments, angle)
        excess = target - angle + math.atan2(slope, radius)  # the normal stands at the angle less that of the slope
        if excess > 0.0:
            low = angle
        else:
            high = angle
        turning = (radius * (radius - second_derivative) + 2.0 * slope * slope) / (radius * radius + slope * slope)
        step = excess / turning
        if abs(step) <= FINAL_FOOT_STEP:
            angle += step
            break
        angle = angle + step if low < angle + step < high else 0.5 * (low + high)
    return _place_point(curve, angle)


@jit_in_place
def _find_farthest(curve: ConvexCurve, x: float, y: float) -> CurvePoint:
    """Return the point of a curve that is farthest from a point, as the centre of a hollow arc around it, by Newton's method."""
    dx, dy = x - curve.x, y - curve.y
    px = curve.cosine * dx + curve.sine * dy
    py = curve.cosine * dy - curve.sine * dx
    column = curve.segments.shape[1] - 2
    first_sample = curve.first_segment + curve.n_segments
    farthest = 0
    largest = -1.0
    for i in range(N_CURVE_SAMPLES):
        ex = curve.segments[first_sample + i, column] - px
        ey = curve.segments[first_sample + i, column + 1] - py
        if ex * ex + ey * ey > largest:
            farthest, largest = i, ex * ex + ey * ey
    spacing = 2.0 * math.pi / N_CURVE_SAMPLES
    angle = farthest * spacing
    low = (farthest - 1) * spacing
    high = (farthest + 1) * spacing
    for _ in range(MAX_FOOT_ITERATIONS):
        radius, slope, second_derivative = evaluate_polar_curve(curve.segments, curve.first_segment, curve.n_segments, angle)
        ux, uy = math.cos(angle), math.sin(angle)
        radial, tangential = px * ux + py * uy - radius, py * ux - px * uy  # from the curve to the point
        excess = radial * slope + tangential * radius
        bending = radial * (second_derivative - radius) + 2.0 * tangential * slope
        if excess < 0.0:
            low = angle
        else:
            high = angle
        step = excess / (slope * slope + radius * radius - bending)
        if abs(step) <= FINAL_FOOT_STEP:
            angle += step
            break
        angle = angle + step if low < angle + step < high else 0.5 * (low + high)
    return _place_point(curve, angle)


@jit_in_place
def _distance_from_round(curve: ConvexCurve, x: float, y: float, radius: float) -> ProfileDistance:
    """Return the distance of a curve from a bulging arc about (x, y), or from a point for the radius 0."""
    dx, dy = x - curve.x, y - curve.y
    px = curve.cosine * dx + curve.sine * dy
    py = curve.cosine * dy - curve.sine * dx
    distance = distance_from_polar_curve(curve.segments, curve.first_segment, curve.n_segments, px, py)
    normal_x = curve.sine * distance.normal_y - curve.cosine * distance.normal_x
    normal_y = -curve.sine * distance.normal_x - curve.cosine * distance.normal_y
    value = distance.value - radius
    curvature = distance.curvature / (1.0 - distance.curvature * distance.value)
    edge_curvature, edge_share = (1.0 / radius, 1.0) if radius > 0.0 else (1.0, 0.0)
    foot_x, foot_y = x + normal_x * distance.value, y + normal_y * distance.value
    rank = abs(value + curve.inset)
    return ProfileDistance(value, normal_x, normal_y, foot_x, foot_y, curvature, edge_curvature, edge_share, rank)


@jit_in_place
def _distance_from_end(curve: ConvexCurve, pieces: FloatArray, i: int, is_end: bool) -> ProfileDistance:
    """Return the distance of a curve from an end of a piece, a corner between this one and its neighbour."""
    c = pieces.shape[1] - N_PIECE_VALUES
    end = end_of_piece(pieces, i) if is_end else PieceEnd(pieces[i, c], pieces[i, c + 1], pieces[i, c - 4], pieces[i, c - 3])
    behind = c - 2 if is_end else c + 2
    distance = _distance_from_round(curve, end.x, end.y, 0.0)
    nx, ny = distance.normal_x, distance.normal_y
    is_before = nx * end.direction_x + ny * end.direction_y < -CORNER_SLACK
    is_beside = is_before or nx * pieces[i, behind] + ny * pieces[i, behind + 1] > CORNER_SLACK
    rank = distance.rank + (BESIDE_CORNER if is_beside else 0.0)
    return ProfileDistance(distance.value, nx, ny, distance.x, distance.y, distance.curvature, 1.0, 0.0, rank)


@jit_in_place
def _distance_from_straight(curve: ConvexCurve, pieces: FloatArray, i: int) -> ProfileDistance:
    """Return the distance of a curve from the line of a straight piece, also beyond its ends."""
    c = pieces.shape[1] - N_PIECE_VALUES
    ux, uy = pieces[i, c + 2], pieces[i, c + 3]
    nx, ny = uy, -ux
    point = _find_support(curve, -nx, -ny)
    value = nx * (point.x - pieces[i, c]) + ny * (point.y - pieces[i, c + 1])
    return ProfileDistance(value, nx, ny, point.x, point.y, point.curvature, 0.0, 1.0, abs(value + curve.inset))


@jit_in_place
def _distance_from_bend(curve: ConvexCurve, pieces: FloatArray, i: int) -> ProfileDistance:
    """Return the distance of a curve from the circle of an arc: from outside of one that bulges, from inside of a hollow one."""
    c = pieces.shape[1] - N_PIECE_VALUES
    ux = pieces[i, c + 2]
    uy = pieces[i, c + 3]
    curvature = pieces[i, c + 5]
    start_x, start_y = uy / curvature, -ux / curvature  # from the centre to the start
    x, y = pieces[i, c] - start_x, pieces[i, c + 1] - start_y
    if curvature > 0.0:
        return _distance_from_round(curve, x, y, 1.0 / curvature)
    point = _find_farthest(curve, x, y)
    ex, ey = point.x - x, point.y - y
    reach = math.hypot(ex, ey)
    value = -1.0 / curvature - reach
    nx = -ex / reach
    ny = -ey / reach
    return ProfileDistance(value, nx, ny, point.x, point.y, point.curvature, curvature, 1.0, abs(value + curve.inset))


@jit_in_place
def touched_point(pair: ProfileDistance) -> EdgePoint:
    """Return the point of the edges that is nearest to a curve; the rate along them is left out."""
    return EdgePoint(pair.x - pair.normal_x * pair.value, pair.y - pair.normal_y * pair.value, pair.normal_x, pair.normal_y, 0.0)


@jit_in_place
def distance_of_curve_from_feature(pieces: FloatArray, feature: int, curve: ConvexCurve) -> ProfileDistance:
    """Return the distance of a curve from a feature, whose edge goes on beyond its ends."""
    i = (feature - 1) // 2
    if feature % 2 == 0:
        return _distance_from_end(curve, pieces, i, True)
    is_straight = pieces[i, pieces.shape[1] - 1] == 0.0
    return _distance_from_straight(curve, pieces, i) if is_straight else _distance_from_bend(curve, pieces, i)


@jit_in_place
def _distance_from_piece(curve: ConvexCurve, pieces: FloatArray, i: int) -> ProfileDistance:
    """Return the distance of a curve from a piece, or from the end that is nearer."""
    distance = distance_of_curve_from_feature(pieces, 2 * i + 1, curve)
    extent = extent_of_feature(pieces, 2 * i + 1, touched_point(distance))
    if max(extent.beyond_start, extent.beyond_end) > 0.0:
        return _distance_from_end(curve, pieces, i, extent.beyond_end > extent.beyond_start)
    return distance


@jit_in_place
def _is_behind(curve: ConvexCurve, pieces: FloatArray, i: int) -> bool:
    """Return whether the origin of a curve is behind a straight piece: unless both parts overlap widely, another piece is nearer."""
    c = pieces.shape[1] - N_PIECE_VALUES
    return bool((curve.x - pieces[i, c]) * pieces[i, c + 3] <= (curve.y - pieces[i, c + 1]) * pieces[i, c + 2])


@jit_in_place
def distance_of_profiles(
    # lines and arcs, see `make_pieces`, and behind them the segments and points of the curve, see `make_curve_pieces`
    pieces: FloatArray,
    first_piece: int,
    n_pieces: int,
    curve: ConvexCurve,
) -> ProfileDistance:
    """Return the distance of a convex curve from the nearest of some lines and arcs; negative where they overlap."""
    nearest = ProfileDistance(math.nan, math.nan, math.nan, math.nan, math.nan, math.nan, math.nan, math.nan, math.inf)
    for is_overlapping in (False, True):
        for i in range(first_piece, first_piece + n_pieces):
            is_straight = pieces[i, pieces.shape[1] - 1] == 0.0
            if is_straight and not is_overlapping and _is_behind(curve, pieces, i):
                continue
            distance = _distance_from_piece(curve, pieces, i)
            if distance.rank < nearest.rank:
                nearest = distance
        if nearest.rank < math.inf:
            break
    return nearest
