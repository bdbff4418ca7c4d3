"""Effects drawn on a pendulum governor: stops, springs, dashpots and friction shoes.

Only effects of the scene are drawn. Effects on the ball radius are shown on the arms.
"""

from __future__ import annotations

import math

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.outlines import make_band, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2, make_bar, make_rectangle
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
    LIFT_READING,
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
_N_COILS = 7


def spindle_foot_distance(governor: PendulumProportions, heights: Vec2) -> float:
    """Return the distance (m) from the low end of the sleeve to the spindle foot, for the lowest and highest lug height (m)."""
    u, shoe_height = governor.arm, sleeve_depth(governor) - governor.sleeve_size[1]
    distance = 0.10 * u + shoe_height
    stops, spring = (
        governor.effect_state.find_effect_on(Stops, LIFT_READING),
        governor.effect_state.find_effect_on(OutputSpring, LIFT_READING),
    )
    if stops and math.isfinite(stops.low):
        distance = max(distance, heights[0] - (governor.zero_lift_height + stops.low) + shoe_height + (COLLAR_HEIGHT + 0.05) * u)
    if spring and not is_spring_above_sleeve(governor, spring):
        distance = max(distance + 0.12 * u, shoe_height + max(0.30 * u, 0.5 * (heights[1] - heights[0])))
    return distance


def pendulum_static_effect_shapes(governor: PendulumProportions) -> tuple[DrawnShape, ...]:
    """Return the shapes fixed to the frame: stops of arms and sleeve, spring seat, dashpot cylinder."""
    return (*arm_stop_shapes(governor), *sleeve_stop_shapes(governor), *_spring_seat_shapes(governor), *_dashpot_shapes(governor))


def pendulum_moving_effect_shapes(
    governor: PendulumProportions, part: Part, pose: FloatArray, time: float
) -> tuple[tuple[DrawnShape, ...], tuple[DrawnShape, ...]]:
    """Return the effect shapes at a pose (bodies, 3) and a time (s): those behind the governor, those in front of it."""
    height = float(pendulum_sleeve_height(governor, part, pose))
    angle = float(pendulum_arm_angles(governor, part, pose))
    sides = pendulum_sides(governor, part, pose)
    behind = (*_piston_shapes(governor, height), *_sleeve_spring_shapes(governor, height), *_sleeve_shoe_shapes(governor, height, time))
    front = (
        *_ball_spring_shapes(governor, sides),
        *_spiral_spring_shapes(governor, angle),
        *_rotary_dashpot_shapes(governor, sides),
        *_arm_shoe_shapes(governor, time),
        *pendulum_impact_shapes(governor, time),
    )
    return behind, front


def _lug_height_range(governor: PendulumProportions) -> Vec2:
    """Return the lowest and highest lug height of the run (m)."""
    low, high = governor.effect_state.reading_ranges.get(LIFT_READING, (0.0, 0.0))
    return governor.zero_lift_height + low, governor.zero_lift_height + high


def _spring_seat_geometry(governor: PendulumProportions) -> tuple[float, float] | None:
    """Return the height of the fixed end of the sleeve spring (m), and the half width of its coils (m)."""
    spring = governor.effect_state.find_effect_on(OutputSpring, LIFT_READING)
    if spring is None:
        return None
    u = governor.arm
    low, high = _lug_height_range(governor)
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
    spring = governor.effect_state.find_effect_on(OutputSpring, LIFT_READING)
    thickness = 0.03 * u if spring and is_spring_above_sleeve(governor, spring) else -0.03 * u
    return [make_rectangle("seat", -half_width - 0.02 * u, half_width + 0.02 * u, min(y, y + thickness), max(y, y + thickness))]


def _sleeve_spring_shapes(governor: PendulumProportions, height: float) -> list[DrawnShape]:
    """Return a helical spring around the spindle, between its seat and the sleeve."""
    seat_geometry, spring = (_spring_seat_geometry(governor), governor.effect_state.find_effect_on(OutputSpring, LIFT_READING))
    if seat_geometry is None or spring is None:
        return []
    y, half_width = seat_geometry
    end = height + sleeve_contact_above_lugs(governor)[0] if is_spring_above_sleeve(governor, spring) else height - governor.sleeve_size[1]
    return [
        Lines(
            "spring", helical_spring_lines((0.0, min(y, end)), (0.0, max(y, end)), half_width, PENDULUM_SPINDLE_HALF_WIDTH * governor.arm)
        )
    ]


def helical_spring_lines(start: Vec2, end: Vec2, half_width: float, hidden_half_width: float) -> tuple[tuple[Vec2, ...], ...]:
    """Return a helical spring of a half width (m) from the side; its back is hidden within `hidden_half_width` (m) of the axis."""
    length, n_segments = math.dist(start, end), 16 * _N_COILS
    c, s = ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 0 else (0.0, 1.0)
    chains: list[list[Vec2]] = [[]]
    for k in range(n_segments + 1):
        angle = 2 * math.pi * _N_COILS * k / n_segments
        across, along = half_width * math.cos(angle), length * k / n_segments
        if math.sin(angle) < -1e-9 and abs(across) < hidden_half_width:
            if chains[-1]:
                chains.append([])
            continue
        chains[-1].append((start[0] + along * c + across * s, start[1] + along * s - across * c))
    return tuple(tuple(chain) for chain in chains if len(chain) > 1)


def _dashpot_box(governor: PendulumProportions) -> tuple[float, float, float, float]:
    """Return left, right, bottom and top of the dashpot (m), long enough for the whole stroke of its piston."""
    u, (low, high) = governor.arm, _lug_height_range(governor)
    x = -(governor.sleeve_size[0] + _DASHPOT_OFFSET * u)
    top = low - governor.sleeve_size[1] - 0.06 * u
    return x - _DASHPOT_HALF_WIDTH * u, x + _DASHPOT_HALF_WIDTH * u, top - max(high - low + 0.20 * u, 0.26 * u), top


def _dashpot_shapes(governor: PendulumProportions) -> list[DrawnShape]:
    """Return an open cylinder filled with oil on a hatched base, next to the sleeve."""
    if not governor.effect_state.find_effect_on(Dashpot, LIFT_READING):
        return []
    u, (left, right, bottom, top) = governor.arm, _dashpot_box(governor)
    wall_thickness = 0.016 * u
    return [
        make_rectangle("dashpot", left, right, bottom, top),
        make_rectangle("bore", left + wall_thickness, right - wall_thickness, bottom + wall_thickness, top),
        make_rectangle("oil", left + wall_thickness, right - wall_thickness, bottom + wall_thickness, top - 0.035 * u),
        make_wall(((left + right) / 2, bottom), math.pi / 2, 1.35 * _DASHPOT_HALF_WIDTH * u, 0.035 * u),
    ]


def _piston_shapes(governor: PendulumProportions, height: float) -> list[DrawnShape]:
    """Return the dashpot piston, its rod, and the bracket that connects it to the sleeve at a height (m)."""
    if not governor.effect_state.find_effect_on(Dashpot, LIFT_READING):
        return []
    u, (left, right, bottom, _) = governor.arm, _dashpot_box(governor)
    x, base = (left + right) / 2, height - governor.sleeve_size[1]
    piston = bottom + 0.05 * u + height - _lug_height_range(governor)[0]
    clearance = 0.022 * u
    return [
        make_rectangle("piston rod", x - 0.013 * u, x + 0.013 * u, piston, base + 0.035 * u),
        make_rectangle("piston", left + clearance, right - clearance, piston, piston + 0.035 * u),
        make_bar("piston rod", (x, base + 0.035 * u), (-0.9 * governor.sleeve_size[0], base + 0.035 * u), 0.036 * u),
    ]


def _sleeve_shoe_shapes(governor: PendulumProportions, height: float, time: float) -> list[DrawnShape]:
    """Return the friction shoes under the sleeve, which slide on the spindle."""
    if not governor.effect_state.find_effect_on(DryFriction, LIFT_READING):
        return []
    u, base = governor.arm, height - governor.sleeve_size[1]
    inner, outer = PENDULUM_SPINDLE_HALF_WIDTH * u, (PENDULUM_SPINDLE_HALF_WIDTH + _SHOE_WIDTH) * u
    return _friction_shoe_shapes(
        governor, LIFT_READING, time, [make_rectangle("shoe", x, x + outer - inner, base - SHOE_HEIGHT * u, base) for x in (-outer, inner)]
    )


def _arm_shoe_shapes(governor: PendulumProportions, time: float) -> list[DrawnShape]:
    """Return a friction shoe over the pin of each arm."""
    friction = governor.effect_state.find_effect_on(DryFriction, *ARM_READINGS)
    if friction is None:
        return []
    u, shoes = governor.arm, []
    for x in (-governor.offset, governor.offset):
        angles = [math.radians(30 + 120 * k / 10) for k in range(11)]
        arc = [(x + 0.075 * u * math.cos(a), 0.075 * u * math.sin(a)) for a in angles]
        shoes.append(make_band("shoe", arc, 0.040 * u))
    return _friction_shoe_shapes(governor, friction.reading, time, shoes)


def _friction_shoe_shapes(governor: PendulumProportions, reading: str, time: float, shoes: list[Polygon]) -> list[DrawnShape]:
    """Return the shoes once for sliding and once for sticking; the set that does not apply has no outline."""
    is_sticking = governor.effect_state.is_held(reading, time)
    return [
        Polygon(role, shoe.points if is_shown else ())
        for role, is_shown in (("shoe", not is_sticking), ("held shoe", is_sticking))
        for shoe in shoes
    ]


def _rotary_dashpot_shapes(governor: PendulumProportions, sides: list[PendulumSide]) -> list[DrawnShape]:
    """Return a small rotary dashpot on the pin of each arm, its vane along the arm."""
    if not governor.effect_state.find_effect_on(Dashpot, *ARM_READINGS):
        return []
    u, shapes = governor.arm, list[DrawnShape]()
    for side in sides:
        dx, dy = ((side.ball[k] - side.arm_pivot[k]) / governor.arm * 0.055 * u for k in (0, 1))
        (x, y) = side.arm_pivot
        shapes.append(Circle("drum", x, y, 0.055 * u))
        shapes.append(Lines("damper", (((x - dy, y + dx), (x + dy, y - dx)),)))
        shapes.append(Circle("pivot", x, y, 0.016 * u))
    return shapes


def _spiral_spring_shapes(governor: PendulumProportions, angle: float) -> list[DrawnShape]:
    """Return a spiral spring around the pin of each arm, wound by the arm."""
    if not governor.effect_state.find_effect_on(OutputSpring, ARM_READINGS[0]):
        return []
    u, shapes = governor.arm, list[DrawnShape]()
    sweep = 5 * math.pi - angle
    for sign in (-1.0, 1.0):
        points = []
        for k in range(73):
            angle_on_spiral, radius = 2.2 - sweep * (1 - k / 72), (0.03 + 0.07 * k / 72) * u
            points.append((sign * (governor.offset + radius * math.cos(angle_on_spiral)), radius * math.sin(angle_on_spiral)))
        shapes.append(Lines("spring", (tuple(points),)))
    return shapes


def _ball_spring_shapes(governor: PendulumProportions, sides: list[PendulumSide]) -> list[DrawnShape]:
    """Return a spring from ball to ball."""
    if not governor.effect_state.find_effect_on(OutputSpring, ARM_READINGS[1]):
        return []
    (left, y), (right, _) = (side.ball for side in sides)
    ends = (left + governor.ball_radius, y), (right - governor.ball_radius, y)
    return [Lines("spring", helical_spring_lines(*ends, 0.06 * governor.arm, 0.0))]
