"""Free space in a drawing: widths swept by moving shapes between two heights."""

import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.types import FloatArray

_N_EDGE_POINTS = 9
"""Number of points along a straight edge: between them a bar of the length of a machine leaves an eighth of it."""


def select_extreme_rows(values: FloatArray) -> list[int]:
    """Return the indices of at most a few hundred rows of values (n, ...) that contain the extremes of every column."""
    flat = values.reshape(len(values), -1)
    even_rows = np.linspace(0, len(values) - 1, min(len(values), 200)).astype(int)
    chosen: list[int] = np.unique(np.concatenate([even_rows, flat.argmin(axis=0), flat.argmax(axis=0)])).tolist()
    return chosen


def horizontal_extents(shapes: Iterable[DrawnShape], bottom: float, top: float) -> list[Vec2]:
    """Return the horizontal extent (m) of each circle and each convex polygon between two heights (m)."""
    extents = []
    for shape in shapes:
        xs: list[float] = []
        if isinstance(shape, Circle):
            vertical_distance = max(bottom - shape.y, shape.y - top, 0.0)
            if vertical_distance < shape.radius:
                half_width = math.sqrt(shape.radius**2 - vertical_distance**2)
                xs = [shape.x - half_width, shape.x + half_width]
        elif isinstance(shape, Polygon):
            for start, end in pairwise((*shape.points, shape.points[0])):
                xs += _ends_within(start, end, bottom, top)
        if xs:
            extents.append((min(xs), max(xs)))
    return extents


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


def _ends_within(start: Vec2, end: Vec2, bottom: float, top: float) -> list[float]:
    """Return both ends (x) of the part of a segment between two heights, or an empty list."""
    (x0, y0), (x1, y1) = (start, end) if start[1] <= end[1] else (end, start)
    if y1 < bottom or y0 > top:
        return []
    rise = y1 - y0
    if rise == 0.0:
        return [x0, x1]
    return [x0 + (x1 - x0) * (min(max(y, y0), y1) - y0) / rise for y in (bottom, top)]
