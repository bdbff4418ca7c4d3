"""What a governor controls, a throttle in the supply pipe or a slide on a scale, and the bell crank and rod that move it.

Lengths in pixels.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, axes_along, axes_shifted, axes_turned, bar_between
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.machines.engine_room import proportions as room
from governor_mechanism.types import FloatArray

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
_CHARACTER_WIDTH = 5.2
"""Mean width of a character of a scale."""
_POST_WIDTH = 7.0
"""Width of the posts under a slide that does not stand on a cylinder."""
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
        yield TextShape("scale", self.centre[0] - 60.0, self.centre[1] + 8.0, "throttle", 44.0)

    def controlled_parts(self, value_at: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield the butterfly with its lever."""
        radius, angle = room.PIPE_HALF_WIDTH, _LEVER_ANGLE - self._sense * self._mean_angle
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

    def __init__(self, fork_x: float, sleeve_heights: FloatArray, values: FloatArray, scale: ScaleRange, has_pipe: bool) -> None:
        self._scale, self._has_pipe = scale, has_pipe
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
        if self._has_pipe:
            yield from pipe_shapes(low)
        else:
            for x in (left - 12.0, room.CYLINDER_END - _POST_WIDTH):
                yield make_rectangle("frame plate", x, x + _POST_WIDTH, room.FLOOR + 16.0, low)
        role, end = ("live steam", room.CYLINDER_END - _PORT_LENGTH) if self._has_pipe else ("bore", room.CYLINDER_END - 3.0)
        yield make_rectangle(role, left - 9.0, end, low + 2.5, high - 2.5)
        top = self._scale_top
        ticks = [(left + k * (right - left) / 10, 6.0 if k % 5 == 0 else 3.5) for k in range(11)]
        yield Lines("scale", (((left, top), (right, top)), *(((x, top), (x, top - length)) for x, length in ticks)))
        texts = (left, self._scale.labels[0]), (right, self._scale.labels[1]), (0.5 * (left + right), self._scale.name)
        for x, text in texts:
            width = _CHARACTER_WIDTH * len(text)
            yield TextShape("scale", x - 0.5 * width, top - 12.0, text, width)

    @property
    def _scale_top(self) -> float:
        """Height of the scale: under the cylinder, or under the slide if there is none."""
        return (room.CYLINDER_BASE if self._has_pipe else room.SLIDE_SCALE[2]) - 4.0

    def controlled_parts(self, value_at: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield the slide with its pointer."""
        axes = axes_shifted(lambda moment: (self.position(value_at(moment)), 0.0))
        yield Attached(frame=axes, shapes=tuple(self._slide_shapes()))

    def _slide_shapes(self) -> Iterator[DrawnShape]:
        """Yield the slide at x = 0."""
        _, _, low, high = room.SLIDE_SCALE
        yield make_rectangle("valve", -7.0, 7.0, low + 2.5, high - 2.5)
        yield make_rectangle("eccentric", -2.0, 2.0, high - 3.0, high + 5.0)
        yield Lines("projection", (((0.0, low + 2.5), (0.0, self._scale_top)),))
        yield Polygon("tracer", ((0.0, self._scale_top), (-3.0, self._scale_top + 6.0), (3.0, self._scale_top + 6.0)))


def rises_with(values: FloatArray, heights: FloatArray) -> bool:
    """Return whether values (n,) rise with heights (n,) on the whole."""
    return float(np.sum((values - values.mean()) * (heights - heights.mean()))) > 0.0


def pipe_shapes(bottom: float) -> Iterator[DrawnShape]:
    """Yield the supply pipe from the ceiling to a height, where it bends to the left into the cylinder or its chest."""
    x, half, wall, top = room.PIPE_AXIS, room.PIPE_HALF_WIDTH, room.PIPE_WALL, room.HEIGHT - 2.0
    # The port in the wall of the cylinder belongs to the inside of the pipe.
    for role, left, t in (("casting", room.CYLINDER_END, 0.0), ("live steam", room.CYLINDER_END - _PORT_LENGTH, wall)):
        outer, inner, low, elbow = x + half + wall - t, x - half - wall + t, bottom + t, bottom + _ELBOW_HEIGHT - t
        yield Polygon(role, ((left, low), (outer, low), (outer, top), (inner, top), (inner, elbow), (left, elbow)))
