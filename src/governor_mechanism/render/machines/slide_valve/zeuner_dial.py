"""Zeuner's diagram on the crank circle: it moves with the film, below the piston whose stroke it measures."""

import math
from collections.abc import Iterator

import numpy as np

from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, TextShape, Vec2
from governor_mechanism.render.machines.governor_parts import visible_pieces
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearPosition, ValveGearProportions
from governor_mechanism.types import FloatArray

_ECCENTRIC_RATIO = 0.80
"""Radius of the eccentric in the diagram, as a fraction of the crank circle."""

_MAX_CURVE_POINTS = 240
"""Largest number of points of the simulated curves."""


def _displacement_scale(valve_gear: ValveGearProportions) -> float:
    """Return metres of the picture per metre of displacement."""
    return _ECCENTRIC_RATIO * valve_gear.crank / valve_gear.eccentric


def _polar_point(angle: float, length: float) -> Vec2:
    return length * math.cos(angle), length * math.sin(angle)


def _circle_polyline(radius: float, centre: Vec2 = (0.0, 0.0)) -> tuple[Vec2, ...]:
    return arc_points(centre, 0.0, math.tau, radius, 72)


def dial_background_shapes(valve_gear: ValveGearProportions, angles: FloatArray, displacements: FloatArray) -> Iterator[DrawnShape]:
    """Yield the divided circle, the theoretical valve and lap circles, and the curves (n,) of the run."""
    u, scale = valve_gear.crank, _displacement_scale(valve_gear)
    line_of_centres_angle = math.pi / 2 - valve_gear.advance
    line_of_centres = (_polar_point(line_of_centres_angle, 0.95 * u), _polar_point(line_of_centres_angle + math.pi, 0.95 * u))
    yield Lines("axis", (((-1.12 * u, 0.0), (1.12 * u, 0.0)), ((0.0, -1.06 * u), (0.0, 1.06 * u)), line_of_centres))
    yield Lines("rim", (_circle_polyline(u),))
    division = ((math.radians(k), 1.06 if k % 30 == 0 else 1.03) for k in range(0, 360, 10))
    yield Lines("division", tuple((_polar_point(angle, u), _polar_point(angle, end * u)) for angle, end in division))
    for lap in (valve_gear.outside_lap, valve_gear.inside_lap):
        yield Lines("lap circle", (_circle_polyline(abs(lap) * scale),))
    half = 0.5 * valve_gear.eccentric * scale
    x, y = half * math.sin(valve_gear.advance), half * math.cos(valve_gear.advance)
    for side in (1.0, -1.0):
        yield Lines("valve circle", (_circle_polyline(half, (side * x, side * y)),))
    yield TextShape("scale", 1.09 * u, 0.09 * u, "0°", 0.2 * u)
    yield TextShape("scale", -1.28 * u, 0.09 * u, "180°", 0.2 * u)
    for end, side in _CYLINDER_ENDS:
        yield Lines(f"{end} curve", _displacement_curve(angles, side * displacements * scale))


_CYLINDER_ENDS = (("crank end", 1.0), ("head end", -1.0))


def _displacement_curve(angles: FloatArray, lengths: FloatArray) -> tuple[tuple[Vec2, ...], ...]:
    """Return the segments of the first turn with a positive displacement."""
    rows = np.flatnonzero(angles <= angles[0] + math.tau * (1 + 1e-9))
    rows = rows[:: max(1, len(rows) // _MAX_CURVE_POINTS)]
    points = [_polar_point(float(angles[k]), float(lengths[k])) for k in rows]
    return visible_pieces(points, [bool(lengths[k] > 0) for k in rows])


def dial_moving_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition, height: float) -> Iterator[DrawnShape]:
    """Yield the crank with the displacement on its ray, and its projection on the piston at a height (m)."""
    u = valve_gear.crank
    length = position.valve_displacement * _displacement_scale(valve_gear)
    pin = _polar_point(position.crank_angle, u)
    stroke_line = ((position.piston_position, 0.0), (position.piston_position, height))
    yield Lines("projection", (_piston_projection(valve_gear, position, pin), stroke_line))
    yield make_bar("arm", (0.0, 0.0), pin, 0.075 * u)
    tips = {end: (_polar_point(position.crank_angle, max(side * length, 0.0)), side * length > 0) for end, side in _CYLINDER_ENDS}
    yield from (Lines(f"{end} chord", (((0.0, 0.0), tip),) if is_shown else ()) for end, (tip, is_shown) in tips.items())
    yield from (Circle(f"{end} mark", *tip, 0.045 * u if is_shown else 0.0) for end, (tip, is_shown) in tips.items())
    yield from (Circle("pivot", *point, 0.055 * u) for point in ((0.0, 0.0), pin))


def _piston_projection(valve_gear: ValveGearProportions, position: ValveGearPosition, pin: Vec2) -> tuple[Vec2, ...]:
    """Return the line from the crank pin to the piston position on the diameter: an arc about the crosshead, or a vertical line."""
    if math.isinf(valve_gear.connecting_rod):
        return pin, (position.piston_position, 0.0)
    rod = valve_gear.connecting_rod
    return arc_points((position.piston_position - rod, 0.0), 0.0, math.asin(pin[1] / rod), rod, 12)[::-1]
