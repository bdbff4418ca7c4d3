"""Zeuner's diagram of the last turn of the crank: displacement of the valve on the crank's ray, within the lap circles."""

import math
from collections.abc import Iterator

import numpy as np

from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, TextShape, Vec2
from governor_mechanism.render.machines.governor_parts import visible_pieces
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearPosition, ValveGearProportions
from governor_mechanism.types import FloatArray

_TRAVEL_RATIO = 0.74
"""Radius of the eccentricity in the diagram, as a fraction of the divided circle."""

_CYLINDER_ENDS = (("crank end", 1.0), ("head end", -1.0))

_MAX_CURVE_POINTS = 90
"""Largest number of points of the curve of a turn."""


def last_turn(angles: FloatArray, displacements: FloatArray, crank_angle: float) -> FloatArray:
    """Return angles and displacements (n, 2) of a run during the last turn before a crank angle (rad)."""
    rows = np.flatnonzero((angles <= crank_angle) & (angles >= crank_angle - math.tau))
    rows = rows[:: max(1, len(rows) // _MAX_CURVE_POINTS)]
    return np.column_stack([angles[rows], displacements[rows]])


def _place(centre: Vec2, angle: float, length: float) -> Vec2:
    return centre[0] + length * math.cos(angle), centre[1] + length * math.sin(angle)


def _scale(valve_gear: ValveGearProportions, radius: float) -> float:
    """Return metres of the picture per metre of displacement."""
    return _TRAVEL_RATIO * radius / valve_gear.eccentric


def dial_background_shapes(valve_gear: ValveGearProportions, centre: Vec2, radius: float) -> Iterator[DrawnShape]:
    """Yield the divided circle and the lap circles around a centre, with a radius (m)."""
    x, y = centre
    yield Lines("axis", (((x - 1.08 * radius, y), (x + 1.08 * radius, y)), ((x, y - 1.06 * radius), (x, y + 1.06 * radius))))
    yield Lines("rim", (arc_points(centre, 0.0, math.tau, radius, 72),))
    division = ((math.radians(k), 1.06 if k % 30 == 0 else 1.03) for k in range(0, 360, 10))
    yield Lines("division", tuple((_place(centre, angle, radius), _place(centre, angle, end * radius)) for angle, end in division))
    for lap in (valve_gear.outside_lap, valve_gear.inside_lap):
        yield Lines("lap circle", (arc_points(centre, 0.0, math.tau, abs(lap) * _scale(valve_gear, radius), 48),))
    yield TextShape("scale", x + 1.10 * radius, y + 0.10 * radius, "0°", 0.2 * radius)


def dial_moving_shapes(
    valve_gear: ValveGearProportions, centre: Vec2, radius: float, position: ValveGearPosition, turn: FloatArray
) -> Iterator[DrawnShape]:
    """Yield the curves of the last turn (n, 2), the crank, and the displacement on its ray."""
    scale = _scale(valve_gear, radius)
    for end, side in _CYLINDER_ENDS:
        points = [_place(centre, angle, side * length * scale) for angle, length in turn.tolist()]
        yield Lines(f"{end} curve", visible_pieces(points, (side * turn[:, 1] > 0).tolist()))
    pin = _place(centre, position.crank_angle, radius)
    yield make_bar("arm", centre, pin, 0.07 * radius)
    for end, side in _CYLINDER_ENDS:
        length = side * position.valve_displacement * scale
        tip = _place(centre, position.crank_angle, max(length, 0.0))
        yield Lines(f"{end} chord", ((centre, tip),) if length > 0 else ())
        yield Circle(f"{end} mark", *tip, 0.05 * radius if length > 0 else 0.0)
    yield from (Circle("pivot", *point, 0.06 * radius) for point in (centre, pin))
