"""A double-acting cylinder in section with the indicator diagram of its gas above or below it, at the scale of the stroke.

The shaft is at the left. The volume axis of the diagram is the travel of the piston, so that the indicator points stand over the piston.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

from governor_mechanism.effects.gas_pressure import pressure_in_stroke
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.render.geometry.outlines import make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, round_step

GAS_ROLES = ("live steam", "expanding steam", "spent steam")
"""Roles of gas above two thirds, one third and below one third of the highest pressure."""

# In strokes of the picture.
BORE_HEIGHT, WALL, PISTON_THICKNESS, MIN_CLEARANCE = 0.15, 0.03, 0.10, 0.02
DIAGRAM_HEIGHT = 0.36
_RIGHT_END = 1.30
"""Right edge of the picture."""
_N_CURVE_POINTS = 120
"""Points of a curve over a stroke."""

BAR = 1e5
"""Pascals in a bar."""


@dataclass(frozen=True, kw_only=True)
class CylinderView:
    """Picture of a cylinder.

    Attributes
    ----------
    name
        Name of the cylinder.
    driving, resisting
        Gas behind the piston in its stroke, and in front of it if that has elements of its own.
    back_pressure
        Pressure in front of the piston, Pa, if it is constant.
    clearance
        Clearance relative to the volume of the stroke.
    stroke
        Stroke of the picture, m.
    base
        Height of the lower edge of the casting, m.
    diagram_base
        Height of the pressure zero of the diagram, m.
    highest_pressure
        Pressure at the top of the diagram, Pa.
    has_moving_diagram
        Whether the loops of the diagram change from stroke to stroke.
    """

    name: str
    driving: CylinderGas
    resisting: CylinderGas | None
    back_pressure: float
    clearance: float
    stroke: float
    base: float
    diagram_base: float
    highest_pressure: float
    has_moving_diagram: bool = False

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
        u, loop = self.stroke, [(k / _N_CURVE_POINTS, False) for k in range(_N_CURVE_POINTS + 1)]
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
        reach, floor = 0.5 * PISTON_THICKNESS * self.stroke + self._drawn_clearance, self.base + WALL * self.stroke
        return -reach, self.stroke + reach, floor, floor + BORE_HEIGHT * self.stroke

    def gas_shapes(self, relative_travel: float, is_return: bool) -> Iterator[DrawnShape]:
        """Yield the loops of a diagram that changes, the gas, and the piston rod up to the piston."""
        u, (left, right, low, high) = self.stroke, self._bore
        if self.has_moving_diagram:
            yield from self._loops()
        x, half, rod = relative_travel * u, 0.5 * PISTON_THICKNESS * u, 0.016 * u
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
        x, faces = relative_travel * self.stroke, self._faces(relative_travel, is_return)
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
