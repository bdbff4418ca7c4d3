"""Joins of the edges of an outline, where the curvature of the way of what touches it jumps, as compiled kernels.

What touches an outline is on one of its features at a time: on an edge, or round the corner at its end. In a step the feature is kept,
and goes on beyond its ends, so that the equations stay smooth; the step ends where the next feature takes over. Features are numbered
1 + 2 i for edge i and 2 + 2 i for the corner at its end; 0 is none.
"""

import math
from typing import NamedTuple

from governor_mechanism.mechanics.curves.outline_kernels import N_PIECE_VALUES, OutlineDistance
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

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
    ux, uy, length, curvature = pieces[i, c + 2], pieces[i, c + 3], pieces[i, c + 4], pieces[i, c + 5]
    turn = curvature * length
    chord = length if turn == 0.0 else 2.0 * math.sin(0.5 * turn) / curvature
    cosine, sine = math.cos(0.5 * turn), math.sin(0.5 * turn)
    x, y = pieces[i, c] + chord * (cosine * ux - sine * uy), pieces[i, c + 1] + chord * (sine * ux + cosine * uy)
    return PieceEnd(x, y, math.cos(turn) * ux - math.sin(turn) * uy, math.sin(turn) * ux + math.cos(turn) * uy)


@jit_in_place
def distance_from_feature(pieces: FloatArray, feature: int, x: float, y: float) -> OutlineDistance:
    """Return the distance of a point outside from a feature, whose edge goes on beyond its ends."""
    i, c = (feature - 1) // 2, pieces.shape[1] - N_PIECE_VALUES
    dx, dy, ux, uy, curvature = x - pieces[i, c], y - pieces[i, c + 1], pieces[i, c + 2], pieces[i, c + 3], pieces[i, c + 5]
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
    dx, dy, ux, uy, length, curvature = (
        point.x - pieces[i, c],
        point.y - pieces[i, c + 1],
        pieces[i, c + 2],
        pieces[i, c + 3],
        pieces[i, c + 4],
        pieces[i, c + 5],
    )
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
        end, behind_x, behind_y = end_of_piece(pieces, i), pieces[i, c - 2], pieces[i, c - 1]
        if behind_x == 0.0 and behind_y == 0.0:
            return feature
        is_smooth = abs(end.direction_x * behind_y - end.direction_y * behind_x) <= SMOOTH_JOIN
        return 2 * following + 1 if is_smooth else feature + 1
    preceding, before_x, before_y = (i if i > first_piece else first_piece + n_pieces) - 1, pieces[i, c - 4], pieces[i, c - 3]
    if before_x == 0.0 and before_y == 0.0:
        return feature
    is_smooth = abs(before_x * pieces[i, c + 3] - before_y * pieces[i, c + 2]) <= SMOOTH_JOIN
    return 2 * preceding + 1 if is_smooth else 2 * preceding + 2


@jit_in_place
def find_feature(pieces: FloatArray, first_piece: int, n_pieces: int, point: EdgePoint) -> int:
    """Return the feature that a point is on; at a join the one that it moves onto."""
    found, room, c = NO_FEATURE, -math.inf, pieces.shape[1] - N_PIECE_VALUES
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
