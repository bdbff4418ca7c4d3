"""Shapes of a machine placed in the drawing of a room: scaled and moved."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Place of a machine: `scale` pixels per metre, with its origin at (x, y) pixels."""

    scale: float
    x: float
    y: float

    def point(self, point: Vec2) -> Vec2:
        """Return the place (pixels) of a point (m)."""
        return self.x + self.scale * point[0], self.y + self.scale * point[1]

    def place(self, shapes: Iterable[DrawnShape]) -> Iterator[DrawnShape]:
        """Yield shapes (m) at their places."""
        for shape in shapes:
            match shape:
                case Circle(role, x, y, radius):
                    yield Circle(role, *self.point((x, y)), self.scale * radius)
                case Polygon(role, points):
                    yield Polygon(role, tuple(map(self.point, points)))
                case Lines(role, lines):
                    yield Lines(role, tuple(tuple(map(self.point, line)) for line in lines))
                case TextShape():
                    x, y = self.point((shape.x, shape.y))
                    yield replace(shape, x=x, y=y, width=self.scale * shape.width)
