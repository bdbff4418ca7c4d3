"""Drawing of a slide valve: the whole engine above, below it the cylinder and its valve in section, and Zeuner's diagram.

The shaft is at the right. The cylinder is drawn at the scale of the picture, and its valve at a larger one; the engine is smaller.
"""

import math
from abc import ABC
from collections.abc import Iterator
from functools import cached_property, partial

from governor_mechanism.machines.slider_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.render.geometry.attached import (
    Attached,
    DrawnPart,
    Frame,
    Moment,
    axes_shifted,
    axes_turned,
    bar_between,
    fixed,
    once_per_moment,
)
from governor_mechanism.render.geometry.outlines import make_bar, make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2, arc_points, axes_to_plane
from governor_mechanism.render.machines import steam_cylinder, steam_distribution
from governor_mechanism.render.machines.machine_drawing import Dimension, MachineDrawing
from governor_mechanism.render.machines.steam_cylinder import PositionAt
from governor_mechanism.render.machines.steam_distribution import (
    ValveGearPosition,
    changing_space_parts,
    key_shapes,
    scale_note_shapes,
    steam_phase,
)
from governor_mechanism.types import FloatArray

_MAX_DRAWN_ROD, _MAX_DRAWN_ECCENTRIC_ROD = 5.5, 3.2
"""Largest drawn lengths of connecting and eccentric rod, in crank radii; longer and infinite rods are shortened."""


class ValveGearProportions(MachineDrawing, ABC):
    """Dimensions (m); laps have a sign. Both rods may be infinite. `centre` is the centre of the valve travel."""

    crank = Dimension("crank")
    connecting_rod = Dimension("connecting_rod")
    eccentric = Dimension("eccentric")
    eccentric_rod = Dimension("eccentric_rod")
    advance = Dimension("advance")
    outside_lap = Dimension("outside_lap")
    inside_lap = Dimension("inside_lap")
    centre = Dimension("centre")
    outward_sign = 1.0

    @property
    def drawn_rod(self) -> float:
        """Drawn length of the connecting rod (m)."""
        return min(self.connecting_rod, _MAX_DRAWN_ROD * self.crank)

    @property
    def drawn_eccentric_rod(self) -> float:
        """Drawn length of the eccentric rod (m)."""
        return min(self.eccentric_rod, _MAX_DRAWN_ECCENTRIC_ROD * self.crank)

    @once_per_moment
    def position_at(self, moment: Moment) -> ValveGearPosition:
        """Return the position of the valve gear at a moment."""
        return self.position(moment.pose)

    def position(self, pose: FloatArray) -> ValveGearPosition:
        """Return the position of the valve gear at a pose (bodies, 3)."""
        crank, crosshead, valve = (pose[self.part.mechanism.body_index(name)].tolist() for name in (CRANK, CROSSHEAD, VALVE))
        piston_position = (0.0 if math.isinf(self.connecting_rod) else self.connecting_rod) - crosshead[0]
        return ValveGearPosition(crank_angle=crank[2], valve_displacement=valve[0] - self.centre, piston_position=piston_position)


# In crank radii of the view.
_RIGHT_MARGIN = 1.16
_LEFT_MARGIN = 0.06
_LOW_EDGE = 1.16
_PISTON_ROD_LENGTH = 2.72
"""Length of the piston rod: the crosshead does not meet the cylinder."""
_BORE_HALF_LENGTH = 1.14
_BORE_HALF_HEIGHT = 0.46
_WALL = 0.12
_PISTON_HALF_THICKNESS = 0.10
_VALVE_LINE_HEIGHT = 0.88
_CHEST_HALF_LENGTH = 0.78
_CHEST_HALF_HEIGHT = 0.26
"""Height of the valve line above the axis of the cylinder, only so that both are visible; half length and half height of the chest."""
_ROD_WIDTH = 0.15
_ECCENTRIC_ROD_WIDTH = 0.10
_THIN_ROD_WIDTH = 0.08
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
        left, bottom = self._to_picture(x + half_width, y - half_height)
        right, top = self._to_picture(x - half_width, y + half_height)
        return make_rectangle(role, left, right, bottom, top)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the casting of cylinder and chest, guides, crank circle and centre lines."""
        u = self._gear.crank
        rod = self._gear.drawn_rod
        middle = self._cylinder_middle
        far_end = middle + (_BORE_HALF_LENGTH + _WALL) * u
        yield Lines("axis", ((self._to_picture(-1.1 * u, 0.0), self._to_picture(far_end, 0.0)),))
        yield Lines("crank circle", (tuple(self._to_picture(*point) for point in arc_points((0.0, 0.0), 0.0, math.tau, u, 48)),))
        yield self._box("casting", middle, 0.0, (_BORE_HALF_LENGTH + _WALL) * u, (_BORE_HALF_HEIGHT + _WALL) * u)
        yield self._box("casting", middle, _VALVE_LINE_HEIGHT * u, _CHEST_HALF_LENGTH * u, _CHEST_HALF_HEIGHT * u)
        yield self._box("live steam", middle, _VALVE_LINE_HEIGHT * u, (_CHEST_HALF_LENGTH - 0.1) * u, (_CHEST_HALF_HEIGHT - 0.1) * u)
        yield self._box("bore", middle, 0.0, _BORE_HALF_LENGTH * u, _BORE_HALF_HEIGHT * u)
        for side in (1.0, -1.0):
            edge, back = side * 0.30 * u, side * 0.42 * u
            left, low = self._to_picture(rod + 1.3 * u, min(edge, back))
            right, high = self._to_picture(rod - 1.3 * u, max(edge, back))
            yield Lines("wall", (tuple(self._to_picture(x, edge) for x in (rod + 1.3 * u, rod - 1.3 * u)),))
            yield make_hatching("hatching", (left, right, low, high), 0.16 * u * self.scale)

    def moving_parts(self, position_at: PositionAt) -> Iterator[DrawnPart]:
        """Yield steam, piston, crosshead, both rods, crank and eccentric."""
        gear = self._gear
        shaft = self._to_picture(0.0, 0.0)
        s = self._gear.crank * self.scale
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
        u = self._gear.crank
        s = self._gear.crank * self.scale
        middle = self._cylinder_middle
        for side in (1.0, -1.0):
            phase_at = partial(self._phase_at, position_at, side)
            yield from changing_space_parts(phase_at, partial(self._space_at, position_at, side))
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


# In crank radii.
_LEFT, _RIGHT = -1.24, 3.70
"""Edges of the picture."""
_DIAL_CENTRE, _DIAL_RADIUS = (2.60, 1.50), 0.90
_KEY_TOP, _SCALES_LEFT = steam_cylinder.CYLINDER_BASE - 0.03, 0.10
"""Height of the upper edge of the key, and left edge of the words on scales."""


class SlideValveDrawing(ValveGearProportions):
    """Drawing of an engine with a slide valve."""

    panel_readings = ("valve_displacement", "crank_end_steam", "head_end_steam", "crank_end_travel")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield castings, the key of the steam, the divided circle, valve circles, and the curves of the run."""
        angles, valve_positions = (self.poses[:, self.part.mechanism.body_index(name), k] for name, k in ((CRANK, 2), (VALVE, 0)))
        scales = {"cylinder": 1.0, "valve": steam_cylinder.valve_magnification(self), "engine": self._engine.scale}
        yield fixed(self._engine.background_shapes())
        yield fixed(steam_cylinder.cylinder_background_shapes(self))
        yield fixed(key_shapes((_LEFT * self.crank, _KEY_TOP * self.crank), self.crank))
        yield fixed(scale_note_shapes((_SCALES_LEFT * self.crank, _KEY_TOP * self.crank), self.crank, scales))
        yield fixed(self._dial.background_shapes())
        yield fixed(self._dial.theory_shapes(self.advance))
        yield fixed(self._dial.curve_shapes(*steam_distribution.first_turn(angles, valve_positions - self.centre)))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield all parts that the crank moves."""
        yield from self._engine.moving_parts(self.position_at)
        yield from steam_cylinder.cylinder_moving_parts(self, self.position_at)
        yield from self._dial.crank_parts(self.position_at)

    @cached_property
    def _engine(self) -> EngineView:
        u = self.crank
        return EngineView(self, _LEFT * u, (_RIGHT - _LEFT) * u, (steam_cylinder.CHEST_TOP + 0.10) * u)

    @cached_property
    def _dial(self) -> steam_distribution.ZeunerDial:
        (x, y), u = _DIAL_CENTRE, self.crank
        return steam_distribution.ZeunerDial(self, (x * u, y * u), _DIAL_RADIUS * u)
