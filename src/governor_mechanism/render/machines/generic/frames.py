"""Bodies with several pins as frames: bars between the outermost points around a translucent web, so that they hide nothing."""

import math
from collections.abc import Iterator, Sequence
from functools import partial

from governor_mechanism.render.geometry.outlines import make_bar, make_plate_outline, shrink_convex
from governor_mechanism.render.geometry.points import convex_hull
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2

WEB_ROLE, RIM_ROLES = "plate web", ("plate rim", "plate edge")
"""Role of what fills a frame, and roles of its bars and their edges."""
_MIN_OPENING = 0.4
"""Least distance of the middle of an opening from the bars around it, relative to their width: a smaller one would be a slit."""


def body_outline_shapes(points: Sequence[Vec2], width: float) -> Iterator[DrawnShape]:
    """Yield the shapes of a body through points (m) with bars of a width (m): a bar or narrow plate, or a frame with its web."""
    corners = convex_hull(points)
    if len(corners) < 3 or not shrink_convex(corners, (0.5 + _MIN_OPENING) * width):
        yield make_plate_outline("plate", points, width)
        return
    outer, inner = make_plate_outline(WEB_ROLE, corners, width).points, tuple(shrink_convex(corners, width / 2))
    yield Polygon(WEB_ROLE, outer)
    yield from (make_bar("plate", *ends, width) for ends in _ribs(points, corners, width))
    # One outline around the rim: out along the outer edge and back along the inner one. Its seam has no stroke of its own.
    yield Polygon("plate rim", (*outer, outer[0], inner[0], *inner[::-1]))
    yield Lines("plate edge", tuple((*edge, edge[0]) for edge in (outer, inner)))


def _ribs(points: Sequence[Vec2], corners: Sequence[Vec2], width: float) -> Iterator[tuple[Vec2, Vec2]]:
    """Yield the ends of bars that join each point inside the rim to the nearest point that is joined already."""
    joined = list(corners)
    for point in sorted(points, key=lambda one: min(math.dist(one, corner) for corner in corners)):
        edges = zip(corners, (*corners[1:], corners[0]), strict=True)
        if min(_distance_to_segment(point, *edge) for edge in edges) > width / 2:
            yield point, min(joined, key=partial(math.dist, point))
            joined.append(point)


def _distance_to_segment(point: Vec2, start: Vec2, end: Vec2) -> float:
    """Return the distance of a point from a segment (m)."""
    (x, y), (x0, y0), (x1, y1) = point, start, end
    share = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / math.dist(start, end) ** 2
    share = min(max(share, 0.0), 1.0)
    return math.dist(point, (x0 + share * (x1 - x0), y0 + share * (y1 - y0)))
