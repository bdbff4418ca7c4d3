"""Stops of a pendulum governor: blocks for the arms, collars for the sleeve, and their impacts."""

from __future__ import annotations

import math

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_band, make_burst, make_hatched_block
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Vec2, make_bar
from governor_mechanism.render.machines.governor_parts import LIFT_READING
from governor_mechanism.render.machines.pendulum.proportions import ARM_WIDTH, PENDULUM_SPINDLE_HALF_WIDTH, PendulumProportions

ARM_READINGS = ("arm_angle", "ball_radius")
"""Readings that determine the position of the arms."""

COLLAR_HEIGHT, SHOE_HEIGHT = 0.07, 0.080
"""Heights of a stop on the spindle and of the friction shoes under the sleeve, as fractions of the arm."""
_QUADRANT_RATIO, _CROSSED_QUADRANT_RATIO = 0.36, 0.62
"""Radius of the arc with the arm stops, as a fraction of the joint distance; for crossed arms beyond their intersection."""
_INNER_STOP_HALF_WIDTH = 0.058
"""Half width of a stop on the spindle inside a spring, as a fraction of the arm."""


def sleeve_depth(governor: PendulumProportions) -> float:
    """Return the depth of the sleeve below the lugs (m), including the friction shoes."""
    shoe_height = SHOE_HEIGHT if governor.find_lift_effect(DryFriction) else 0.0
    return governor.sleeve_size[1] + shoe_height * governor.arm


def sleeve_contact_above_lugs(governor: PendulumProportions) -> Vec2:
    """Return the height above the lugs at which a part on the spindle meets the sleeve (m), and its largest half width (m)."""
    u = governor.arm
    half_gap = abs(governor.lug_offset) - 0.05 * u
    if half_gap >= 0.065 * u:
        return -0.045 * u, min(half_gap, 0.10 * u)
    return (0.068 if governor.clearance else 0.046) * u, 0.09 * u


def is_spring_above_sleeve(governor: PendulumProportions, spring: OutputSpring) -> bool:
    """Return whether a spring is above the sleeve and pushes it down; otherwise it carries the sleeve."""
    low, high = governor.effect_state.reading_ranges.get(LIFT_READING, (0.0, 0.0))
    return spring.free_value <= (low + high) / 2


def _stop_angles(governor: PendulumProportions) -> tuple[str, float, float] | None:
    """Return the reading with stops on the arms, and the limits of the arm angle (rad, infinite if there is no stop)."""
    stops = governor.effect_state.find_effect_on(Stops, *ARM_READINGS)
    if stops is None:
        return None
    if stops.reading == ARM_READINGS[0]:
        return stops.reading, stops.low, stops.high
    low_limit, high_limit = ((radius - governor.offset) / governor.arm for radius in (stops.low, stops.high))
    return (stops.reading, math.asin(low_limit) if low_limit > -1 else -math.inf, math.asin(high_limit) if high_limit < 1 else math.inf)


def arm_stop_shapes(governor: PendulumProportions) -> list[DrawnShape]:
    """Return an arc on each side, fixed to the spindle, with a block at each stop of the arm."""
    stop_angles = _stop_angles(governor)
    if stop_angles is None:
        return []
    _, low, high = stop_angles
    u, radius, shapes = governor.arm, _quadrant_radius(governor), list[DrawnShape]()
    min_angle, max_angle = (float(v) for v in governor.effect_state.reading_ranges.get(ARM_READINGS[0], (low, high)))
    angle_margin = (ARM_WIDTH / 2 + 0.05) * u / radius
    start = low - angle_margin if math.isfinite(low) else min(min_angle, high) - angle_margin
    stop = high + angle_margin if math.isfinite(high) else max(max_angle, low) + angle_margin
    for sign in (-1.0, 1.0):
        arc = [_quadrant_point(governor, sign, start + (stop - start) * k / 24) for k in range(25)]
        shapes.append(make_bar("bracket", (sign * PENDULUM_SPINDLE_HALF_WIDTH * u, arc[0][1]), arc[0], 0.022 * u))
        shapes.append(make_band("bracket", arc, 0.022 * u))
        for angle, side in ((low, -1.0), (high, 1.0)):
            if math.isfinite(angle):
                axes = (sign * governor.offset, 0.0, -math.pi / 2 + sign * angle)
                inner, outer = sorted((sign * side * ARM_WIDTH / 2 * u, sign * side * (ARM_WIDTH / 2 + 0.055) * u))
                shapes += make_hatched_block("stop", axes, (radius - 0.05 * u, radius + 0.05 * u, inner, outer), 0.030 * u)
    return shapes


def _quadrant_radius(governor: PendulumProportions) -> float:
    return (_QUADRANT_RATIO if governor.offset >= 0 else _CROSSED_QUADRANT_RATIO) * governor.joint_distance


def _quadrant_point(governor: PendulumProportions, sign: float, angle: float) -> Vec2:
    radius = _quadrant_radius(governor)
    return sign * (governor.offset + radius * math.sin(angle)), -radius * math.cos(angle)


def sleeve_stop_shapes(governor: PendulumProportions) -> list[DrawnShape]:
    """Return the collars on the spindle that stop the sleeve, in section on both sides."""
    u, shapes = governor.arm, list[DrawnShape]()
    for _, (left, right, bottom, top) in collar_boxes(governor):
        for side in (-1.0, 1.0):
            x0, x1 = sorted((side * left, side * right))
            shapes += make_hatched_block("stop", (0.0, 0.0, 0.0), (x0, x1, bottom, top), 0.030 * u)
    return shapes


def collar_boxes(governor: PendulumProportions) -> list[tuple[bool, BoundingBox]]:
    """Return the right halves of the collars: whether it is the low one, and left, right, bottom and top (m)."""
    stops = governor.find_lift_effect(Stops)
    if stops is None:
        return []
    u, inner, boxes = governor.arm, PENDULUM_SPINDLE_HALF_WIDTH * governor.arm, []
    spring = governor.find_lift_effect(OutputSpring)
    if math.isfinite(stops.low):
        top = governor.zero_lift_height + stops.low - sleeve_depth(governor)
        half_width = _INNER_STOP_HALF_WIDTH * u if spring and not is_spring_above_sleeve(governor, spring) else 0.11 * u
        boxes.append((True, (inner, half_width, top - COLLAR_HEIGHT * u, top)))
    if math.isfinite(stops.high):
        contact_height, half_width = sleeve_contact_above_lugs(governor)
        if spring and is_spring_above_sleeve(governor, spring):
            half_width = min(half_width, _INNER_STOP_HALF_WIDTH * u)
        bottom = governor.zero_lift_height + stops.high + contact_height
        boxes.append((False, (inner, half_width, bottom, bottom + COLLAR_HEIGHT * u)))
    return boxes


def pendulum_impact_shapes(governor: PendulumProportions, time: float) -> list[DrawnShape]:
    """Return rays where an arm or the sleeve has just struck a stop."""
    u, shapes = governor.arm, list[DrawnShape]()
    stop_angles = _stop_angles(governor)
    if stop_angles is not None:
        last_impact, impact_points = governor.effect_state.recent_impact(stop_angles[0], time), list[Vec2]()
        if last_impact is not None:
            impact_points = [
                _quadrant_point(governor, sign, stop_angles[2] if last_impact.is_high_stop else stop_angles[1]) for sign in (-1.0, 1.0)
            ]
        shapes.append(make_burst("burst", impact_points, 0.085 * u))
    if governor.find_lift_effect(Stops):
        last_impact, impact_points = governor.effect_state.recent_impact(LIFT_READING, time), list[Vec2]()
        for is_low, (_, half_width, bottom, top) in collar_boxes(governor):
            if last_impact is not None and last_impact.is_high_stop != is_low:
                # At the sides of the collar, clear of the sleeve.
                impact_points = [(side * (half_width + 0.01 * u), (top + bottom) / 2) for side in (-1.0, 1.0)]
        shapes.append(make_burst("burst", impact_points, 0.075 * u))
    return shapes
