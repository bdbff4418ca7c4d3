"""Proportions of the drawings of pendulum governors, and the effects on them.

Only effects of the scene are drawn. Effects on the ball radius are shown on the arms.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Clearance, DryFriction, Stops
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.machines.pendulum import LEFT_BALL, RIGHT_BALL, SLEEVE
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Frame, Moment, fixed
from governor_mechanism.render.geometry.outlines import (
    helical_spring_lines,
    make_band,
    make_bar,
    make_burst,
    make_hatched_block,
    make_rectangle,
    spiral_points,
)
from governor_mechanism.render.geometry.primitives import (
    CAST_IRON_DENSITY,
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    Vec2,
    axes_to_plane,
    drawn_ball_radius,
)
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.governor_parts import LIFT_READING, CylinderSizes, GovernorDrawing, PistonSizes
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.types import FloatArray

ARM_WIDTH, LINK_WIDTH = 0.058, 0.042
"""Widths of an arm and of a link, as fractions of the arm."""
GROOVE_RATIO = 0.62
"""Half width of the groove of a light sleeve, as a fraction of the half width of the sleeve."""


@dataclass(frozen=True, kw_only=True)
class PendulumSide:
    """One half of the governor at one pose: the positions of its joints (m).

    The lug of the sleeve is at `link_end`, except for the clearance.
    """

    arm_pivot: Vec2
    link_joint: Vec2
    ball: Vec2
    link_end: Vec2


class PendulumProportions(GovernorDrawing):
    """Dimensions of the drawing in m and kg."""

    spindle_ratio = 0.030
    cylinder = CylinderSizes(half_width=0.075, axis_distance=0.16, extra_length=0.20, min_length=0.26, wall=0.016, gap=0.035)
    piston = PistonSizes(clearance=0.022, lowest=0.05, thickness=0.035, rod_half_width=0.013, bracket_width=0.036)

    arm = Dimension("arm")
    offset = Dimension("offset")
    arm_joint = Dimension("arm_joint")
    link = Dimension("link")

    @cached_property
    def ball_radius(self) -> float:
        """Radius of a ball (m): the given one, or that of a ball of cast iron."""
        rods = self.find_effect(RodMasses)
        return (rods.ball_radius if rods else 0.0) or drawn_ball_radius(self.part.dimensions["ball_mass"], self.arm)

    @cached_property
    def clearance(self) -> float:
        """Width of the slots in the sleeve (m)."""
        clearance = self.find_effect(Clearance)
        return clearance.width if clearance else 0.0

    @property
    def dashpot_top(self) -> float:
        """Height of the top of a dashpot next to the sleeve (m)."""
        return self.lug_height_range[0] - self.sleeve_size[1] - 0.06 * self.arm

    @cached_property
    def body_names(self) -> frozenset[str]:
        """Names of the bodies of the mechanism; a massless sleeve or link is none."""
        return frozenset(body.name for body in self.part.mechanism.bodies)

    @cached_property
    def sleeve_size(self) -> Vec2:
        """Half width, and depth below the lugs (m), of a cast-iron drum with the mass of the sleeve, or of a light collar."""
        u = self.arm
        if SLEEVE not in self.body_names:
            return max(0.115 * u, abs(self.lug_offset) + 0.06 * u), 0.24 * u
        # A cylinder with a height of 1.3 radii has this radius; very heavy or very light drums are drawn at a limit.
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON_DENSITY))
        radius = min(max(radius, 0.16 * u), 0.38 * u)
        return max(radius, abs(self.lug_offset) + 0.06 * u), 0.09 * u + 1.3 * radius

    @cached_property
    def spring_side(self) -> int:
        """1 for a spring above the sleeve, which pushes it down; -1 for one below, which carries it; 0 without a spring."""
        spring = self.find_lift_effect(OutputSpring)
        if spring is None:
            return 0
        return 1 if spring.free_value <= sum(self.reading_range(LIFT_READING)) / 2 else -1

    def ball_centres(self, poses: FloatArray, name: str = RIGHT_BALL) -> FloatArray:
        """Return the centre of a ball (..., 2) (m) at poses (..., bodies, 3); the mass centre of its body may be elsewhere."""
        body, centre = self.part.mechanism.body_index(name), self._arm_end
        x, y, angle = (poses[..., body, column] for column in range(3))
        c = np.cos(angle)
        s = np.sin(angle)
        centres = np.empty((*poses.shape[:-2], 2))
        centres[..., 0], centres[..., 1] = x + c * centre.x - s * centre.y, y + s * centre.x + c * centre.y
        return centres

    @cached_property
    def _arm_end(self) -> Point:
        """The centre of a ball in the axes of its body."""
        arm = self.part.mechanism.reading("arm_angle")
        return arm.end if isinstance(arm, LineAngle) else Point(body=RIGHT_BALL)

    def arm_angles(self, poses: FloatArray) -> FloatArray:
        """Return the angle of the right arm from the vertical (...) (rad)."""
        centres = self.ball_centres(poses)
        x, y = centres[..., 0], centres[..., 1]
        angles: FloatArray = np.arctan2(x - self.offset, -y)
        return angles

    def taut_link_height(self, poses: FloatArray) -> FloatArray:
        """Return the lug height (...) (m) without clearance, from the links, at poses (..., bodies, 3)."""
        centres = self.ball_centres(poses)
        x, y = centres[..., 0], centres[..., 1]
        joint_ratio = self.arm_joint / self.arm
        lateral_distance = self.offset + joint_ratio * (x - self.offset) - self.lug_offset
        height: FloatArray = joint_ratio * y - np.sqrt(np.maximum(self.link**2 - lateral_distance**2, 0.0))
        return height

    def sleeve_height(self, poses: FloatArray) -> FloatArray:
        """Return the lug height (...) (m) at poses (..., bodies, 3), of the sleeve body or of a massless sleeve."""
        if SLEEVE in self.body_names:
            height: FloatArray = poses[..., self.part.mechanism.body_index(SLEEVE), 1]
            return height
        return self.taut_link_height(poses)

    @cached_property
    def arm_axes(self) -> list[Frame]:
        """Axes of the left and the right arm, from the pivot to the ball."""
        return self.axes_between("arm_pivot", "ball")

    @cached_property
    def link_axes(self) -> list[Frame]:
        """Axes of the left and the right link, from the joint of the arm to the lug."""
        return self.axes_between("link_joint", "link_end")

    def pin_axes(self, number: int, joint: str) -> Frame:
        """Return axes that hold the pin of a joint of the left (0) or the right (1) half."""
        return (self.link_axes if joint == "link_end" else self.arm_axes)[number]

    def sides(self, pose: FloatArray) -> list[PendulumSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        height = float((self.taut_link_height if self.clearance else self.sleeve_height)(pose))
        joint_ratio, centre, sides = self.arm_joint / self.arm, self._arm_end, []
        for name, sign in ((LEFT_BALL, -1.0), (RIGHT_BALL, 1.0)):
            x, y = axes_to_plane(pose[self.part.mechanism.body_index(name)].tolist(), centre.x, centre.y)
            pivot_x = sign * self.offset
            link_joint = (pivot_x + joint_ratio * (x - pivot_x), joint_ratio * y)
            link_end = (sign * self.lug_offset, height)
            sides.append(PendulumSide(arm_pivot=(pivot_x, 0.0), link_joint=link_joint, ball=(x, y), link_end=link_end))
        return sides


_ARM_READINGS = ("arm_angle", "ball_radius")
"""Readings that determine the position of the arms."""

_COLLAR_HEIGHT = 0.07
_SHOE_WIDTH = 0.060
_SHOE_HEIGHT = 0.080
"""Height of a stop on the spindle, and sizes of the friction shoes under the sleeve, as fractions of the arm."""
_QUADRANT_RATIO, _CROSSED_QUADRANT_RATIO = 0.36, 0.62
"""Radius of the arc with the arm stops, as a fraction of the joint distance; for crossed arms beyond their intersection."""
_INNER_STOP_HALF_WIDTH = 0.058
"""Half width of a stop on the spindle inside a spring, as a fraction of the arm."""


def spindle_foot_height(governor: PendulumProportions) -> float:
    """Return the height (m) of the spindle foot, below the lowest position of the sleeve and of what acts there."""
    u = governor.arm
    low, high = governor.lug_height_range
    depth = governor.sleeve_size[1]
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
    coils = helical_spring_lines((0.0, low), (0.0, high), half_width, governor.spindle_ratio * governor.arm)
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
    return Lines("spring", helical_spring_lines(*ends, 0.06 * governor.arm, 0.0))


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
        yield make_burst([_quadrant_point(governor, sign, angle) for sign in signs] if struck_side else [], 0.085 * u)
    if governor.find_lift_effect(Stops):
        box = _collar_boxes(governor).get(governor.struck_side(parts.LIFT_READING, time))
        yield make_burst([(sign * (box[1] + 0.01 * u), (box[3] + box[2]) / 2) for sign in signs] if box else [], 0.075 * u)
