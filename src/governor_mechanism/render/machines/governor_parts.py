"""Parts that the drawings of governors share: spindle, bearings, lift scale, dashpot, springs, friction shoes, and the throttle gear."""

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, ClassVar

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.model.output_variables import FollowerHeight, PointCoordinate
from governor_mechanism.render.geometry.attached import Attached, Frame, Moment, axes_along, axes_shifted, fixed, once_per_moment
from governor_mechanism.render.geometry.outlines import make_bar, make_hatched_block, make_rectangle, make_wall
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    PoseTuple,
    TextShape,
    Vec2,
    arc_points,
    axes_to_plane,
    place_points,
    round_step,
)
from governor_mechanism.render.machines.machine_drawing import Dimension, MachineDrawing
from governor_mechanism.render.part_run import EffectT, PartRun
from governor_mechanism.types import FloatArray

LIFT_READING = "sleeve_lift"

LiftTicks = list[tuple[float, float]]
"""Lift (mm) and height (m) of each tick of a lift scale."""


@dataclass(frozen=True, kw_only=True)
class CylinderSizes:
    """Sizes of a dashpot cylinder next to the sleeve, as fractions of the arm.

    `axis_distance` is that of its axis from the sleeve. It is longer than the stroke by `extra_length`. `gap` is the free height above the
    oil and the depth of the hatched base.
    """

    half_width: float
    axis_distance: float
    extra_length: float
    min_length: float
    wall: float
    gap: float


@dataclass(frozen=True, kw_only=True)
class PistonSizes:
    """Sizes of the piston of a dashpot and its rod, as fractions of the arm.

    `clearance` is that to the outside of the cylinder, `lowest` the lowest height above the bottom; the bracket joins rod and sleeve.
    """

    clearance: float
    lowest: float
    thickness: float
    rod_half_width: float
    bracket_width: float


class GovernorDrawing(MachineDrawing):
    """What the drawings of all governors have in common. `spindle_ratio` is the half width of the spindle, as a fraction of the arm."""

    shows_bodies = True
    spindle_ratio: ClassVar[float]
    cylinder: ClassVar[CylinderSizes]
    piston: ClassVar[PistonSizes]

    arm: ClassVar[Dimension]
    lug_offset = Dimension("lug_offset")
    sleeve_mass = Dimension("sleeve_mass")

    @property
    @abstractmethod
    def sleeve_size(self) -> Vec2:
        """Half width of the sleeve, and its depth below the lugs (m)."""

    @property
    @abstractmethod
    def dashpot_top(self) -> float:
        """Height of the top of a dashpot next to the sleeve (m)."""

    @property
    @abstractmethod
    def fork_depth(self) -> float:
        """Depth of the pin of the throttle's fork below the lugs (m)."""

    @property
    @abstractmethod
    def throttle_gear(self) -> "ThrottleGear":
        """The throttle that the sleeve moves."""

    @abstractmethod
    def sides(self, pose: FloatArray) -> list[Any]:
        """Return the left and the right half at a pose (bodies, 3), as records of the places of their joints (m)."""

    @abstractmethod
    def sleeve_height(self, poses: FloatArray) -> FloatArray:
        """Return the height (...) of the sleeve lugs (m) at poses (..., bodies, 3)."""

    @cached_property
    def zero_lift_height(self) -> float:
        """Lug height at zero lift (m)."""
        lift = self.part.mechanism.reading(LIFT_READING)
        return lift.zero if isinstance(lift, PointCoordinate | FollowerHeight) else 0.0

    def sleeve_axes(self, moment: Moment) -> PoseTuple:
        """Return the axes of the sleeve at a moment; their origin is at the height of the lugs."""
        return 0.0, float(self.sleeve_height(moment.pose)), 0.0

    @cached_property
    def first_height(self) -> float:
        """Lug height at the first moment (m)."""
        return self.sleeve_axes(self.first_moment)[1]

    @cached_property
    def lug_height_range(self) -> Vec2:
        """Lowest and highest lug height of the run (m)."""
        low, high = self.reading_range(LIFT_READING)
        return self.zero_lift_height + low, self.zero_lift_height + high

    @property
    def fork_pin_range(self) -> Vec2:
        """Lowest and highest height of the pin of the throttle's fork in the run (m)."""
        low, high = self.lug_height_range
        return low - self.fork_depth, high - self.fork_depth

    def throttle_parts(self) -> Iterator[Attached]:
        """Yield what moves of the throttle gear."""
        return self.throttle_gear.moving_parts(lambda moment: self.sleeve_axes(moment)[1] - self.fork_depth)

    def drive_parts(self, top: float, unit: float) -> Iterator[Attached]:
        """Yield the drive of the spindle below a height (m), what is fixed of the throttle gear, and the key of friction shoes."""
        yield fixed(spindle_drive_shapes(top, unit))
        yield fixed(self.throttle_gear.background_shapes())
        key_left = _KEY_LEFT_OF_AXIS if self.throttle_gear.side > 0.0 else _KEY_RIGHT_OF_PULLEY
        yield fixed(_shoe_key_shapes(self, key_left * unit, top - _PITCH_RADIUS * unit, unit))

    @once_per_moment
    def sides_at(self, moment: Moment) -> list[Any]:
        """Return the left and the right half at a moment."""
        return self.sides(moment.pose)

    def place_of(self, number: int, joint: str, moment: Moment) -> Vec2:
        """Return where a joint of the left (0) or the right (1) half is at a moment (m)."""
        place: Vec2 = getattr(self.sides_at(moment)[number], joint)
        return place

    def axes_at(self, joint: str) -> list[Frame]:
        """Return axes that move with a joint of the left and of the right half and stay upright, as the light on a ball does."""
        return [axes_shifted(partial(self.place_of, number, joint)) for number in (0, 1)]

    def axes_between(self, first: str, second: str) -> list[Frame]:
        """Return axes from one joint to another of the left and of the right half."""
        return [axes_along(partial(self._ends_at, number, first, second)) for number in (0, 1)]

    def _ends_at(self, number: int, first: str, second: str, moment: Moment) -> tuple[Vec2, Vec2]:
        return self.place_of(number, first, moment), self.place_of(number, second, moment)

    def find_lift_effect(self, kind: type[EffectT]) -> EffectT | None:
        """Return the effect of a kind on the sleeve lift, if the scene has one."""
        return self.find_effect(kind, LIFT_READING)


def both_sides(inner: float, outer: float) -> tuple[Vec2, Vec2]:
    """Return left and right of an interval of radii (m) on both sides of the axis."""
    return (-outer, -inner), (inner, outer)


def mirror_outline(outline: Sequence[Vec2]) -> tuple[Vec2, ...]:
    """Return the closed outline of a right half (m)."""
    return (*outline, *((-x, y) for x, y in reversed(outline)))


def spindle_shapes(half_width: float, axis: Vec2, bottom: float, top: float) -> Iterator[DrawnShape]:
    """Yield the axis between two heights, and the shaded spindle from bottom to top (m)."""
    yield Lines("axis", (((0.0, axis[0]), (0.0, axis[1])),))
    yield make_rectangle("spindle", -half_width, half_width, bottom, top)
    yield Lines("spindle shade", (((0.45 * half_width, bottom), (0.45 * half_width, top)),))


def hatched_pair_shapes(role: str, radii: Vec2, heights: Vec2, spacing: float) -> Iterator[DrawnShape]:
    """Yield two hatched blocks at the sides of the spindle, between two radii and two heights (m): a bearing or a stop in section."""
    for sides in both_sides(*radii):
        yield from make_hatched_block(role, (0.0, 0.0, 0.0), (*sides, *heights), spacing)


def lift_ticks(lifts: Vec2, zero_height: float, min_range: float, min_length: float) -> LiftTicks:
    """Return ticks that cover the lifts (m), lowest and highest, on a scale long enough for two numbers without overlap."""
    low, high = lifts
    step = round_step(max(high - low, min_range), 5)
    first = math.floor(low / step + 1e-9)
    last = max(math.ceil(high / step - 1e-9), first + math.ceil(min_length / step))
    return [(k * step * 1e3, k * step + zero_height) for k in range(first, last + 1)]


def lift_scale_shapes(x: float, ticks: LiftTicks, sizes: tuple[float, float, float, float]) -> list[DrawnShape]:
    """Return a lift scale at x (m); `sizes` are the lengths of end ticks and other ticks, text distance and text width (m)."""
    end_length, length, text_distance, text_width = sizes
    ends = ticks[0], ticks[-1]
    lines = [((x, y), (x + (end_length if tick in ends else length), y)) for tick in ticks for y in tick[1:]]
    labels = [
        TextShape("scale", x + text_distance, y, f"{lift:.6g}{unit}", text_width) for (lift, y), unit in zip(ends, ("", " mm"), strict=True)
    ]
    return [Lines("scale", (((x, ends[0][1]), (x, ends[1][1])), *lines)), *labels]


def friction_shoe_parts(run: PartRun, reading: str, shoes: Attached) -> Iterator[Attached]:
    """Yield shoes on the contact of a reading once for sliding and once for sticking, of which one set is there."""
    for role, is_held in (("shoe", False), ("held shoe", True)):
        shapes = tuple(replace(shape, role=role) for shape in shoes.shapes)
        yield replace(shoes, shapes=shapes, shown=partial(_holds, run, reading, is_held))


def _holds(run: PartRun, reading: str, is_held: bool, moment: Moment) -> bool:
    """Return whether a reading is held at a moment, or whether it is not."""
    return run.is_held(reading, moment.time) == is_held


def spindle_shoe_parts(governor: GovernorDrawing, depth: float, sizes: Vec2) -> Iterator[Attached]:
    """Yield friction shoes under the sleeve, at a depth below its lugs (m); `sizes` are width and height, as fractions of the arm."""
    if not governor.find_lift_effect(DryFriction):
        return
    u, (width, height) = governor.arm, sizes
    sides = both_sides(governor.spindle_ratio * u, (governor.spindle_ratio + width) * u)
    shoes = tuple(make_rectangle("shoe", left, right, -depth - height * u, -depth) for left, right in sides)
    yield from friction_shoe_parts(governor, LIFT_READING, Attached(frame=governor.sleeve_axes, shapes=shoes, turns=False))


def ball_parts(axes: Sequence[Frame], radius: float) -> Iterator[Attached]:
    """Yield balls of a radius (m) at the origins of axes, and the light on them."""
    yield from (Attached(frame=one, shapes=(Circle("ball", 0.0, 0.0, radius),)) for one in axes)
    yield from (Attached(frame=one, shapes=(_ball_shine(radius),), section_only=True) for one in axes)


def _ball_shine(radius: float) -> Lines:
    """Return two arcs inside the upper left rim of a ball of a radius (m) around the origin: the highlight of a sphere."""
    arcs = (
        arc_points((0.0, 0.0), math.radians(135 - half), math.radians(2 * half), ratio * radius, 12)
        for ratio, half in ((0.78, 42.0), (0.60, 30.0))
    )
    return Lines("ball shine", tuple(arcs))


def _shoe_key_shapes(governor: GovernorDrawing, left: float, middle: float, unit: float) -> Iterator[DrawnShape]:
    """Yield what the colours of friction shoes mean, from a left edge on, about a height (m); nothing without dry friction."""
    if not governor.find_effect(DryFriction):
        return
    half = 0.0275 * unit
    for role, text, y in (("held shoe", "holds", middle + _KEY_ROW * unit), ("shoe", "slides", middle - _KEY_ROW * unit)):
        yield make_rectangle(f"{role} key", left, left + 2.0 * half, y - half, y + half)
        yield TextShape("scale", left + 3.0 * half, y, text, 0.3 * unit)


def _cylinder_box(governor: GovernorDrawing) -> BoundingBox:
    """Return left, right, bottom and top of the cylinder of a dashpot (m)."""
    sizes, u = governor.cylinder, governor.arm
    low, high = governor.lug_height_range
    x = -(governor.sleeve_size[0] + sizes.axis_distance * u)
    bottom = governor.dashpot_top - max(high - low + sizes.extra_length * u, sizes.min_length * u)
    return x - sizes.half_width * u, x + sizes.half_width * u, bottom, governor.dashpot_top


def cylinder_shapes(governor: GovernorDrawing) -> Iterator[DrawnShape]:
    """Yield an open cylinder filled with oil on a hatched base, if a dashpot acts on the sleeve."""
    if governor.find_lift_effect(Dashpot):
        left, right, bottom, top = _cylinder_box(governor)
        t, gap = governor.cylinder.wall * governor.arm, governor.cylinder.gap * governor.arm
        yield make_rectangle("dashpot", left, right, bottom, top)
        yield make_rectangle("bore", left + t, right - t, bottom + t, top)
        yield make_rectangle("oil", left + t, right - t, bottom + t, top - gap)
        yield make_wall(((left + right) / 2, bottom), math.pi / 2, 1.35 * (right - left) / 2, gap)


def throttle_pivot_distance(governor: GovernorDrawing, distance: float, gap: float) -> float:
    """Return the distance from the axis (m) of the pivot of a lever at the left: `distance`, or beyond a dashpot by `gap` (m)."""
    if not governor.find_lift_effect(Dashpot):
        return distance
    return max(distance, gap - _cylinder_box(governor)[0])


def piston_parts(governor: GovernorDrawing, rod_depth: float) -> Iterator[Attached]:
    """Yield the piston of a dashpot, its rod, and the bracket to the sleeve from the top of the rod, at a depth below the lugs (m)."""
    if governor.find_lift_effect(Dashpot):
        yield governor.attach(governor.sleeve_axes, _piston_shapes(governor, governor.first_height, rod_depth), turns=False)


def _piston_shapes(governor: GovernorDrawing, height: float, rod_depth: float) -> Iterator[DrawnShape]:
    """Yield piston, rod and bracket for a sleeve with its lugs at a height (m)."""
    rod_top = height - rod_depth
    sizes = governor.piston
    u = governor.arm
    left, right, bottom, _ = _cylinder_box(governor)
    x = (left + right) / 2
    y = bottom + sizes.lowest * u + (height - governor.lug_height_range[0])
    clearance = sizes.clearance * u
    rod = sizes.rod_half_width * u
    yield make_rectangle("piston rod", x - rod, x + rod, y, rod_top)
    yield make_rectangle("piston", left + clearance, right - clearance, y, y + sizes.thickness * u)
    yield make_bar("piston rod", (x, rod_top), (-0.9 * governor.sleeve_size[0], rod_top), sizes.bracket_width * u)


# Lengths as fractions of the unit of the drive.
_PITCH_RADIUS = 0.105
_FACE_WIDTH = 0.05
_SHAFT_HALF_WIDTH = 0.018
_SHAFT_END = 0.60
_BEARING_LEFT = 0.22
_BEARING_RIGHT = 0.31
_BEARING_HEIGHT = 0.05
_PULLEY_LEFT = 0.42
_PULLEY_RIGHT = 0.56
_PULLEY_RADIUS = 0.13
_KEY_RIGHT_OF_PULLEY, _KEY_LEFT_OF_AXIS = 0.63, -0.70
_KEY_ROW = 0.075
_TEETH = (-0.8, -0.55, -0.25, 0.05, 0.35, 0.6, 0.82)
"""Places of the drawn teeth across a wheel, as fractions of its pitch radius."""


def spindle_drive_shapes(top: float, unit: float) -> Iterator[DrawnShape]:
    """Yield two bevel wheels below a height `top` (m), the shaft to the right, its bearing, and its pulley; `unit` (m) sizes them."""
    radius = _PITCH_RADIUS * unit
    face = _FACE_WIDTH * unit
    half = _SHAFT_HALF_WIDTH * unit
    apex = top - radius
    for bottom, height in ((apex + half, _BEARING_HEIGHT * unit), (apex - half - _BEARING_HEIGHT * unit, _BEARING_HEIGHT * unit)):
        box = (_BEARING_LEFT * unit, _BEARING_RIGHT * unit, bottom, bottom + height)
        block, lining = make_hatched_block("bearing", (0.0, 0.0, 0.0), box, 0.03 * unit)
        yield Polygon("gearing bearing", block.points)
        yield Lines("gearing hatching", lining.lines)
    yield make_rectangle("gearing shaft", radius, _SHAFT_END * unit, apex - half, apex + half)
    pulley = (_PULLEY_LEFT * unit, _PULLEY_RIGHT * unit, apex - _PULLEY_RADIUS * unit, apex + _PULLEY_RADIUS * unit)
    yield make_rectangle("gearing wheel", *pulley)
    middle = 0.5 * (pulley[0] + pulley[1])
    yield Lines("gearing tooth", (((middle, pulley[2]), (middle, pulley[3])),))
    yield from _bevel_wheel(radius, face, apex, upright=True)
    yield from _bevel_wheel(radius, face, apex, upright=False)


def _bevel_wheel(radius: float, face: float, apex: float, *, upright: bool) -> Iterator[DrawnShape]:
    """Yield a wheel whose pitch cone has its apex on the axis at a height (m): on the spindle if it is upright, else on the shaft."""

    def place(across: float, along: float) -> Vec2:
        """Return a point at distances from the axis of the wheel and along it from the apex (m)."""
        return (across, apex + along) if upright else (along, apex + across)

    inner = radius - face
    yield Polygon("gearing wheel", tuple(place(*point) for point in ((-radius, radius), (radius, radius), (inner, inner), (-inner, inner))))
    hub = ((-0.5 * radius, radius), (0.5 * radius, radius), (0.5 * radius, 1.25 * radius), (-0.5 * radius, 1.25 * radius))
    yield Polygon("gearing wheel", tuple(place(*point) for point in hub))
    teeth = tuple((place(part * inner, inner), place(part * radius, radius)) for part in _TEETH)
    yield Lines("gearing tooth", teeth)


# Lengths as fractions of the unit of the gear.
_MIN_HALF_LIFT = 0.11
"""Half the smallest lift for which the gear is designed: a smaller one turns the valve by less."""
_VALVE_ARM, _MIN_ROD = 0.12, 0.36
_SWING = math.radians(38)
"""Angle by which the valve turns to either side over the lift for which the gear is designed (rad)."""
_CLOSING_ANGLE = math.radians(47)
"""Angle of the plate to its pipe when the sleeve is in the middle of its travel (rad)."""
_PIPE_HALF_LENGTH = 0.17
_PIPE_HALF_HEIGHT = 0.072
_WALL_THICKNESS = 0.022
_LEVER_WIDTH = 0.046
_ROD_WIDTH = 0.026
_PIN_RADIUS = 0.017
_FORK_END = 0.045
_STRAP_HEIGHT = 0.055
_POST_WIDTH, _POST_HEIGHT = 0.05, 0.22


@dataclass(frozen=True, kw_only=True)
class ThrottleGear:
    """A forked lever, a rod and a throttle valve, moved by a pin on the sleeve at the spindle's axis."""

    unit: float  # length (m) that sizes the parts
    side: float  # -1 for a gear at the left of the spindle, 1 at the right
    pin_range: Vec2  # lowest and highest height of the pin over the run, m
    strap_half_width: float  # half the width of the strap around the sleeve, m
    pivot_distance: float  # distance of the lever's fixed pivot from the axis, m
    valve_height: float  # highest height of the throttle valve, m

    @cached_property
    def pivot(self) -> Vec2:
        """Fixed pivot of the lever (m), at the middle height of the pin."""
        return self.side * self.pivot_distance, 0.5 * (self.pin_range[0] + self.pin_range[1])

    @cached_property
    def _half_lift(self) -> float:
        return max(0.5 * (self.pin_range[1] - self.pin_range[0]), _MIN_HALF_LIFT * self.unit)

    @cached_property
    def outer_arm(self) -> float:
        """Length of the lever beyond its pivot (m), such that the valve turns by its swing over the lift."""
        return _VALVE_ARM * self.unit * math.sin(_SWING) / math.sin(math.atan2(self._half_lift, self.pivot_distance))

    @cached_property
    def valve(self) -> Vec2:
        """Axis of the valve (m); its arm is level, and the rod upright, when the lever is level."""
        x, y = self.pivot
        return x + self.side * (self.outer_arm + _VALVE_ARM * self.unit), min(self.valve_height, y - _MIN_ROD * self.unit)

    @property
    def rod_length(self) -> float:
        """Length of the rod (m)."""
        return self.pivot[1] - self.valve[1]

    def lever_end(self, pin_height: float) -> Vec2:
        """Return the outer end of the lever (m) for a height of the pin (m)."""
        x, y = self.pivot
        angle = math.atan2(pin_height - y, self.pivot_distance)
        return x + self.side * self.outer_arm * math.cos(angle), y - self.outer_arm * math.sin(angle)

    def valve_arm_end(self, pin_height: float) -> Vec2:
        """Return the end of the valve's arm (m): where the circles of arm and rod meet, on the side of the pivot."""
        (x, y), (end_x, end_y) = self.valve, self.lever_end(pin_height)
        distance, heading = math.dist((x, y), (end_x, end_y)), math.atan2(end_y - y, end_x - x)
        arm, rod = _VALVE_ARM * self.unit, self.rod_length
        cosine = (arm**2 + distance**2 - rod**2) / (2 * arm * distance)
        return axes_to_plane((x, y, heading + self.side * math.acos(min(max(cosine, -1.0), 1.0))), arm, 0.0)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the post that carries the lever, and the pipe in section."""
        u, (x, y) = self.unit, self.pivot
        valve_x, valve_y = self.valve
        foot = y - _POST_HEIGHT * u
        yield make_bar("throttle post", (x, foot), (x, y), _POST_WIDTH * u)
        yield make_rectangle("throttle post", x - 0.06 * u, x + 0.06 * u, foot - 0.02 * u, foot + 0.01 * u)
        yield Lines("throttle ground", make_wall((x, foot - 0.02 * u), math.pi / 2, 0.10 * u, 0.03 * u).lines)
        left, right = valve_x - _PIPE_HALF_LENGTH * u, valve_x + _PIPE_HALF_LENGTH * u
        half, wall = _PIPE_HALF_HEIGHT * u, _WALL_THICKNESS * u
        yield make_rectangle("throttle bore", left, right, valve_y - half, valve_y + half)
        for bottom in (valve_y - half - wall, valve_y + half):
            yield make_rectangle("throttle pipe", left, right, bottom, bottom + wall)

    def lever_axes(self, pin_height: float) -> PoseTuple:
        """Return the axes of the lever for a height of the pin (m): the origin is in its pivot, and x leads to the pin."""
        x, y = self.pivot
        return x, y, math.atan2(pin_height - y, -x)

    def valve_axes(self, pin_height: float) -> PoseTuple:
        """Return the axes of the valve for a height of the pin (m); x leads along its arm."""
        (x, y), (end_x, end_y) = self.valve, self.valve_arm_end(pin_height)
        return x, y, math.atan2(end_y - y, end_x - x)

    def moving_parts(self, pin_height: Callable[[Any], float]) -> Iterator[Attached]:
        """Yield strap, lever, rod and valve; `pin_height` is the height of the pin (m) at a moment."""
        strap_axes = axes_shifted(lambda moment: (0.0, pin_height(moment)))
        rod_axes = axes_along(lambda moment: (self.lever_end(pin_height(moment)), self.valve_arm_end(pin_height(moment))))

        def lever_axes(moment: Any) -> PoseTuple:
            return self.lever_axes(pin_height(moment))

        def valve_axes(moment: Any) -> PoseTuple:
            return self.valve_axes(pin_height(moment))

        yield _part(strap_axes, self._strap())
        yield _part(lever_axes, *self._lever_shapes())
        yield _part(valve_axes, *self._valve_shapes())
        yield _part(rod_axes, make_bar("throttle rod", (0.0, 0.0), (self.rod_length, 0.0), _ROD_WIDTH * self.unit))
        yield _part(strap_axes, self._pin((0.0, 0.0)))
        yield _part(lever_axes, self._pin((0.0, 0.0)), self._pin((-self.outer_arm, 0.0)))
        yield _part(valve_axes, self._pin((_VALVE_ARM * self.unit, 0.0)), self._pin((0.0, 0.0)))

    def _strap(self) -> Polygon:
        half = 0.5 * _STRAP_HEIGHT * self.unit
        return make_rectangle("throttle strap", -self.strap_half_width, self.strap_half_width, -half, half)

    def _lever_shapes(self) -> Iterator[DrawnShape]:
        """Yield the lever with its fork in its axes; the fork is slotted: the pin moves straight, the lever about its pivot."""
        u = self.unit
        reach = math.hypot(self.pivot_distance, 0.5 * (self.pin_range[1] - self.pin_range[0])) + _FORK_END * u
        yield make_bar("throttle lever", (-self.outer_arm, 0.0), (reach, 0.0), _LEVER_WIDTH * u)
        yield make_bar("throttle slot", (self.pivot_distance, 0.0), (reach - _FORK_END * u, 0.0), 2 * _PIN_RADIUS * u)

    def _valve_shapes(self) -> Iterator[DrawnShape]:
        """Yield plate and arm of the valve in its axes."""
        level = math.pi if self.side > 0 else 0.0
        plate = (0.0, 0.0, self.side * _CLOSING_ANGLE - level)
        half = (_PIPE_HALF_HEIGHT - 0.004) * self.unit
        yield Lines("throttle plate", (place_points(plate, ((-half, 0.0), (half, 0.0))),))
        yield make_bar("throttle rod", (0.0, 0.0), (_VALVE_ARM * self.unit, 0.0), 1.3 * _ROD_WIDTH * self.unit)

    def _pin(self, place: Vec2) -> Circle:
        return Circle("throttle pin", *place, _PIN_RADIUS * self.unit)


def _part(frame: Frame, *shapes: DrawnShape) -> Attached:
    """Return shapes in axes that move; none of them turns with the spindle."""
    return Attached(frame=frame, shapes=shapes, turns=False)
