"""Drawing of Hartung's governor: hollow weights with their springs, bell cranks, hangers, sleeve and spindle, and the effects on it.

The effects are weight stops, a dashpot, a sleeve spring and friction shoes.
"""

import math
from collections.abc import Iterator
from functools import cached_property
from itertools import chain

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_bar, make_box, make_burst, make_hatched_block, make_hatching, make_rectangle
from governor_mechanism.render.geometry.points import axes_to_plane, place_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, Vec2
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.hartung.proportions import HartungProportions, HartungSide
from governor_mechanism.render.machines.spindle_drive import spindle_drive_shapes
from governor_mechanism.render.machines.throttle_gear import ThrottleGear
from governor_mechanism.types import FloatArray

_WEIGHT_READINGS = ("lever_angle", "weight_radius")
"""Readings that determine the position of the weights."""
_STOP_HALF_HEIGHT = 0.16
"""Half height of the weight stops, as a fraction of the weight arm."""
_SHOE_HEIGHT = 0.20
# Widths and radii as fractions of the weight arm.
_ARM_WIDTH, _HANGER_WIDTH, _PIVOT_RADIUS, _ROD_HALF_WIDTH = 0.17, 0.12, 0.055, 0.05
_GROOVE_BASE, _GROOVE_HEIGHT = 0.14, 0.22
"""Height of the groove for the fork above the foot of the sleeve, and of the groove itself, as fractions of the weight arm."""
_GEAR_UNIT = 2.2
"""Length that sizes the throttle gear and the drive of the spindle, as a multiple of the weight arm."""
_WALL_RATIO = 0.28
"""Thickness of the inner wall of a weight, relative to its half width."""
_N_SPRING_TURNS = 8
"""Coils of each spring; as many as stay distinguishable when the spring is compressed."""


class HartungDrawing(HartungProportions):
    """Drawing of a Hartung governor."""

    panel_readings = ("spring_force", "sleeve_lift", "spindle_speed", "lever_angle")
    plan_caption = ("from above,", "marked: the", "right weight")

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the spindle in its bearings, the frame with fulcrums and spring seats, and the lift scale."""
        u, w = self.arm, self.spindle_ratio * self.arm
        collar_height, top = _spindle_collar_height(self), self.weight_size[1] + 0.34 * u
        yield from parts.spindle_shapes(w, (collar_height - 0.92 * u, top + 0.2 * u), collar_height - 0.34 * u, top + 0.08 * u)
        for heights in ((top - 0.16 * u, top), (collar_height - 0.26 * u, collar_height - 0.10 * u)):
            yield from parts.hatched_pair_shapes("bearing", (w, 0.42 * u), heights, 0.09 * u)
        yield make_rectangle("spindle", -1.7 * w, 1.7 * w, collar_height - 0.10 * u, collar_height - 0.04 * u)
        yield from _frame_shapes(self)
        yield from _static_effect_shapes(self)
        if not self.is_magnified:
            ticks = parts.lift_ticks(self.reading_range(parts.LIFT_READING), self.zero_lift_height, 0.1 * u, 0.3 * u)
            yield from parts.lift_scale_shapes(self.sleeve_size[0] + 0.38 * u, ticks, (0.14 * u, 0.08 * u, 0.18 * u, 0.9 * u))
        yield from spindle_drive_shapes(collar_height - 0.34 * u, _GEAR_UNIT * u)
        yield from self.throttle_gear.background_shapes()
        yield from parts.shoe_key_shapes(self, (-2.3 * u, collar_height), _GEAR_UNIT * u)

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
        """Yield sleeve, hangers, weights, bell cranks and springs; the right half covers the left one."""
        u, sides, height = self.arm, self.sides(pose), float(self.sleeve_height(pose))
        yield from _moving_effect_shapes(self, height, time)
        yield from _sleeve_shapes(self, height)
        yield from self.throttle_gear.moving_shapes(height - self.fork_depth)
        yield from (_bore_shape(self, side) for side in sides)
        # The strands of the springs behind the cross rod and in front of it; the walls of the weights hide rod and springs.
        behind, front = (tuple(chain.from_iterable(pair)) for pair in zip(*(_coil_strands(self, side) for side in sides), strict=True))
        yield Lines("coil behind", behind)
        seat, half_rod = self.spring_seat_radius, _ROD_HALF_WIDTH * u
        yield make_rectangle("rod", -seat, seat, -half_rod, half_rod)
        yield from (Lines(role, front) for role in ("coil edge", "coil"))
        yield from (shape for side in sides for shape in _weight_shapes(self, side))
        yield from (shape for side in sides for shape in _crank_shapes(self, side))
        pivots = [point for side in sides for point in (side.fulcrum, side.sleeve_arm_end, side.lug)]
        yield from (Circle("pivot", *point, _PIVOT_RADIUS * u) for point in pivots)
        yield from _impact_shapes(self, sides, time)

    @cached_property
    def throttle_gear(self) -> ThrottleGear:
        """The throttle that the sleeve moves."""
        u, (low, high), half_width = self.arm, self.lug_height_range, self.sleeve_size[0]
        return ThrottleGear(
            unit=_GEAR_UNIT * u,
            side=1.0,
            pin_range=(low - self.fork_depth, high - self.fork_depth),
            strap_half_width=0.66 * half_width,
            pivot_distance=max(0.42 * _GEAR_UNIT * u, half_width + 0.3 * u),
            valve_height=_spindle_collar_height(self) - 0.1 * u,
        )

    @property
    def fork_depth(self) -> float:
        """Depth of the groove for the fork below the eyes of the sleeve (m)."""
        return self.sleeve_size[1] - (_GROOVE_BASE + 0.5 * _GROOVE_HEIGHT) * self.arm

    def plan_shapes(self, pose: FloatArray, angle: float) -> Iterator[DrawnShape]:
        """Yield weights, cross rod and sleeve from above; a mark identifies the right weight."""
        (w, h), seat, axes = self.weight_size, self.spring_seat_radius, (0.0, 0.0, angle)
        left, right = (side.weight[0] for side in self.sides(pose))
        yield Lines("plan arm", ((axes_to_plane(axes, -seat, 0.0), axes_to_plane(axes, seat, 0.0)),))
        for x in (left, right):
            yield make_box("weight section", axes, (x - w, x + w, -h, h))
        yield Circle("sleeve", 0.0, 0.0, 0.3 * self.arm)
        yield Circle("ball", *axes_to_plane(axes, right, 0.0), 0.3 * h)


def _weight_axes(governor: HartungProportions, side: HartungSide) -> PoseTuple:
    """Return the axes of a weight, with x outward at the right; it stays upright or rotates with its arm."""
    cranks = governor.find_effect(BellCrankMasses)
    is_tilted = cranks is not None and bool(cranks.weight_width or cranks.weight_height)
    return *side.weight, side.sign * side.lever_angle if is_tilted else 0.0


def _bore_shape(governor: HartungProportions, side: HartungSide) -> Polygon:
    """Return the bore of a weight for its spring, open outward."""
    (w, _), bore = governor.weight_size, governor.bore_half_height
    inner, outer = sorted((-side.sign * (1.0 - _WALL_RATIO) * w, side.sign * w))
    return make_box("weight bore", _weight_axes(governor, side), (inner, outer, -bore, bore))


def _weight_shapes(governor: HartungProportions, side: HartungSide) -> Iterator[DrawnShape]:
    """Yield a weight in section: the walls around its bore with their lining."""
    (w, h), bore, axes, sign = governor.weight_size, governor.bore_half_height, _weight_axes(governor, side), side.sign
    corner, wall = 0.12 * h, -(1.0 - _WALL_RATIO) * w
    half = [(wall, bore), (w, bore), (w, h - corner), (w - corner, h), (-w + corner, h), (-w, h - corner)]
    outline = [*half, *((x, -y) for x, y in reversed(half))]
    yield Polygon("weight section", place_points(axes, ((sign * x, y) for x, y in outline)))
    boxes = (-w + corner, w - corner, bore, h), (-w + corner, w - corner, -h, -bore), (-w, wall, -bore, bore)
    strokes = (stroke for box in boxes for stroke in make_hatching("weight section hatching", box, 0.12 * governor.arm).lines)
    yield Lines("weight section hatching", tuple(place_points(axes, ((sign * x, y) for x, y in stroke)) for stroke in strokes))


def _crank_shapes(governor: HartungProportions, side: HartungSide) -> Iterator[DrawnShape]:
    """Yield hanger and bell crank of one side; the boss of the crank is at the fulcrum."""
    u, (x, y) = governor.arm, side.lug
    yield make_bar("link", side.sleeve_arm_end, side.lug, _HANGER_WIDTH * u)
    if math.isinf(governor.hanger):
        half = 0.10 * u
        yield make_rectangle("block", x - half, x + half, y - 0.7 * half, y + 0.7 * half)
    yield from (make_bar("arm", side.fulcrum, end, _ARM_WIDTH * u) for end in (side.weight, side.sleeve_arm_end))
    yield Circle("arm", *side.fulcrum, 0.13 * u)


def _coil_strands(governor: HartungProportions, side: HartungSide) -> tuple[tuple[tuple[Vec2, ...], ...], tuple[tuple[Vec2, ...], ...]]:
    """Return the strands of a spring from the inner wall of the weight to its seat: those behind the cross rod, those in front of it."""
    start = abs(side.weight[0]) - (1.0 - _WALL_RATIO) * governor.weight_size[0]
    pitch = (governor.spring_seat_radius - start) / _N_SPRING_TURNS
    half_height = 0.80 * governor.bore_half_height
    low = [(side.sign * (start + (k + 0.1) * pitch), -half_height) for k in range(_N_SPRING_TURNS)]
    high = [(side.sign * (start + (k + 0.55) * pitch), half_height) for k in range(_N_SPRING_TURNS)]
    return tuple(zip(high[:-1], low[1:], strict=True)), tuple(zip(low, high, strict=True))


def _frame_shapes(governor: HartungProportions) -> Iterator[DrawnShape]:
    """Yield the beam with the fulcrums, keyed to the spindle, and the hub and end plates of the cross rod."""
    u, x, y = governor.arm, governor.fulcrum_radius, governor.fulcrum_height
    plate, bore, seat = 0.06 * u, governor.bore_half_height, governor.spring_seat_radius
    yield make_rectangle("frame", -0.2 * u, 0.2 * u, y - 0.12 * u, 0.12 * u)
    yield make_bar("frame", (-x, y), (x, y), 0.19 * u)
    yield from (make_rectangle("seat", *side, -1.05 * bore, 1.05 * bore) for side in reversed(parts.both_sides(seat, seat + plate)))
    yield from (make_rectangle("rod", *side, -0.11 * u, 0.11 * u) for side in reversed(parts.both_sides(seat + plate, seat + 2.4 * plate)))


def _sleeve_shapes(governor: HartungProportions, height: float) -> Iterator[DrawnShape]:
    """Yield head, collar with the groove for the fork, and a pointer; vertical hangers slide in a slot of the head."""
    u, (half_width, drop) = governor.arm, governor.sleeve_size
    head_half_height, base = 0.14 * u, height - drop
    neck, waist_half_width = 0.62 * half_width, 0.72 * half_width
    waist, neck_base = height - 1.6 * head_half_height, base + _GROOVE_BASE * u
    neck_top = neck_base + _GROOVE_HEIGHT * u
    head = (half_width, height + head_half_height), (half_width, height - head_half_height)
    collar = (neck, neck_top), (neck, neck_base), (0.9 * half_width, neck_base), (0.9 * half_width, base)
    yield Polygon("sleeve", parts.mirror_outline((*head, (waist_half_width, waist), (waist_half_width, neck_top), *collar)))
    strokes = (((part * half_width, waist - 0.02 * u), (part * half_width, neck_top + 0.02 * u)) for part in (0.44, 0.56, 0.65))
    yield Lines("engraving", tuple(strokes))
    x, y = half_width - 0.06 * u, 0.065 * u
    slot = ((-x, height - y), (x, height - y), (x, height + y), (-x, height + y))
    yield Polygon("slot", slot if math.isinf(governor.hanger) else ())
    tip = half_width + 0.34 * u
    yield Polygon("pointer", ((tip, height), (tip - 0.2 * u, height + 0.08 * u), (tip - 0.2 * u, height - 0.08 * u)))


def _spindle_collar_height(governor: HartungProportions) -> float:
    """Return the height (m) of the lower spindle collar, below the sleeve at its lowest."""
    u, gap = governor.arm, 0.14 * governor.arm
    if governor.find_lift_effect(DryFriction):
        gap += _SHOE_HEIGHT * u
    if governor.find_lift_effect(OutputSpring):
        gap += 0.9 * u
    return governor.lug_height_range[0] - governor.sleeve_size[1] - gap


def _static_effect_shapes(governor: HartungProportions) -> Iterator[DrawnShape]:
    """Yield the shapes fixed to the frame: weight stops, dashpot cylinder and spring seat."""
    u = governor.arm
    if stops := governor.find_effect(Stops, *_WEIGHT_READINGS):
        yield from _weight_stop_shapes(governor, stops)
    yield from parts.cylinder_shapes(governor)
    if governor.find_lift_effect(OutputSpring):
        y = _spindle_collar_height(governor)
        yield make_rectangle("seat", -0.45 * u, 0.45 * u, y - 0.04 * u, y)


def _moving_effect_shapes(governor: HartungProportions, height: float, time: float) -> Iterator[DrawnShape]:
    """Yield the shapes that move with the sleeve, with its lugs at a height (m), at a time (s)."""
    u, base = governor.arm, height - governor.sleeve_size[1]
    w = governor.spindle_ratio * u
    yield from parts.piston_shapes(governor, height, height)
    if governor.find_lift_effect(OutputSpring):
        yield Lines("spring", parts.helical_spring_lines((0.0, _spindle_collar_height(governor)), (0.0, base), 0.36 * u, w))
    yield from parts.spindle_shoe_shapes(governor, time, base, (0.2, _SHOE_HEIGHT))


def _impact_shapes(governor: HartungProportions, sides: list[HartungSide], time: float) -> Iterator[DrawnShape]:
    """Yield rays where a weight has just struck its stop."""
    if stops := governor.find_effect(Stops, *_WEIGHT_READINGS):
        struck_side = governor.struck_side(stops.reading, time)
        is_inner_stop = (struck_side > 0) == (stops.reading == "lever_angle")  # the lever angle increases inward
        face = -governor.weight_size[0] if is_inner_stop else governor.weight_size[0]
        points = [(side.sign * (abs(side.weight[0]) + face), _stop_height(governor)) for side in sides]
        yield make_burst("burst", points if struck_side else [], 0.3 * governor.arm)


def _stop_height(governor: HartungProportions) -> float:
    """Return the height (m) at which the weights meet their stops."""
    return 0.5 * (governor.bore_half_height + governor.weight_size[1])


def _stop_radii(governor: HartungProportions, stops: Stops) -> Vec2:
    """Return the radii (m) of the weight centres at the inner and outer stop; not finite where there is no stop."""
    if stops.reading == "weight_radius":
        return stops.low, stops.high
    inner, outer = (governor.weight_radius(angle) if math.isfinite(angle) else math.nan for angle in (stops.high, stops.low))
    return inner, outer


def _weight_stop_shapes(governor: HartungProportions, stops: Stops) -> Iterator[DrawnShape]:
    """Yield the blocks that stop the weights: inside on a post of the hub, outside on brackets from the spring seats."""
    u, y, (weight_half_width, weight_half_height) = governor.arm, _stop_height(governor), governor.weight_size
    inner_radius, outer_radius = _stop_radii(governor, stops)
    half_height = min(_STOP_HALF_HEIGHT * u, 0.8 * (weight_half_height - governor.bore_half_height) / 2)
    inner, outer = inner_radius - weight_half_width, outer_radius + weight_half_width
    if math.isfinite(inner):
        hub_face = max(inner - 0.16 * u, -0.2 * u) if inner > 0.05 * u else inner - 0.1 * u
        post = max(hub_face, 1.5 * governor.spindle_ratio * u)
        yield make_rectangle("frame", -post, post, 0.12 * u, y + 0.5 * half_height)
        near, far = sorted((max(hub_face, 0.02 * u), inner))
        yield from parts.hatched_pair_shapes("stop", (near, far), (y - half_height, y + half_height), 0.07 * u)
    if math.isfinite(outer):
        plate = governor.spring_seat_radius + 0.03 * u
        for sign, sides in zip((-1.0, 1.0), parts.both_sides(outer, outer + 0.13 * u), strict=True):
            yield make_bar("frame", (sign * outer + sign * 0.1 * u, y), (sign * plate, y), 0.11 * u)
            yield make_bar("frame", (sign * plate, 0.9 * governor.bore_half_height), (sign * plate, y), 0.09 * u)
            yield from make_hatched_block("stop", (0.0, 0.0, 0.0), (*sides, y - half_height, y + half_height), 0.07 * u)
