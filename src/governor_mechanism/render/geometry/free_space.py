"""Free space in a drawing: widths swept by moving shapes between two heights."""

import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Polygon, Vec2
from governor_mechanism.types import FloatArray


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


def _ends_within(start: Vec2, end: Vec2, bottom: float, top: float) -> list[float]:
    """Return both ends (x) of the part of a segment between two heights, or an empty list."""
    (x0, y0), (x1, y1) = (start, end) if start[1] <= end[1] else (end, start)
    if y1 < bottom or y0 > top:
        return []
    rise = y1 - y0
    if rise == 0.0:
        return [x0, x1]
    return [x0 + (x1 - x0) * (min(max(y, y0), y1) - y0) / rise for y in (bottom, top)]
