"""View of the whole engine at a small scale: shaft with crank and eccentric at the right, rods, crosshead, cylinder at the left."""

from __future__ import annotations

import math

from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearPosition, ValveGearProportions

_STRIP_WIDTH = 2.96
"""Width of the strip, in crank radii."""

_PISTON_ROD_LENGTH, _CYLINDER_LENGTH, _BORE_HALF_HEIGHT = 2.5, 2.5, 0.62
"""Length of the piston rod, length of the cylinder and half height of the bore, in crank radii of the engine view."""

_VALVE_LINE_HEIGHT = 0.90
"""Height of the valve line above the cylinder axis, in crank radii of the engine view; only so that both are visible."""


def engine_scale(valve_gear: ValveGearProportions) -> float:
    """Return the scale of the engine view: metres of the picture per metre."""
    return _STRIP_WIDTH / (1.25 + valve_gear.drawn_rod / valve_gear.crank + 1.0 + _PISTON_ROD_LENGTH + _CYLINDER_LENGTH - 1.0)


class _EngineToPicture:
    """Map from engine coordinates (m from the shaft, away from it and up) to picture coordinates (m)."""

    def __init__(self, valve_gear: ValveGearProportions, base_height: float) -> None:
        self.scale = engine_scale(valve_gear)
        self.x = 0.5 * _STRIP_WIDTH * valve_gear.crank - 1.25 * valve_gear.crank * self.scale
        self.y = base_height + 1.2 * valve_gear.crank * self.scale

    def __call__(self, x: float, y: float) -> Vec2:
        return self.x - x * self.scale, self.y + y * self.scale


def steam_engine_background_shapes(valve_gear: ValveGearProportions, base_height: float) -> tuple[DrawnShape, ...]:
    """Return cylinder and chest, guides and centre line; `base_height` (m) is the lower edge of the strip."""
    u, to_picture = valve_gear.crank, _EngineToPicture(valve_gear, base_height)
    cylinder_near_end = valve_gear.drawn_rod + (_PISTON_ROD_LENGTH - 1.0) * u
    cylinder_far_end = cylinder_near_end + _CYLINDER_LENGTH * u
    left, right = to_picture(cylinder_far_end, 0.0)[0], to_picture(cylinder_near_end, 0.0)[0]
    low, high = (to_picture(0.0, y * u)[1] for y in (-_BORE_HALF_HEIGHT, _BORE_HALF_HEIGHT))
    chest = to_picture(0.0, (_VALVE_LINE_HEIGHT + 0.30) * u)[1]
    guide = [
        (to_picture(valve_gear.drawn_rod - 1.25 * u, y * u), to_picture(valve_gear.drawn_rod + 1.25 * u, y * u)) for y in (-0.32, 0.32)
    ]
    return (
        Lines("axis", ((to_picture(-1.2 * u, 0.0), to_picture(cylinder_far_end + 0.15 * u, 0.0)),)),
        make_rectangle("casting", left, right, low, high),
        make_rectangle("casting", left + 0.15 * (right - left), right - 0.15 * (right - left), high, chest),
        Lines("guide", tuple(guide)),
        Lines("guide", (tuple(to_picture(u * math.cos(math.tau * k / 48), u * math.sin(math.tau * k / 48)) for k in range(49)),)),
    )


def steam_engine_moving_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition, base_height: float) -> tuple[DrawnShape, ...]:
    """Return crank, eccentric, both rods, crosshead, and the rods of piston and valve."""
    u, to_picture, scale = valve_gear.crank, _EngineToPicture(valve_gear, base_height), engine_scale(valve_gear)
    # At 0 the crank points away from the cylinder.
    pin = -u * math.cos(position.crank_angle), u * math.sin(position.crank_angle)
    theta = position.crank_angle + valve_gear.advance
    eccentric = valve_gear.eccentric * math.sin(theta), valve_gear.eccentric * math.cos(theta)
    crosshead = valve_gear.drawn_rod - position.piston_position
    valve = valve_gear.drawn_eccentric_rod + position.valve_displacement
    cylinder_near_end = valve_gear.drawn_rod + (_PISTON_ROD_LENGTH - 1.0) * u
    valve_line_height = _VALVE_LINE_HEIGHT * u
    return (
        Lines("small rod", ((to_picture(crosshead, 0.0), to_picture(cylinder_near_end, 0.0)),)),
        Lines("eccentric rod", ((to_picture(valve, valve_line_height), to_picture(cylinder_near_end, valve_line_height)),)),
        Circle("crank web", *to_picture(0.0, 0.0), 0.30 * u * scale),
        make_bar("crank web", to_picture(0.0, 0.0), to_picture(*pin), 0.30 * u * scale),
        Circle("eccentric", *to_picture(*eccentric), 1.9 * valve_gear.eccentric * scale),
        Lines("eccentric rod", ((to_picture(*eccentric), to_picture(valve, valve_line_height)),)),
        Lines("small rod", ((to_picture(*pin), to_picture(crosshead, 0.0)),)),
        make_rectangle("block", *_horizontal_interval(to_picture, crosshead, 0.24 * u), *_vertical_interval(to_picture, 0.30 * u)),
        make_rectangle(
            "block", *_horizontal_interval(to_picture, valve, 0.10 * u), *_vertical_interval(to_picture, 0.13 * u, valve_line_height)
        ),
        Circle("pivot", *to_picture(0.0, 0.0), 0.10 * u * scale),
        Circle("pivot", *to_picture(*pin), 0.09 * u * scale),
    )


def _horizontal_interval(to_picture: _EngineToPicture, x: float, half_width: float) -> Vec2:
    return to_picture(x + half_width, 0.0)[0], to_picture(x - half_width, 0.0)[0]


def _vertical_interval(to_picture: _EngineToPicture, half_height: float, y: float = 0.0) -> Vec2:
    return to_picture(0.0, y - half_height)[1], to_picture(0.0, y + half_height)[1]
