"""Enlarged details beside a pendulum governor, with scales in millimetres: the clearance of the links, and a lift too small to be seen.

A detail of the clearance shows one slot of the sleeve. A detail of the lift shows the pointer on a part of the scale.
"""

import math
from collections.abc import Iterator

from governor_mechanism.effects.clearance import CLEARANCE_READING
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_shifted, fixed
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2, round_step
from governor_mechanism.render.machines.governor_parts import LIFT_READING
from governor_mechanism.render.machines.pendulum.proportions import PendulumProportions

# Lengths as fractions of the arm.
_WIDTH, _HEIGHT, _TOP, _MIN_RIGHT = 0.80, 0.64, 0.40, 0.34
_CAPTION_DISTANCE, _CAPTION_WIDTH = 0.065, 0.66
_MAX_DRAWN_CLEARANCE, _SLOT_CENTRE_HEIGHT, _EYE_RADIUS, _LUG_HALF_WIDTH, _LINK_HALF_WIDTH = 0.24, 0.25, 0.062, 0.15, 0.036
_LUG_X, _RULER_X, _TICK, _TEXT_DISTANCE, _TEXT_WIDTH = 0.19, 0.39, 0.03, 0.05, 0.34
_MAX_DRAWN_LIFT, _POINTER_X, _POINTER_LENGTH = 0.38, 0.375, 0.16
_SMALL_LIFT, _LEAST_LIFT = 0.025, 1e-6
"""Range of the lift (as a fraction of the arm) below which a detail shows it, and below which it counts as rest."""


def clearance_magnification(governor: PendulumProportions) -> float:
    """Return the magnification of the clearance in the detail: 1, 2 or 5 x 10^n."""
    largest = _MAX_DRAWN_CLEARANCE * governor.arm / governor.clearance
    decade = float(10.0 ** math.floor(math.log10(largest)))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= largest * (1 + 1e-9))


def lift_magnification(governor: PendulumProportions) -> float:
    """Return the magnification of the lift in the detail, of one digit, or 0 for a lift that needs none, or where others show it."""
    low, high = governor.reading_range(LIFT_READING)
    has_company = len(governor.run.scene.parts) > 1
    is_small = _LEAST_LIFT * governor.arm < high - low < _SMALL_LIFT * governor.arm
    if governor.clearance or has_company or governor.is_magnified or not is_small:
        return 0.0
    largest = _MAX_DRAWN_LIFT * governor.arm / (high - low)
    decade = float(10.0 ** math.floor(math.log10(largest)))
    return math.floor(largest / decade) * decade


def lens_frame(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield the frame of the detail with its magnification and its scale, if there is a detail."""
    magnification, name = (clearance_magnification(governor), "clearance") if governor.clearance else (lift_magnification(governor), "lift")
    if not magnification:
        return
    u, (left, bottom) = governor.arm, _corner(governor)
    ratio = f"{magnification:g} : 1" if magnification >= 1.0 else f"1 : {1 / magnification:g}"
    yield make_rectangle("lens", left, left + _WIDTH * u, bottom, bottom + _HEIGHT * u)
    yield TextShape("scale", left, bottom + (_HEIGHT + _CAPTION_DISTANCE) * u, f"{name}, {ratio}", _CAPTION_WIDTH * u)
    if governor.clearance:
        middle = bottom + _SLOT_CENTRE_HEIGHT * u
        half = 0.5 * magnification * governor.clearance
        yield from _ruler(governor, left, [(middle - half, "0"), (middle + half, f"{governor.clearance * 1e3:.4g} mm")])
    else:
        low, high = governor.reading_range(LIFT_READING)
        step = round_step(high - low, 5)
        lifts = [k * step for k in range(math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9) + 1)]
        # Numbers at the ends alone stay apart.
        texts = [f"{lifts[0] * 1e3:.6g}", *[""] * (len(lifts) - 2), f"{lifts[-1] * 1e3:.6g} mm"]
        yield from _ruler(governor, left, [(_lift_height(governor, lift), text) for lift, text in zip(lifts, texts, strict=True)])


def lens_parts(governor: PendulumProportions) -> Iterator[DrawnPart]:
    """Yield what moves in the detail, if there is one: the eye of a link in the slot of a lug, or the pointer of the lift."""
    if governor.clearance:
        yield from _clearance_parts(governor)
    elif lift_magnification(governor):
        u, tip = governor.arm, _corner(governor)[0] + _POINTER_X * governor.arm
        back, half = -_POINTER_LENGTH * u, 0.05 * u
        frame = axes_shifted(lambda moment: (tip, _lift_height(governor, governor.sleeve_axes(moment)[1] - governor.zero_lift_height)))
        yield Attached(frame=frame, shapes=(Polygon("pointer", ((0.0, 0.0), (back, half), (back, -half))),), section_only=True)


def _corner(governor: PendulumProportions) -> Vec2:
    """Return the lower left corner of the detail (m): at the left of the upper bearing, above balls and arms."""
    u, high = governor.arm, governor.reading_range("arm_angle")[1]
    highest_ball = -math.cos(min(high, math.pi / 2)) * u + governor.ball_radius + 0.04 * u
    bottom = max((_TOP - _HEIGHT) * u, highest_ball)
    arm_x = abs(governor.offset) + max(-bottom, 0.0) * math.tan(min(high, 1.4)) + 0.10 * u
    return -max(_MIN_RIGHT * u, arm_x) - _WIDTH * u, bottom


def _lift_height(governor: PendulumProportions, lift: float) -> float:
    """Return the height (m) in the detail of a lift (m)."""
    low, high = governor.reading_range(LIFT_READING)
    middle = _corner(governor)[1] + 0.5 * _HEIGHT * governor.arm
    return middle + lift_magnification(governor) * (lift - 0.5 * (low + high))


def _ruler(governor: PendulumProportions, left: float, ticks: list[tuple[float, str]]) -> Iterator[DrawnShape]:
    """Yield a ruler in a detail with its left edge at `left` (m), with ticks at heights (m) and their texts."""
    u, x = governor.arm, left + _RULER_X * governor.arm
    lines = [((x, y), (x + _TICK * u, y)) for y, _ in ticks]
    yield Lines("scale", (((x, ticks[0][0]), (x, ticks[-1][0])), *lines))
    yield from (TextShape("scale", x + _TEXT_DISTANCE * u, y, text, _TEXT_WIDTH * u) for y, text in ticks if text)


def _clearance_parts(governor: PendulumProportions) -> Iterator[DrawnPart]:
    """Yield a lug with its slot, and in it the eye of a link from above; the eye flashes at an impact."""
    u, (left, bottom) = governor.arm, _corner(governor)
    x, y, radius = left + _LUG_X * u, bottom + _SLOT_CENTRE_HEIGHT * u, _EYE_RADIUS * u
    half_clearance = clearance_magnification(governor) * governor.clearance / 2
    lug_top = bottom + (2 * _SLOT_CENTRE_HEIGHT - 0.04) * u
    lug = make_rectangle("sleeve", x - _LUG_HALF_WIDTH * u, x + _LUG_HALF_WIDTH * u, bottom, lug_top)
    yield fixed([lug, make_bar("slot", (x, y - half_clearance), (x, y + half_clearance), 2 * radius)], section_only=True)

    def pin_at(moment: Moment) -> Vec2:
        offset = float(governor.sleeve_height(moment.pose) - governor.taut_link_height(moment.pose))
        return x, y - min(max(clearance_magnification(governor) * offset, -half_clearance), half_clearance)

    def link_shapes(moment: Moment) -> list[DrawnShape]:
        # It goes on beyond the edge of the detail.
        return [make_rectangle("link", x - _LINK_HALF_WIDTH * u, x + _LINK_HALF_WIDTH * u, pin_at(moment)[1], bottom + _HEIGHT * u)]

    eye = axes_shifted(pin_at)
    yield Flexible(shapes_at=link_shapes, section_only=True)
    yield Attached(frame=eye, shapes=(Circle("eyelet", 0.0, 0.0, radius),), section_only=True)
    yield Attached(
        frame=eye,
        shapes=(Circle("struck", 0.0, 0.0, radius),),
        section_only=True,
        shown=lambda moment: bool(governor.struck_side(CLEARANCE_READING, moment.time)),
    )
    yield Attached(frame=eye, shapes=(Circle("pivot", 0.0, 0.0, 0.028 * u),), section_only=True)
