"""Drawing of an engine with a flywheel: the engine at a small scale, and below it each cylinder with its indicator diagram.

The shaft is at the left. The volume axis of the diagram is the travel of the piston, so that the indicator points stand over the piston.

The machine stands with its cylinders below the shaft; the drawing lays it on its side, with the shaft at the left.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from governor_mechanism.effects.gas_pressure import pressure_in_stroke
from governor_mechanism.machines.flywheel_engine import EXPANSION, FLYWHEEL, THROTTLE
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_shifted, axes_turned, bar_between, fixed
from governor_mechanism.render.geometry.outlines import make_bar, make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    TextShape,
    Vec2,
    arc_points,
    axes_to_plane,
    round_step,
)
from governor_mechanism.render.machines.machine_drawing import Dimension, MachineDrawing
from governor_mechanism.types import FloatArray

GAS_ROLES = ("live steam", "expanding steam", "spent steam")
"""Roles of gas above two thirds, one third and below one third of the highest pressure."""

# In strokes of the picture.
BORE_HEIGHT = 0.15
WALL = 0.03
PISTON_THICKNESS = 0.10
MIN_CLEARANCE = 0.02
DIAGRAM_HEIGHT = 0.36
_RIGHT_END = 1.37
"""Right edge of the picture."""
_N_CURVE_POINTS = 120
"""Points of a curve over a stroke."""

BAR = 1e5
"""Pascals in a bar."""


@dataclass(frozen=True, kw_only=True)
class CylinderView:
    """Picture of a cylinder."""

    name: str  # name of the cylinder
    # driving, resisting: gas behind the piston in its stroke, and in front of it if that has elements of
    # its own
    driving: CylinderGas
    resisting: CylinderGas | None
    back_pressure: float  # pressure in front of the piston, Pa, if it is constant
    clearance: float  # clearance relative to the volume of the stroke
    stroke: float  # stroke of the picture, m
    base: float  # height of the lower edge of the casting, m
    diagram_base: float  # height of the pressure zero of the diagram, m
    highest_pressure: float  # pressure at the top of the diagram, Pa
    has_moving_diagram: bool = False  # whether the loops of the diagram change from stroke to stroke

    @property
    def axis(self) -> float:
        """Height of the piston rod, m."""
        return self.base + (WALL + 0.5 * BORE_HEIGHT) * self.stroke

    def shaft_side_pressure(self, relative_travel: float, is_return: bool) -> float:
        """Return the pressure (Pa) on the face of the piston toward the shaft, at a travel relative to the stroke."""
        return self._pressure_in_front(1 - relative_travel) if is_return else self._pressure_behind(relative_travel)

    def far_side_pressure(self, relative_travel: float, is_return: bool) -> float:
        """Return the pressure (Pa) on the other face."""
        return self.shaft_side_pressure(1 - relative_travel, not is_return)

    def _pressure_behind(self, stroke_travel: float) -> float:
        return float(pressure_in_stroke(self.driving, stroke_travel))

    def _pressure_in_front(self, stroke_travel: float) -> float:
        return self.back_pressure if self.resisting is None else float(pressure_in_stroke(self.resisting, stroke_travel))

    @cached_property
    def _drawn_clearance(self) -> float:
        return max(self.clearance, MIN_CLEARANCE) * self.stroke

    def _height(self, pressure: float) -> float:
        """Return the height in the diagram of a pressure (Pa), m."""
        return self.diagram_base + DIAGRAM_HEIGHT * self.stroke * pressure / self.highest_pressure

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the casting, and the diagram with its loops."""
        u, (left, right, low, high) = self.stroke, self._bore
        wall = WALL * u
        yield make_rectangle("casting", left - wall, right + wall, low - wall, high + wall)
        for section in ((left - wall, right + wall, low - wall, low), (left - wall, right + wall, high, high + wall)):
            yield make_hatching("casting hatching", section, 0.03 * u)
        yield make_rectangle("bore", left, right, low, high)
        yield TextShape("scale", right + wall + 0.03 * u, self.axis, self.name, _RIGHT_END * u - right - wall - 0.03 * u)
        yield from self._diagram_axes()
        if not self.has_moving_diagram:
            yield from self._loops()

    def _loops(self) -> Iterator[DrawnShape]:
        """Yield the pressures on both faces over a turn."""
        u = self.stroke
        loop = [(k / _N_CURVE_POINTS, False) for k in range(_N_CURVE_POINTS + 1)]
        loop += [(1 - k / _N_CURVE_POINTS, True) for k in range(_N_CURVE_POINTS + 1)]
        for role, pressure in (("head end curve", self.far_side_pressure), ("crank end curve", self.shaft_side_pressure)):
            points = [(travel * u, self._height(pressure(travel, is_return))) for travel, is_return in loop]
            yield Lines(role, ((*points, points[0]),))

    def _diagram_axes(self) -> Iterator[DrawnShape]:
        """Yield axes and pressure lines with their numbers in bar."""
        u, top = self.stroke, self.highest_pressure
        step = round_step(top / BAR, 4)
        ticks = [step * k for k in range(math.floor(top / BAR / step + 1e-9) + 1)]
        yield Lines("leader", tuple(((0.0, self._height(tick * BAR)), (u, self._height(tick * BAR))) for tick in ticks[1:]))
        yield Lines("scale", (((0.0, self._height(top)), (0.0, self._height(0.0)), (u, self._height(0.0))),))
        for tick in ticks:
            unit = " bar" if tick == ticks[-1] else ""
            yield TextShape("scale", 1.03 * u, self._height(tick * BAR), f"{tick:g}{unit}", 0.2 * u)

    @property
    def _bore(self) -> tuple[float, float, float, float]:
        """Left, right, lower and upper end of the bore, m."""
        reach = 0.5 * PISTON_THICKNESS * self.stroke + self._drawn_clearance
        floor = self.base + WALL * self.stroke
        return -reach, self.stroke + reach, floor, floor + BORE_HEIGHT * self.stroke

    def gas_shapes(self, relative_travel: float, is_return: bool) -> Iterator[DrawnShape]:
        """Yield the loops of a diagram that changes, the gas, and the piston rod up to the piston."""
        u, (left, right, low, high) = self.stroke, self._bore
        if self.has_moving_diagram:
            yield from self._loops()
        x = relative_travel * u
        half = 0.5 * PISTON_THICKNESS * u
        rod = 0.016 * u
        for (start, end), pressure in zip(((left, x - half), (x + half, right)), self._faces(relative_travel, is_return), strict=True):
            outline = make_rectangle("bore", start, end, low, high).points
            yield from (Polygon(role, outline if role == self.gas_role(pressure) else ()) for role in GAS_ROLES)
        yield make_rectangle("piston rod", left - 0.08 * u, x, self.axis - rod, self.axis + rod)

    def piston(self) -> Polygon:
        """Return the piston at the start of its stroke."""
        half, (_, _, low, high) = 0.5 * PISTON_THICKNESS * self.stroke, self._bore
        return make_rectangle("piston", -half, half, low, high)

    def mark_shapes(self, relative_travel: float, is_return: bool) -> Iterator[DrawnShape]:
        """Yield the indicator points over the piston."""
        x = relative_travel * self.stroke
        faces = self._faces(relative_travel, is_return)
        points = [(x, self._height(pressure)) for pressure in faces]
        reach = min((self.axis, *(y for _, y in points))), max((self.axis, *(y for _, y in points)))
        yield Lines("projection", (((x, reach[0]), (x, reach[1])),))
        for role, point in zip(("crank end mark", "head end mark"), points, strict=True):
            yield Circle(role, *point, 0.022 * self.stroke)

    def _faces(self, relative_travel: float, is_return: bool) -> tuple[float, float]:
        """Return the pressures (Pa) on both faces, that toward the shaft first."""
        return self.shaft_side_pressure(relative_travel, is_return), self.far_side_pressure(relative_travel, is_return)

    def gas_role(self, pressure: float) -> str:
        """Return the role of gas at a pressure (Pa)."""
        share = pressure / self.highest_pressure
        return GAS_ROLES[0 if share > 2 / 3 else 1 if share > 1 / 3 else 2]


def highest_pressure(gases: Iterable[CylinderGas]) -> float:
    """Return the highest pressure of gases in a stroke, Pa."""
    return max(float(pressure_in_stroke(gas, travel)) for gas in gases for travel in (0.0, 0.5, 1.0))


# In crank radii of the view.
WHEEL_RADIUS = 1.9
_RIM_WIDTH = 0.28
_HUB_RADIUS = 0.36
MAX_DRAWN_ROD = 4.2
_PISTON_ROD = 1.35
_CYLINDER_LENGTH = 2.5
_CYLINDER_HALF_HEIGHT = 0.5
_N_SPOKES = 6


@dataclass(frozen=True, kw_only=True)
class EngineView:
    """Picture of the engine; the shaft is at the left, and the crank turns anticlockwise from its left dead centre."""

    crank: float  # crank radius of the engine, m
    rod: float  # length of its connecting rod, m; infinite for a yoke
    # left, right: edges of the picture, m
    left: float
    right: float
    base: float  # lower edge of the picture, m
    # length of the picture in crank radii if longer than needed: the piston rod is that much longer
    length: float = 0.0

    @cached_property
    def _has_yoke(self) -> bool:
        return math.isinf(self.rod)

    @cached_property
    def _drawn_rod(self) -> float:
        """Length of the connecting rod, or of the rod of the yoke, in crank radii."""
        return 1.2 if self._has_yoke else min(self.rod / self.crank, MAX_DRAWN_ROD)

    @cached_property
    def needed_length(self) -> float:
        """Length of the picture in crank radii with the shortest piston rod."""
        return WHEEL_RADIUS + self._drawn_rod + 1.0 + _PISTON_ROD + _CYLINDER_LENGTH

    @cached_property
    def scale(self) -> float:
        """Crank radius of the picture, m."""
        return (self.right - self.left) / max(self.needed_length, self.length)

    @property
    def height(self) -> float:
        """Height of the picture, m."""
        return 2 * WHEEL_RADIUS * self.scale

    @cached_property
    def shaft(self) -> Vec2:
        """Middle of the shaft in the picture, m."""
        return self.left + WHEEL_RADIUS * self.scale, self.base + WHEEL_RADIUS * self.scale

    def _to_picture(self, x: float, y: float) -> Vec2:
        """Return the place of a point in crank radii from the shaft."""
        return self.shaft[0] + x * self.scale, self.shaft[1] + y * self.scale

    @property
    def cylinder_box(self) -> BoundingBox:
        """Left, right, lower and upper edge of the cylinder in the picture, m."""
        near, far = self._cylinder_ends
        left, low = self._to_picture(near, -_CYLINDER_HALF_HEIGHT)
        right, high = self._to_picture(far, _CYLINDER_HALF_HEIGHT)
        return left, right, low, high

    @cached_property
    def _cylinder_ends(self) -> Vec2:
        """Ends of the cylinder, in crank radii from the shaft."""
        start = max(self.needed_length, self.length) - WHEEL_RADIUS - _CYLINDER_LENGTH
        return start, start + _CYLINDER_LENGTH

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield centre line, bearing, guides and cylinder."""
        yield Lines("axis", ((self._to_picture(-WHEEL_RADIUS, 0.0), self._to_picture(self._cylinder_ends[1], 0.0)),))
        yield make_rectangle("casting", *self.cylinder_box)
        if not self._has_yoke:
            ends = self._drawn_rod - 1.35, self._drawn_rod + 1.35
            yield Lines("guide", tuple(tuple(self._to_picture(x, y) for x in ends) for y in (-0.33, 0.33)))

    def moving_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield the parts; `angle_at` is the crank angle at a moment, rad."""
        yield from self.wheel_parts(angle_at)
        yield from self.crank_parts(angle_at)

    def crank_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield crank, connecting rod and crosshead; `angle_at` is the crank angle at a moment, rad."""
        s = self.scale
        shaft = self.shaft
        near_end = self._to_picture(self._cylinder_ends[0], 0.0)
        crank_axes = axes_turned(shaft, angle_at)
        yield Attached(frame=crank_axes, shapes=(make_bar("crank web", (0.0, 0.0), (-s, 0.0), 0.42 * s),))
        yield fixed([Circle("hub", *shaft, 0.16 * s)])
        if self._has_yoke:
            yoke_axes = axes_shifted(lambda moment: self._to_picture(-math.cos(angle_at(moment)), 0.0))
            yoke = make_bar("rod", (0.0, -1.15 * s), (0.0, 1.15 * s), 0.34 * s)
            yield Attached(frame=yoke_axes, shapes=(yoke, make_bar("slot", (0.0, -1.05 * s), (0.0, 1.05 * s), 0.2 * s)))
            yield Flexible(shapes_at=lambda moment: [Lines("small rod", ((axes_to_plane(yoke_axes(moment), 0.17 * s, 0.0), near_end),))])
        else:
            crosshead_at = partial(self._crosshead, angle_at)
            yield Flexible(shapes_at=lambda moment: [Lines("small rod", ((crosshead_at(moment), near_end),))])
            pin_at = partial(self._pin, angle_at)
            yield bar_between("rod", lambda moment: (pin_at(moment), crosshead_at(moment)), 0.16 * s, length=self._drawn_rod * s)
            block = make_rectangle("block", -0.25 * s, 0.25 * s, -0.3 * s, 0.3 * s)
            yield Attached(frame=axes_shifted(crosshead_at), shapes=(block,))
        yield Attached(frame=crank_axes, shapes=(Circle("pivot", -s, 0.0, 0.12 * s),))

    def _pin(self, angle_at: Callable[[Any], float], moment: Any) -> Vec2:
        """Return the place of the crank pin."""
        angle = angle_at(moment)
        return self._to_picture(-math.cos(angle), -math.sin(angle))

    def _crosshead(self, angle_at: Callable[[Any], float], moment: Any) -> Vec2:
        """Return the place of the crosshead."""
        angle = angle_at(moment)
        return self._to_picture(-math.cos(angle) + math.sqrt(self._drawn_rod**2 - math.sin(angle) ** 2), 0.0)

    def wheel_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield rim, spokes and hub; `angle_at` is the crank angle at a moment, rad. The spoke opposite to the crank is marked."""
        s, shaft = self.scale, self.shaft
        yield fixed([Circle("wheel", *shaft, WHEEL_RADIUS * s), Circle("wheel web", *shaft, (WHEEL_RADIUS - _RIM_WIDTH) * s)])
        spokes = [self._spoke(math.tau * k / _N_SPOKES) for k in range(_N_SPOKES)]
        shapes = (Lines("spoke", tuple(spokes[1:])), Lines("marked spoke", (spokes[0],)))
        yield Attached(frame=axes_turned(shaft, angle_at), shapes=shapes)
        rim = Lines("rim", (arc_points(shaft, 0.0, math.tau, WHEEL_RADIUS * s, 72),))
        yield fixed([Circle("hub", *shaft, _HUB_RADIUS * s), rim])

    def _spoke(self, angle: float) -> tuple[Vec2, Vec2]:
        """Return the ends of a spoke at an angle (rad) from the shaft."""
        direction = (math.cos(angle), math.sin(angle))
        start = _HUB_RADIUS * self.scale
        end = (WHEEL_RADIUS - _RIM_WIDTH) * self.scale
        return (start * direction[0], start * direction[1]), (end * direction[0], end * direction[1])


# In strokes of the picture.
_GAP = 0.07
_LEFT = -0.12
_RIGHT = 1.26
_CASTING_HEIGHT = BORE_HEIGHT + 2 * WALL


def expansion_gas(gases: Mapping[str, CylinderGas], opening: float, cut_off: float) -> CylinderGas:
    """Return the gas behind the expansion piston at an opening of the throttle and a cut-off, without what moves it."""
    pressure = gases[EXPANSION].pressure + (opening * gases[THROTTLE].pressure if THROTTLE in gases else 0.0)
    return replace(gases[EXPANSION], pressure=pressure, switch_travel=cut_off, cut_off=None)


class FlywheelEngineDrawing(MachineDrawing):
    """Drawing of an engine with a flywheel. Lengths in m."""

    panel_readings = ("shaft_speed", "gas_torque", "stored_work")
    stroke = Dimension("stroke")
    pump_stroke = Dimension("pump_stroke")
    connecting_rod = Dimension("connecting_rod")
    pump_connecting_rod = Dimension("pump_connecting_rod")
    clearance = Dimension("clearance")
    pump_clearance = Dimension("pump_clearance")
    back_pressure = Dimension("back_pressure")

    @cached_property
    def _gases(self) -> dict[str, CylinderGas]:
        """Gas on the faces of the pistons by name."""
        elements = self.part.mechanism.force_elements
        return {element.name: element for element in elements if isinstance(element, CylinderGas)}

    @cached_property
    def _controls(self) -> FloatArray:
        """Opening of the throttle, 1 without one, and cut-off at the reported times; shape (n, 2). Only for gas in cylinders."""
        readings = self.select_entries(self.run.readings)
        cut_offs = readings["cut_off"]
        return np.column_stack([readings.get("throttle_opening", np.ones_like(cut_offs)), cut_offs])

    def _expansion_gas(self, k: int) -> CylinderGas:
        """Return the gas behind the expansion piston at the reported time k."""
        opening, cut_off = self._controls[k].tolist()
        return expansion_gas(self._gases, opening, cut_off)

    @cached_property
    def _cylinders(self) -> tuple[CylinderView, ...]:
        """The expansion cylinder, and below it the pump if there is one; none where the torque of the gas is averaged."""
        if not self._gases:
            return ()
        widest_opening = int(np.argmax(self._controls[:, 0]))
        gases = self._gases | {"expansion": self._expansion_gas(widest_opening)}
        u, top = self.stroke, highest_pressure(gases.values())
        has_pump = "suction" in gases
        base = (DIAGRAM_HEIGHT + _GAP + _CASTING_HEIGHT + _GAP) * u if has_pump else 0.0
        expansion = CylinderView(
            name="engine",
            driving=gases["expansion"],
            resisting=None,
            back_pressure=self.back_pressure,
            clearance=self.clearance,
            stroke=u,
            base=base,
            diagram_base=base + (_CASTING_HEIGHT + _GAP) * u,
            highest_pressure=top,
            has_moving_diagram=bool(np.any(np.ptp(self._controls, axis=0) > 0.0)),
        )
        if not has_pump:
            return (expansion,)
        pump = CylinderView(
            name="pump",
            driving=gases["suction"],
            resisting=gases["delivery"],
            back_pressure=0.0,
            clearance=self.pump_clearance,
            stroke=u,
            base=(DIAGRAM_HEIGHT + _GAP) * u,
            diagram_base=0.0,
            highest_pressure=top,
        )
        return expansion, pump

    def expansion_cylinders(self, time: float) -> tuple[CylinderView, ...]:
        """Return the expansion cylinder with its gas at a time (s); none where the torque of the gas is averaged."""
        cylinders = self._cylinders[:1]
        if not any(one.has_moving_diagram for one in cylinders):
            return cylinders
        last_sample = int(np.searchsorted(self.run.times, time, side="right")) - 1
        return tuple(replace(one, driving=self._expansion_gas(last_sample)) for one in cylinders)

    @cached_property
    def _engine(self) -> EngineView:
        u, base = self.stroke, 0.0
        if self._cylinders:
            base = self._cylinders[0].diagram_base + (DIAGRAM_HEIGHT + _GAP) * u
        return EngineView(crank=0.5 * u, rod=self.connecting_rod, left=_LEFT * u, right=_RIGHT * u, base=base)

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield castings, guides and indicator diagrams."""
        yield fixed(self._engine.background_shapes())
        yield from (fixed(cylinder.background_shapes()) for cylinder in self._cylinders)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield wheel, crank, rods and pistons, the gas, and the points on its diagrams."""
        yield from self._engine.moving_parts(self._angle_at)
        rods = (self.connecting_rod, 0.5 * self.stroke), (self.pump_connecting_rod, 0.5 * self.pump_stroke)
        for number, (cylinder, (rod, crank)) in enumerate(zip(self._cylinders, rods, strict=False)):
            travel_at = partial(self._travel_at, crank / rod)
            yield Flexible(shapes_at=partial(self._cylinder_shapes, CylinderView.gas_shapes, number, travel_at))
            piston_axes = axes_shifted(partial(_piston_place, travel_at, cylinder.stroke))
            yield Attached(frame=piston_axes, shapes=(cylinder.piston(),))
            yield Flexible(shapes_at=partial(self._cylinder_shapes, CylinderView.mark_shapes, number, travel_at))

    def _angle_at(self, moment: Moment) -> float:
        """Return the crank angle at a moment (rad)."""
        return float(moment.pose[self.part.mechanism.body_index(FLYWHEEL), 2])

    def _travel_at(self, rod_ratio: float, moment: Moment) -> float:
        """Return the travel of a piston relative to its stroke at a moment."""
        return relative_travel(self._angle_at(moment), rod_ratio)

    def _cylinder_shapes(
        self,
        shapes_of_view: Callable[[CylinderView, float, bool], Iterator[DrawnShape]],
        number: int,
        travel_at: Callable[[Moment], float],
        moment: Moment,
    ) -> Iterator[DrawnShape]:
        """Return some shapes of a cylinder with its gas at a moment; the first one is the expansion cylinder."""
        cylinder = self.expansion_cylinders(moment.time)[0] if number == 0 else self._cylinders[number]
        is_return = bool(math.floor(self._angle_at(moment) / math.pi) % 2)
        return shapes_of_view(cylinder, travel_at(moment), is_return)


def _piston_place(travel_at: Callable[[Moment], float], stroke: float, moment: Moment) -> Vec2:
    """Return how far a piston is from the start of its stroke (m)."""
    return travel_at(moment) * stroke, 0.0


def relative_travel(crank_angle: float, rod_ratio: float) -> float:
    """Return the travel of a piston relative to its stroke; `rod_ratio` is that of crank and connecting rod."""
    across = rod_ratio * math.sin(crank_angle)
    shortening = 0.5 * across * math.sin(crank_angle) / (1 + math.sqrt(1 - across**2))
    return min(max(math.sin(0.5 * crank_angle) ** 2 - shortening, 0.0), 1.0)
