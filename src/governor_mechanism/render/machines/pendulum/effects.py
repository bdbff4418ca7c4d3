"""Effects drawn on a pendulum governor: stops, springs, dashpots and friction shoes.

Only effects of the scene are drawn. Effects on the ball radius are shown on the arms.
"""

import math
from collections.abc import Iterator
from functools import partial

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, fixed
from governor_mechanism.render.geometry.outlines import make_band, make_bar, make_burst, make_hatched_block, make_rectangle
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.generic.force_elements import spiral_points
from governor_mechanism.render.machines.pendulum.proportions import ARM_WIDTH, PendulumProportions, PendulumSide

_ARM_READINGS = ("arm_angle", "ball_radius")
"""Readings that determine the position of the arms."""

_COLLAR_HEIGHT, _SHOE_WIDTH, _SHOE_HEIGHT = 0.07, 0.060, 0.080
"""Height of a stop on the spindle, and sizes of the friction shoes under the sleeve, as fractions of the arm."""
_QUADRANT_RATIO, _CROSSED_QUADRANT_RATIO = 0.36, 0.62
"""Radius of the arc with the arm stops, as a fraction of the joint distance; for crossed arms beyond their intersection."""
_INNER_STOP_HALF_WIDTH = 0.058
"""Half width of a stop on the spindle inside a spring, as a fraction of the arm."""


def spindle_foot_height(governor: PendulumProportions) -> float:
    """Return the height (m) of the spindle foot, below the lowest position of the sleeve and of what acts there."""
    u, (low, high), depth = governor.arm, governor.lug_height_range, governor.sleeve_size[1]
    shoe_height = _sleeve_depth(governor) - depth
    distance = 0.10 * u + shoe_height
    collar = (_COLLAR_HEIGHT + 0.05) * u
    stops = governor.find_lift_effect(Stops)
    if stops and math.isfinite(stops.low):
        distance = max(distance, low - (governor.zero_lift_height + stops.low) + shoe_height + collar)
    if governor.spring_side < 0:
        distance = max(distance + 0.12 * u, shoe_height + max(0.30 * u, 0.5 * (high - low)))
    return low - depth - distance


def fixed_effect_parts(governor: PendulumProportions) -> Iterator[Attached]:
    """Yield what is fixed to the frame: stops of arms and sleeve, the disc that supports the sleeve spring, dashpot cylinder."""
    yield fixed(_arm_stop_shapes(governor), turns=True)
    for box in _collar_boxes(governor).values():
        yield fixed(parts.hatched_pair_shapes("stop", box[:2], box[2:], 0.030 * governor.arm), turns=True)
    if governor.spring_side:
        y, half_width = _spring_seat(governor)
        low, high = sorted((y, y + governor.spring_side * 0.03 * governor.arm))
        yield fixed([make_rectangle("seat", -half_width - 0.02 * governor.arm, half_width + 0.02 * governor.arm, low, high)])
    yield fixed(parts.cylinder_shapes(governor))


def sleeve_effect_parts(governor: PendulumProportions) -> Iterator[DrawnPart]:
    """Yield the effects on the sleeve, behind the governor."""
    depth = governor.sleeve_size[1]
    yield from parts.piston_parts(governor, depth - 0.035 * governor.arm)
    if governor.spring_side:
        yield Flexible(shapes_at=partial(_sleeve_spring_shapes, governor))
    yield from parts.spindle_shoe_parts(governor, depth, (_SHOE_WIDTH, _SHOE_HEIGHT))


def _sleeve_spring_shapes(governor: PendulumProportions, moment: Moment) -> list[DrawnShape]:
    """Return the spring between its seat and the sleeve."""
    height = governor.sleeve_axes(moment)[1]
    seat, half_width = _spring_seat(governor)
    contact = _sleeve_contact_above_lugs(governor)[0] if governor.spring_side > 0 else -governor.sleeve_size[1]
    low, high = sorted((seat, height + contact))
    coils = parts.helical_spring_lines((0.0, low), (0.0, high), half_width, governor.spindle_ratio * governor.arm)
    return [Lines("spring", coils)]


def arm_effect_parts(governor: PendulumProportions) -> Iterator[DrawnPart]:
    """Yield the effects on the arms, in front of the governor, and the impacts."""
    if governor.find_effect(OutputSpring, "ball_radius"):
        yield Flexible(shapes_at=lambda moment: [_ball_spring(governor, governor.sides_at(moment))])
    if governor.find_effect(OutputSpring, "arm_angle"):
        spirals = partial(_spiral_springs, governor)
        yield Flexible(shapes_at=lambda moment: spirals(float(governor.arm_angles(moment.pose))), turns=True)
    if governor.find_effect(Dashpot, *_ARM_READINGS):
        yield from _rotary_dashpot_parts(governor)
    if friction := governor.find_effect(DryFriction, *_ARM_READINGS):
        yield from parts.friction_shoe_parts(governor, friction.reading, fixed(_arm_shoe_shapes(governor)))
    yield Flexible(shapes_at=lambda moment: _impact_shapes(governor, moment.time))


def _spring_seat(governor: PendulumProportions) -> Vec2:
    """Return the height of the fixed end of the sleeve spring (m), and the half width of its coils (m)."""
    u, (low, high) = governor.arm, governor.lug_height_range
    if governor.spring_side < 0:
        return spindle_foot_height(governor), 0.105 * u
    contact_height, half_width = _sleeve_contact_above_lugs(governor)
    seat_height = high + contact_height + max(0.24 * u, 0.4 * (high - low))
    if high_collar := _collar_boxes(governor).get(1):
        seat_height = max(seat_height, high_collar[3] + 0.05 * u)
    return max(min(seat_height, -0.085 * u), high + contact_height + 0.04 * u), min(half_width, 0.085 * u)


def _arm_shoe_shapes(governor: PendulumProportions) -> list[Polygon]:
    """Return a friction shoe over the pin of each arm."""
    u, angles = governor.arm, [math.radians(30 + 120 * k / 10) for k in range(11)]
    arcs = ([(x + 0.075 * u * math.cos(a), 0.075 * u * math.sin(a)) for a in angles] for x in (-governor.offset, governor.offset))
    return [make_band("shoe", arc, 0.040 * u) for arc in arcs]


def _rotary_dashpot_parts(governor: PendulumProportions) -> Iterator[Attached]:
    """Yield a small rotary dashpot on the pin of each arm, its vane along the arm."""
    u, is_aside = governor.arm, governor.offset != 0.0
    vane = Lines("damper", (((0.0, 0.055 * u), (0.0, -0.055 * u)),))
    for axes in governor.arm_axes:
        shapes = (Circle("drum", 0.0, 0.0, 0.055 * u), vane, Circle("pivot", 0.0, 0.0, 0.016 * u))
        yield Attached(frame=axes, shapes=shapes, turns=is_aside)


def _spiral_springs(governor: PendulumProportions, angle: float) -> list[DrawnShape]:
    """Return a spiral spring around the pin of each arm, wound by the arm."""
    points = spiral_points((governor.offset, 0.0), 2.2, angle, governor.arm)
    return [Lines("spring", (tuple((sign * x, y) for x, y in points),)) for sign in (-1.0, 1.0)]


def _ball_spring(governor: PendulumProportions, sides: list[PendulumSide]) -> Lines:
    """Return a spring from ball to ball."""
    (left, y), (right, _) = (side.ball for side in sides)
    ends = (left + governor.ball_radius, y), (right - governor.ball_radius, y)
    return Lines("spring", parts.helical_spring_lines(*ends, 0.06 * governor.arm, 0.0))


def _sleeve_depth(governor: PendulumProportions) -> float:
    """Return the depth of the sleeve below the lugs (m), including the friction shoes."""
    shoe_height = _SHOE_HEIGHT if governor.find_lift_effect(DryFriction) else 0.0
    return governor.sleeve_size[1] + shoe_height * governor.arm


def _sleeve_contact_above_lugs(governor: PendulumProportions) -> Vec2:
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


def _arm_stop_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield an arc on each side, fixed to the spindle, with a block at each stop of the arm."""
    stops = governor.find_effect(Stops, *_ARM_READINGS)
    if stops is None:
        return
    low, high = _stop_angles(governor, stops)
    u, radius = governor.arm, _quadrant_radius(governor)
    min_angle, max_angle = governor.reading_range("arm_angle", (low, high))
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


def _collar_boxes(governor: PendulumProportions) -> dict[int, BoundingBox]:
    """Return left, right, bottom and top (m) of the right halves of the low (-1) and the high (1) collar."""
    stops = governor.find_lift_effect(Stops)
    u, inner = governor.arm, governor.spindle_ratio * governor.arm
    boxes: dict[int, BoundingBox] = {}
    if stops and math.isfinite(stops.low):
        top = governor.zero_lift_height + stops.low - _sleeve_depth(governor)
        half_width = _INNER_STOP_HALF_WIDTH * u if governor.spring_side < 0 else 0.11 * u
        boxes[-1] = (inner, half_width, top - _COLLAR_HEIGHT * u, top)
    if stops and math.isfinite(stops.high):
        contact_height, half_width = _sleeve_contact_above_lugs(governor)
        if governor.spring_side > 0:
            half_width = min(half_width, _INNER_STOP_HALF_WIDTH * u)
        bottom = governor.zero_lift_height + stops.high + contact_height
        boxes[1] = (inner, half_width, bottom, bottom + _COLLAR_HEIGHT * u)
    return boxes


def _impact_shapes(governor: PendulumProportions, time: float) -> Iterator[DrawnShape]:
    """Yield rays where an arm or the sleeve has just struck a stop; those of the sleeve are at the sides of the collar, clear of it."""
    u, signs = governor.arm, (-1.0, 1.0)
    if stops := governor.find_effect(Stops, *_ARM_READINGS):
        struck_side = governor.struck_side(stops.reading, time)
        angle = _stop_angles(governor, stops)[struck_side > 0]
        yield make_burst("burst", [_quadrant_point(governor, sign, angle) for sign in signs] if struck_side else [], 0.085 * u)
    if governor.find_lift_effect(Stops):
        box = _collar_boxes(governor).get(governor.struck_side(parts.LIFT_READING, time))
        yield make_burst("burst", [(sign * (box[1] + 0.01 * u), (box[3] + box[2]) / 2) for sign in signs] if box else [], 0.075 * u)
