"""View of the whole engine: crank, eccentric and both rods at the right, crosshead, and the cylinder in section at the left."""

import math
from collections.abc import Iterator

from governor_mechanism.render.geometry.outlines import make_bar, make_hatching, make_rectangle
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearProportions
from governor_mechanism.render.machines.slide_valve.steam_distribution import STEAM_PHASES, ValveGearPosition, steam_phase

# In crank radii of the view.
_RIGHT_MARGIN, _LEFT_MARGIN, _LOW_EDGE = 1.16, 0.06, 1.16
_PISTON_ROD_LENGTH = 2.72
"""Length of the piston rod: the crosshead does not meet the cylinder."""
_BORE_HALF_LENGTH, _BORE_HALF_HEIGHT, _WALL = 1.14, 0.46, 0.12
_PISTON_HALF_THICKNESS = 0.10
_VALVE_LINE_HEIGHT, _CHEST_HALF_LENGTH, _CHEST_HALF_HEIGHT = 0.88, 0.78, 0.26
"""Height of the valve line above the axis of the cylinder, only so that both are visible; half length and half height of the chest."""
_ROD_WIDTH, _ECCENTRIC_ROD_WIDTH, _THIN_ROD_WIDTH = 0.15, 0.10, 0.08
_STRAP_RATIO = 1.9
"""Radius of the eccentric's strap, relative to the eccentricity."""


class EngineView:
    """Map from the engine (m from the shaft, away from it and up) to a picture from `left` on, `width` wide, above `base` (m)."""

    def __init__(self, valve_gear: ValveGearProportions, left: float, width: float, base: float) -> None:
        self._gear, u = valve_gear, valve_gear.crank
        # Distance of the middle of the cylinder from the shaft.
        self._cylinder_middle = valve_gear.drawn_rod + _PISTON_ROD_LENGTH * u
        length = _RIGHT_MARGIN * u + self._cylinder_middle + (_BORE_HALF_LENGTH + _WALL + _LEFT_MARGIN) * u
        self.scale = width / length
        """Metres of the picture per metre of the engine."""
        self._x, self._y = left + width - _RIGHT_MARGIN * u * self.scale, base + _LOW_EDGE * u * self.scale

    def _to_picture(self, x: float, y: float) -> Vec2:
        return self._x - x * self.scale, self._y + y * self.scale

    def _box(self, role: str, x: float, y: float, half_width: float, half_height: float) -> Polygon:
        """Return a box with its middle at (x, y)."""
        (left, bottom), (right, top) = self._to_picture(x + half_width, y - half_height), self._to_picture(x - half_width, y + half_height)
        return make_rectangle(role, left, right, bottom, top)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the casting of cylinder and chest, guides, crank circle and centre lines."""
        u, rod, middle = self._gear.crank, self._gear.drawn_rod, self._cylinder_middle
        far_end = middle + (_BORE_HALF_LENGTH + _WALL) * u
        yield Lines("axis", ((self._to_picture(-1.1 * u, 0.0), self._to_picture(far_end, 0.0)),))
        yield Lines("crank circle", (tuple(self._to_picture(*point) for point in arc_points((0.0, 0.0), 0.0, math.tau, u, 48)),))
        yield self._box("casting", middle, 0.0, (_BORE_HALF_LENGTH + _WALL) * u, (_BORE_HALF_HEIGHT + _WALL) * u)
        yield self._box("casting", middle, _VALVE_LINE_HEIGHT * u, _CHEST_HALF_LENGTH * u, _CHEST_HALF_HEIGHT * u)
        yield self._box("live steam", middle, _VALVE_LINE_HEIGHT * u, (_CHEST_HALF_LENGTH - 0.1) * u, (_CHEST_HALF_HEIGHT - 0.1) * u)
        yield self._box("bore", middle, 0.0, _BORE_HALF_LENGTH * u, _BORE_HALF_HEIGHT * u)
        for side in (1.0, -1.0):
            edge, back = side * 0.30 * u, side * 0.42 * u
            (left, low), (right, high) = self._to_picture(rod + 1.3 * u, min(edge, back)), self._to_picture(rod - 1.3 * u, max(edge, back))
            yield Lines("wall", (tuple(self._to_picture(x, edge) for x in (rod + 1.3 * u, rod - 1.3 * u)),))
            yield make_hatching("hatching", (left, right, low, high), 0.16 * u * self.scale)

    def moving_shapes(self, position: ValveGearPosition) -> Iterator[DrawnShape]:
        """Yield steam, piston, crosshead, both rods, crank and eccentric."""
        gear, u, scale, shaft = self._gear, self._gear.crank, self.scale, self._to_picture(0.0, 0.0)
        # At 0 the crank points away from the cylinder.
        pin = self._to_picture(-u * math.cos(position.crank_angle), u * math.sin(position.crank_angle))
        theta = position.crank_angle + gear.advance
        eccentric = self._to_picture(gear.eccentric * math.sin(theta), gear.eccentric * math.cos(theta))
        crosshead_x, valve_x = gear.drawn_rod - position.piston_position, gear.drawn_eccentric_rod + position.valve_displacement
        crosshead, valve = self._to_picture(crosshead_x, 0.0), self._to_picture(valve_x, _VALVE_LINE_HEIGHT * u)
        yield from self._cylinder_shapes(position, crosshead)
        chest = self._to_picture(self._cylinder_middle - _CHEST_HALF_LENGTH * u, _VALVE_LINE_HEIGHT * u)
        yield make_bar("piston rod", chest, valve, _THIN_ROD_WIDTH * u * scale)
        yield Circle("eccentric", *eccentric, _STRAP_RATIO * gear.eccentric * scale)
        yield make_bar("eccentric", eccentric, valve, _ECCENTRIC_ROD_WIDTH * u * scale)
        yield make_bar("crank web", shaft, pin, 0.34 * u * scale)
        yield self._box("block", crosshead_x, 0.0, 0.24 * u, 0.30 * u)
        yield make_bar("rod", pin, crosshead, _ROD_WIDTH * u * scale)
        yield from (Circle("pivot", *point, 0.09 * u * scale) for point in (pin, crosshead, valve))
        yield Circle("hub", *shaft, 0.14 * u * scale)

    def _cylinder_shapes(self, position: ValveGearPosition, crosshead: Vec2) -> Iterator[DrawnShape]:
        """Yield the steam at both ends, the piston and its rod."""
        u, middle, half = self._gear.crank, self._cylinder_middle, _PISTON_HALF_THICKNESS * self._gear.crank
        piston_x = middle - position.piston_position
        for side in (1.0, -1.0):
            phase = steam_phase(self._gear, position, side)
            # The crank end is the nearer one.
            face, end = piston_x - side * half, middle - side * _BORE_HALF_LENGTH * u
            space = self._box("", 0.5 * (face + end), 0.0, 0.5 * abs(face - end), _BORE_HALF_HEIGHT * u).points
            yield from (Polygon(role, space if role == phase else ()) for role in STEAM_PHASES)
        yield make_bar("piston rod", self._to_picture(piston_x, 0.0), crosshead, _THIN_ROD_WIDTH * u * self.scale)
        bore = self._box("bore", middle, 0.0, _BORE_HALF_LENGTH * u, _BORE_HALF_HEIGHT * u).points
        yield Lines("bore edge", ((*bore, bore[0]),))
        yield self._box("piston", piston_x, 0.0, half, _BORE_HALF_HEIGHT * u)
