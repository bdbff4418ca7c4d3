"""What a governor moves: a strap on the sleeve, a forked lever about a fixed pivot, its rod, and the throttle valve in its pipe."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, make_wall
from governor_mechanism.render.geometry.points import axes_to_plane
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2

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
    """A forked lever, a rod and a throttle valve, moved by a pin on the sleeve at the spindle's axis.

    Attributes
    ----------
    unit
        Length (m) that sizes the parts.
    side
        -1 for a gear at the left of the spindle, 1 at the right.
    pin_range
        Lowest and highest height of the pin over the run, m.
    strap_half_width
        Half the width of the strap around the sleeve, m.
    pivot_distance
        Distance of the lever's fixed pivot from the axis, m.
    valve_height
        Highest height of the throttle valve, m.
    """

    unit: float
    side: float
    pin_range: Vec2
    strap_half_width: float
    pivot_distance: float
    valve_height: float

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

    def moving_shapes(self, pin_height: float) -> Iterator[DrawnShape]:
        """Yield strap, lever, rod and valve for a height of the pin (m)."""
        u, pin, pivot, valve = self.unit, (0.0, pin_height), self.pivot, self.valve
        end, arm_end = self.lever_end(pin_height), self.valve_arm_end(pin_height)
        half = 0.5 * _STRAP_HEIGHT * u
        yield make_rectangle("throttle strap", -self.strap_half_width, self.strap_half_width, pin_height - half, pin_height + half)
        # The fork is slotted: the pin moves straight, the lever about its pivot.
        reach = math.hypot(self.pivot_distance, 0.5 * (self.pin_range[1] - self.pin_range[0])) + _FORK_END * u
        axes = (*pivot, math.atan2(pin_height - pivot[1], -pivot[0]))
        yield make_bar("throttle lever", end, axes_to_plane(axes, reach, 0.0), _LEVER_WIDTH * u)
        slot = (axes_to_plane(axes, distance, 0.0) for distance in (self.pivot_distance, reach - _FORK_END * u))
        yield make_bar("throttle slot", next(slot), next(slot), 2 * _PIN_RADIUS * u)
        angle = math.atan2(arm_end[1] - valve[1], arm_end[0] - valve[0])
        level = math.pi if self.side > 0 else 0.0
        plate = (*valve, angle - level + self.side * _CLOSING_ANGLE)
        ends = tuple(axes_to_plane(plate, sign * (_PIPE_HALF_HEIGHT - 0.004) * u, 0.0) for sign in (-1, 1))
        yield Lines("throttle plate", (ends,))
        yield make_bar("throttle rod", valve, arm_end, 1.3 * _ROD_WIDTH * u)
        yield make_bar("throttle rod", end, arm_end, _ROD_WIDTH * u)
        yield from (Circle("throttle pin", *point, _PIN_RADIUS * u) for point in (pin, pivot, end, arm_end, valve))
