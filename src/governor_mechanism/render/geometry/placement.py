"""Placement of what is drawn in axes of its own: moved, turned, scaled and mirrored."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, Frame
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, TextShape, Vec2


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

    @property
    def scale(self) -> float:
        """Length in the picture of one metre of the axes, m."""
        return math.hypot(*self.x_axis)

    def place_pose(self, pose: PoseTuple) -> PoseTuple:
        """Return the pose in the picture of axes that have a pose in these axes."""
        (ax, ay), (bx, by) = self.x_axis, self.y_axis
        handedness = math.copysign(1.0, ax * by - ay * bx)
        return *self(pose[:2]), math.atan2(ay, ax) + handedness * pose[2]

    def place_parts(self, parts: Iterable[DrawnPart]) -> Iterator[DrawnPart]:
        """Yield parts of a drawing that is given in the axes."""
        (ax, ay), (bx, by) = self.x_axis, self.y_axis
        # What is attached is scaled and mirrored in its own axes, and turned with these.
        handed_scale = math.copysign(self.scale, ax * by - ay * bx)
        own = Placement(origin=(0.0, 0.0), x_axis=(self.scale, 0.0), y_axis=(0.0, handed_scale))
        for part in parts:
            frame = _PlacedFrame(self, part.frame)
            if isinstance(part, Flexible):
                yield replace(part, frame=frame, shapes_at=_PlacedShapes(own, part))
            else:
                yield replace(part, frame=frame, shapes=tuple(own.place(part.shapes)))


@dataclass(frozen=True)
class _PlacedFrame:
    """Axes that are placed; equal for equal axes."""

    placement: Placement
    frame: Frame

    def __call__(self, moment: Any) -> PoseTuple:
        """Return their pose in the picture."""
        return self.placement.place_pose(self.frame(moment))


@dataclass(frozen=True, eq=False)
class _PlacedShapes:
    """Shapes of a flexible part that is placed."""

    placement: Placement
    part: Flexible

    def __call__(self, moment: Any) -> Iterator[DrawnShape]:
        """Yield them in the picture."""
        return self.placement.place(self.part.shapes_at(moment))
