"""Effects drawn on a pendulum governor: stops, springs, dashpots and friction shoes.

Only effects of the scene are drawn. Effects on the ball radius are shown on the arms.
"""

from __future__ import annotations

import math

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.outlines import make_band
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2, make_rectangle
from governor_mechanism.render.machines.governor_parts import (
    DashpotGeometry,
    friction_shoe_shapes,
    helical_spring_lines,
    spindle_shoe_shapes,
    spindle_spring_shapes,
)
from governor_mechanism.render.machines.pendulum.proportions import (
    PENDULUM_SPINDLE_HALF_WIDTH,
    PendulumProportions,
    PendulumSide,
    pendulum_arm_angles,
    pendulum_sides,
    pendulum_sleeve_height,
)
from governor_mechanism.render.machines.pendulum.stops import (
    ARM_READINGS,
    COLLAR_HEIGHT,
    SHOE_HEIGHT,
    arm_stop_shapes,
    collar_boxes,
    is_spring_above_sleeve,
    pendulum_impact_shapes,
    sleeve_contact_above_lugs,
    sleeve_depth,
    sleeve_stop_shapes,
)
from governor_mechanism.types import FloatArray

_SHOE_WIDTH = 0.060
"""Width of the friction shoes under the sleeve, as a fraction of the arm."""
_DASHPOT_HALF_WIDTH, _DASHPOT_OFFSET = 0.075, 0.16
"""Half width of the dashpot, and distance of its axis from the sleeve, as fractions of the arm."""


def spindle_foot_distance(governor: PendulumProportions, heights: Vec2) -> float:
    """Return the distance (m) from the low end of the sleeve to the spindle foot, for the lowest and highest lug height (m)."""
    u, shoe_height = governor.arm, sleeve_depth(governor) - governor.sleeve_size[1]
    distance = 0.10 * u + shoe_height
    stops, spring = governor.find_lift_effect(Stops), governor.find_lift_effect(OutputSpring)
    if stops and math.isfinite(stops.low):
        distance = max(distance, heights[0] - (governor.zero_lift_height + stops.low) + shoe_height + (COLLAR_HEIGHT + 0.05) * u)
    if spring and not is_spring_above_sleeve(governor, spring):
        distance = max(distance + 0.12 * u, shoe_height + max(0.30 * u, 0.5 * (heights[1] - heights[0])))
    return distance


def pendulum_static_effect_shapes(governor: PendulumProportions) -> tuple[DrawnShape, ...]:
    """Return the shapes fixed to the frame: stops of arms and sleeve, spring seat, dashpot cylinder."""
    shapes = [*arm_stop_shapes(governor), *sleeve_stop_shapes(governor), *_spring_seat_shapes(governor)]
    return (*shapes, *(_dashpot_geometry(governor).cylinder_shapes() if governor.find_lift_effect(Dashpot) else ()))


def pendulum_moving_effect_shapes(
    governor: PendulumProportions, part: Part, pose: FloatArray, time: float
) -> tuple[tuple[DrawnShape, ...], tuple[DrawnShape, ...]]:
    """Return the effect shapes at a pose (bodies, 3) and a time (s): those behind the governor, those in front of it."""
    u, height = governor.arm, float(pendulum_sleeve_height(governor, part, pose))
    base = height - governor.sleeve_size[1]
    angle = float(pendulum_arm_angles(governor, part, pose))
    sides = pendulum_sides(governor, part, pose)
    piston = _dashpot_geometry(governor).piston_shapes(height - governor.lug_height_range[0], base + 0.035 * u)
    radii = PENDULUM_SPINDLE_HALF_WIDTH * u, (PENDULUM_SPINDLE_HALF_WIDTH + _SHOE_WIDTH) * u
    behind = (
        *(piston if governor.find_lift_effect(Dashpot) else ()),
        *_sleeve_spring_shapes(governor, height),
        *spindle_shoe_shapes(governor, time, radii, base, SHOE_HEIGHT * u),
    )
    front = (
        *_ball_spring_shapes(governor, sides),
        *_spiral_spring_shapes(governor, angle),
        *_rotary_dashpot_shapes(governor, sides),
        *_arm_shoe_shapes(governor, time),
        *pendulum_impact_shapes(governor, time),
    )
    return behind, front


def _spring_seat_geometry(governor: PendulumProportions) -> tuple[float, float] | None:
    """Return the height of the fixed end of the sleeve spring (m), and the half width of its coils (m)."""
    spring = governor.find_lift_effect(OutputSpring)
    if spring is None:
        return None
    u = governor.arm
    low, high = governor.lug_height_range
    if not is_spring_above_sleeve(governor, spring):
        return low - governor.sleeve_size[1] - spindle_foot_distance(governor, (low, high)), 0.105 * u
    contact_height, half_width = sleeve_contact_above_lugs(governor)
    seat_height = high + contact_height + max(0.24 * u, 0.4 * (high - low))
    seat_height = max([seat_height, *(top + 0.05 * u for is_low, (_, _, _, top) in collar_boxes(governor) if not is_low)])
    return max(min(seat_height, -0.085 * u), high + contact_height + 0.04 * u), min(half_width, 0.085 * u)


def _spring_seat_shapes(governor: PendulumProportions) -> list[DrawnShape]:
    """Return the disc on the spindle that supports the sleeve spring."""
    seat_geometry, u = _spring_seat_geometry(governor), governor.arm
    if seat_geometry is None:
        return []
    y, half_width = seat_geometry
    spring = governor.find_lift_effect(OutputSpring)
    thickness = 0.03 * u if spring and is_spring_above_sleeve(governor, spring) else -0.03 * u
    return [make_rectangle("seat", -half_width - 0.02 * u, half_width + 0.02 * u, min(y, y + thickness), max(y, y + thickness))]


def _sleeve_spring_shapes(governor: PendulumProportions, height: float) -> list[DrawnShape]:
    """Return a helical spring around the spindle, between its seat and the sleeve."""
    seat_geometry, spring = (_spring_seat_geometry(governor), governor.find_lift_effect(OutputSpring))
    if seat_geometry is None or spring is None:
        return []
    y, half_width = seat_geometry
    end = height + sleeve_contact_above_lugs(governor)[0] if is_spring_above_sleeve(governor, spring) else height - governor.sleeve_size[1]
    return spindle_spring_shapes(min(y, end), max(y, end), half_width, PENDULUM_SPINDLE_HALF_WIDTH * governor.arm)


def _dashpot_geometry(governor: PendulumProportions) -> DashpotGeometry:
    """Return the dashpot, long enough for the whole stroke of its piston."""
    u, (low, high), (width, depth) = governor.arm, governor.lug_height_range, governor.sleeve_size
    x, top = -(width + _DASHPOT_OFFSET * u), low - depth - 0.06 * u
    bottom = top - max(high - low + 0.20 * u, 0.26 * u)
    return DashpotGeometry(
        box=(x - _DASHPOT_HALF_WIDTH * u, x + _DASHPOT_HALF_WIDTH * u, bottom, top),
        wall_thickness=0.016 * u,
        gap=0.035 * u,
        piston_clearance=0.022 * u,
        lowest_piston=0.05 * u,
        piston_thickness=0.035 * u,
        rod_half_width=0.013 * u,
        bracket_end=-0.9 * width,
        bracket_width=0.036 * u,
    )


def _arm_shoe_shapes(governor: PendulumProportions, time: float) -> list[DrawnShape]:
    """Return a friction shoe over the pin of each arm."""
    friction = governor.effect_state.find_effect_on(DryFriction, *ARM_READINGS)
    if friction is None:
        return []
    u, angles = governor.arm, [math.radians(30 + 120 * k / 10) for k in range(11)]
    arcs = ([(x + 0.075 * u * math.cos(a), 0.075 * u * math.sin(a)) for a in angles] for x in (-governor.offset, governor.offset))
    return friction_shoe_shapes(governor.effect_state, friction.reading, time, [make_band("shoe", arc, 0.040 * u) for arc in arcs])


def _rotary_dashpot_shapes(governor: PendulumProportions, sides: list[PendulumSide]) -> list[DrawnShape]:
    """Return a small rotary dashpot on the pin of each arm, its vane along the arm."""
    if not governor.effect_state.find_effect_on(Dashpot, *ARM_READINGS):
        return []
    u, shapes = governor.arm, list[DrawnShape]()
    for side in sides:
        dx, dy = ((side.ball[k] - side.arm_pivot[k]) / governor.arm * 0.055 * u for k in (0, 1))
        x, y = side.arm_pivot
        vane = Lines("damper", (((x - dy, y + dx), (x + dy, y - dx)),))
        shapes += [Circle("drum", x, y, 0.055 * u), vane, Circle("pivot", x, y, 0.016 * u)]
    return shapes


def _spiral_spring_shapes(governor: PendulumProportions, angle: float) -> list[DrawnShape]:
    """Return a spiral spring around the pin of each arm, wound by the arm."""
    if not governor.effect_state.find_effect_on(OutputSpring, ARM_READINGS[0]):
        return []
    polar = [(2.2 - (5 * math.pi - angle) * (1 - k / 72), (0.03 + 0.07 * k / 72) * governor.arm) for k in range(73)]
    points = [(governor.offset + radius * math.cos(a), radius * math.sin(a)) for a, radius in polar]
    return [Lines("spring", (tuple((sign * x, y) for x, y in points),)) for sign in (-1.0, 1.0)]


def _ball_spring_shapes(governor: PendulumProportions, sides: list[PendulumSide]) -> list[DrawnShape]:
    """Return a spring from ball to ball."""
    if not governor.effect_state.find_effect_on(OutputSpring, ARM_READINGS[1]):
        return []
    (left, y), (right, _) = (side.ball for side in sides)
    ends = (left + governor.ball_radius, y), (right - governor.ball_radius, y)
    return [Lines("spring", helical_spring_lines(*ends, 0.06 * governor.arm, 0.0))]
