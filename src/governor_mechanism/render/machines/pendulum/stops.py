"""The stops of a pendulum governor: blocks that arms meet, collars that the sleeve meets, and the blows they take."""

from __future__ import annotations

import math

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import band, block, burst
from governor_mechanism.render.geometry.primitives import Box, Pair, Shape, bar
from governor_mechanism.render.machines.pendulum.proportions import ARM, SPINDLE, Governor

LIFT = "sleeve_lift"
SWING = ("arm_angle", "ball_radius")
"""The readings that the arms show."""

# As fractions of the arm.
COLLAR, GLAND = 0.07, 0.080
"""height of a stop on the spindle, and of the shoes under the sleeve"""
QUADRANT, QUADRANT_CROSSED = 0.36, 0.62
"""radius of the arc that carries the stops of the arms, of the length to the joint; beyond where crossed arms meet"""
WITHIN = 0.058
"""half width of a stop on the spindle that stands within a spring's coils"""


def under(governor: Governor) -> float:
    """How far below the lugs the sleeve ends (m), with the shoes that rub on the spindle."""
    gland = GLAND if governor.acting.on(DryFriction, LIFT) else 0.0
    return governor.load[1] + gland * governor.arm


def over_lugs(governor: Governor) -> Pair:
    """How far above the lugs something on the spindle meets the sleeve (m), and its half width (m) at most."""
    u = governor.arm
    between = abs(governor.lug) - 0.05 * u
    if between >= 0.065 * u:
        return -0.045 * u, min(between, 0.10 * u)
    return (0.068 if governor.play else 0.046) * u, 0.09 * u


def sits_above(governor: Governor, spring: SpringOn) -> bool:
    """Whether a spring sits above the sleeve and pushes it down; else it carries it."""
    low, high = governor.acting.ranges.get(LIFT, (0.0, 0.0))
    return spring.free <= (low + high) / 2


def _stop_angles(governor: Governor) -> tuple[str, float, float] | None:
    """The reading whose stops the arms meet, and the arm angles (rad, infinite where there is none)."""
    stops = governor.acting.on(Stops, *SWING)
    if stops is None:
        return None
    if stops.reading == SWING[0]:
        return stops.reading, stops.low, stops.high
    low, high = ((radius - governor.offset) / governor.arm for radius in (stops.low, stops.high))
    return stops.reading, math.asin(low) if low > -1 else -math.inf, math.asin(high) if high < 1 else math.inf


def arm_stops(governor: Governor) -> list[Shape]:
    """An arc on each side, held by the spindle, with a block where the arm meets it."""
    found = _stop_angles(governor)
    if found is None:
        return []
    _, low, high = found
    u, radius, shapes = governor.arm, _quadrant(governor), list[Shape]()
    least, most = (float(v) for v in governor.acting.ranges.get(SWING[0], (low, high)))
    spread = (ARM / 2 + 0.05) * u / radius
    start = low - spread if math.isfinite(low) else min(least, high) - spread
    stop = high + spread if math.isfinite(high) else max(most, low) + spread
    for sign in (-1.0, 1.0):
        arc = [_on_arc(governor, sign, start + (stop - start) * k / 24) for k in range(25)]
        shapes.append(bar("bracket", (sign * SPINDLE * u, arc[0][1]), arc[0], 0.022 * u))
        shapes.append(band("bracket", arc, 0.022 * u))
        for angle, side in ((low, -1.0), (high, 1.0)):
            if math.isfinite(angle):
                axes = (sign * governor.offset, 0.0, -math.pi / 2 + sign * angle)
                near, far = sorted((sign * side * ARM / 2 * u, sign * side * (ARM / 2 + 0.055) * u))
                shapes += block("stop", axes, (radius - 0.05 * u, radius + 0.05 * u, near, far), 0.030 * u)
    return shapes


def _quadrant(governor: Governor) -> float:
    return (QUADRANT if governor.offset >= 0 else QUADRANT_CROSSED) * governor.joint


def _on_arc(governor: Governor, sign: float, angle: float) -> Pair:
    radius = _quadrant(governor)
    return sign * (governor.offset + radius * math.sin(angle)), -radius * math.cos(angle)


def sleeve_stops(governor: Governor) -> list[Shape]:
    """Collars on the spindle that the sleeve meets, in section on both sides of it."""
    u, shapes = governor.arm, list[Shape]()
    for _, (left, right, bottom, top) in collars(governor):
        for side in (-1.0, 1.0):
            x0, x1 = sorted((side * left, side * right))
            shapes += block("stop", (0.0, 0.0, 0.0), (x0, x1, bottom, top), 0.030 * u)
    return shapes


def collars(governor: Governor) -> list[tuple[bool, Box]]:
    """The right halves of the collars: whether it is the low one, and left, right, bottom and top (m)."""
    stops = governor.acting.on(Stops, LIFT)
    if stops is None:
        return []
    u, inner, found = governor.arm, SPINDLE * governor.arm, []
    spring = governor.acting.on(SpringOn, LIFT)
    if math.isfinite(stops.low):
        top = governor.zero + stops.low - under(governor)
        half = WITHIN * u if spring and not sits_above(governor, spring) else 0.11 * u
        found.append((True, (inner, half, top - COLLAR * u, top)))
    if math.isfinite(stops.high):
        over, half = over_lugs(governor)
        if spring and sits_above(governor, spring):
            half = min(half, WITHIN * u)
        bottom = governor.zero + stops.high + over
        found.append((False, (inner, half, bottom, bottom + COLLAR * u)))
    return found


def blows(governor: Governor, time: float) -> list[Shape]:
    """Rays where arm or sleeve has just struck a stop."""
    u, shapes = governor.arm, list[Shape]()
    swing = _stop_angles(governor)
    if swing is not None:
        strike, spots = governor.acting.struck(swing[0], time), list[Pair]()
        if strike is not None:
            spots = [_on_arc(governor, sign, swing[2] if strike.high else swing[1]) for sign in (-1.0, 1.0)]
        shapes.append(burst("burst", spots, 0.085 * u))
    if governor.acting.on(Stops, LIFT):
        strike, spots = governor.acting.struck(LIFT, time), list[Pair]()
        for low, (_, half, bottom, top) in collars(governor):
            if strike is not None and strike.high != low:
                # Beside the collar's own middle, clear of the sleeve.
                spots = [(side * (half + 0.01 * u), (top + bottom) / 2) for side in (-1.0, 1.0)]
        shapes.append(burst("burst", spots, 0.075 * u))
    return shapes
