"""Zeuner's diagram on the crank circle: the displacement of the valve on the ray of the crank, within the lap circles."""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_turned
from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, TextShape, Vec2
from governor_mechanism.render.machines.governor_parts import visible_pieces
from governor_mechanism.render.machines.slide_valve.steam_distribution import SteamDistribution, ValveGearPosition
from governor_mechanism.types import FloatArray, IntArray

_ECCENTRIC_RATIO = 0.80
"""Radius of the eccentric in the diagram, as a fraction of the crank circle."""
_MAX_CURVE_POINTS = 180
"""Largest number of points of the curves of a turn: two degrees apart."""
_ZERO_WIDTH = 0.2
"""Width of the word at the zero, as a fraction of the crank circle."""
_CYLINDER_ENDS = (("crank end", 1.0), ("head end", -1.0))


class ZeunerDial:
    """Diagram of a valve gear around a centre (m), with a crank circle of a radius (m).

    `start` is the direction of the crank at the dead centre of the crank end, rad.
    """

    def __init__(self, valve_gear: SteamDistribution, centre: Vec2, radius: float, start: float = 0.0) -> None:
        self._gear, self._centre, self._radius, self._start = valve_gear, centre, radius, start
        self.scale = _ECCENTRIC_RATIO * radius / valve_gear.eccentric
        """Metres of the picture per metre of displacement."""

    def _place(self, angle: float, length: float) -> Vec2:
        """Return the place (m) at an angle of the crank (rad) and a distance (m) from the centre."""
        direction = self._start + angle
        return self._centre[0] + length * math.cos(direction), self._centre[1] + length * math.sin(direction)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the divided circle and the lap circles."""
        (x, y), radius = self._centre, self._radius
        yield Lines("axis", (((x - 1.08 * radius, y), (x + 1.08 * radius, y)), ((x, y - 1.06 * radius), (x, y + 1.06 * radius))))
        yield Lines("rim", (self._circle(radius),))
        division = ((math.radians(k), 1.06 if k % 30 == 0 else 1.03) for k in range(0, 360, 10))
        yield Lines("division", tuple((self._place(angle, radius), self._place(angle, end * radius)) for angle, end in division))
        for lap in (self._gear.outside_lap, self._gear.inside_lap):
            yield Lines("lap circle", (self._circle(abs(lap) * self.scale),))
        zero_x = x + (1.10 if math.cos(self._start) > -0.5 else -1.10 - _ZERO_WIDTH) * radius
        yield TextShape("scale", zero_x, y + 0.10 * radius, "0°", _ZERO_WIDTH * radius)

    def theory_shapes(self, advance: float) -> Iterator[DrawnShape]:
        """Yield the line of centres and the valve circles of an endless eccentric rod, for an angle of advance (rad)."""
        half = 0.5 * self._gear.eccentric * self.scale
        angles = (math.pi / 2 - advance, 1.5 * math.pi - advance)
        yield Lines("axis", (tuple(self._place(angle, 0.95 * self._radius) for angle in angles),))
        yield from (Lines("valve circle", (self._circle(half, self._place(angle, half)),)) for angle in angles)

    def curve_shapes(self, angles: FloatArray, displacements: FloatArray) -> Iterator[DrawnShape]:
        """Yield the positive displacements (n,) m at crank angles (n,) rad, for each end of the cylinder."""
        for end, side in _CYLINDER_ENDS:
            lengths = side * self._gear.outward_sign * displacements * self.scale
            points = [self._place(angle, length) for angle, length in zip(angles.tolist(), lengths.tolist(), strict=True)]
            yield Lines(f"{end} curve", visible_pieces(points, (lengths > 0).tolist()))

    def crank_parts(self, position_at: Callable[[Moment], ValveGearPosition]) -> Iterator[DrawnPart]:
        """Yield the crank with the displacement on its ray."""
        radius = self._radius
        crank_axes = axes_turned(self._centre, lambda moment: self._start + position_at(moment).crank_angle)
        yield Attached(frame=crank_axes, shapes=(make_bar("arm", (0.0, 0.0), (radius, 0.0), 0.075 * radius),))
        for end, side in _CYLINDER_ENDS:
            yield Flexible(shapes_at=partial(self._chord_shapes, end, side, position_at))
        yield Attached(frame=crank_axes, shapes=tuple(Circle("pivot", x, 0.0, 0.06 * radius) for x in (0.0, radius)))

    def _chord_shapes(self, end: str, side: float, position_at: Callable[[Moment], ValveGearPosition], moment: Moment) -> list[DrawnShape]:
        """Return the displacement that opens the port of an end on the ray of the crank, and a mark at its tip."""
        position = position_at(moment)
        length = side * self._gear.outward_sign * position.valve_displacement * self.scale
        tip = self._place(position.crank_angle, max(length, 0.0))
        chord = Lines(f"{end} chord", ((self._centre, tip),) if length > 0 else ())
        return [chord, Circle(f"{end} mark", *tip, 0.05 * self._radius if length > 0 else 0.0)]

    def _circle(self, radius: float, centre: Vec2 | None = None) -> tuple[Vec2, ...]:
        return arc_points(self._centre if centre is None else centre, 0.0, math.tau, radius, 72)


def turn_before(angles: FloatArray, displacements: FloatArray, crank_angle: float) -> tuple[FloatArray, FloatArray]:
    """Return angles and displacements (n,) of a run during the last turn before a crank angle (rad)."""
    rows = _thin_out(np.flatnonzero((angles <= crank_angle) & (angles >= crank_angle - math.tau)))
    return angles[rows], displacements[rows]


def first_turn(angles: FloatArray, displacements: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return angles and displacements (n,) of a run during its first turn."""
    rows = _thin_out(np.flatnonzero(angles <= angles[0] + math.tau * (1 + 1e-9)))
    return angles[rows], displacements[rows]


def _thin_out(rows: IntArray) -> IntArray:
    """Return rows of a turn, evenly thinned out to about the largest number of points of a curve."""
    return rows[:: max(1, len(rows) // _MAX_CURVE_POINTS)]
