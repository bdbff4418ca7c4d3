"""Effects drawn on a Hartung governor: weight stops, dashpot, sleeve spring and friction shoes."""

from __future__ import annotations

import math

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_burst, make_hatched_block
from governor_mechanism.render.geometry.primitives import DrawnShape, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines.governor_parts import DashpotGeometry, spindle_shoe_shapes, spindle_spring_shapes
from governor_mechanism.render.machines.hartung.proportions import HARTUNG_SPINDLE_HALF_WIDTH, HartungProportions, HartungSide

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
    if governor.find_lift_effect(DryFriction):
        gap += _SHOE_HEIGHT * u
    if governor.find_lift_effect(OutputSpring):
        gap += 0.9 * u
    return lowest - governor.sleeve_size[1] - gap


def hartung_static_effect_shapes(governor: HartungProportions, heights: Vec2) -> list[DrawnShape]:
    """Return the shapes fixed to the frame: weight stops, dashpot cylinder and spring seat."""
    u, shapes = governor.arm, _weight_stop_shapes(governor)
    if governor.find_lift_effect(Dashpot):
        shapes += _dashpot_geometry(governor, heights).cylinder_shapes()
    if governor.find_lift_effect(OutputSpring):
        y = spindle_collar_height(governor, heights[0])
        shapes.append(make_rectangle("seat", -0.45 * u, 0.45 * u, y - 0.04 * u, y))
    return shapes


def hartung_moving_effect_shapes(governor: HartungProportions, height: float, time: float) -> list[DrawnShape]:
    """Return the shapes that move with the sleeve, with its lugs at a height (m), at a time (s)."""
    u, base = governor.arm, height - governor.sleeve_size[1]
    low, high = governor.lug_height_range
    dashpot = _dashpot_geometry(governor, (low, high))
    shapes = dashpot.piston_shapes(height - low, height) if governor.find_lift_effect(Dashpot) else []
    if governor.find_lift_effect(OutputSpring):
        shapes += spindle_spring_shapes(spindle_collar_height(governor, low), base, 0.36 * u, HARTUNG_SPINDLE_HALF_WIDTH * u)
    radii = HARTUNG_SPINDLE_HALF_WIDTH * u, (HARTUNG_SPINDLE_HALF_WIDTH + 0.2) * u
    return [*shapes, *spindle_shoe_shapes(governor, time, radii, base, _SHOE_HEIGHT * u)]


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


def _dashpot_geometry(governor: HartungProportions, heights: Vec2) -> DashpotGeometry:
    """Return the dashpot for the lowest and highest lug height (m), long enough for the whole stroke of its piston."""
    u, (low, high), width = governor.arm, heights, governor.sleeve_size[0]
    x, top = -(width + _DASHPOT_OFFSET * u), low - 0.45 * u
    bottom = top - max(high - low + 0.45 * u, 0.7 * u)
    return DashpotGeometry(
        box=(x - _DASHPOT_HALF_WIDTH * u, x + _DASHPOT_HALF_WIDTH * u, bottom, top),
        wall_thickness=0.05 * u,
        gap=0.1 * u,
        piston_clearance=0.06 * u,
        lowest_piston=0.14 * u,
        piston_thickness=0.1 * u,
        rod_half_width=0.04 * u,
        bracket_end=-0.9 * width,
        bracket_width=0.1 * u,
    )
