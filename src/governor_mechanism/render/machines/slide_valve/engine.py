"""View of the whole engine at a small scale: shaft with crank and eccentric at the right, rods, crosshead, cylinder at the left."""

import math
from collections.abc import Iterator

from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearPosition, ValveGearProportions

_STRIP_WIDTH = 2.96
"""Width of the strip, in crank radii."""

_PISTON_ROD_LENGTH, _CYLINDER_LENGTH, _BORE_HALF_HEIGHT = 2.5, 2.5, 0.62
"""Length of the piston rod, length of the cylinder and half height of the bore, in crank radii of the engine view."""

_VALVE_LINE_HEIGHT = 0.90
"""Height of the valve line above the cylinder axis, in crank radii of the engine view; only so that both are visible."""


class _EngineToPicture:
    """Map from engine coordinates (m from the shaft, away from it and up) to picture coordinates (m).

    `base_height` (m) is the lower edge of the strip; `scale` is in metres of the picture per metre.
    """

    def __init__(self, valve_gear: ValveGearProportions, base_height: float) -> None:
        u = valve_gear.crank
        self.cylinder_near_end = valve_gear.drawn_rod + (_PISTON_ROD_LENGTH - 1.0) * u
        self.scale = _STRIP_WIDTH / (1.25 + valve_gear.drawn_rod / u + 1.0 + _PISTON_ROD_LENGTH + _CYLINDER_LENGTH - 1.0)
        self.x = 0.5 * _STRIP_WIDTH * u - 1.25 * u * self.scale
        self.y = base_height + 1.2 * u * self.scale

    def __call__(self, x: float, y: float) -> Vec2:
        return self.x - x * self.scale, self.y + y * self.scale

    def block(self, x: float, y: float, half_width: float, half_height: float) -> Polygon:
        """Return a sliding block with its centre at (x, y)."""
        (left, bottom), (right, top) = self(x + half_width, y - half_height), self(x - half_width, y + half_height)
        return make_rectangle("block", left, right, bottom, top)


def engine_background_shapes(valve_gear: ValveGearProportions, base_height: float) -> Iterator[DrawnShape]:
    """Yield cylinder and chest, guides and centre line; `base_height` (m) is the lower edge of the strip."""
    u, to_picture = valve_gear.crank, _EngineToPicture(valve_gear, base_height)
    cylinder_far_end = to_picture.cylinder_near_end + _CYLINDER_LENGTH * u
    left, low = to_picture(cylinder_far_end, -_BORE_HALF_HEIGHT * u)
    right, high = to_picture(to_picture.cylinder_near_end, _BORE_HALF_HEIGHT * u)
    chest_inset = 0.15 * (right - left)
    chest_top = to_picture(0.0, (_VALVE_LINE_HEIGHT + 0.30) * u)[1]
    yield Lines("axis", ((to_picture(-1.2 * u, 0.0), to_picture(cylinder_far_end + 0.15 * u, 0.0)),))
    yield make_rectangle("casting", left, right, low, high)
    yield make_rectangle("casting", left + chest_inset, right - chest_inset, high, chest_top)
    guide_ends = valve_gear.drawn_rod - 1.25 * u, valve_gear.drawn_rod + 1.25 * u
    yield Lines("guide", tuple(tuple(to_picture(x, y * u) for x in guide_ends) for y in (-0.32, 0.32)))
    angles = [math.tau * k / 48 for k in range(49)]
    yield Lines("guide", (tuple(to_picture(u * math.cos(angle), u * math.sin(angle)) for angle in angles),))


def engine_moving_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition, base_height: float) -> Iterator[DrawnShape]:
    """Yield crank, eccentric, both rods, crosshead, and the rods of piston and valve."""
    u, to_picture = valve_gear.crank, _EngineToPicture(valve_gear, base_height)
    valve_line_height = _VALVE_LINE_HEIGHT * u
    scale = to_picture.scale
    shaft = to_picture(0.0, 0.0)
    # At 0 the crank points away from the cylinder.
    pin = to_picture(-u * math.cos(position.crank_angle), u * math.sin(position.crank_angle))
    theta = position.crank_angle + valve_gear.advance
    eccentric = to_picture(valve_gear.eccentric * math.sin(theta), valve_gear.eccentric * math.cos(theta))
    crosshead_x, valve_x = valve_gear.drawn_rod - position.piston_position, valve_gear.drawn_eccentric_rod + position.valve_displacement
    crosshead, valve = to_picture(crosshead_x, 0.0), to_picture(valve_x, valve_line_height)
    yield Lines("small rod", ((crosshead, to_picture(to_picture.cylinder_near_end, 0.0)),))
    yield Lines("eccentric rod", ((valve, to_picture(to_picture.cylinder_near_end, valve_line_height)),))
    yield Circle("crank web", *shaft, 0.30 * u * scale)
    yield make_bar("crank web", shaft, pin, 0.30 * u * scale)
    yield Circle("eccentric", *eccentric, 1.9 * valve_gear.eccentric * scale)
    yield Lines("eccentric rod", ((eccentric, valve),))
    yield Lines("small rod", ((pin, crosshead),))
    yield to_picture.block(crosshead_x, 0.0, 0.24 * u, 0.30 * u)
    yield to_picture.block(valve_x, valve_line_height, 0.10 * u, 0.13 * u)
    yield Circle("pivot", *shaft, 0.10 * u * scale)
    yield Circle("pivot", *pin, 0.09 * u * scale)
