"""View of the whole engine: crank, eccentric and both rods at the right, crosshead, and the cylinder in section at the left."""

import math
from collections.abc import Iterator
from functools import partial

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Frame, Moment, axes_shifted, axes_turned, bar_between, fixed
from governor_mechanism.render.geometry.outlines import make_bar, make_hatching, make_rectangle
from governor_mechanism.render.geometry.points import arc_points, axes_to_plane
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.slide_valve.cylinder import PositionAt
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearProportions
from governor_mechanism.render.machines.slide_valve.steam_distribution import STEAM_PHASES, changing_space_parts, steam_phase

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

    def moving_parts(self, position_at: PositionAt) -> Iterator[DrawnPart]:
        """Yield steam, piston, crosshead, both rods, crank and eccentric."""
        gear, shaft, s = self._gear, self._to_picture(0.0, 0.0), self._gear.crank * self.scale
        chest = self._to_picture(self._cylinder_middle - _CHEST_HALF_LENGTH * gear.crank, _VALVE_LINE_HEIGHT * gear.crank)
        eccentricity, ahead = gear.eccentric * self.scale, gear.advance + math.pi / 2
        # At 0 the crank points away from the cylinder, which is to the right in the picture.
        crank_axes = axes_turned(shaft, lambda moment: position_at(moment).crank_angle)
        crosshead_axes, valve_axes = (axes_shifted(partial(place, position_at)) for place in (self._crosshead, self._valve))

        def rod_ends(moment: Moment) -> tuple[Vec2, Vec2]:
            return axes_to_plane(crank_axes(moment), s, 0.0), self._crosshead(position_at, moment)

        def eccentric_rod_ends(moment: Moment) -> tuple[Vec2, Vec2]:
            x, y, angle = crank_axes(moment)
            return axes_to_plane((x, y, angle + ahead), eccentricity, 0.0), self._valve(position_at, moment)

        yield from self._cylinder_parts(position_at, crosshead_axes)
        yield bar_between("piston rod", lambda moment: (chest, self._valve(position_at, moment)), _THIN_ROD_WIDTH * s)
        eccentric = axes_to_plane((0.0, 0.0, ahead), eccentricity, 0.0)
        yield Attached(frame=crank_axes, shapes=(Circle("eccentric", *eccentric, _STRAP_RATIO * eccentricity),))
        # The valve line is drawn above its place, so that the length of this rod changes.
        yield bar_between("eccentric", eccentric_rod_ends, _ECCENTRIC_ROD_WIDTH * s)
        yield Attached(frame=crank_axes, shapes=(make_bar("crank web", (0.0, 0.0), (s, 0.0), 0.34 * s),))
        yield Attached(frame=crosshead_axes, shapes=(make_rectangle("block", -0.24 * s, 0.24 * s, -0.30 * s, 0.30 * s),))
        length = gear.connecting_rod * self.scale if gear.connecting_rod == gear.drawn_rod else None
        yield bar_between("rod", rod_ends, _ROD_WIDTH * s, length=length)
        yield Attached(frame=crank_axes, shapes=(Circle("pivot", s, 0.0, 0.09 * s),))
        yield from (Attached(frame=axes, shapes=(Circle("pivot", 0.0, 0.0, 0.09 * s),)) for axes in (crosshead_axes, valve_axes))
        yield fixed([Circle("hub", *shaft, 0.14 * s)])

    def _crosshead(self, position_at: PositionAt, moment: Moment) -> Vec2:
        """Return the place of the crosshead."""
        return self._to_picture(self._gear.drawn_rod - position_at(moment).piston_position, 0.0)

    def _valve(self, position_at: PositionAt, moment: Moment) -> Vec2:
        """Return the place of the pin of the eccentric rod on the valve rod."""
        x = self._gear.drawn_eccentric_rod + position_at(moment).valve_displacement
        return self._to_picture(x, _VALVE_LINE_HEIGHT * self._gear.crank)

    def _cylinder_parts(self, position_at: PositionAt, crosshead_axes: Frame) -> Iterator[DrawnPart]:
        """Yield the steam at both ends, the piston and its rod."""
        u, s, middle = self._gear.crank, self._gear.crank * self.scale, self._cylinder_middle
        for side in (1.0, -1.0):
            phase_at = partial(self._phase_at, position_at, side)
            yield from changing_space_parts(STEAM_PHASES, phase_at, partial(self._space_at, position_at, side))
        # The piston stands at the left of the crosshead.
        rod = (middle - self._gear.drawn_rod) * self.scale
        yield Attached(frame=crosshead_axes, shapes=(make_bar("piston rod", (-rod, 0.0), (0.0, 0.0), _THIN_ROD_WIDTH * s),))
        bore = self._box("bore", middle, 0.0, _BORE_HALF_LENGTH * u, _BORE_HALF_HEIGHT * u).points
        yield fixed([Lines("bore edge", ((*bore, bore[0]),))])
        half, height = _PISTON_HALF_THICKNESS * s, _BORE_HALF_HEIGHT * s
        yield Attached(frame=crosshead_axes, shapes=(make_rectangle("piston", -rod - half, -rod + half, -height, height),))

    def _phase_at(self, position_at: PositionAt, side: float, moment: Moment) -> str:
        return steam_phase(self._gear, position_at(moment), side)

    def _space_at(self, position_at: PositionAt, side: float, moment: Moment) -> tuple[Vec2, ...]:
        """Return the outline of the space between the piston and an end of the bore; the crank end is the nearer one."""
        u, middle = self._gear.crank, self._cylinder_middle
        face = middle - position_at(moment).piston_position - side * _PISTON_HALF_THICKNESS * u
        end = middle - side * _BORE_HALF_LENGTH * u
        return self._box("", 0.5 * (face + end), 0.0, 0.5 * abs(face - end), _BORE_HALF_HEIGHT * u).points
