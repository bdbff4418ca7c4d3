"""Drawing of Hartung's governor: hollow weights with springs, bell cranks, hangers, sleeve and spindle, and the effects on it.

The effects are weight stops, a dashpot, a sleeve spring and friction shoes.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain

import numpy as np

from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.machines.hartung import LEFT_WEIGHT, RIGHT_WEIGHT, SLEEVE
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Frame, Moment, fixed, once_per_moment
from governor_mechanism.render.geometry.outlines import (
    helical_spring_lines,
    make_bar,
    make_box,
    make_burst,
    make_hatched_block,
    make_hatching,
    make_rectangle,
)
from governor_mechanism.render.geometry.primitives import (
    CAST_IRON_DENSITY,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    PoseTuple,
    Vec2,
    axes_to_plane,
)
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.governor_parts import CylinderSizes, GovernorDrawing, PistonSizes, ThrottleGear
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.types import FloatArray

_NOMINAL_LEVER_SINE = 0.26
"""Sine of the lever angle for which weights and springs are proportioned."""


@dataclass(frozen=True, kw_only=True)
class HartungSide:
    """One half of the governor at one pose: its sign (-1 left, 1 right), lever angle (rad), and the positions of its joints (m)."""

    sign: float
    lever_angle: float
    fulcrum: Vec2
    weight: Vec2
    sleeve_arm_end: Vec2
    lug: Vec2


class HartungProportions(GovernorDrawing):
    """Dimensions of the drawing in m, kg and rad; `hanger` is infinite if the hangers stay vertical."""

    spindle_ratio = 0.115
    cylinder = CylinderSizes(half_width=0.24, axis_distance=0.50, extra_length=0.45, min_length=0.7, wall=0.05, gap=0.1)
    piston = PistonSizes(clearance=0.06, lowest=0.14, thickness=0.1, rod_half_width=0.04, bracket_width=0.1)

    arm = Dimension("weight_arm")
    sleeve_arm = Dimension("sleeve_arm")
    bell_crank_angle = Dimension("bell_crank_angle")
    fulcrum_radius = Dimension("fulcrum_radius")
    fulcrum_height = Dimension("fulcrum_height")
    hanger = Dimension("hanger")

    @cached_property
    def weight_size(self) -> Vec2:
        """Half width and half height of a weight (m): the given ones, or those of a block of cast iron with equal depth and height."""
        cranks = self.find_effect(BellCrankMasses)
        if cranks and cranks.weight_width and cranks.weight_height:
            return cranks.weight_width / 2, cranks.weight_height / 2
        half_width = 0.83 * max(self.fulcrum_radius - _NOMINAL_LEVER_SINE * self.arm, 0.3 * self.arm)
        half_height = 0.5 * math.sqrt(self.part.dimensions["weight_mass"] / (CAST_IRON_DENSITY * 2 * half_width))
        return half_width, min(max(half_height, 0.45 * self.arm), 0.82 * self.arm)

    @cached_property
    def spring_seat_radius(self) -> float:
        """Distance of the outer spring ends from the axis (m)."""
        outermost = max(self.reading_range("weight_radius")[1], self.fulcrum_radius + _NOMINAL_LEVER_SINE * self.arm)
        return outermost + self.weight_size[0] + 0.22 * self.arm

    @property
    def dashpot_top(self) -> float:
        """Height of the top of a dashpot next to the sleeve (m)."""
        return self.lug_height_range[0] - 0.45 * self.arm

    @property
    def bore_half_height(self) -> float:
        """Half height of the bore that holds the spring of a weight (m)."""
        return 0.48 * self.weight_size[1]

    @cached_property
    def sleeve_size(self) -> Vec2:
        """Half width, and depth below the lugs (m), of a cast-iron sleeve with the given mass, within the limits of a clear drawing."""
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON_DENSITY))
        min_radius = abs(self.lug_offset) + 0.22 * self.arm
        if math.isinf(self.hanger):
            ends = (self._sleeve_arm_end(angle)[0] for angle in self.reading_range("lever_angle"))
            min_radius = max(0.42 * self.arm, *(abs(end) + 0.11 * self.arm for end in ends))
        radius = max(min(max(radius, 0.45 * self.arm), 1.1 * self.arm), min_radius)
        return radius, 0.2 * self.arm + 1.0 * radius

    def _sleeve_arm_end(self, lever_angle: float) -> Vec2:
        """Return the end of the right sleeve arm at a lever angle (rad), m."""
        angle = self.bell_crank_angle + lever_angle
        return self.fulcrum_radius - self.sleeve_arm * math.sin(angle), self.fulcrum_height + self.sleeve_arm * math.cos(angle)

    def weight_radius(self, lever_angle: float) -> float:
        """Return the distance of a weight centre from the axis (m) at a lever angle (rad)."""
        return self.fulcrum_radius - self.arm * math.sin(lever_angle)

    def sleeve_height(self, poses: FloatArray) -> FloatArray:
        """Return the height (...) of the sleeve lugs (m) at poses (..., bodies, 3)."""
        height: FloatArray = poses[..., self.part.mechanism.body_index(SLEEVE), 1]
        return height

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the centre of the right weight."""
        lever_angle = poses[..., self.part.mechanism.body_index(RIGHT_WEIGHT), 2]
        x = self.fulcrum_radius - self.arm * np.sin(lever_angle)
        y = self.fulcrum_height + self.arm * np.cos(lever_angle)
        return np.stack([x, y], axis=-1)

    @cached_property
    def crank_axes(self) -> list[Frame]:
        """Axes of the left and the right bell crank, from the fulcrum to the weight."""
        return self.axes_between("fulcrum", "weight")

    @cached_property
    def hanger_axes(self) -> list[Frame]:
        """Axes of the left and the right hanger, from the bell crank to the sleeve."""
        return self.axes_between("sleeve_arm_end", "lug")

    @cached_property
    def weight_axes(self) -> list[Frame]:
        """Axes of the left and the right weight, with x outward at the right; it stays upright or rotates with its arm."""
        cranks = self.find_effect(BellCrankMasses)
        is_tilted = cranks is not None and bool(cranks.weight_width or cranks.weight_height)
        return [partial(self._weight_pose, number, is_tilted) for number in (0, 1)]

    def _weight_pose(self, number: int, is_tilted: bool, moment: Moment) -> PoseTuple:
        side = self.sides_at(moment)[number]
        return *side.weight, side.sign * side.lever_angle if is_tilted else 0.0

    def sides(self, pose: FloatArray) -> list[HartungSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        height = float(self.sleeve_height(pose))
        y = self.fulcrum_height
        sides = []
        for name, sign in ((LEFT_WEIGHT, -1.0), (RIGHT_WEIGHT, 1.0)):
            lever_angle = sign * float(pose[self.part.mechanism.body_index(name), 2])
            weight = self.weight_radius(lever_angle), y + self.arm * math.cos(lever_angle)
            arm_end = self._sleeve_arm_end(lever_angle)
            lug = arm_end[0] if math.isinf(self.hanger) else self.lug_offset, height
            fulcrum, weight, arm_end, lug = ((sign * px, py) for px, py in ((self.fulcrum_radius, y), weight, arm_end, lug))
            sides.append(HartungSide(sign=sign, lever_angle=lever_angle, fulcrum=fulcrum, weight=weight, sleeve_arm_end=arm_end, lug=lug))
        return sides


_WEIGHT_READINGS = ("lever_angle", "weight_radius")
"""Readings that determine the position of the weights."""
_STOP_HALF_HEIGHT = 0.16
"""Half height of the weight stops, as a fraction of the weight arm."""
_SHOE_HEIGHT = 0.20
# Widths and radii as fractions of the weight arm.
_ARM_WIDTH = 0.17
_HANGER_WIDTH = 0.12
_PIVOT_RADIUS = 0.055
_ROD_HALF_WIDTH = 0.05
_GROOVE_BASE, _GROOVE_HEIGHT = 0.14, 0.22
"""Height of the groove for the fork above the foot of the sleeve, and of the groove itself, as fractions of the weight arm."""
_GEAR_UNIT = 2.2
"""Length that sizes the throttle gear and the drive of the spindle, as a multiple of the weight arm."""
_WALL_RATIO = 0.28
"""Thickness of the inner wall of a weight, relative to its half width."""
_N_SPRING_TURNS = 8
"""Coils of each spring; as many as stay distinguishable when the spring is compressed."""


_Strands = tuple[tuple[Vec2, ...], ...]
"""Strands of a spring, m."""


class HartungDrawing(HartungProportions):
    """Drawing of a Hartung governor."""

    panel_readings = ("spring_force", "sleeve_lift", "spindle_speed", "lever_angle")
    plan_caption = ("from above,", "marked: the", "right weight")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the spindle in its bearings, the frame with fulcrums and spring seats, and the lift scale."""
        u, collar_height = self.arm, _spindle_collar_height(self)
        yield fixed(self._spindle_shapes(collar_height))
        yield fixed(_frame_shapes(self), turns=True)
        yield from _fixed_effect_parts(self)
        if not self.is_magnified:
            ticks = parts.lift_ticks(self.reading_range(parts.LIFT_READING), self.zero_lift_height, 0.1 * u, 0.3 * u)
            yield fixed(parts.lift_scale_shapes(self.sleeve_size[0] + 0.38 * u, ticks, (0.14 * u, 0.08 * u, 0.18 * u, 0.9 * u)))
        yield from self.drive_parts(collar_height - 0.34 * u, _GEAR_UNIT * u)

    def _spindle_shapes(self, collar_height: float) -> Iterator[DrawnShape]:
        """Yield the spindle in its bearings."""
        u = self.arm
        w = self.spindle_ratio * self.arm
        top = self.weight_size[1] + 0.34 * self.arm
        yield from parts.spindle_shapes(w, (collar_height - 0.92 * u, top + 0.2 * u), collar_height - 0.34 * u, top + 0.08 * u)
        for heights in ((top - 0.16 * u, top), (collar_height - 0.26 * u, collar_height - 0.10 * u)):
            yield from parts.hatched_pair_shapes("bearing", (w, 0.42 * u), heights, 0.09 * u)
        yield make_rectangle("spindle", -1.7 * w, 1.7 * w, collar_height - 0.10 * u, collar_height - 0.04 * u)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield sleeve, hangers, weights, bell cranks and springs; the right half covers the left one."""
        u = self.arm
        first_sides: list[HartungSide] = self.sides_at(self.first_moment)
        yield from _moving_effect_parts(self)
        yield Attached(frame=self.sleeve_axes, shapes=tuple(_sleeve_shapes(self)), turns=False)
        yield from self.throttle_parts()
        for number, side in enumerate(first_sides):
            yield Attached(frame=self.weight_axes[number], shapes=(_bore_shape(self, side),), section_only=True)
        # The strands of the springs behind the cross rod and in front of it; the walls of the weights hide rod and springs.
        yield Flexible(shapes_at=lambda moment: [Lines("coil behind", self._strands_at(moment)[0])], turns=True)
        seat, half_rod = self.spring_seat_radius, _ROD_HALF_WIDTH * u
        yield fixed([make_rectangle("rod", -seat, seat, -half_rod, half_rod)], turns=True)
        for role in ("coil edge", "coil"):
            yield Flexible(shapes_at=partial(self._front_coils, role), turns=True)
        for number, side in enumerate(first_sides):
            wall, lining = _weight_shapes(self, side)
            yield Attached(frame=self.weight_axes[number], shapes=(wall,))
            yield Attached(frame=self.weight_axes[number], shapes=(lining,), section_only=True)
        for number, side in enumerate(first_sides):
            yield from self._crank_parts(number, side)
        for number, side in enumerate(first_sides):
            points = (side.fulcrum, side.sleeve_arm_end)
            yield self.attach(self.crank_axes[number], [Circle("pivot", *point, _PIVOT_RADIUS * u) for point in points])
            yield self.attach(self.hanger_axes[number], [Circle("pivot", *side.lug, _PIVOT_RADIUS * u)])
        yield Flexible(shapes_at=lambda moment: _impact_shapes(self, self.sides_at(moment), moment.time))

    def _crank_parts(self, number: int, side: HartungSide) -> Iterator[Attached]:
        """Yield hanger and bell crank of one side; the boss of the crank is at the fulcrum."""
        u, (x, y) = self.arm, side.lug
        yield self.attach(self.hanger_axes[number], [make_bar("link", side.sleeve_arm_end, side.lug, _HANGER_WIDTH * u)])
        if math.isinf(self.hanger):
            half = 0.10 * u
            block = make_rectangle("block", x - half, x + half, y - 0.7 * half, y + 0.7 * half)
            yield self.attach(self.hanger_axes[number], [block])
        arms = [make_bar("arm", side.fulcrum, end, _ARM_WIDTH * u) for end in (side.weight, side.sleeve_arm_end)]
        yield self.attach(self.crank_axes[number], [*arms, Circle("arm", *side.fulcrum, 0.13 * u)])

    @once_per_moment
    def _strands_at(self, moment: Moment) -> tuple[_Strands, _Strands]:
        """Return the strands of both springs behind the cross rod, and those in front of it."""
        behind, front = zip(*(_coil_strands(self, side) for side in self.sides_at(moment)), strict=True)
        return tuple(chain.from_iterable(behind)), tuple(chain.from_iterable(front))

    def _front_coils(self, role: str, moment: Moment) -> list[DrawnShape]:
        return [Lines(role, self._strands_at(moment)[1])]

    @cached_property
    def throttle_gear(self) -> ThrottleGear:
        """The throttle that the sleeve moves."""
        u, half_width = self.arm, self.sleeve_size[0]
        return ThrottleGear(
            unit=_GEAR_UNIT * u,
            side=1.0,
            pin_range=self.fork_pin_range,
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
        w, h = self.weight_size
        seat = self.spring_seat_radius
        axes = (0.0, 0.0, angle)
        left, right = (side.weight[0] for side in self.sides(pose))
        yield Lines("plan arm", ((axes_to_plane(axes, -seat, 0.0), axes_to_plane(axes, seat, 0.0)),))
        for x in (left, right):
            yield make_box("weight section", axes, (x - w, x + w, -h, h))
        yield Circle("sleeve", 0.0, 0.0, 0.3 * self.arm)
        yield Circle("ball", *axes_to_plane(axes, right, 0.0), 0.3 * h)


def _bore_shape(governor: HartungProportions, side: HartungSide) -> Polygon:
    """Return the bore of a weight for its spring, open outward, in the axes of the weight."""
    (w, _), bore = governor.weight_size, governor.bore_half_height
    inner, outer = sorted((-side.sign * (1.0 - _WALL_RATIO) * w, side.sign * w))
    return make_rectangle("weight bore", inner, outer, -bore, bore)


def _weight_shapes(governor: HartungProportions, side: HartungSide) -> tuple[Polygon, Lines]:
    """Return a weight in section in its axes: the walls around its bore, and their lining."""
    w, h = governor.weight_size
    bore = governor.bore_half_height
    sign = side.sign
    corner, wall = 0.12 * h, -(1.0 - _WALL_RATIO) * w
    half = [(wall, bore), (w, bore), (w, h - corner), (w - corner, h), (-w + corner, h), (-w, h - corner)]
    outline = [*half, *((x, -y) for x, y in reversed(half))]
    boxes = (-w + corner, w - corner, bore, h), (-w + corner, w - corner, -h, -bore), (-w, wall, -bore, bore)
    strokes = (stroke for box in boxes for stroke in make_hatching("weight section hatching", box, 0.12 * governor.arm).lines)
    lining = tuple(tuple((sign * x, y) for x, y in stroke) for stroke in strokes)
    return Polygon("weight section", tuple((sign * x, y) for x, y in outline)), Lines("weight section hatching", lining)


def _coil_strands(governor: HartungProportions, side: HartungSide) -> tuple[_Strands, _Strands]:
    """Return the strands of a spring from the inner wall of the weight to its seat: those behind the cross rod, those in front of it."""
    start = abs(side.weight[0]) - (1.0 - _WALL_RATIO) * governor.weight_size[0]
    pitch = (governor.spring_seat_radius - start) / _N_SPRING_TURNS
    half_height = 0.80 * governor.bore_half_height
    low = [(side.sign * (start + (k + 0.1) * pitch), -half_height) for k in range(_N_SPRING_TURNS)]
    high = [(side.sign * (start + (k + 0.55) * pitch), half_height) for k in range(_N_SPRING_TURNS)]
    return tuple(zip(high[:-1], low[1:], strict=True)), tuple(zip(low, high, strict=True))


def _frame_shapes(governor: HartungProportions) -> Iterator[DrawnShape]:
    """Yield the beam with the fulcrums, keyed to the spindle, and the hub and end plates of the cross rod."""
    u = governor.arm
    x = governor.fulcrum_radius
    y = governor.fulcrum_height
    plate = 0.06 * u
    bore = governor.bore_half_height
    seat = governor.spring_seat_radius
    yield make_rectangle("frame", -0.2 * u, 0.2 * u, y - 0.12 * u, 0.12 * u)
    yield make_bar("frame", (-x, y), (x, y), 0.19 * u)
    yield from (make_rectangle("seat", *side, -1.05 * bore, 1.05 * bore) for side in reversed(parts.both_sides(seat, seat + plate)))
    yield from (make_rectangle("rod", *side, -0.11 * u, 0.11 * u) for side in reversed(parts.both_sides(seat + plate, seat + 2.4 * plate)))


def _sleeve_shapes(governor: HartungProportions) -> Iterator[DrawnShape]:
    """Yield head, collar with a groove for the fork, and pointer in the axes of the sleeve; upright hangers slide in a slot."""
    u, (half_width, drop) = governor.arm, governor.sleeve_size
    head_half_height, base = 0.14 * u, -drop
    neck, waist_half_width = 0.62 * half_width, 0.72 * half_width
    waist, neck_base = -1.6 * head_half_height, base + _GROOVE_BASE * u
    neck_top = neck_base + _GROOVE_HEIGHT * u
    head = (half_width, head_half_height), (half_width, -head_half_height)
    collar = (neck, neck_top), (neck, neck_base), (0.9 * half_width, neck_base), (0.9 * half_width, base)
    yield Polygon("sleeve", parts.mirror_outline((*head, (waist_half_width, waist), (waist_half_width, neck_top), *collar)))
    strokes = (((part * half_width, waist - 0.02 * u), (part * half_width, neck_top + 0.02 * u)) for part in (0.44, 0.56, 0.65))
    yield Lines("engraving", tuple(strokes))
    x, y = half_width - 0.06 * u, 0.065 * u
    slot = ((-x, -y), (x, -y), (x, y), (-x, y))
    yield Polygon("slot", slot if math.isinf(governor.hanger) else ())
    tip = half_width + 0.34 * u
    if not governor.is_magnified:  # without the scale beside it
        yield Polygon("pointer", ((tip, 0.0), (tip - 0.2 * u, 0.08 * u), (tip - 0.2 * u, -0.08 * u)))


def _spindle_collar_height(governor: HartungProportions) -> float:
    """Return the height (m) of the lower spindle collar, below the sleeve at its lowest."""
    u, gap = governor.arm, 0.14 * governor.arm
    if governor.find_lift_effect(DryFriction):
        gap += _SHOE_HEIGHT * u
    if governor.find_lift_effect(OutputSpring):
        gap += 0.9 * u
    return governor.lug_height_range[0] - governor.sleeve_size[1] - gap


def _fixed_effect_parts(governor: HartungProportions) -> Iterator[Attached]:
    """Yield what is fixed to the frame: weight stops, dashpot cylinder and spring seat."""
    u = governor.arm
    if stops := governor.find_effect(Stops, *_WEIGHT_READINGS):
        yield fixed(_weight_stop_shapes(governor, stops), turns=True)
    yield fixed(parts.cylinder_shapes(governor))
    if governor.find_lift_effect(OutputSpring):
        y = _spindle_collar_height(governor)
        yield fixed([make_rectangle("seat", -0.45 * u, 0.45 * u, y - 0.04 * u, y)])


def _moving_effect_parts(governor: HartungProportions) -> Iterator[DrawnPart]:
    """Yield the effects on the sleeve that move with it."""
    yield from parts.piston_parts(governor, 0.0)
    if governor.find_lift_effect(OutputSpring):
        yield Flexible(shapes_at=partial(_spring_shapes, governor))
    yield from parts.spindle_shoe_parts(governor, governor.sleeve_size[1], (0.2, _SHOE_HEIGHT))


def _spring_shapes(governor: HartungProportions, moment: Moment) -> list[DrawnShape]:
    """Return the spring between its seat and the foot of the sleeve."""
    u = governor.arm
    base = governor.sleeve_axes(moment)[1] - governor.sleeve_size[1]
    ends = (0.0, _spindle_collar_height(governor)), (0.0, base)
    return [Lines("spring", helical_spring_lines(*ends, 0.36 * u, governor.spindle_ratio * u))]


def _impact_shapes(governor: HartungProportions, sides: list[HartungSide], time: float) -> Iterator[DrawnShape]:
    """Yield rays where a weight has just struck its stop."""
    if stops := governor.find_effect(Stops, *_WEIGHT_READINGS):
        struck_side = governor.struck_side(stops.reading, time)
        is_inner_stop = (struck_side > 0) == (stops.reading == "lever_angle")  # the lever angle increases inward
        face = -governor.weight_size[0] if is_inner_stop else governor.weight_size[0]
        points = [(side.sign * (abs(side.weight[0]) + face), _stop_height(governor)) for side in sides]
        yield make_burst(points if struck_side else [], 0.3 * governor.arm)


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
    u = governor.arm
    y = _stop_height(governor)
    weight_half_width, weight_half_height = governor.weight_size
    inner_radius, outer_radius = _stop_radii(governor, stops)
    half_height = min(_STOP_HALF_HEIGHT * u, 0.8 * (weight_half_height - governor.bore_half_height) / 2)
    inner = inner_radius - weight_half_width
    outer = outer_radius + weight_half_width
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
