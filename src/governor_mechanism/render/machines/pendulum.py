"""Drawing of the pendulum governor: spindle, cross piece, arms, links, balls, the sleeve with its load, and the gear that it moves.

A detail of the clearance shows one slot of the sleeve. A detail of the lift shows the pointer on a part of the scale.
"""

import math
from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise

from governor_mechanism.effects.holding import CLEARANCE_READING
from governor_mechanism.machines.pendulum import RIGHT_LINK, SLEEVE
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_shifted, fixed
from governor_mechanism.render.geometry.outlines import first_free_position, make_bar, make_rectangle, select_extreme_rows
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2, round_step
from governor_mechanism.render.geometry.recording import horizontal_extents, record_parts
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines import pendulum_parts
from governor_mechanism.render.machines.governor_parts import LIFT_READING, ThrottleGear, mirror_outline, throttle_pivot_distance
from governor_mechanism.render.machines.pendulum_parts import ARM_WIDTH, GROOVE_RATIO, LINK_WIDTH, PendulumProportions, spindle_foot_height
from governor_mechanism.types import FloatArray

# Lengths as fractions of the arm.
_COLLAR_GROOVE_DEPTH, _DRUM_FORK_RATIO = 0.148, 0.60
"""Depth of the groove of a light collar below the lugs, and that of the strap on a drum, relative to the depth of its foot."""
_PIVOT_DISTANCE = 0.40
_PIVOT_GAP = 0.14
_VALVE_DEPTH = 0.10


# Lengths as fractions of the arm.
_WIDTH = 0.90
_HEIGHT = 0.64
_TOP = 0.40
_MIN_RIGHT = 0.34
_CAPTION_DISTANCE, _CAPTION_WIDTH = 0.075, 0.85
_MAX_DRAWN_CLEARANCE = 0.24
_SLOT_CENTRE_HEIGHT = 0.25
_EYE_RADIUS = 0.062
_LUG_HALF_WIDTH = 0.15
_LINK_HALF_WIDTH = 0.036
_LUG_X = 0.19
_RULER_X = 0.39
_TICK = 0.03
_TEXT_DISTANCE = 0.05
_TEXT_WIDTH = 0.44
_MAX_DRAWN_LIFT = 0.38
_LIFT_RULER_X = 0.24
_POINTER_GAP = 0.015
_POINTER_LENGTH = 0.16
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
        yield from _ruler(governor, left + _RULER_X * u, [(middle - half, "0"), (middle + half, f"{governor.clearance * 1e3:.4g} mm")])
    else:
        low, high = governor.reading_range(LIFT_READING)
        step = round_step(high - low, 5)
        lifts = [k * step for k in range(math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9) + 1)]
        # Numbers at the ends alone stay apart.
        texts = [f"{lifts[0] * 1e3:.6g}", *[""] * (len(lifts) - 2), f"{lifts[-1] * 1e3:.6g} mm"]
        yield from _ruler(
            governor, left + _LIFT_RULER_X * u, [(_lift_height(governor, lift), text) for lift, text in zip(lifts, texts, strict=True)]
        )


def lens_parts(governor: PendulumProportions) -> Iterator[DrawnPart]:
    """Yield what moves in the detail, if there is one: the eye of a link in the slot of a lug, or the pointer of the lift."""
    if governor.clearance:
        yield from _clearance_parts(governor)
    elif lift_magnification(governor):
        u = governor.arm
        tip = _corner(governor)[0] + (_LIFT_RULER_X - _POINTER_GAP) * governor.arm
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


def _ruler(governor: PendulumProportions, x: float, ticks: list[tuple[float, str]]) -> Iterator[DrawnShape]:
    """Yield a ruler at x (m), with ticks at heights (m) and their texts."""
    u = governor.arm
    lines = [((x, y), (x + _TICK * u, y)) for y, _ in ticks]
    yield Lines("scale", (((x, ticks[0][0]), (x, ticks[-1][0])), *lines))
    yield from (TextShape("scale", x + _TEXT_DISTANCE * u, y, text, _TEXT_WIDTH * u) for y, text in ticks if text)


def _clearance_parts(governor: PendulumProportions) -> Iterator[DrawnPart]:
    """Yield a lug with its slot, and in it the eye of a link from above; the eye flashes at an impact."""
    u, (left, bottom) = governor.arm, _corner(governor)
    x = left + _LUG_X * u
    y = bottom + _SLOT_CENTRE_HEIGHT * u
    radius = _EYE_RADIUS * u
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


_SLOT_HALF_LENGTH = 0.022
"""Half length of the clearance slots in the lugs, as a fraction of the arm."""
_LUG_WIDTH = 0.085
"""Width of a lug, as a fraction of the arm."""


def sleeve_parts(governor: PendulumProportions) -> Iterator[Attached]:
    """Yield the lugs, the rest of the sleeve, which is round, and the slots for the clearance of the links."""
    has_lugs_aside = governor.lug_offset != 0.0
    yield Attached(frame=governor.sleeve_axes, shapes=tuple(_lug_shapes(governor)), turns=has_lugs_aside)
    yield Attached(frame=governor.sleeve_axes, shapes=tuple(_sleeve_shapes(governor)), turns=False)
    yield Attached(frame=governor.sleeve_axes, shapes=tuple(_clearance_slot_shapes(governor)), turns=has_lugs_aside)


def _lug_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    u = governor.arm
    lug_top = _SLOT_HALF_LENGTH * u if governor.clearance else 0.0
    for x in (-governor.lug_offset, governor.lug_offset):
        yield make_bar("sleeve", (x, -0.06 * u), (x, lug_top), _LUG_WIDTH * u)


def _sleeve_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield collar and load with shading; the load is below the lugs, clear of arms and links."""
    u, (width, drop) = governor.arm, governor.sleeve_size
    is_loaded = SLEEVE in governor.body_names
    neck = abs(governor.lug_offset) + 0.06 * u
    top = -0.045 * u
    base = -drop
    outline = (_drum_outline if is_loaded else _collar_outline)(neck, width, top, base, u)
    yield Polygon("sleeve", mirror_outline(outline))
    yield Lines("engraving", _shading_strokes(outline, width if is_loaded else GROOVE_RATIO * width, base, u))
    tip = width + 0.085 * u
    if not governor.is_magnified:  # without the scale beside it
        yield Polygon("pointer", ((tip, base), (tip - 0.07 * u, base + 0.03 * u), (tip - 0.07 * u, base - 0.03 * u)))


def _drum_outline(neck: float, width: float, top: float, base: float, u: float) -> tuple[Vec2, ...]:
    """Return the right half of the outline of the load, from the top down: neck, rounded shoulder, body and foot moulding."""
    corner_radius = min(0.10 * u, 0.5 * (width - neck)) if width > neck else 0.0
    shoulder = top - 0.045 * u
    corner = tuple(
        (width - corner_radius * (1 - math.sin(a)), shoulder - corner_radius * (1 - math.cos(a)))
        for a in (k * math.pi / 12 for k in range(7))
    )
    return ((0.0, top), (neck, top), (neck, shoulder), *corner, (width, base + 0.03 * u), (0.93 * width, base))


def _collar_outline(neck: float, width: float, top: float, base: float, u: float) -> tuple[Vec2, ...]:
    """Return the right half of the outline of a light collar, with the groove for the throttle fork."""
    flange, groove = 0.045 * u, GROOVE_RATIO * width
    upper_flange = (width, top - 0.01 * u), (width, top - flange - 0.01 * u), (groove, top - flange - 0.01 * u)
    return (0.0, top), (neck, top), *upper_flange, (groove, base + flange), (width, base + flange), (width, base)


def _shading_strokes(outline: tuple[Vec2, ...], width: float, base: float, u: float) -> tuple[tuple[Vec2, ...], ...]:
    """Return upright strokes whose spacing decreases toward the right edge: the shading of a cylinder of half width `width`."""
    strokes = []
    for sine in (0.42, 0.57, 0.69, 0.79, 0.87, 0.94):
        x = sine * width
        # The outline starts at the axis; its highest crossing of x is the top of the stroke.
        tops = [y0 + (y1 - y0) * (x - x0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(outline) if x0 <= x < x1]
        strokes.append(((x, max(tops) - 0.02 * u), (x, base + 0.03 * u)))
    strokes.append(((-0.94 * width, strokes[-1][0][1]), (-0.94 * width, base + 0.03 * u)))
    return tuple(strokes)


def _clearance_slot_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield a slot in each lug; none without clearance."""
    half_length = _SLOT_HALF_LENGTH * governor.arm
    for x in (-governor.lug_offset, governor.lug_offset) if governor.clearance else ():
        yield make_bar("slot", (x, -half_length), (x, half_length), 0.05 * governor.arm)


_PIVOT_RADIUS = 0.021
_SCALE_WIDTH = 0.365
"""Width of the lift scale with its numbers, as a fraction of the arm."""


class PendulumDrawing(PendulumProportions):
    """Drawing of a pendulum governor."""

    panel_readings = ("arm_angle", "sleeve_lift", "spindle_speed")
    plan_caption = ("from above,", "marked: the", "right ball")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the spindle in its bearings, the suspension, the axis, the lift scale, and the effects fixed to the frame."""
        u, spindle_foot = self.arm, pendulum_parts.spindle_foot_height(self)
        yield fixed(self._spindle_shapes(spindle_foot))
        yield from pendulum_parts.fixed_effect_parts(self)
        # The cross piece with the arm pins, keyed to the spindle.
        cross_piece = make_bar("frame", (-abs(self.offset), 0.0), (abs(self.offset), 0.0), 0.085 * u)
        yield fixed([make_rectangle("frame", -0.062 * u, 0.062 * u, -0.062 * u, 0.085 * u), cross_piece], turns=True)
        yield fixed(() if self.is_magnified else _lift_scale_shapes(self))
        yield fixed(lens_frame(self), section_only=True)
        yield from self.drive_parts(spindle_foot - 0.19 * u, u)

    def _spindle_shapes(self, spindle_foot: float) -> Iterator[DrawnShape]:
        """Yield the spindle in its bearings."""
        u, w = self.arm, self.spindle_ratio * self.arm
        yield from parts.spindle_shapes(w, (spindle_foot - 0.48 * u, 0.40 * u), spindle_foot - 0.19 * u, 0.33 * u)
        for bottom, top in ((0.17 * u, 0.27 * u), (spindle_foot - 0.14 * u, spindle_foot - 0.04 * u)):
            yield from parts.hatched_pair_shapes("bearing", (w, 0.15 * u), (bottom, top), 0.034 * u)
        yield make_rectangle("spindle", -1.6 * w, 1.6 * w, spindle_foot - 0.04 * u, spindle_foot - 0.012 * u)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield sleeve, links, arms, balls, pins and their effects; the right half covers the left one."""
        yield from pendulum_parts.sleeve_effect_parts(self)
        yield from sleeve_parts(self)
        yield from self.throttle_parts()
        yield from self.linkage_parts()
        for number in (0, 1):
            yield from (self._pin(number, joint) for joint in ("arm_pivot", "link_joint", "link_end"))
        yield from pendulum_parts.arm_effect_parts(self)
        yield from lens_parts(self)

    def _pin(self, number: int, joint: str) -> Attached:
        """Return the pin of a joint of the left (0) or the right (1) half; on the axis it is round."""
        x, y = self.place_of(number, joint, self.first_moment)
        frame = self.pin_axes(number, joint)
        return self.attach(frame, [Circle("pivot", x, y, _PIVOT_RADIUS * self.arm)], turns=x != 0.0)

    @cached_property
    def throttle_gear(self) -> ThrottleGear:
        """The throttle that the sleeve moves, beyond the sleeve and its dashpot."""
        u, half_width = self.arm, self.sleeve_size[0]
        return ThrottleGear(
            unit=u,
            side=-1.0,
            pin_range=self.fork_pin_range,
            strap_half_width=1.03 * half_width if SLEEVE in self.body_names else (GROOVE_RATIO + 0.04) * half_width,
            pivot_distance=throttle_pivot_distance(self, max(_PIVOT_DISTANCE * u, half_width + _PIVOT_GAP * u), _PIVOT_GAP * u),
            valve_height=spindle_foot_height(self) - _VALVE_DEPTH * u,
        )

    @cached_property
    def fork_depth(self) -> float:
        """Depth of the pin of the fork below the lugs (m): in the groove of a light collar, or at the strap around a drum."""
        is_loaded = SLEEVE in self.body_names
        return _DRUM_FORK_RATIO * self.sleeve_size[1] if is_loaded else _COLLAR_GROOVE_DEPTH * self.arm

    def plan_shapes(self, pose: FloatArray, angle: float) -> Iterator[DrawnShape]:
        """Yield sleeve, arms and balls from above; a mark identifies the right ball."""
        left, right = ((side.ball[0] * math.cos(angle), side.ball[0] * math.sin(angle)) for side in self.sides(pose))
        yield Circle("sleeve", 0.0, 0.0, self.sleeve_size[0])
        yield Lines("plan arm", ((left, right),))
        yield from (Circle("ball", *point, self.ball_radius) for point in (left, right))
        yield Circle("mark", *right, 0.42 * self.ball_radius)

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the centre of the right ball."""
        return self.ball_centres(poses)

    def linkage_parts(self) -> Iterator[Attached]:
        """Yield links, arms and balls. A link with mass is drawn as a rod."""
        u, first_sides = self.arm, self.sides_at(self.first_moment)
        role, width = ("rod", 1.2 * LINK_WIDTH) if RIGHT_LINK in self.body_names else ("link", LINK_WIDTH)
        for number, side in enumerate(first_sides):
            yield self.attach(self.link_axes[number], [make_bar(role, side.link_joint, side.link_end, width * u)])
            yield self.attach(self.arm_axes[number], [make_bar("arm", side.arm_pivot, side.ball, ARM_WIDTH * u)])
        yield from parts.ball_parts(self.axes_at("ball"), self.ball_radius)


def _lift_scale_shapes(governor: PendulumDrawing) -> Iterator[DrawnShape]:
    """Yield a scale (mm) that covers the lifts of the run, at the height of the pointer."""
    # It is next to the sleeve, or further out with leader lines if a part of the linkage passes there.
    u, (width, drop) = governor.arm, governor.sleeve_size
    ticks_mm = parts.lift_ticks(governor.reading_range(parts.LIFT_READING), governor.zero_lift_height - drop, 0.04 * u, 0.14 * u)
    bottom, top = ticks_mm[0][1] - 0.04 * u, ticks_mm[-1][1] + 0.04 * u
    preferred_x = width + 0.10 * u
    moments = [Moment(pose, 0.0) for pose in governor.poses[select_extreme_rows(governor.poses)]]
    linkage = record_parts(tuple(governor.linkage_parts()), moments)
    # Leave a small gap to the linkage.
    x = first_free_position(horizontal_extents(linkage, bottom, top), preferred_x - 0.01 * u, _SCALE_WIDTH * u)
    # Text keeps its size when a wide machine is drawn at a small scale: far out, its space grows with the width.
    if x < preferred_x:
        x, text_width = preferred_x, 0.3 * u
    else:
        x += 0.05 * u
        text_width = 0.4 * x
        yield Lines("leader", tuple(((preferred_x, y), (x, y)) for _, y in ticks_mm))
    yield from parts.lift_scale_shapes(x, ticks_mm, (0.05 * u, 0.03 * u, 0.065 * u, text_width))
