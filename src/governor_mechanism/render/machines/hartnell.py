"""Drawing of Hartnell's governor: casing with pivots, bell cranks with balls and rollers, sleeve, spring, spindle, and the effects."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.machines.hartnell import LEFT_BALL, RIGHT_BALL
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, fixed
from governor_mechanism.render.geometry.outlines import helical_spring_lines, make_bar, make_burst, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2, drawn_ball_radius
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.governor_parts import LIFT_READING, CylinderSizes, GovernorDrawing, PistonSizes, ThrottleGear
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.types import FloatArray

ROLLER_RADIUS, FLANGE_HEIGHT = 0.075, 0.10
"""Radius of a roller, and height of the flange of the sleeve above it, as fractions of the ball's arm."""
STOP_READINGS = ("arm_angle", "ball_radius", LIFT_READING)
"""Readings whose stops are drawn at the sleeve."""


@dataclass(frozen=True, kw_only=True)
class HartnellSide:
    """One half of the governor at one pose: its pivot, ball and roller (m)."""

    pivot: Vec2
    ball: Vec2
    roller: Vec2


class HartnellProportions(GovernorDrawing):
    """Dimensions of the drawing in m, kg and rad; the lugs of the sleeve are the tops of the rollers' axes."""

    spindle_ratio = 0.075
    cylinder = CylinderSizes(half_width=0.17, axis_distance=0.32, extra_length=0.34, min_length=0.5, wall=0.035, gap=0.07)
    piston = PistonSizes(clearance=0.05, lowest=0.1, thickness=0.07, rod_half_width=0.03, bracket_width=0.08)

    arm = Dimension("ball_arm")
    sleeve_arm = Dimension("sleeve_arm")
    bell_crank_angle = Dimension("bell_crank_angle")
    pivot_radius = Dimension("pivot_radius")

    @cached_property
    def ball_radius(self) -> float:
        """Radius of a ball of cast iron (m)."""
        return drawn_ball_radius(self.part.dimensions["ball_mass"], self.arm)

    def arm_angles(self, poses: FloatArray) -> FloatArray:
        """Return the angle of the arms from the upright (...), positive outward (rad), at poses (..., bodies, 3)."""
        angles: FloatArray = -poses[..., self.part.mechanism.body_index(RIGHT_BALL), 2]
        return angles

    def roller_position(self, arm_angle: float) -> Vec2:
        """Return the position of the right roller (m) at an arm angle (rad)."""
        angle = self.bell_crank_angle - arm_angle
        return self.pivot_radius - self.sleeve_arm * math.sin(angle), self.sleeve_arm * math.cos(angle)

    def sleeve_height(self, poses: FloatArray) -> FloatArray:
        """Return the height (...) of the rollers (m) at poses (..., bodies, 3)."""
        height: FloatArray = self.sleeve_arm * np.cos(self.bell_crank_angle - self.arm_angles(poses))
        return height

    @cached_property
    def _roller_radii(self) -> Vec2:
        """Smallest and largest distance of the rollers from the axis in the run (m)."""
        low, high = self.reading_range("arm_angle")
        # nearest to the axis where the sleeve's arm is horizontal
        angles = [low, high, min(max(self.bell_crank_angle - math.pi / 2, low), high)]
        radii = [self.roller_position(angle)[0] for angle in angles]
        return min(radii), max(radii)

    @property
    def flange_half_width(self) -> float:
        """Half width of the flange of the sleeve, beyond the rollers (m)."""
        return max(self._roller_radii[1] + (ROLLER_RADIUS + 0.02) * self.arm, 0.26 * self.arm)

    @property
    def tube_half_width(self) -> float:
        """Half width of the sleeve between the rollers (m)."""
        u = self.arm
        return max(min(0.17 * u, self._roller_radii[0] - (ROLLER_RADIUS + 0.02) * u), (self.spindle_ratio + 0.015) * u)

    @property
    def column_radius(self) -> float:
        """Distance of the columns of the casing from the axis (m)."""
        return self.flange_half_width + 0.09 * self.arm

    @property
    def sleeve_size(self) -> Vec2:
        """Half width of the grooved end of the sleeve, and depth of its lower face below the rollers (m)."""
        return self.tube_half_width + 0.12 * self.arm, 0.78 * self.arm

    @property
    def dashpot_top(self) -> float:
        """Height of the top of a dashpot next to the sleeve (m)."""
        return self.lug_height_range[0] - self.sleeve_size[1] - 0.10 * self.arm

    @cached_property
    def flange_top_range(self) -> Vec2:
        """Lowest and highest height of the top of the flange in the run (m)."""
        low, high = self.lug_height_range
        rise = (ROLLER_RADIUS + FLANGE_HEIGHT) * self.arm
        return low + rise, high + rise

    @cached_property
    def cap_height(self) -> float:
        """Height of the underside of the casing's cap, on which the spring bears (m)."""
        _, high = self.flange_top_range
        length = max(0.95 * self.arm, 2.2 * (high - self.flange_top_range[0]))
        stop = self.stop_heights[1]
        return max(high + length, stop + 0.3 * self.arm if math.isfinite(stop) else -math.inf)

    @cached_property
    def has_spring_above(self) -> bool:
        """Whether a spring acts on the sleeve from the cap."""
        return self.find_lift_effect(OutputSpring) is not None

    @cached_property
    def stop_heights(self) -> Vec2:
        """Heights of the rollers at the low and the high stop (m); infinite where there is none."""
        stops = self.find_effect(Stops, *STOP_READINGS)
        if stops is None:
            return -math.inf, math.inf
        if stops.reading == LIFT_READING:
            return self.zero_lift_height + stops.low, self.zero_lift_height + stops.high
        angles = (stops.low, stops.high) if stops.reading == "arm_angle" else (self._arm_angle(stops.low), self._arm_angle(stops.high))
        low, high = (self.roller_position(angle)[1] if math.isfinite(angle) else angle for angle in angles)
        return low, high

    def _arm_angle(self, radius: float) -> float:
        """Return the arm angle (rad) at a radius of the balls (m); infinite outside their reach."""
        sine = (radius - self.pivot_radius) / self.arm
        return math.asin(sine) if abs(sine) < 1 else math.copysign(math.inf, sine)

    def sides(self, pose: FloatArray) -> list[HartnellSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        sides = []
        roller_x, roller_y = self.roller_position(float(self.arm_angles(pose)))
        for name, sign in ((LEFT_BALL, -1.0), (RIGHT_BALL, 1.0)):
            x, y, _ = pose[self.part.mechanism.body_index(name)].tolist()
            sides.append(HartnellSide(pivot=(sign * self.pivot_radius, 0.0), ball=(x, y), roller=(sign * roller_x, roller_y)))
        return sides


# Widths and heights as fractions of the ball's arm.
_ARM_WIDTH = 0.095
_COLUMN_HALF_WIDTH = 0.05
_CAP_HEIGHT = 0.14
_PIVOT_RADIUS = 0.035
_COLUMN_FOOT = 0.30
"""Depth of the feet of the columns below the pivots."""
_LIP = 0.09
_GROOVE_TOP = 0.24
_GEAR_UNIT = 1.6
"""Thickness of the two lips of the sleeve's groove, height of its upper one above the foot, and the length that sizes the gears."""
_SHOE_WIDTH = 0.13
_SHOE_HEIGHT = 0.15
_STOP_HEIGHT = 0.11


class HartnellDrawing(HartnellProportions):
    """Drawing of a Hartnell governor."""

    panel_readings = ("ball_radius", "sleeve_lift", "spindle_speed", "static_sleeve_force", "arm_angle")
    plan_caption = ("from above,", "marked: the", "right ball")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the spindle in its bearings, the casing with the pivots, stops, dashpot cylinder and lift scale."""
        u, foot = self.arm, _spindle_foot(self)
        yield fixed(self._spindle_shapes(foot))
        yield fixed(_casing_shapes(self), turns=True)
        yield fixed([_nut(self)])
        yield fixed(_stop_shapes(self), turns=True)
        yield fixed(parts.cylinder_shapes(self))
        yield fixed(() if self.is_magnified else _lift_scale_shapes(self))
        yield from self.drive_parts(foot - 0.32 * u, _GEAR_UNIT * u)

    def _spindle_shapes(self, foot: float) -> Iterator[DrawnShape]:
        """Yield the spindle in its bearings."""
        u = self.arm
        w = self.spindle_ratio * self.arm
        cap_top = self.cap_height + _CAP_HEIGHT * self.arm
        yield from parts.spindle_shapes(w, (foot - 0.82 * u, cap_top + 0.62 * u), foot - 0.32 * u, cap_top + 0.52 * u)
        for heights in ((cap_top + 0.24 * u, cap_top + 0.42 * u), (foot - 0.22 * u, foot - 0.06 * u)):
            yield from parts.hatched_pair_shapes("bearing", (w, 0.34 * u), heights, 0.075 * u)
        yield make_rectangle("spindle", -1.7 * w, 1.7 * w, foot - 0.06 * u, foot - 0.01 * u)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield sleeve, spring, bell cranks and balls; the right half covers the left one."""
        u, depth = self.arm, self.sleeve_size[1]
        first_sides: list[HartnellSide] = self.sides_at(self.first_moment)
        crank_axes = self.axes_between("pivot", "ball")
        yield from parts.piston_parts(self, depth - 0.05 * u)
        yield Attached(frame=self.sleeve_axes, shapes=tuple(_sleeve_shapes(self)), turns=False)
        yield from self.throttle_parts()
        if self.has_spring_above:
            yield Flexible(shapes_at=self._spring_shapes)
        yield from parts.spindle_shoe_parts(self, depth, (_SHOE_WIDTH, _SHOE_HEIGHT))
        for side, frame in zip(first_sides, crank_axes, strict=True):
            yield self.attach(frame, _crank_shapes(u, side))
        yield from parts.ball_parts(self.axes_at("ball"), self.ball_radius)
        for side, frame in zip(first_sides, crank_axes, strict=True):
            yield self.attach(frame, [Circle("pivot", *point, _PIVOT_RADIUS * u) for point in (side.pivot, side.roller)])
        yield Flexible(shapes_at=lambda moment: _impact_shapes(self, moment.time))

    def _spring_shapes(self, moment: Moment) -> list[DrawnShape]:
        """Return the spring between the flange of the sleeve and the cap."""
        u = self.arm
        top = self.sleeve_axes(moment)[1] + (ROLLER_RADIUS + FLANGE_HEIGHT) * self.arm
        return [Lines("spring", helical_spring_lines((0.0, top), (0.0, self.cap_height), 0.22 * u, self.spindle_ratio * u))]

    @cached_property
    def throttle_gear(self) -> ThrottleGear:
        """The throttle that the sleeve moves."""
        u = self.arm
        return ThrottleGear(
            unit=_GEAR_UNIT * u,
            side=-1.0,
            pin_range=self.fork_pin_range,
            strap_half_width=1.06 * self.tube_half_width,
            pivot_distance=parts.throttle_pivot_distance(self, 0.9 * u, 0.3 * u),
            valve_height=_spindle_foot(self) - 0.15 * u,
        )

    @property
    def fork_depth(self) -> float:
        """Depth of the middle of the groove for the fork below the rollers (m)."""
        return self.sleeve_size[1] - 0.5 * (_GROOVE_TOP + _LIP) * self.arm

    def plan_shapes(self, pose: FloatArray, angle: float) -> Iterator[DrawnShape]:
        """Yield casing, balls and sleeve from above; a mark identifies the right ball."""
        c, s = math.cos(angle), math.sin(angle)
        left, right = ((side.ball[0] * c, side.ball[0] * s) for side in self.sides(pose))
        x, y = self.pivot_radius * c, self.pivot_radius * s
        yield Lines("plan arm", ((left, right),))
        yield make_bar("frame", (-x, -y), (x, y), 0.2 * self.arm)
        yield Circle("frame", 0.0, 0.0, self.column_radius)
        yield from (Circle("ball", *point, self.ball_radius) for point in (left, right))
        yield Circle("mark", *right, 0.42 * self.ball_radius)

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the centre of the right ball."""
        path: FloatArray = poses[..., self.part.mechanism.body_index("right ball"), :2]
        return path


def _crank_shapes(u: float, side: HartnellSide) -> Iterator[DrawnShape]:
    """Yield the bell crank of one side with its roller."""
    yield make_bar("arm", side.pivot, side.roller, _ARM_WIDTH * u)
    yield make_bar("arm", side.pivot, side.ball, _ARM_WIDTH * u)
    yield Circle("arm", *side.pivot, 0.085 * u)
    yield Circle("eyelet", *side.roller, ROLLER_RADIUS * u)


def _casing_shapes(governor: HartnellProportions) -> Iterator[DrawnShape]:
    """Yield the casing, keyed to the spindle: brackets with the pivots, columns and cap."""
    u = governor.arm
    x = governor.column_radius
    cap = governor.cap_height
    half, foot = _COLUMN_HALF_WIDTH * u, -_COLUMN_FOOT * u
    for sign in (-1.0, 1.0):
        yield make_bar("frame", (sign * x, foot + half), (sign * governor.pivot_radius, 0.0), 2 * half)
        yield Circle("frame", sign * governor.pivot_radius, 0.0, 0.12 * u)
        yield make_rectangle("frame", sign * x - half, sign * x + half, foot, cap)
    yield make_rectangle("frame", -x - half, x + half, cap, cap + _CAP_HEIGHT * u)


def _nut(governor: HartnellProportions) -> Polygon:
    """Return the nut on the cap that tightens the spring."""
    top = governor.cap_height + _CAP_HEIGHT * governor.arm
    w = governor.spindle_ratio * governor.arm
    return make_rectangle("seat", -2.2 * w, 2.2 * w, top, top + 0.08 * governor.arm)


def _sleeve_shapes(governor: HartnellProportions) -> Iterator[DrawnShape]:
    """Yield the sleeve in its axes, the rollers at the origin: flange on the rollers, tube, grooved end for the fork, and a pointer."""
    u, (end, depth) = governor.arm, governor.sleeve_size
    flange, tube = governor.flange_half_width, governor.tube_half_width
    low = ROLLER_RADIUS * u
    base = -depth
    lip = _LIP * u
    top, groove = low + FLANGE_HEIGHT * u, base + (_GROOVE_TOP + _LIP) * u
    upper = (flange, top), (flange, low), (tube, low), (tube, groove), (end, groove), (end, groove - lip)
    lower = (tube, groove - lip), (tube, base + lip), (end, base + lip), (end, base)
    yield Polygon("sleeve", parts.mirror_outline((*upper, *lower)))
    strokes = (((part * tube, low - 0.02 * u), (part * tube, groove + 0.02 * u)) for part in (0.5, 0.68, 0.82))
    yield Lines("engraving", tuple(strokes))
    tip = end + 0.16 * u
    if not governor.is_magnified:  # without the scale beside it
        yield Polygon("pointer", ((tip, base), (tip - 0.14 * u, base + 0.055 * u), (tip - 0.14 * u, base - 0.055 * u)))


def _lift_scale_shapes(governor: HartnellProportions) -> list[DrawnShape]:
    """Return a scale of the lifts of the run at the grooved end of the sleeve."""
    u, (end, depth) = governor.arm, governor.sleeve_size
    ticks = parts.lift_ticks(governor.reading_range(parts.LIFT_READING), governor.zero_lift_height - depth, 0.06 * u, 0.22 * u)
    return parts.lift_scale_shapes(end + 0.19 * u, ticks, (0.10 * u, 0.06 * u, 0.13 * u, 0.7 * u))


def _spindle_foot(governor: HartnellProportions) -> float:
    """Return the height (m) of the lower spindle collar, below the sleeve and what acts there."""
    u = governor.arm
    base = min(governor.lug_height_range[0], governor.stop_heights[0] if math.isfinite(governor.stop_heights[0]) else math.inf)
    gap = 0.12 * u
    if governor.find_lift_effect(DryFriction):
        gap += _SHOE_HEIGHT * u
    if math.isfinite(governor.stop_heights[0]):
        gap += _STOP_HEIGHT * u
    return base - governor.sleeve_size[1] - gap


def _stop_shapes(governor: HartnellProportions) -> Iterator[DrawnShape]:
    """Yield the stops as collars on the spindle: below the sleeve, and above its flange inside the spring."""
    u = governor.arm
    w = governor.spindle_ratio * governor.arm
    low, high = governor.stop_heights
    shoe = _SHOE_HEIGHT * u if governor.find_lift_effect(DryFriction) else 0.0
    if math.isfinite(low):
        top = low - governor.sleeve_size[1] - shoe
        yield from parts.hatched_pair_shapes("stop", (w, w + 0.13 * u), (top - _STOP_HEIGHT * u, top), 0.05 * u)
    if math.isfinite(high):
        bottom = high + (ROLLER_RADIUS + FLANGE_HEIGHT) * u
        yield from parts.hatched_pair_shapes("stop", (w, w + 0.09 * u), (bottom, bottom + _STOP_HEIGHT * u), 0.05 * u)


def _impact_shapes(governor: HartnellProportions, time: float) -> Iterator[DrawnShape]:
    """Yield rays where the sleeve has just struck a stop."""
    low, high = governor.stop_heights
    if not (math.isfinite(low) or math.isfinite(high)):
        return
    side = next((struck for reading in STOP_READINGS if (struck := governor.struck_side(reading, time))), 0)
    height = low - governor.sleeve_size[1] if side < 0 else high + (ROLLER_RADIUS + FLANGE_HEIGHT) * governor.arm
    points = [(sign * 0.2 * governor.arm, height) for sign in (-1.0, 1.0)] if side else []
    yield make_burst(points, 0.18 * governor.arm)
