"""Outlines of parts: bars, boxes, plates, springs, bands, arrows, section lining and hatched walls; and the space between parts."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, pairwise
from operator import itemgetter

import numpy as np

from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    PoseTuple,
    Vec2,
    arc_points,
    axes_to_plane,
    convex_hull,
    place_points,
)
from governor_mechanism.types import FloatArray

_HALF_CIRCLE = [(y, -x) for x, y in arc_points((0.0, 0.0), 0.0, math.pi, 1.0)]
"""Half circle from the right side of a bar to the left one, in axes along and across it, for its end; mirrored at the start."""


def make_bar(role: str, start: Vec2, end: Vec2, width: float) -> Polygon:
    """Return a straight bar with round ends from start to end (m), of a width (m)."""
    length = math.dist(start, end)
    ux, uy = ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 0 else (1.0, 0.0)
    x0, y0 = start
    x1, y1 = end
    half_circle = [(width / 2 * x, width / 2 * y) for x, y in _HALF_CIRCLE]
    tip = [(x1 + f * ux - g * uy, y1 + f * uy + g * ux) for f, g in half_circle]
    return Polygon(role, (*tip, *[(x0 - f * ux + g * uy, y0 - f * uy - g * ux) for f, g in half_circle]))


def make_rectangle(role: str, left: float, right: float, bottom: float, top: float) -> Polygon:
    """Return an upright rectangle (m)."""
    return Polygon(role, ((left, bottom), (right, bottom), (right, top), (left, top)))


def make_hatching(role: str, box: BoundingBox, spacing: float) -> Lines:
    """Return section lining at 45 degrees in a box (m), with a spacing (m) along x."""
    left, right, bottom, top = box
    height = top - bottom
    strokes: list[tuple[Vec2, ...]] = []
    start_x = left - height + spacing / 2
    while start_x < right:
        low, high = max(start_x, left), min(start_x + height, right)
        strokes.append(((low, bottom + low - start_x), (high, bottom + high - start_x)))
        start_x += spacing
    return Lines(role, tuple(strokes))


def make_box(role: str, axes: PoseTuple, box: BoundingBox) -> Polygon:
    """Return a box (m) in axes."""
    return Polygon(role, place_points(axes, make_rectangle(role, *box).points))


def make_hatched_block(role: str, axes: PoseTuple, box: BoundingBox, spacing: float) -> tuple[Polygon, Lines]:
    """Return a box (m) in axes and its section lining, `spacing` (m) apart; the lining's role is "<role> hatching"."""
    lining = make_hatching(f"{role} hatching", box, spacing)
    return make_box(role, axes, box), Lines(lining.role, tuple(place_points(axes, stroke) for stroke in lining.lines))


def make_plate_outline(role: str, points: Sequence[Vec2], width: float) -> Polygon:
    """Return a plate around all points, half a width (m) beyond the outermost: a bar for two points, a disc for one."""
    corners = convex_hull(points)
    if len(corners) < 2:
        return Polygon(role, arc_points(corners[0], 0.0, 2 * math.pi, width / 2, 16))
    outline: list[Vec2] = []
    for previous, corner, following in zip((corners[-1], *corners), corners, (*corners[1:], corners[0]), strict=False):
        start, end = (math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in ((previous, corner), (corner, following)))
        outline += arc_points(corner, start - math.pi / 2, (end - start) % (2 * math.pi), width / 2)
    return Polygon(role, tuple(outline))


def shrink_convex(corners: Sequence[Vec2], distance: float) -> list[Vec2]:
    """Return the corners of the part of a convex polygon (anticlockwise, m) that is at least a distance (m) inside all its edges."""
    kept = list(corners)
    for (x0, y0), (x1, y1) in zip(corners, (*corners[1:], corners[0]), strict=True):
        length = math.dist((x0, y0), (x1, y1))
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        depths = [ux * (y - y0) - uy * (x - x0) - distance for x, y in kept]
        kept = list(_cut_at_line(kept, depths))
    return kept


def _cut_at_line(corners: Sequence[Vec2], depths: Sequence[float]) -> Iterator[Vec2]:
    """Yield the corners of the part of a polygon whose depth behind a line, known at its corners, is not negative."""
    for k, (x, y) in enumerate(corners):
        x0, y0 = corners[k - 1]
        before = depths[k - 1]
        here = depths[k]
        if before * here < 0.0:
            share = before / (before - here)
            yield x0 + share * (x - x0), y0 + share * (y - y0)
        if here >= 0.0:
            yield x, y


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
    tip = arc_points(chain[-1], headings[-1] - math.pi / 2, math.pi, half)
    return Polygon(role, (*sides[0], *tip, *sides[1][::-1], *arc_points(chain[0], headings[0] + math.pi / 2, math.pi, half)))


def make_parallel_outline(outline: Sequence[Vec2], distance: float) -> tuple[Vec2, ...]:
    """Return the curve at a distance (m) outside of a closed one, which goes round anticlockwise; inside for a negative distance."""
    before, after = (outline[-1], *outline[:-1]), (*outline[1:], outline[0])
    headings = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(before, after, strict=True)]
    return tuple((x + distance * math.sin(h), y - distance * math.cos(h)) for (x, y), h in zip(outline, headings, strict=True))


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


def make_wall(position: Vec2, heading: float, half: float, depth: float, lean: int = 1) -> Lines:
    """Return a wall through a position, perpendicular to `heading` (rad), hatched behind; lengths in m."""
    # The hatching leans to the right of the heading, or to the left if `lean` is -1: two walls that
    # face each other, one of each, mirror.
    c, s = math.cos(heading), math.sin(heading)

    def wall_point(across: float, behind: float) -> Vec2:
        return position[0] - behind * c - across * s, position[1] - behind * s + across * c

    count = max(round(2 * half / (0.9 * depth)), 2)
    hatch_positions = [-half + (k + 0.5) * 2 * half / count for k in range(count)]
    strokes = tuple(
        (wall_point(hatch_position, 0.0), wall_point(hatch_position - lean * 0.8 * depth, depth)) for hatch_position in hatch_positions
    )
    return Lines("wall", ((wall_point(-half, 0.0), wall_point(half, 0.0)), *strokes))


def make_burst(positions: Sequence[Vec2], radius: float) -> Lines:
    """Return rays around each position, from 0.45 to 1 `radius` (m): the mark of an impact."""
    rays = [(math.cos(k * math.pi / 4 + 0.2), math.sin(k * math.pi / 4 + 0.2)) for k in range(8)]
    strokes = [
        tuple((x + fraction * radius * c, y + fraction * radius * s) for fraction in (0.45, 1.0)) for x, y in positions for c, s in rays
    ]
    return Lines("burst", tuple(strokes))


_N_EDGE_POINTS = 9
"""Number of points along a straight edge: between them a bar of the length of a machine leaves an eighth of it."""


_N_COILS = 7
"""Coils of a drawn helical spring."""


def visible_pieces(points: Sequence[Vec2], is_visible: Sequence[bool]) -> tuple[tuple[Vec2, ...], ...]:
    """Return the runs of consecutive visible points."""
    runs = groupby(zip(points, is_visible, strict=True), key=itemgetter(1))
    return tuple(tuple(point for point, _ in run) for is_shown, run in runs if is_shown)


def helical_spring_lines(start: Vec2, end: Vec2, half_width: float, hidden_half_width: float) -> tuple[tuple[Vec2, ...], ...]:
    """Return a helical spring of a half width (m) from the side; its back is hidden within `hidden_half_width` (m) of the axis."""
    length, n_segments = math.dist(start, end), 16 * _N_COILS
    c, s = ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 0 else (0.0, 1.0)
    angles = [2 * math.pi * _N_COILS * k / n_segments for k in range(n_segments + 1)]
    offsets = [(length * k / n_segments, half_width * math.cos(angle)) for k, angle in enumerate(angles)]
    points = [(start[0] + along * c + across * s, start[1] + along * s - across * c) for along, across in offsets]
    is_visible = [math.sin(a) >= -1e-9 or abs(across) >= hidden_half_width for a, (_, across) in zip(angles, offsets, strict=True)]
    return tuple(piece for piece in visible_pieces(points, is_visible) if len(piece) > 1)


def spiral_points(centre: Vec2, start_angle: float, wound_angle: float, u: float) -> tuple[Vec2, ...]:
    """Return a spiral spring inward of `start_angle` (rad), wound up by `wound_angle` (rad) from two and a half turns."""
    sweep = 5 * math.pi - wound_angle
    return tuple(axes_to_plane((*centre, start_angle - sweep * (1 - k / 72)), (0.03 + 0.07 * k / 72) * u, 0.0) for k in range(73))


def select_extreme_rows(values: FloatArray) -> list[int]:
    """Return the indices of at most a few hundred rows of values (n, ...) that contain the extremes of every column."""
    flat = values.reshape(len(values), -1)
    even_rows = np.linspace(0, len(values) - 1, min(len(values), 200)).astype(int)
    chosen: list[int] = np.unique(np.concatenate([even_rows, flat.argmin(axis=0), flat.argmax(axis=0)])).tolist()
    return chosen


def first_free_position(occupied: Iterable[Vec2], start: float, width: float) -> float:
    """Return the smallest x (m) from `start` at which a `width` (m) is free of all occupied extents."""
    x = start
    for left, right in sorted(occupied):
        if left < x + width and right > x:
            x = right
    return x


def find_free_corner(shapes: Iterable[DrawnShape], box: BoundingBox) -> tuple[Vec2, float]:
    """Return the corner of a box (m) with the largest square that no outline enters, and the side of this square (m)."""
    outlines = np.concatenate([_outline_points(shape) for shape in shapes])
    left, right, bottom, top = box
    sides = {(x, y): float(np.abs(outlines - (x, y)).max(axis=1).min()) for x in (left, right) for y in (top, bottom)}
    corner = max(sides, key=sides.__getitem__)
    return corner, sides[corner]


def _outline_points(shape: DrawnShape) -> FloatArray:
    """Return points (n, 2) m along the outline of a shape, close enough to find out what it leaves free; none of words."""
    match shape:
        case Circle(_, x, y, radius):
            chains = [arc_points((x, y), 0.0, math.tau, radius, 16)]
        case Polygon(_, points) if points:
            chains = [(*points, points[0])]
        case Lines(_, lines):
            chains = list(lines)
        case _:
            chains = []
    fractions = np.linspace(0.0, 1.0, _N_EDGE_POINTS)[:, None, None]
    edges = [np.array(chain) for chain in chains if len(chain) > 1]
    pieces = [((1.0 - fractions) * chain[:-1] + fractions * chain[1:]).reshape(-1, 2) for chain in edges]
    return np.concatenate([*pieces, np.empty((0, 2))])
