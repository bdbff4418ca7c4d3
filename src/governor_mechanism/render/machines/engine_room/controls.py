"""What stands between engine and governor: belts, line shaft and brake; throttle or slide with the bell crank and rod that move it.

Lengths in pixels.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.render.geometry.attached import (
    Attached,
    DrawnPart,
    Flexible,
    axes_along,
    axes_shifted,
    axes_turned,
    bar_between,
    fixed,
)
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.machines.engine_room import arrangement as room
from governor_mechanism.types import FloatArray


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
        distance = math.dist(self.first, self.second)
        heading = math.atan2(y1 - y0, x1 - x0)
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
    wheel = Circle("wheel", 0.0, 0.0, radius)
    hub = Circle("hub", 0.0, 0.0, min(3.0, 0.35 * radius))
    return Attached(frame=axes_turned(centre, angle_at), shapes=(wheel, mark, hub))


def bevel_wheel_parts(bottom: float, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
    """Yield the bevel wheel at the foot of the spindle, seen from its edge; a tooth marks the angle of the spindle."""
    x = room.GOVERNOR_AXIS
    half = 13.0
    height = 7.0
    top = bottom + height

    def tooth(moment: Any) -> list[DrawnShape]:
        angle = angle_at(moment)
        mark = x + half * math.cos(angle)
        return [Lines("marked spoke", (((mark, bottom), (x + 0.7 * (mark - x), top)),) if math.sin(angle) > 0.0 else ())]

    yield fixed([Polygon("wheel", ((x - half, bottom), (x + half, bottom), (x + 0.7 * half, top), (x - 0.7 * half, top)))])
    yield Flexible(shapes_at=tooth)
    yield fixed([make_rectangle("spindle", x - 2.5, x + 2.5, top, room.GOVERNOR_BASE)])


_DRUM = 13.0
_BLOCK_HALF_WIDTH = 10.0
_BLOCK_HEIGHT = 6.0
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
        x, y = room.LINE_SHAFT
        top = room.LINE_SHAFT[1] + _DRUM
        end = room.LINE_SHAFT[0] + room.BRAKE_ARM
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, y - _DRUM - _BLOCK_HEIGHT, y - _DRUM)
        yield Lines("small rod", tuple(((x + side, y - _DRUM - _BLOCK_HEIGHT), (x + side, top + 8.0)) for side in (-17.0, 17.0)))
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, top, top + _BLOCK_HEIGHT)
        yield make_bar("arm", (x - 20.0, top + 8.0), (end, top + 8.0), 5.0)
        yield Lines("small rod", (((end, top + 8.0), (end, top + 8.0 - _HANGER)),))

    def _weight(self, fraction: float) -> Polygon:
        """Return the weight for a fraction of the largest load of the run."""
        end = room.LINE_SHAFT[0] + room.BRAKE_ARM
        weight_top = room.LINE_SHAFT[1] + _DRUM + 8.0 - _HANGER
        height = max(fraction, 0.0) * room.MAX_WEIGHT_HEIGHT
        return make_rectangle("weight", end - 0.5 * room.WEIGHT_WIDTH, end + 0.5 * room.WEIGHT_WIDTH, weight_top - height, weight_top)


_LEVER_LENGTH, _MIN_LEVER_LENGTH = 50.0, 22.0
_MIN_ARM, _MAX_ARM = 8.0, 44.0


@dataclass(frozen=True, kw_only=True)
class BellCrank:
    """A bell crank whose fork follows the sleeve; the other arm points up (`side` 1) or down (-1) and pulls a rod to the right."""

    fork_x: float
    pivot: Vec2
    arm: float
    side: int

    def arm_end(self, sleeve_height: float) -> Vec2:
        """Return the end of the arm for a height of the sleeve."""
        x, y = self.pivot
        angle = math.atan2(sleeve_height - y, self.fork_x - x) - self.side * 0.5 * math.pi
        return x + self.arm * math.cos(angle), y + self.arm * math.sin(angle)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the post that carries the pivot."""
        x, y = self.pivot
        yield make_bar("bracket", (x, room.GOVERNOR_BASE - 6.0), (x, y), 7.0)

    def moving_parts(self, sleeve_at: Callable[[Any], float], rod_end_at: Callable[[Any], Vec2]) -> Iterator[DrawnPart]:
        """Yield lever, arm and rod; at a moment, the height of the sleeve and the other end of the rod."""

        def rod_ends(moment: Any) -> tuple[Vec2, Vec2]:
            return self.arm_end(sleeve_at(moment)), rod_end_at(moment)

        def lever_ends(moment: Any) -> tuple[Vec2, Vec2]:
            return self.pivot, (self.fork_x, sleeve_at(moment))

        arm_axes = axes_along(lambda moment: (self.pivot, self.arm_end(sleeve_at(moment))))
        # The fork of the lever slides on the sleeve.
        yield bar_between("rod", rod_ends, 3.2)
        yield bar_between("arm", lever_ends, 5.5)
        yield Attached(frame=arm_axes, shapes=(make_bar("arm", (0.0, 0.0), (self.arm, 0.0), 5.5),))
        yield Attached(frame=arm_axes, shapes=tuple(Circle("pivot", x, 0.0, 2.2) for x in (self.arm, 0.0)))
        fork_axes = axes_shifted(lambda moment: (self.fork_x, sleeve_at(moment)))
        yield Attached(frame=fork_axes, shapes=(Circle("pivot", 0.0, 0.0, 2.2),))


def make_bell_crank(fork_x: float, sleeve_heights: FloatArray, rod_travel: float, side: int) -> BellCrank:
    """Return the bell crank for the heights (n,) of the sleeve over a run and the travel of the rod, so that the rod keeps its length.

    Where the arm would become too long, the lever is shorter.
    """
    low, high = float(sleeve_heights.min()), float(sleeve_heights.max())
    lever, arm = _LEVER_LENGTH, _MIN_ARM
    if high > low:
        arm = 0.5 * rod_travel / math.sin(math.atan2(0.5 * (high - low), lever))
    if arm > _MAX_ARM:
        arm = _MAX_ARM
        lever = max(0.5 * (high - low) / math.tan(math.asin(min(0.5 * rod_travel / arm, 0.9))), _MIN_LEVER_LENGTH)
    return BellCrank(fork_x=fork_x, pivot=(fork_x + lever, 0.5 * (low + high)), arm=max(arm, _MIN_ARM), side=side)


_ELBOW_HEIGHT, _PORT_LENGTH = 14.0, 3.0
"""Height of the supply pipe where it bends to the cylinder, and length of the port in its wall."""
_CHARACTER_WIDTH = 6.6
"""Mean width of a character of a scale."""
_SCALE_TOP, _SCALE_MARGIN = room.CYLINDER_BASE - 4.0, 6.0
"""Height of the scale of a slide: under the cylinder; and how far its last number may go beyond it."""
_VALVE_LEVER, _LEVER_ANGLE = 26.0, math.radians(-140)
"""Length of the lever of the butterfly, and its angle in the middle of its range: beside the pipe, so that the disc is seen."""


class Control(ABC):
    """A controlled part with the bell crank that moves it; `values` (n,) are its values over the run."""

    crank: BellCrank

    @abstractmethod
    def rod_end(self, value: float) -> Vec2:
        """Return the end of the rod at the controlled part for a value."""

    @abstractmethod
    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the shapes that do not move."""

    @abstractmethod
    def controlled_parts(self, value_at: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield the controlled part; `value_at` is its value at a moment."""

    def moving_parts(self, sleeve_at: Callable[[Any], float], value_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield the controlled part, rod and bell crank; at a moment, the height of the sleeve and the value."""

        def rod_end_at(moment: Any) -> Vec2:
            return self.rod_end(value_at(moment))

        yield from self.controlled_parts(value_at)
        yield from self.crank.moving_parts(sleeve_at, rod_end_at)
        yield Attached(frame=axes_shifted(rod_end_at), shapes=(Circle("pivot", 0.0, 0.0, 2.2),))


def disc_angle(opening: float) -> float:
    """Return the angle of a throttle disc from its closed position at which it leaves a fraction `opening` of the pipe free."""
    return math.acos(1.0 - min(max(opening, 0.0), 1.0))


class Throttle(Control):
    """Butterfly in the supply pipe; the free width of the pipe is the opening."""

    def __init__(self, fork_x: float, sleeve_heights: FloatArray, openings: FloatArray) -> None:
        angles = [disc_angle(float(one)) for one in (openings.min(), openings.max())]
        self._mean_angle = 0.5 * (angles[0] + angles[1])
        # The rod moves to the right while the sleeve rises.
        self._sense = 1.0 if rises_with(openings, sleeve_heights) else -1.0
        travel = -2 * _VALVE_LEVER * math.sin(0.5 * (angles[1] - angles[0])) * math.sin(_LEVER_ANGLE)
        self.crank = make_bell_crank(fork_x, sleeve_heights, travel, side=1)
        self.centre = room.PIPE_AXIS, self.crank.pivot[1] + self.crank.arm - _VALVE_LEVER * math.sin(_LEVER_ANGLE)

    def rod_end(self, value: float) -> Vec2:
        """Return the end of the lever of the butterfly."""
        angle = _LEVER_ANGLE + self._sense * (disc_angle(value) - self._mean_angle)
        return self.centre[0] + _VALVE_LEVER * math.cos(angle), self.centre[1] + _VALVE_LEVER * math.sin(angle)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the supply pipe and the name of the valve."""
        yield from pipe_shapes(room.SLIDE_SCALE[2] - 22.0)
        yield TextShape("scale", self.centre[0] - 66.0, self.centre[1] + 9.0, "throttle", 48.0)

    def controlled_parts(self, value_at: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield the butterfly with its lever."""
        radius = room.PIPE_HALF_WIDTH
        angle = _LEVER_ANGLE - self._sense * self._mean_angle
        disc = Lines("butterfly", (((-radius, 0.0), (radius, 0.0)),))
        lever = make_bar("eccentric", (0.0, 0.0), (_VALVE_LEVER * math.cos(angle), _VALVE_LEVER * math.sin(angle)), 4.0)
        axes = axes_turned(self.centre, lambda moment: self._sense * disc_angle(value_at(moment)))
        yield Attached(frame=axes, shapes=(disc, lever, Circle("pivot", 0.0, 0.0, 2.6)))


@dataclass(frozen=True, kw_only=True)
class ScaleRange:
    """Range of a scale, with the labels of its ends and its name."""

    low: float
    high: float
    labels: tuple[str, str]
    name: str


class Slide(Control):
    """Slide on a scale: a cut-off gear, whose scale is the stroke of the piston below it, or the torque of an engine."""

    def __init__(self, fork_x: float, sleeve_heights: FloatArray, values: FloatArray, scale: ScaleRange) -> None:
        self._scale = scale
        travel = self.position(float(values.max())) - self.position(float(values.min()))
        side = 1 if rises_with(values, sleeve_heights) else -1
        self.crank = make_bell_crank(fork_x, sleeve_heights, travel, side)

    def position(self, value: float) -> float:
        """Return the position (x) of the slide at a value, within the scale."""
        left, right, _, _ = room.SLIDE_SCALE
        fraction = (value - self._scale.low) / (self._scale.high - self._scale.low)
        return left + min(max(fraction, 0.0), 1.0) * (right - left)

    def rod_end(self, value: float) -> Vec2:
        """Return the pin of the slide."""
        return self.position(value), room.SLIDE_SCALE[3] + 5.0

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield chest, supply pipe and scale."""
        left, right, low, high = room.SLIDE_SCALE
        yield make_rectangle("casting", left - 12.0, room.CYLINDER_END, low, high)
        yield from pipe_shapes(low)
        yield make_rectangle("live steam", left - 9.0, room.CYLINDER_END - _PORT_LENGTH, low + 2.5, high - 2.5)
        top = _SCALE_TOP
        ticks = [(left + k * (right - left) / 10, 6.0 if k % 5 == 0 else 3.5) for k in range(11)]
        yield Lines("scale", (((left, top), (right, top)), *(((x, top), (x, top - length)) for x, length in ticks)))
        first, last = self._scale.labels
        name = self._scale.name
        middle = 0.5 * (left + right)
        # A long name stands below the numbers at both ends.
        is_long = _CHARACTER_WIDTH * (0.5 * len(first + last) + len(name) + 2) > right - left
        for x, text, drop in ((left, first, 12.0), (right, last, 12.0), (middle, name, 24.0 if is_long else 12.0)):
            width = _CHARACTER_WIDTH * len(text)
            yield TextShape("scale", min(x - 0.5 * width, right + _SCALE_MARGIN - width), top - drop, text, width)

    def controlled_parts(self, value_at: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield the slide with its pointer."""
        axes = axes_shifted(lambda moment: (self.position(value_at(moment)), 0.0))
        yield Attached(frame=axes, shapes=tuple(self._slide_shapes()))

    def _slide_shapes(self) -> Iterator[DrawnShape]:
        """Yield the slide at x = 0."""
        _, _, low, high = room.SLIDE_SCALE
        yield make_rectangle("valve", -7.0, 7.0, low + 2.5, high - 2.5)
        yield make_rectangle("eccentric", -2.0, 2.0, high - 3.0, high + 5.0)
        yield Lines("projection", (((0.0, low + 2.5), (0.0, _SCALE_TOP)),))
        yield Polygon("tracer", ((0.0, _SCALE_TOP), (-3.0, _SCALE_TOP + 6.0), (3.0, _SCALE_TOP + 6.0)))


def rises_with(values: FloatArray, heights: FloatArray) -> bool:
    """Return whether values (n,) rise with heights (n,) on the whole."""
    return float(np.sum((values - values.mean()) * (heights - heights.mean()))) > 0.0


def pipe_shapes(bottom: float) -> Iterator[DrawnShape]:
    """Yield the supply pipe from the ceiling to a height, where it bends to the left into the cylinder or its chest."""
    x = room.PIPE_AXIS
    half = room.PIPE_HALF_WIDTH
    wall = room.PIPE_WALL
    top = room.HEIGHT - 2.0
    # The port in the wall of the cylinder belongs to the inside of the pipe.
    for role, left, t in (("casting", room.CYLINDER_END, 0.0), ("live steam", room.CYLINDER_END - _PORT_LENGTH, wall)):
        outer = x + half + wall - t
        inner = x - half - wall + t
        low = bottom + t
        elbow = bottom + _ELBOW_HEIGHT - t
        yield Polygon(role, ((left, low), (outer, low), (outer, top), (inner, top), (inner, elbow), (left, elbow)))
