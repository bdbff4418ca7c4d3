"""Effects drawn on a pendulum governor: stops, springs, dashpots and friction shoes.

Only effects of the scene are drawn. Effects on the ball radius are shown on the arms.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_band
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2, make_rectangle
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.generic.force_elements import spiral_points
from governor_mechanism.render.machines.pendulum import stops as stop_drawing
from governor_mechanism.render.machines.pendulum.proportions import PendulumProportions, PendulumSide
from governor_mechanism.types import FloatArray

_SHOE_WIDTH = 0.060
"""Width of the friction shoes under the sleeve, as a fraction of the arm."""
_CYLINDER = parts.CylinderSizes(half_width=0.075, axis_distance=0.16, extra_length=0.20, min_length=0.26, wall=0.016, gap=0.035)
_PISTON = parts.PistonSizes(clearance=0.022, lowest=0.05, thickness=0.035, rod_half_width=0.013, bracket_width=0.036)


def spindle_foot_distance(governor: PendulumProportions, heights: Vec2) -> float:
    """Return the distance (m) from the low end of the sleeve to the spindle foot, for the lowest and highest lug height (m)."""
    u, shoe_height = governor.arm, stop_drawing.sleeve_depth(governor) - governor.sleeve_size[1]
    distance, collar = 0.10 * u + shoe_height, (stop_drawing.COLLAR_HEIGHT + 0.05) * u
    stops = governor.find_lift_effect(Stops)
    if stops and math.isfinite(stops.low):
        distance = max(distance, heights[0] - (governor.zero_lift_height + stops.low) + shoe_height + collar)
    if governor.spring_side < 0:
        distance = max(distance + 0.12 * u, shoe_height + max(0.30 * u, 0.5 * (heights[1] - heights[0])))
    return distance


def static_effect_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield the shapes fixed to the frame: stops of arms and sleeve, the disc that supports the sleeve spring, dashpot cylinder."""
    yield from stop_drawing.arm_stop_shapes(governor)
    yield from stop_drawing.sleeve_stop_shapes(governor)
    if governor.spring_side:
        y, half_width = _spring_seat(governor)
        low, high = sorted((y, y + governor.spring_side * 0.03 * governor.arm))
        yield make_rectangle("seat", -half_width - 0.02 * governor.arm, half_width + 0.02 * governor.arm, low, high)
    if governor.find_lift_effect(Dashpot):
        yield from _dashpot(governor).cylinder_shapes()


def sleeve_effect_shapes(governor: PendulumProportions, height: float, time: float) -> Iterator[DrawnShape]:
    """Yield the effects on the sleeve, behind the governor, with its lugs at a height (m), at a time (s)."""
    u, w, base = governor.arm, governor.spindle_ratio * governor.arm, height - governor.sleeve_size[1]
    if governor.find_lift_effect(Dashpot):
        yield from _dashpot(governor).piston_shapes(height - governor.lug_height_range[0], base + 0.035 * u)
    if governor.spring_side:
        seat, half_width = _spring_seat(governor)
        low, high = sorted((seat, height + stop_drawing.sleeve_contact_above_lugs(governor)[0] if governor.spring_side > 0 else base))
        yield Lines("spring", parts.helical_spring_lines((0.0, low), (0.0, high), half_width, w))
    yield from parts.spindle_shoe_shapes(governor, time, base, (_SHOE_WIDTH, stop_drawing.SHOE_HEIGHT))


def arm_effect_shapes(governor: PendulumProportions, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
    """Yield the effects on the arms, in front of the governor, at a pose (bodies, 3) and a time (s), and the impacts."""
    find_effect_on, sides = governor.effect_state.find_effect_on, governor.sides(pose)
    if find_effect_on(OutputSpring, "ball_radius"):
        yield _ball_spring(governor, sides)
    if find_effect_on(OutputSpring, "arm_angle"):
        yield from _spiral_springs(governor, float(governor.arm_angles(pose)))
    if find_effect_on(Dashpot, *stop_drawing.ARM_READINGS):
        yield from _rotary_dashpot_shapes(governor, sides)
    if friction := find_effect_on(DryFriction, *stop_drawing.ARM_READINGS):
        yield from _arm_shoe_shapes(governor, friction, time)
    yield from stop_drawing.arm_impact_shapes(governor, time)
    yield from stop_drawing.sleeve_impact_shapes(governor, time)


def _spring_seat(governor: PendulumProportions) -> Vec2:
    """Return the height of the fixed end of the sleeve spring (m), and the half width of its coils (m)."""
    u, (low, high) = governor.arm, governor.lug_height_range
    if governor.spring_side < 0:
        return low - governor.sleeve_size[1] - spindle_foot_distance(governor, (low, high)), 0.105 * u
    contact_height, half_width = stop_drawing.sleeve_contact_above_lugs(governor)
    seat_height = high + contact_height + max(0.24 * u, 0.4 * (high - low))
    if high_collar := stop_drawing.collar_boxes(governor).get(True):
        seat_height = max(seat_height, high_collar[3] + 0.05 * u)
    return max(min(seat_height, -0.085 * u), high + contact_height + 0.04 * u), min(half_width, 0.085 * u)


def _dashpot(governor: PendulumProportions) -> parts.DashpotDrawing:
    u, (low, high), (width, depth) = governor.arm, governor.lug_height_range, governor.sleeve_size
    top, stroke = low - depth - 0.06 * u, high - low
    return parts.DashpotDrawing(cylinder=_CYLINDER, piston=_PISTON, arm=u, sleeve_half_width=width, top=top, stroke=stroke)


def _arm_shoe_shapes(governor: PendulumProportions, friction: DryFriction, time: float) -> list[DrawnShape]:
    """Return a friction shoe over the pin of each arm."""
    u, angles = governor.arm, [math.radians(30 + 120 * k / 10) for k in range(11)]
    arcs = ([(x + 0.075 * u * math.cos(a), 0.075 * u * math.sin(a)) for a in angles] for x in (-governor.offset, governor.offset))
    return parts.friction_shoe_shapes(governor.effect_state, friction.reading, time, [make_band("shoe", arc, 0.040 * u) for arc in arcs])


def _rotary_dashpot_shapes(governor: PendulumProportions, sides: list[PendulumSide]) -> Iterator[DrawnShape]:
    """Yield a small rotary dashpot on the pin of each arm, its vane along the arm."""
    u = governor.arm
    for side in sides:
        dx, dy = ((side.ball[k] - side.arm_pivot[k]) / u * 0.055 * u for k in (0, 1))
        x, y = side.arm_pivot
        yield Circle("drum", x, y, 0.055 * u)
        yield Lines("damper", (((x - dy, y + dx), (x + dy, y - dx)),))
        yield Circle("pivot", x, y, 0.016 * u)


def _spiral_springs(governor: PendulumProportions, angle: float) -> list[DrawnShape]:
    """Return a spiral spring around the pin of each arm, wound by the arm."""
    points = spiral_points((governor.offset, 0.0), 2.2, angle, governor.arm)
    return [Lines("spring", (tuple((sign * x, y) for x, y in points),)) for sign in (-1.0, 1.0)]


def _ball_spring(governor: PendulumProportions, sides: list[PendulumSide]) -> Lines:
    """Return a spring from ball to ball."""
    (left, y), (right, _) = (side.ball for side in sides)
    ends = (left + governor.ball_radius, y), (right - governor.ball_radius, y)
    return Lines("spring", parts.helical_spring_lines(*ends, 0.06 * governor.arm, 0.0))
