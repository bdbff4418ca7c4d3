"""Stops of a pendulum governor: blocks for the arms, collars for the sleeve, and their impacts."""

from __future__ import annotations

import math
from collections.abc import Iterator

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_band, make_burst, make_hatched_block
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Vec2, make_bar
from governor_mechanism.render.machines.governor_parts import LIFT_READING, stop_block_shapes
from governor_mechanism.render.machines.pendulum.proportions import ARM_WIDTH, PendulumProportions

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


def _stop_angles(governor: PendulumProportions, stops: Stops) -> Vec2:
    """Return the limits of the arm angle (rad, infinite if there is no stop)."""
    if stops.reading == "arm_angle":
        return stops.low, stops.high
    low_sine, high_sine = ((radius - governor.offset) / governor.arm for radius in (stops.low, stops.high))
    return math.asin(low_sine) if low_sine > -1 else -math.inf, math.asin(high_sine) if high_sine < 1 else math.inf


def arm_stop_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield an arc on each side, fixed to the spindle, with a block at each stop of the arm."""
    stops = governor.effect_state.find_effect_on(Stops, *ARM_READINGS)
    if stops is None:
        return
    low, high = _stop_angles(governor, stops)
    u, radius = governor.arm, _quadrant_radius(governor)
    min_angle, max_angle = governor.effect_state.reading_ranges.get("arm_angle", (low, high))
    angle_margin = (ARM_WIDTH / 2 + 0.05) * u / radius
    start = low - angle_margin if math.isfinite(low) else min(min_angle, high) - angle_margin
    stop = high + angle_margin if math.isfinite(high) else max(max_angle, low) + angle_margin
    for sign in (-1.0, 1.0):
        arc = [_quadrant_point(governor, sign, start + (stop - start) * k / 24) for k in range(25)]
        yield make_bar("bracket", (sign * governor.spindle_ratio * u, arc[0][1]), arc[0], 0.022 * u)
        yield make_band("bracket", arc, 0.022 * u)
        for angle, side in ((low, -1.0), (high, 1.0)):
            if math.isfinite(angle):
                axes = (sign * governor.offset, 0.0, -math.pi / 2 + sign * angle)
                inner, outer = sorted((sign * side * ARM_WIDTH / 2 * u, sign * side * (ARM_WIDTH / 2 + 0.055) * u))
                yield from make_hatched_block("stop", axes, (radius - 0.05 * u, radius + 0.05 * u, inner, outer), 0.030 * u)


def _quadrant_radius(governor: PendulumProportions) -> float:
    return (_QUADRANT_RATIO if governor.offset >= 0 else _CROSSED_QUADRANT_RATIO) * governor.arm_joint


def _quadrant_point(governor: PendulumProportions, sign: float, angle: float) -> Vec2:
    radius = _quadrant_radius(governor)
    return sign * (governor.offset + radius * math.sin(angle)), -radius * math.cos(angle)


def sleeve_stop_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield the collars on the spindle that stop the sleeve, in section on both sides."""
    for box in collar_boxes(governor).values():
        yield from stop_block_shapes(*box, 0.030 * governor.arm)


def collar_boxes(governor: PendulumProportions) -> dict[bool, BoundingBox]:
    """Return left, right, bottom and top (m) of the right halves of the low (False) and the high (True) collar."""
    stops, u, inner = governor.find_lift_effect(Stops), governor.arm, governor.spindle_ratio * governor.arm
    boxes: dict[bool, BoundingBox] = {}
    if stops and math.isfinite(stops.low):
        top = governor.zero_lift_height + stops.low - sleeve_depth(governor)
        half_width = _INNER_STOP_HALF_WIDTH * u if governor.spring_side < 0 else 0.11 * u
        boxes[False] = (inner, half_width, top - COLLAR_HEIGHT * u, top)
    if stops and math.isfinite(stops.high):
        contact_height, half_width = sleeve_contact_above_lugs(governor)
        if governor.spring_side > 0:
            half_width = min(half_width, _INNER_STOP_HALF_WIDTH * u)
        bottom = governor.zero_lift_height + stops.high + contact_height
        boxes[True] = (inner, half_width, bottom, bottom + COLLAR_HEIGHT * u)
    return boxes


def arm_impact_shapes(governor: PendulumProportions, time: float) -> Iterator[DrawnShape]:
    """Yield rays where an arm has just struck a stop."""
    if stops := governor.effect_state.find_effect_on(Stops, *ARM_READINGS):
        impact = governor.effect_state.recent_impact(stops.reading, time)
        low, high = _stop_angles(governor, stops)
        sides = (-1.0, 1.0) if impact else ()
        angle = high if impact and impact.is_high_stop else low
        yield make_burst("burst", [_quadrant_point(governor, side, angle) for side in sides], 0.085 * governor.arm)


def sleeve_impact_shapes(governor: PendulumProportions, time: float) -> Iterator[DrawnShape]:
    """Yield rays where the sleeve has just struck a stop: at the sides of the collar, clear of the sleeve."""
    if governor.find_lift_effect(Stops):
        impact, points = governor.effect_state.recent_impact(LIFT_READING, time), list[Vec2]()
        if impact and (box := collar_boxes(governor).get(impact.is_high_stop)):
            _, half_width, bottom, top = box
            points = [(side * (half_width + 0.01 * governor.arm), (top + bottom) / 2) for side in (-1.0, 1.0)]
        yield make_burst("burst", points, 0.075 * governor.arm)
