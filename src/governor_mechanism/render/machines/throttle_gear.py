"""What a governor moves: a strap on the sleeve, a forked lever about a fixed pivot, its rod, and the throttle valve in its pipe."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, Frame, axes_along, axes_shifted
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, make_wall
from governor_mechanism.render.geometry.points import axes_to_plane, place_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, Vec2

# Lengths as fractions of the unit of the gear.
_MIN_HALF_LIFT = 0.11
"""Half the smallest lift for which the gear is designed: a smaller one turns the valve by less."""
_VALVE_ARM, _MIN_ROD = 0.12, 0.36
_SWING = math.radians(38)
"""Angle by which the valve turns to either side over the lift for which the gear is designed (rad)."""
_CLOSING_ANGLE = math.radians(47)
"""Angle of the plate to its pipe when the sleeve is in the middle of its travel (rad)."""
_PIPE_HALF_LENGTH, _PIPE_HALF_HEIGHT, _WALL_THICKNESS = 0.17, 0.072, 0.022
_LEVER_WIDTH, _ROD_WIDTH, _PIN_RADIUS, _FORK_END, _STRAP_HEIGHT = 0.046, 0.026, 0.017, 0.045, 0.055
_POST_WIDTH, _POST_HEIGHT = 0.05, 0.22


@dataclass(frozen=True, kw_only=True)
class ThrottleGear:
    """A forked lever, a rod and a throttle valve, moved by a pin on the sleeve at the spindle's axis."""

    unit: float  # length (m) that sizes the parts
    side: float  # -1 for a gear at the left of the spindle, 1 at the right
    pin_range: Vec2  # lowest and highest height of the pin over the run, m
    strap_half_width: float  # half the width of the strap around the sleeve, m
    pivot_distance: float  # distance of the lever's fixed pivot from the axis, m
    valve_height: float  # highest height of the throttle valve, m

    @property
    def pivot(self) -> Vec2:
        """Fixed pivot of the lever (m), at the middle height of the pin."""
        return self.side * self.pivot_distance, 0.5 * (self.pin_range[0] + self.pin_range[1])

    @property
    def _half_lift(self) -> float:
        return max(0.5 * (self.pin_range[1] - self.pin_range[0]), _MIN_HALF_LIFT * self.unit)

    @property
    def outer_arm(self) -> float:
        """Length of the lever beyond its pivot (m), such that the valve turns by its swing over the lift."""
        return _VALVE_ARM * self.unit * math.sin(_SWING) / math.sin(math.atan2(self._half_lift, self.pivot_distance))

    @property
    def valve(self) -> Vec2:
        """Axis of the valve (m); its arm is level, and the rod upright, when the lever is level."""
        x, y = self.pivot
        return x + self.side * (self.outer_arm + _VALVE_ARM * self.unit), min(self.valve_height, y - _MIN_ROD * self.unit)

    @property
    def rod_length(self) -> float:
        """Length of the rod (m)."""
        return self.pivot[1] - self.valve[1]

    def lever_end(self, pin_height: float) -> Vec2:
        """Return the outer end of the lever (m) for a height of the pin (m)."""
        x, y = self.pivot
        angle = math.atan2(pin_height - y, self.pivot_distance)
        return x + self.side * self.outer_arm * math.cos(angle), y - self.outer_arm * math.sin(angle)

    def valve_arm_end(self, pin_height: float) -> Vec2:
        """Return the end of the valve's arm (m): where the circles of arm and rod meet, on the side of the pivot."""
        (x, y), (end_x, end_y) = self.valve, self.lever_end(pin_height)
        distance, heading = math.dist((x, y), (end_x, end_y)), math.atan2(end_y - y, end_x - x)
        arm, rod = _VALVE_ARM * self.unit, self.rod_length
        cosine = (arm**2 + distance**2 - rod**2) / (2 * arm * distance)
        return axes_to_plane((x, y, heading + self.side * math.acos(min(max(cosine, -1.0), 1.0))), arm, 0.0)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the post that carries the lever, and the pipe in section."""
        u, (x, y), (valve_x, valve_y) = self.unit, self.pivot, self.valve
        foot = y - _POST_HEIGHT * u
        yield make_bar("throttle post", (x, foot), (x, y), _POST_WIDTH * u)
        yield make_rectangle("throttle post", x - 0.06 * u, x + 0.06 * u, foot - 0.02 * u, foot + 0.01 * u)
        yield Lines("throttle ground", make_wall((x, foot - 0.02 * u), math.pi / 2, 0.10 * u, 0.03 * u).lines)
        left, right = valve_x - _PIPE_HALF_LENGTH * u, valve_x + _PIPE_HALF_LENGTH * u
        half, wall = _PIPE_HALF_HEIGHT * u, _WALL_THICKNESS * u
        yield make_rectangle("throttle bore", left, right, valve_y - half, valve_y + half)
        for bottom in (valve_y - half - wall, valve_y + half):
            yield make_rectangle("throttle pipe", left, right, bottom, bottom + wall)

    def lever_axes(self, pin_height: float) -> PoseTuple:
        """Return the axes of the lever for a height of the pin (m): the origin is in its pivot, and x leads to the pin."""
        x, y = self.pivot
        return x, y, math.atan2(pin_height - y, -x)

    def valve_axes(self, pin_height: float) -> PoseTuple:
        """Return the axes of the valve for a height of the pin (m); x leads along its arm."""
        (x, y), (end_x, end_y) = self.valve, self.valve_arm_end(pin_height)
        return x, y, math.atan2(end_y - y, end_x - x)

    def moving_parts(self, pin_height: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield strap, lever, rod and valve; `pin_height` is the height of the pin (m) at a moment."""
        strap_axes = axes_shifted(lambda moment: (0.0, pin_height(moment)))
        rod_axes = axes_along(lambda moment: (self.lever_end(pin_height(moment)), self.valve_arm_end(pin_height(moment))))

        def lever_axes(moment: Any) -> PoseTuple:
            return self.lever_axes(pin_height(moment))

        def valve_axes(moment: Any) -> PoseTuple:
            return self.valve_axes(pin_height(moment))

        arm = _VALVE_ARM * self.unit
        yield _part(strap_axes, self._strap())
        yield _part(lever_axes, *self._lever_shapes())
        yield _part(valve_axes, *self._valve_shapes())
        yield _part(rod_axes, make_bar("throttle rod", (0.0, 0.0), (self.rod_length, 0.0), _ROD_WIDTH * self.unit))
        yield _part(strap_axes, self._pin((0.0, 0.0)))
        yield _part(lever_axes, self._pin((0.0, 0.0)), self._pin((-self.outer_arm, 0.0)))
        yield _part(valve_axes, self._pin((arm, 0.0)), self._pin((0.0, 0.0)))

    def _strap(self) -> Polygon:
        half = 0.5 * _STRAP_HEIGHT * self.unit
        return make_rectangle("throttle strap", -self.strap_half_width, self.strap_half_width, -half, half)

    def _lever_shapes(self) -> Iterator[DrawnShape]:
        """Yield the lever with its fork in its axes; the fork is slotted: the pin moves straight, the lever about its pivot."""
        u = self.unit
        reach = math.hypot(self.pivot_distance, 0.5 * (self.pin_range[1] - self.pin_range[0])) + _FORK_END * u
        yield make_bar("throttle lever", (-self.outer_arm, 0.0), (reach, 0.0), _LEVER_WIDTH * u)
        yield make_bar("throttle slot", (self.pivot_distance, 0.0), (reach - _FORK_END * u, 0.0), 2 * _PIN_RADIUS * u)

    def _valve_shapes(self) -> Iterator[DrawnShape]:
        """Yield plate and arm of the valve in its axes."""
        level = math.pi if self.side > 0 else 0.0
        plate = (0.0, 0.0, self.side * _CLOSING_ANGLE - level)
        half = (_PIPE_HALF_HEIGHT - 0.004) * self.unit
        yield Lines("throttle plate", (place_points(plate, ((-half, 0.0), (half, 0.0))),))
        yield make_bar("throttle rod", (0.0, 0.0), (_VALVE_ARM * self.unit, 0.0), 1.3 * _ROD_WIDTH * self.unit)

    def _pin(self, place: Vec2) -> Circle:
        return Circle("throttle pin", *place, _PIN_RADIUS * self.unit)


def _part(frame: Frame, *shapes: DrawnShape) -> Attached:
    """Return shapes in axes that move; none of them turns with the spindle."""
    return Attached(frame=frame, shapes=shapes, turns=False)
