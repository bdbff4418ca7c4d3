"""Belts of the room: from the crank shaft to the governor's spindle and to the line shaft. Lengths in pixels, angles in rad."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_turned, fixed
from governor_mechanism.render.geometry.outlines import make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.engine_room import proportions as room


@dataclass(frozen=True, kw_only=True)
class BeltDrive:
    """A belt over two pulleys; `ratio` is that of the speed of the second to that of the first, negative for a crossed belt."""

    first: Vec2
    second: Vec2
    first_radius: float
    second_radius: float
    is_crossed: bool = False

    @property
    def strands(self) -> tuple[tuple[Vec2, Vec2], tuple[Vec2, Vec2]]:
        """Both strands: common tangents of the pulleys, inner ones for a crossed belt."""
        (x0, y0), (x1, y1) = self.first, self.second
        distance, heading = math.dist(self.first, self.second), math.atan2(y1 - y0, x1 - x0)
        far_radius = -self.second_radius if self.is_crossed else self.second_radius
        spread = math.acos((self.first_radius - far_radius) / distance)
        ends = []
        for side in (1, -1):
            c, s = math.cos(heading + side * spread), math.sin(heading + side * spread)
            start = x0 + self.first_radius * c, y0 + self.first_radius * s
            ends.append((start, (x1 + far_radius * c, y1 + far_radius * s)))
        return ends[0], ends[1]

    def belt_shapes(self, is_broken: bool = False) -> Iterator[DrawnShape]:
        """Yield the strands; those of a broken belt hang from the first pulley to the floor."""
        strands: tuple[tuple[Vec2, ...], ...] = self.strands
        if is_broken:
            (x, y), r = self.first, self.first_radius
            strands = tuple(((x + d, y), (x + d, room.FLOOR + 2.0), (x + d + 18.0, room.FLOOR + 2.0)) for d in (-r, r))
        yield Lines("belt", strands)

    def second_pulley_parts(self, angle_at: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield the second pulley; `angle_at` is its angle at a moment."""
        yield pulley_part(self.second, self.second_radius, angle_at)


def make_governor_belt(shaft: Vec2, ratio: float) -> BeltDrive:
    """Return the belt to the governor's layshaft for a ratio of speeds; pulleys of an extreme ratio are drawn at a limit."""
    first, second = room.MAX_PULLEY, room.MAX_PULLEY / abs(ratio)
    if abs(ratio) < 1.0:
        first, second = room.MAX_PULLEY * abs(ratio), room.MAX_PULLEY
    first, second = max(first, room.MIN_PULLEY), max(second, room.MIN_PULLEY)
    return BeltDrive(first=shaft, second=room.LAYSHAFT, first_radius=first, second_radius=second, is_crossed=ratio < 0.0)


def pulley_part(centre: Vec2, radius: float, angle_at: Callable[[Any], float]) -> Attached:
    """Return a pulley with a spoke that marks its angle at a moment."""
    mark = Lines("marked spoke", (((0.0, 0.0), (0.8 * radius, 0.0)),))
    wheel, hub = Circle("wheel", 0.0, 0.0, radius), Circle("hub", 0.0, 0.0, min(3.0, 0.35 * radius))
    return Attached(frame=axes_turned(centre, angle_at), shapes=(wheel, mark, hub))


def bevel_wheel_parts(bottom: float, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
    """Yield the bevel wheel at the foot of the spindle, seen from its edge; a tooth marks the angle of the spindle."""
    x, half, height = room.GOVERNOR_AXIS, 13.0, 7.0
    top = bottom + height

    def tooth(moment: Any) -> list[DrawnShape]:
        angle = angle_at(moment)
        mark = x + half * math.cos(angle)
        return [Lines("marked spoke", (((mark, bottom), (x + 0.7 * (mark - x), top)),) if math.sin(angle) > 0.0 else ())]

    yield fixed([Polygon("wheel", ((x - half, bottom), (x + half, bottom), (x + 0.7 * half, top), (x - 0.7 * half, top)))])
    yield Flexible(shapes_at=tooth)
    yield fixed([make_rectangle("spindle", x - 2.5, x + 2.5, top, room.GOVERNOR_BASE)])
