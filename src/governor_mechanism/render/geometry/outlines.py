"""Outlines of parts: plates with rounded corners, bands along a curve, arrows, and hatched walls."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Lines,
    Polygon,
    PoseTuple,
    Vec2,
    make_hatching,
    make_rectangle,
    place_points,
)

N_CORNER_SEGMENTS = 8
"""Number of segments of a rounded corner."""


def convex_hull(points: Sequence[Vec2]) -> list[Vec2]:
    """Return the corners of the convex hull of points, anticlockwise, without points on an edge."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered
    span = max(math.dist(point, ordered[0]) for point in ordered)

    def half_hull(chain: Sequence[Vec2]) -> list[Vec2]:
        """Return the corners of the hull above or below the points."""
        corners: list[Vec2] = []
        for x, y in chain:
            while len(corners) > 1:
                (x0, y0), (x1, y1) = corners[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 1e-9 * span**2:
                    break
                corners.pop()
            corners.append((x, y))
        return corners[:-1]

    return half_hull(ordered) + half_hull(ordered[::-1])


def make_plate_outline(role: str, points: Sequence[Vec2], width: float) -> Polygon:
    """Return a plate around all points, half a width (m) beyond the outermost: a bar for two points, a disc for one."""
    corners = convex_hull(points)
    if len(corners) < 2:
        return Polygon(role, _arc_points(corners[0], 0.0, 2 * math.pi, width / 2, 2 * N_CORNER_SEGMENTS))
    outline: list[Vec2] = []
    for previous, corner, following in zip((corners[-1], *corners), corners, (*corners[1:], corners[0]), strict=False):
        start, end = (math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in ((previous, corner), (corner, following)))
        outline += _arc_points(corner, start - math.pi / 2, (end - start) % (2 * math.pi), width / 2, N_CORNER_SEGMENTS)
    return Polygon(role, tuple(outline))


def make_band(role: str, chain: Sequence[Vec2], width: float) -> Polygon:
    """Return a strip of a width (m) along a chain of points, with round ends."""
    if len(set(chain)) < 2:
        return make_plate_outline(role, chain[:1], width)
    half = width / 2
    # Central differences give strips of curves without steps.
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip((chain[0], *chain), (*chain[1:], chain[-1]), strict=False)]
    sides = [
        tuple((x + s * half * math.sin(h), y - s * half * math.cos(h)) for (x, y), h in zip(chain, headings, strict=True)) for s in (1, -1)
    ]
    tip = _arc_points(chain[-1], headings[-1] - math.pi / 2, math.pi, half, N_CORNER_SEGMENTS)
    tail = _arc_points(chain[0], headings[0] + math.pi / 2, math.pi, half, N_CORNER_SEGMENTS)
    return Polygon(role, (*sides[0], *tip, *sides[1][::-1], *tail))


def make_arrow(role: str, chain: Sequence[Vec2], head: float) -> tuple[Lines, Polygon]:
    """Return a line and a head of a length (m) at its end; empty shapes for a line without length."""
    length = sum(math.dist(a, b) for a, b in pairwise(chain))
    if length < 0.1 * head:
        return Lines(role, ()), Polygon(role, ())
    head = min(head, 0.8 * length)
    shaft = list(chain)
    tip = shaft[-1]
    while len(shaft) > 2 and math.dist(shaft[-2], tip) < head:
        shaft.pop(-2)
    (x0, y0) = shaft[-2]
    last_length = math.dist((x0, y0), tip)
    ux, uy = (tip[0] - x0) / last_length, (tip[1] - y0) / last_length
    head_base = (tip[0] - head * ux, tip[1] - head * uy)
    wings = tuple((head_base[0] + side * 0.36 * head * -uy, head_base[1] + side * 0.36 * head * ux) for side in (1, -1))
    return Lines(role, ((*shaft[:-1], head_base),)), Polygon(role, (tip, *wings))


def make_wall(position: Vec2, heading: float, half: float, depth: float) -> Lines:
    """Return a fixed wall through a position, perpendicular to `heading` (rad), hatched on the far side; lengths in m."""
    c, s = math.cos(heading), math.sin(heading)

    def wall_point(across: float, behind: float) -> Vec2:
        return position[0] - behind * c - across * s, position[1] - behind * s + across * c

    count = max(round(2 * half / (0.9 * depth)), 2)
    hatch_positions = [-half + (k + 0.5) * 2 * half / count for k in range(count)]
    strokes = tuple(
        (wall_point(hatch_position, 0.0), wall_point(hatch_position - 0.8 * depth, depth)) for hatch_position in hatch_positions
    )
    return Lines("wall", ((wall_point(-half, 0.0), wall_point(half, 0.0)), *strokes))


def make_burst(role: str, positions: Sequence[Vec2], radius: float) -> Lines:
    """Return rays around each position, from 0.45 to 1 `radius` (m): the mark of an impact."""
    rays = [(math.cos(k * math.pi / 4 + 0.2), math.sin(k * math.pi / 4 + 0.2)) for k in range(8)]
    strokes = [
        tuple((x + fraction * radius * c, y + fraction * radius * s) for fraction in (0.45, 1.0)) for x, y in positions for c, s in rays
    ]
    return Lines(role, tuple(strokes))


def make_hatched_block(role: str, axes: PoseTuple, box: BoundingBox, spacing: float) -> tuple[Polygon, Lines]:
    """Return a box (m) in axes and its section lining, `spacing` (m) apart; the lining's role is "<role> hatching"."""
    lining = make_hatching(f"{role} hatching", box, spacing)
    outline = Polygon(role, place_points(axes, make_rectangle(role, *box).points))
    return outline, Lines(lining.role, tuple(place_points(axes, stroke) for stroke in lining.lines))


def distinct_points(points: Iterable[Vec2], min_distance: float) -> list[Vec2]:
    """Return the points in order, without those closer than `min_distance` (m) to an earlier one."""
    kept: list[Vec2] = []
    for point in points:
        if all(math.dist(point, other) >= min_distance for other in kept):
            kept.append(point)
    return kept


def _arc_points(centre: Vec2, start: float, sweep: float, radius: float, n_segments: int) -> tuple[Vec2, ...]:
    """Return points of an arc."""
    angles = (start + sweep * k / n_segments for k in range(n_segments + 1))
    return tuple((centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles)
