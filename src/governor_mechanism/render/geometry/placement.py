"""Placement of shapes that are drawn in axes of their own: moved, turned, scaled and mirrored."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Axes in the picture: the place of their origin (m), and the vectors of one metre along x and along y, of equal length.

    Axes of the other handedness mirror.
    """

    origin: Vec2
    x_axis: Vec2
    y_axis: Vec2

    def __call__(self, point: Vec2) -> Vec2:
        """Return the place (m) of a point given in the axes (m)."""
        (x0, y0), (ax, ay), (bx, by), (x, y) = self.origin, self.x_axis, self.y_axis, point
        return x0 + x * ax + y * bx, y0 + x * ay + y * by

    def place(self, shapes: Iterable[DrawnShape]) -> Iterator[DrawnShape]:
        """Yield shapes that are given in the axes; words stay upright and keep their width."""
        for shape in shapes:
            match shape:
                case Polygon(role, points):
                    yield Polygon(role, tuple(map(self, points)))
                case Lines(role, lines):
                    yield Lines(role, tuple(tuple(map(self, line)) for line in lines))
                case Circle(role, x, y, radius):
                    yield Circle(role, *self((x, y)), radius * math.hypot(*self.x_axis))
                case TextShape(role, x, y, text, width):
                    yield TextShape(role, *self((x, y)), text, width)
