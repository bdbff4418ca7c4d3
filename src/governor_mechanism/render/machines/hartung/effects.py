"""Effects drawn on a Hartung governor: weight stops, dashpot, sleeve spring and friction shoes."""

from __future__ import annotations

import math

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_burst, make_hatched_block, make_wall
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines.hartung.proportions import HARTUNG_SPINDLE_HALF_WIDTH, HartungProportions, HartungSide
from governor_mechanism.render.machines.pendulum.effects import helical_spring_lines

_LIFT_READING = "sleeve_lift"
_WEIGHT_READINGS = ("lever_angle", "weight_radius")
"""Readings that determine the position of the weights."""

_DASHPOT_HALF_WIDTH, _DASHPOT_OFFSET = 0.24, 0.50
"""Half width of the dashpot, and distance of its axis from the sleeve, as fractions of the weight arm."""
_STOP_HALF_HEIGHT = 0.16
"""Half height of the weight stops, as a fraction of the weight arm."""
_SHOE_HEIGHT = 0.20


def spindle_collar_height(governor: HartungProportions, lowest: float) -> float:
    """Return the height (m) of the lower spindle collar if the lowest height of the sleeve lugs is `lowest` (m)."""
    u, gap = governor.arm, 0.14 * governor.arm
    if governor.effect_state.find_effect_on(DryFriction, _LIFT_READING):
        gap += _SHOE_HEIGHT * u
    if governor.effect_state.find_effect_on(OutputSpring, _LIFT_READING):
        gap += 0.9 * u
    return lowest - governor.sleeve_size[1] - gap


def hartung_static_effect_shapes(governor: HartungProportions, heights: Vec2) -> list[DrawnShape]:
    """Return the shapes fixed to the frame: weight stops, dashpot cylinder and spring seat."""
    return [*_weight_stop_shapes(governor), *_dashpot_shapes(governor, heights), *_spring_seat_shapes(governor, heights[0])]


def hartung_moving_effect_shapes(governor: HartungProportions, height: float, time: float) -> list[DrawnShape]:
    """Return the shapes that move with the sleeve, with its lugs at a height (m), at a time (s)."""
    return [*_piston_shapes(governor, height), *_spring_shapes(governor, height), *_friction_shoe_shapes(governor, height, time)]


def hartung_impact_shapes(governor: HartungProportions, sides: list[HartungSide], time: float) -> list[DrawnShape]:
    """Return rays where a weight has just struck its stop."""
    stops = governor.effect_state.find_effect_on(Stops, *_WEIGHT_READINGS)
    if stops is None:
        return []
    last_impact = governor.effect_state.recent_impact(stops.reading, time)
    impact_points: list[Vec2] = []
    if last_impact is not None:
        is_inner_stop = last_impact.is_high_stop == (stops.reading == _WEIGHT_READINGS[0])  # the lever angle increases inward
        for side in sides:
            face_radius = abs(side.weight[0]) + (-governor.half_width if is_inner_stop else governor.half_width)
            impact_points.append((side.sign * face_radius, _stop_height(governor)))
    return [make_burst("burst", impact_points, 0.3 * governor.arm)]


def _stop_height(governor: HartungProportions) -> float:
    """Return the height (m) at which the weights meet their stops."""
    return 0.5 * (governor.bore_half_height + governor.half_height)


def _stop_radii(governor: HartungProportions) -> tuple[float, float] | None:
    """Return the radii (m) of the weight centres at the inner and outer stop; NaN where there is no stop."""
    stops = governor.effect_state.find_effect_on(Stops, *_WEIGHT_READINGS)
    if stops is None:
        return None
    if stops.reading == _WEIGHT_READINGS[1]:
        inner, outer = stops.low, stops.high
    else:
        inner, outer = (
            governor.weight_radius(lever_angle) if math.isfinite(lever_angle) else math.nan for lever_angle in (stops.high, stops.low)
        )
    return (inner if math.isfinite(inner) else math.nan), (outer if math.isfinite(outer) else math.nan)


def _weight_stop_shapes(governor: HartungProportions) -> list[DrawnShape]:
    """Return the blocks that stop the weights: inside on the hub, outside on brackets from the spring seats."""
    radii = _stop_radii(governor)
    if radii is None:
        return []
    u, y, shapes = governor.arm, _stop_height(governor), list[DrawnShape]()
    half_height = min(_STOP_HALF_HEIGHT * u, 0.8 * (governor.half_height - governor.bore_half_height) / 2)
    inner, outer = radii[0] - governor.half_width, radii[1] + governor.half_width
    if math.isfinite(inner):
        hub_face = max(inner - 0.16 * u, -0.2 * u) if inner > 0.05 * u else inner - 0.1 * u
        shapes.append(make_rectangle("bracket", -max(hub_face, 0.0), max(hub_face, 0.0), y - 0.5 * half_height, y + 0.5 * half_height))
        for sign in (-1.0, 1.0):
            left, right = sorted((sign * max(hub_face, 0.02 * u), sign * inner))
            shapes += make_hatched_block("stop", (0.0, 0.0, 0.0), (left, right, y - half_height, y + half_height), 0.07 * u)
    if math.isfinite(outer):
        plate = governor.spring_seat_radius + 0.03 * u
        for sign in (-1.0, 1.0):
            left, right = sorted((sign * outer, sign * (outer + 0.13 * u)))
            shapes.append(make_bar("bracket", (sign * plate, 0.9 * governor.bore_half_height), (sign * plate, y), 0.07 * u))
            shapes.append(make_bar("bracket", (sign * outer + sign * 0.1 * u, y), (sign * plate, y), 0.07 * u))
            shapes += make_hatched_block("stop", (0.0, 0.0, 0.0), (left, right, y - half_height, y + half_height), 0.07 * u)
    return shapes


def _dashpot_box(governor: HartungProportions, heights: Vec2) -> tuple[float, float, float, float]:
    """Return left, right, bottom and top of the dashpot (m), long enough for the whole stroke of its piston."""
    u, (low, high) = governor.arm, heights
    x = -(governor.sleeve_size[0] + _DASHPOT_OFFSET * u)
    top = low - 0.45 * u
    return x - _DASHPOT_HALF_WIDTH * u, x + _DASHPOT_HALF_WIDTH * u, top - max(high - low + 0.45 * u, 0.7 * u), top


def _lug_height_range(governor: HartungProportions) -> Vec2:
    """Return the lowest and highest lug height of the run (m)."""
    low, high = governor.effect_state.reading_ranges.get(_LIFT_READING, (0.0, 0.0))
    return governor.zero_lift_height + low, governor.zero_lift_height + high


def _dashpot_shapes(governor: HartungProportions, heights: Vec2) -> list[DrawnShape]:
    """Return an open cylinder filled with oil on a hatched base, next to the sleeve."""
    if not governor.effect_state.find_effect_on(Dashpot, _LIFT_READING):
        return []
    u, (left, right, bottom, top) = governor.arm, _dashpot_box(governor, heights)
    wall_thickness = 0.05 * u
    return [
        make_rectangle("dashpot", left, right, bottom, top),
        make_rectangle("bore", left + wall_thickness, right - wall_thickness, bottom + wall_thickness, top),
        make_rectangle("oil", left + wall_thickness, right - wall_thickness, bottom + wall_thickness, top - 0.1 * u),
        make_wall(((left + right) / 2, bottom), math.pi / 2, 1.35 * _DASHPOT_HALF_WIDTH * u, 0.1 * u),
    ]


def _piston_shapes(governor: HartungProportions, height: float) -> list[DrawnShape]:
    """Return the dashpot piston, its rod, and the bracket that connects it to the sleeve."""
    if not governor.effect_state.find_effect_on(Dashpot, _LIFT_READING):
        return []
    u, low = governor.arm, _lug_height_range(governor)[0]
    left, right, bottom, _ = _dashpot_box(governor, _lug_height_range(governor))
    x, clearance = (left + right) / 2, 0.06 * u
    piston = bottom + 0.14 * u + height - low
    return [
        make_rectangle("piston rod", x - 0.04 * u, x + 0.04 * u, piston, height),
        make_rectangle("piston", left + clearance, right - clearance, piston, piston + 0.1 * u),
        make_bar("piston rod", (x, height), (-0.9 * governor.sleeve_size[0], height), 0.1 * u),
    ]


def _spring_seat_shapes(governor: HartungProportions, lowest: float) -> list[DrawnShape]:
    """Return the disc on the spindle that supports the sleeve spring."""
    if not governor.effect_state.find_effect_on(OutputSpring, _LIFT_READING):
        return []
    u, y, half_width = governor.arm, spindle_collar_height(governor, lowest), 0.45 * governor.arm
    return [make_rectangle("seat", -half_width, half_width, y - 0.04 * u, y)]


def _spring_shapes(governor: HartungProportions, height: float) -> list[DrawnShape]:
    """Return a helical spring around the spindle, below the sleeve."""
    if not governor.effect_state.find_effect_on(OutputSpring, _LIFT_READING):
        return []
    start, end = spindle_collar_height(governor, _lug_height_range(governor)[0]), height - governor.sleeve_size[1]
    return [Lines("spring", helical_spring_lines((0.0, start), (0.0, end), 0.36 * governor.arm, HARTUNG_SPINDLE_HALF_WIDTH * governor.arm))]


def _friction_shoe_shapes(governor: HartungProportions, height: float, time: float) -> list[DrawnShape]:
    """Return the friction shoes under the sleeve, coloured by sliding or sticking."""
    if not governor.effect_state.find_effect_on(DryFriction, _LIFT_READING):
        return []
    u, base, is_sticking = (governor.arm, height - governor.sleeve_size[1], governor.effect_state.is_held(_LIFT_READING, time))
    inner, outer = HARTUNG_SPINDLE_HALF_WIDTH * u, (HARTUNG_SPINDLE_HALF_WIDTH + 0.2) * u
    shoes = [make_rectangle("shoe", x, x + outer - inner, base - _SHOE_HEIGHT * u, base) for x in (-outer, inner)]
    return [
        Polygon(role, shoe.points if is_shown else ())
        for role, is_shown in (("shoe", not is_sticking), ("held shoe", is_sticking))
        for shoe in shoes
    ]
