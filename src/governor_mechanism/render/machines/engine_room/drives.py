"""What the crank shaft drives: the spindle of the governor, and a line shaft with a Prony brake, by belts. Lengths in pixels."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_turned, fixed
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, make_wall
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


_DRUM, _BLOCK_HALF_WIDTH, _BLOCK_HEIGHT = 13.0, 10.0, 6.0
_HANGER = 12.0
"""Length of the rod on which the weight hangs."""


class Brake:
    """Prony brake on a line shaft: its drum drags the blocks, and the weight at the end of the lever holds them back."""

    def __init__(self, shaft: Vec2) -> None:
        self._belt = BeltDrive(first=shaft, second=room.LINE_SHAFT, first_radius=room.LOAD_PULLEY, second_radius=room.LOAD_PULLEY)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the bracket of the line shaft under the ceiling."""
        x, y = room.LINE_SHAFT
        yield make_wall((x, room.HEIGHT - 8.0), -math.pi / 2, 20.0, 6.0)
        yield make_bar("bracket", (x, y), (x, room.HEIGHT - 12.0), 9.0)

    def belt_shapes(self) -> Iterator[DrawnShape]:
        """Yield the belt from the shaft of the engine."""
        yield from self._belt.belt_shapes()

    def moving_parts(self, angle_at: Callable[[Any], float], fraction_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield line shaft, brake and weight; at a moment, the drawn angle (rad) of the shaft, and the load relative to its largest."""
        (x, y), end = room.LINE_SHAFT, room.LINE_SHAFT[0] + room.BRAKE_ARM
        yield from self._belt.second_pulley_parts(angle_at)
        drum = Circle("frame", 0.0, 0.0, _DRUM), Lines("mark spoke", (((0.0, 0.0), (0.9 * _DRUM, 0.0)),))
        yield Attached(frame=axes_turned((x, y), angle_at), shapes=drum)
        yield fixed(self._frame_shapes())
        yield Flexible(shapes_at=lambda moment: [self._weight(fraction_at(moment))])
        yield fixed([Circle("pivot", end, y + _DRUM + 8.0, 2.2)])

    def _frame_shapes(self) -> Iterator[DrawnShape]:
        """Yield the blocks with their bolts, the lever, and the rod on which the weight hangs."""
        (x, y), top, end = room.LINE_SHAFT, room.LINE_SHAFT[1] + _DRUM, room.LINE_SHAFT[0] + room.BRAKE_ARM
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, y - _DRUM - _BLOCK_HEIGHT, y - _DRUM)
        yield Lines("small rod", tuple(((x + side, y - _DRUM - _BLOCK_HEIGHT), (x + side, top + 8.0)) for side in (-17.0, 17.0)))
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, top, top + _BLOCK_HEIGHT)
        yield make_bar("arm", (x - 20.0, top + 8.0), (end, top + 8.0), 5.0)
        yield Lines("small rod", (((end, top + 8.0), (end, top + 8.0 - _HANGER)),))

    def _weight(self, fraction: float) -> Polygon:
        """Return the weight for a fraction of the largest load of the run."""
        end, weight_top = room.LINE_SHAFT[0] + room.BRAKE_ARM, room.LINE_SHAFT[1] + _DRUM + 8.0 - _HANGER
        height = max(fraction, 0.0) * room.MAX_WEIGHT_HEIGHT
        return make_rectangle("weight", end - 0.5 * room.WEIGHT_WIDTH, end + 0.5 * room.WEIGHT_WIDTH, weight_top - height, weight_top)
