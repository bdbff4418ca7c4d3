"""Zeuner's diagram on the crank circle: the displacement of the valve on the ray of the crank, within the lap circles."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_turned, fixed_axes
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, visible_pieces
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2, arc_points
from governor_mechanism.types import FloatArray, IntArray

STEAM_PHASES = ("live steam", "expanding steam", "spent steam", "pressed steam")


@dataclass(frozen=True, kw_only=True)
class ValveGearPosition:
    """Valve gear at a pose: crank angle (rad), valve displacement away from the shaft (m), piston position (m), sense of rotation.

    The crank angle counts from the dead centre of the crank end, and the dead centre of the head end lies at `head_end_angle`. The piston
    position along the stroke is -crank at the head end (left) to crank at the crank end (right).
    """

    crank_angle: float
    valve_displacement: float
    piston_position: float
    sense: float = 1.0
    head_end_angle: float = math.pi

    @property
    def is_outstroke(self) -> bool:
        """Whether the piston moves away from the crank end."""
        return (self.crank_angle % math.tau < self.head_end_angle) == (self.sense > 0)


class SteamDistribution(Protocol):
    """Crank radius, eccentricity or half the travel of the valve, and laps, m; laps have a sign.

    `outward_sign` is 1 if a displacement of the valve away from the shaft opens the steam port of the crank end, as with outside
    admission, and -1 if it opens that of the head end.
    """

    @property
    def crank(self) -> float:
        """Crank radius, m."""

    @property
    def eccentric(self) -> float:
        """Eccentricity, or half the travel of the valve, m."""

    @property
    def outside_lap(self) -> float:
        """Lap over the edges that admit steam, m; those of a valve with inside admission are its inner ones."""

    @property
    def inside_lap(self) -> float:
        """Lap over the edges of the exhaust, m."""

    @property
    def outward_sign(self) -> float:
        """Sign of the displacement that admits steam to the crank end."""


def steam_phase(distribution: SteamDistribution, position: ValveGearPosition, side: float) -> str:
    """Return the phase of the steam at one end; `side` is 1 at the crank end, -1 at the head end."""
    admission, expansion, exhaust, compression = STEAM_PHASES
    port_displacement = side * distribution.outward_sign * position.valve_displacement
    if port_displacement > distribution.outside_lap:
        return admission
    if -port_displacement > distribution.inside_lap:
        return exhaust
    return expansion if (side > 0) == position.is_outstroke else compression


def phase_parts(phase_at: Callable[[Any], str], outline: tuple[Vec2, ...]) -> Iterator[Attached]:
    """Yield a space that steam fills, in the colour of each phase, of which one is there; `phase_at` is that of a moment."""
    yield from (
        Attached(frame=fixed_axes, shapes=(Polygon(role, outline),), shown=partial(_is_phase, phase_at, role)) for role in STEAM_PHASES
    )


def _is_phase(phase_at: Callable[[Any], str], role: str, moment: Any) -> bool:
    return phase_at(moment) == role


def changing_space_parts(phase_at: Callable[[Any], str], outline_at: Callable[[Any], tuple[Vec2, ...]]) -> Iterator[Flexible]:
    """Yield a space whose outline changes, in the colour of each phase, of which one is there; `phase_at` is that of a moment."""
    yield from (Flexible(shapes_at=partial(_changing_space, phase_at, outline_at, role)) for role in STEAM_PHASES)


def _changing_space(
    phase_at: Callable[[Any], str], outline_at: Callable[[Any], tuple[Vec2, ...]], role: str, moment: Any
) -> list[DrawnShape]:
    return [Polygon(role, outline_at(moment) if phase_at(moment) == role else ())]


def sense_of_rotation(times: FloatArray, angles: FloatArray, time: float) -> float:
    """Return 1 if the angle of a crank at times (n,) s grows just before a time (s), -1 if it falls."""
    k = min(int(np.searchsorted(times, time)), len(angles) - 1)
    return -1.0 if angles[k] < angles[max(k - 1, 0)] else 1.0


PHASE_NAMES = dict(zip(STEAM_PHASES, ("live steam", "expansion", "exhaust", "compression"), strict=True))
"""Name of each phase: what the steam at one end of the cylinder does."""

# In crank radii.
_ROW_PITCH = 0.16
_WORD_PLACE = 0.26
_WORD_WIDTH = 0.80
_NOTE_WIDTH = 1.35
_SQUARE_WIDTH, _SQUARE_HEIGHT = 0.18, 0.10


def key_shapes(corner: Vec2, unit: float) -> Iterator[DrawnShape]:
    """Yield what the colours of the steam mean, from an upper left corner (m), of a size that suits a crank radius in the picture (m)."""
    left, half = corner[0], 0.5 * _SQUARE_HEIGHT * unit
    for row, (phase, name) in enumerate(PHASE_NAMES.items()):
        y = _row_height(corner, unit, row)
        yield make_rectangle(f"{phase} key", left, left + _SQUARE_WIDTH * unit, y - half, y + half)
        yield TextShape("scale", left + _WORD_PLACE * unit, y, name, _WORD_WIDTH * unit)


def scale_note_shapes(corner: Vec2, unit: float, scales: Mapping[str, float]) -> Iterator[DrawnShape]:
    """Yield how much larger or smaller views are than the first one, to which the scale bar belongs, as large as a key."""
    base, *others = scales
    lines = [f"bar: {base}"]
    for name in others:
        ratio = scales[name] / scales[base]
        lines.append(f"{name}: {ratio:.2g} × larger" if ratio >= 1.0 else f"{name}: {1.0 / ratio:.2g} × smaller")
    for row, words in enumerate(lines):
        yield TextShape("scale", corner[0], _row_height(corner, unit, row), words, _NOTE_WIDTH * unit)


def _row_height(corner: Vec2, unit: float, number: int) -> float:
    return corner[1] - (number + 0.5) * _ROW_PITCH * unit


_ECCENTRIC_RATIO = 0.80
"""Radius of the eccentric in the diagram, as a fraction of the crank circle."""
_MAX_CURVE_POINTS = 180
"""Largest number of points of the curves of a turn: two degrees apart."""
_ZERO_WIDTH, _LEFT_ZERO_WIDTH = 0.2, 0.42
"""Width of the word at the zero, as a fraction of the crank circle: on the right, and on the left, where it ends at the circle."""
_CYLINDER_ENDS = (("crank end", 1.0), ("head end", -1.0))


class ZeunerDial:
    """Diagram of a valve gear around a centre (m), with a crank circle of a radius (m).

    `start` is the direction of the crank at the dead centre of the crank end, rad.
    """

    def __init__(self, valve_gear: SteamDistribution, centre: Vec2, radius: float, start: float = 0.0) -> None:
        self._gear = valve_gear
        self._centre = centre
        self._radius = radius
        self._start = start
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
        is_right = math.cos(self._start) > -0.5
        width = (_ZERO_WIDTH if is_right else _LEFT_ZERO_WIDTH) * radius
        yield TextShape("scale", x + 1.10 * radius if is_right else x - 1.10 * radius - width, y + 0.10 * radius, "0°", width)

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
