"""Drawing of the parabolic governor: spindle with guides, balls, crosshead, lazy tongs and sleeve, and the effects on it.

The machine gives the sleeve's lift, not what lifts it. Lazy tongs of equal cells between a pivot on the spindle, the crosshead of the balls
and the sleeve have exactly this motion: half of their cells are above the crosshead, so that the sleeve is the image of the pivot.
"""

import math
from collections.abc import Iterator
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.machines.parabolic import LEFT_BALL, RIGHT_BALL, SLEEVE
from governor_mechanism.render.geometry.attached import (
    Attached,
    DrawnPart,
    Flexible,
    Moment,
    axes_along,
    axes_shifted,
    fixed,
    once_per_moment,
)
from governor_mechanism.render.geometry.outlines import helical_spring_lines, make_band, make_bar, make_burst, make_rectangle
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, Circle, DrawnShape, Lines, Polygon, Vec2, drawn_ball_radius
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.generic.force_elements import output_effect_parts
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents
from governor_mechanism.render.machines.governor_parts import CylinderSizes, GovernorDrawing, PistonSizes, ThrottleGear
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.types import FloatArray

N_CELLS = 4
"""Number of cells of the lazy tongs; the crosshead holds their middle."""
_LINK_RATIO = 1.10
"""Half length of a bar of the lazy tongs, as a multiple of the half height of their cells where they are stretched most."""
_HUB_CLEARANCE = 0.30
"""Distance of the sleeve's eye at its highest below the vertex of the parabola, as a fraction of the outer radius."""
NECK_HALF_WIDTH = 0.085
DRUM_TOP = -0.085
FLANGE_HEIGHT = 0.045
GROOVE_HEIGHT = 0.07
"""Half width of the sleeve's neck; top of its drum above the eye; heights of flange and groove, as fractions of the outer radius."""


class ParabolicSide(NamedTuple):
    """One half of the governor at one pose: the centre of its ball (m)."""

    ball: Vec2


class ParabolicProportions(GovernorDrawing, MechanismExtents):
    """Dimensions of the drawing in m and kg. The outer radius of the guide is its unit."""

    spindle_ratio = 0.040
    cylinder = CylinderSizes(half_width=0.09, axis_distance=0.20, extra_length=0.22, min_length=0.30, wall=0.02, gap=0.04)
    piston = PistonSizes(clearance=0.026, lowest=0.06, thickness=0.04, rod_half_width=0.016, bracket_width=0.04)

    arm = Dimension("outer_radius")
    inner_radius = Dimension("inner_radius")
    double_parameter = Dimension("double_parameter")

    def guide_height(self, radius: float) -> float:
        """Return the height of the guide (m) at a distance from the axis (m)."""
        return radius**2 / self.double_parameter

    @cached_property
    def ball_radius(self) -> float:
        """Radius of a ball of cast iron (m)."""
        return drawn_ball_radius(self.part.dimensions["ball_mass"], self.arm)

    @cached_property
    def upper_pivot_height(self) -> float:
        """Height of the upper end of the lazy tongs (m), so far up that cells and sleeve are clear of the guides at every lift."""
        inner, outer = self.guide_height(self.inner_radius), self.guide_height(self.arm)
        return max(outer + 1.2 * (outer - inner), 2 * outer + _HUB_CLEARANCE * self.arm)

    @cached_property
    def half_link(self) -> float:
        """Half the length of a bar of the lazy tongs (m)."""
        return _LINK_RATIO * (self.upper_pivot_height - self.guide_height(self.inner_radius)) / N_CELLS

    @cached_property
    def zero_lift_height(self) -> float:
        """Height of the sleeve's eye at zero lift (m)."""
        return 2 * self.guide_height(self.inner_radius) - self.upper_pivot_height

    def sleeve_height(self, poses: FloatArray) -> FloatArray:
        """Return the height (...) of the eye of the sleeve (m) at poses (..., bodies, 3)."""
        mechanism = self.part.mechanism
        body = mechanism.body_index(SLEEVE)
        # The machine leaves open where along the spindle the sleeve is; only its travel is given.
        lowest = 2 * self.guide_height(self.inner_radius) - 2 * self.arm
        height: FloatArray = poses[..., body, 1] + (self.zero_lift_height - lowest)
        return height

    @cached_property
    def sleeve_size(self) -> Vec2:
        """Half width, and depth below the eye (m), of a cast-iron sleeve with the given mass, within the limits of a clear drawing."""
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON_DENSITY))
        radius = min(max(radius, 0.17 * self.arm), 0.38 * self.arm)
        return radius, 1.3 * radius + (FLANGE_HEIGHT + GROOVE_HEIGHT - DRUM_TOP) * self.arm

    @property
    def dashpot_top(self) -> float:
        """Height of the top of a dashpot next to the sleeve (m)."""
        return self.lug_height_range[0] - self.sleeve_size[1] - 0.06 * self.arm

    def sides(self, pose: FloatArray) -> list[ParabolicSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        places = (pose[self.part.mechanism.body_index(name), :2].tolist() for name in (LEFT_BALL, RIGHT_BALL))
        return [ParabolicSide(ball=(x, y)) for x, y in places]

    @once_per_moment
    def tongs_at(self, moment: Moment) -> list[tuple[Vec2, Vec2, Vec2]]:
        """Return the joints of the lazy tongs at a moment."""
        return self.tongs_joints(moment.pose)

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the right ball."""
        path: FloatArray = poses[..., self.part.mechanism.body_index(RIGHT_BALL), :2]
        return path

    def tongs_joints(self, pose: FloatArray) -> list[tuple[Vec2, Vec2, Vec2]]:
        """Return the joints of the lazy tongs (m), from the top down: left end, middle on the axis, and right end of each height.

        The heights alternate between crossings on the axis, where all three coincide, and the outer joints half a cell lower.
        """
        half_height = (self.upper_pivot_height - float(self.sleeve_height(pose))) / (2 * N_CELLS)
        half_width = math.sqrt(max(self.half_link**2 - half_height**2, 0.0))
        heights = self.upper_pivot_height - half_height * np.arange(2 * N_CELLS + 1)
        widths = [half_width if k % 2 else 0.0 for k in range(2 * N_CELLS + 1)]
        return [((-x, y), (0.0, y), (x, y)) for x, y in zip(widths, heights.tolist(), strict=True)]


# Widths, heights and lengths as fractions of the outer radius of the guide.
_STRIP_WIDTH = 0.13
_SLOT_WIDTH = 0.066
_GUIDE_END = 0.07
_CROSSHEAD_WIDTH = 0.075
_CROSSHEAD_SLOT_WIDTH = 0.034
_LINK_WIDTH = 0.040
_PIVOT_RADIUS = 0.020
_SHOE_WIDTH = 0.08
_SHOE_HEIGHT = 0.10
_STOP_WIDTH = 0.09
_STOP_HEIGHT = 0.08
_EYE_RADIUS = 0.055


class ParabolicDrawing(ParabolicProportions):
    """Drawing of a parabolic governor."""

    panel_readings = ("ball_radius", "sleeve_lift", "spindle_speed")
    plan_caption = ("from above,", "marked: the", "right ball")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the spindle in its bearings, the frame with the guides, the lift scale, and the effects fixed to the frame."""
        u, foot = self.arm, _spindle_foot(self)
        yield fixed(self._spindle_shapes(foot))
        yield fixed(_frame_shapes(self), turns=True)
        yield from _fixed_effect_parts(self)
        yield fixed(() if self.is_magnified else _lift_scale_shapes(self))
        yield from self.drive_parts(foot - 0.25 * u, u)

    def _spindle_shapes(self, foot: float) -> Iterator[DrawnShape]:
        """Yield the spindle in its bearings."""
        u = self.arm
        w = self.spindle_ratio * self.arm
        top = self.upper_pivot_height
        yield from parts.spindle_shapes(w, (foot - 0.52 * u, top + 0.46 * u), foot - 0.25 * u, top + 0.36 * u)
        for heights in ((top + 0.14 * u, top + 0.27 * u), (foot - 0.18 * u, foot - 0.05 * u)):
            yield from parts.hatched_pair_shapes("bearing", (w, 0.19 * u), heights, 0.045 * u)
        yield make_rectangle("spindle", -1.7 * w, 1.7 * w, foot - 0.05 * u, foot - 0.01 * u)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield sleeve, crosshead, balls and lazy tongs, and the effects."""
        yield from _moving_effect_parts(self)
        yield Attached(frame=self.sleeve_axes, shapes=tuple(_sleeve_shapes(self)), turns=False)
        yield from self.throttle_parts()
        yield Attached(frame=axes_shifted(lambda moment: (0.0, self.place_of(1, "ball", moment)[1])), shapes=tuple(_crosshead_shapes(self)))
        yield from parts.ball_parts(self.axes_at("ball"), self.ball_radius)
        yield from _tongs_parts(self)
        yield from output_effect_parts(self, without=parts.LIFT_READING)
        yield Flexible(shapes_at=lambda moment: _impact_shapes(self, self.sleeve_axes(moment)[1], moment.time))

    @cached_property
    def throttle_gear(self) -> ThrottleGear:
        """The throttle that the sleeve moves."""
        u = self.arm
        return ThrottleGear(
            unit=u,
            side=-1.0,
            pin_range=self.fork_pin_range,
            strap_half_width=0.66 * self.sleeve_size[0],
            pivot_distance=parts.throttle_pivot_distance(self, 0.46 * u, 0.15 * u),
            valve_height=_spindle_foot(self) - 0.12 * u,
        )

    @property
    def fork_depth(self) -> float:
        """Depth of the groove for the fork below the eye of the sleeve (m)."""
        return self.sleeve_size[1] - (FLANGE_HEIGHT + 0.5 * GROOVE_HEIGHT) * self.arm

    def plan_shapes(self, pose: FloatArray, angle: float) -> Iterator[DrawnShape]:
        """Yield guides, sleeve and balls from above; a mark identifies the right ball."""
        c = math.cos(angle)
        s = math.sin(angle)
        end = (1.0 + _GUIDE_END) * self.arm
        left, right = ((side.ball[0] * c, side.ball[0] * s) for side in self.sides(pose))
        yield make_bar("frame plate", (-end * c, -end * s), (end * c, end * s), _STRIP_WIDTH * self.arm)
        yield Circle("sleeve", 0.0, 0.0, self.sleeve_size[0])
        yield Lines("plan arm", ((left, right),))
        yield from (Circle("ball", *point, self.ball_radius) for point in (left, right))
        yield Circle("mark", *right, 0.42 * self.ball_radius)


def _guide_chain(governor: ParabolicProportions, first: float, last: float) -> list[Vec2]:
    """Return points of the parabola between two distances from the axis (m), negative ones at the left."""
    return [(x, governor.guide_height(x)) for x in np.linspace(first, last, 33).tolist()]


def _frame_shapes(governor: ParabolicProportions) -> Iterator[DrawnShape]:
    """Yield what is keyed to the spindle: the guides on their hub with struts, and the boss that carries the lazy tongs."""
    u, top = governor.arm, governor.upper_pivot_height
    end = (1.0 + _GUIDE_END) * u
    for sign in (-1.0, 1.0):
        x = sign * (governor.inner_radius + 0.62 * (u - governor.inner_radius))
        yield make_bar("frame", (0.0, -0.13 * u), (x, governor.guide_height(x)), 0.055 * u)
    yield make_rectangle("frame", -0.085 * u, 0.085 * u, -0.175 * u, 0.065 * u)
    yield make_band("frame plate", _guide_chain(governor, -end, end), _STRIP_WIDTH * u)
    for sign in (-1.0, 1.0):
        chain = _guide_chain(governor, sign * governor.inner_radius, sign * u)
        yield make_band("slot", chain, _SLOT_WIDTH * u)
    yield make_rectangle("frame", -0.075 * u, 0.075 * u, top - 0.045 * u, top + 0.075 * u)


def _crosshead_shapes(governor: ParabolicProportions) -> Iterator[DrawnShape]:
    """Yield the crosshead in axes at the height of the balls: their pins slide in its slots, and it slides on the spindle."""
    u, end = governor.arm, (1.0 + _GUIDE_END) * governor.arm
    yield make_bar("rod", (-end, 0.0), (end, 0.0), _CROSSHEAD_WIDTH * u)
    for sign in (-1.0, 1.0):
        yield make_bar("slot", (sign * governor.inner_radius, 0.0), (sign * u, 0.0), _CROSSHEAD_SLOT_WIDTH * u)
    yield make_rectangle("rod", -0.065 * u, 0.065 * u, -0.06 * u, 0.06 * u)


def _tongs_parts(governor: ParabolicProportions) -> Iterator[Attached]:
    """Yield the bars of the lazy tongs, and their pins."""
    u = governor.arm
    first_joints = governor.tongs_at(governor.first_moment)
    frames = {}
    for start, end in _tongs_bars(len(first_joints) - 1):
        frames[start] = axes_along(partial(_bar_ends, governor, start, end))
        (x, y), (end_x, end_y) = _bar_ends(governor, start, end, governor.first_moment)
        length = math.dist((x, y), (end_x, end_y))
        yield Attached(frame=frames[start], shapes=(make_bar("link", (0.0, 0.0), (length, 0.0), _LINK_WIDTH * u),))
    last = len(first_joints) - 1
    for row in range(last + 1):
        for place in (_LEFT, _RIGHT) if row % 2 else (_MIDDLE,):
            # A pin on the axis is in the middle of the bars that cross there, or at the end of the last ones.
            bar = (row, place) if row % 2 else (max(row - 1, 0), _LEFT)
            x, y = first_joints[row][place]
            yield governor.attach(frames[bar], [Circle("pivot", x, y, _PIVOT_RADIUS * u)], turns=bool(row % 2))


_LEFT = 0
_MIDDLE = 1
_RIGHT = 2
"""Places of the joints of a height."""


def _tongs_bars(last: int) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield rows and places of the ends of the bars: half bars at both ends, whole bars that cross on the axis between them."""
    # The upper half bars are named after the side to which they lead.
    for left, right in ((_LEFT, _RIGHT), (_RIGHT, _LEFT)):
        yield (0, left), (1, left)
        yield from (((k - 1, left), (k + 1, right)) for k in range(2, last, 2))
        yield (last - 1, left), (last, _MIDDLE)


def _bar_ends(governor: ParabolicProportions, start: tuple[int, int], end: tuple[int, int], moment: Moment) -> tuple[Vec2, Vec2]:
    """Return the ends of a bar (m); on the axis, all places of a height coincide."""
    joints = governor.tongs_at(moment)
    return joints[start[0]][start[1]], joints[end[0]][end[1]]


def _sleeve_shapes(governor: ParabolicProportions) -> Iterator[DrawnShape]:
    """Yield the sleeve, whose eye is at the origin of its axes: neck, drum with shading, groove for the fork, and a pointer."""
    u, (width, depth) = governor.arm, governor.sleeve_size
    neck = NECK_HALF_WIDTH * u
    base = -depth
    top = DRUM_TOP * u
    flange = base + FLANGE_HEIGHT * u
    groove = base + (FLANGE_HEIGHT + GROOVE_HEIGHT) * u
    corner = 0.3 * (width - neck)
    drum = (neck, top), (width - corner, top), (width, top - corner), (width, groove)
    foot = (0.62 * width, groove), (0.62 * width, flange), (0.86 * width, flange), (0.86 * width, base)
    yield Circle("sleeve", 0.0, 0.0, _EYE_RADIUS * u)
    yield Polygon("sleeve", parts.mirror_outline(((neck, -0.02 * u), *drum, *foot)))
    strokes = [((part * width, top - 0.02 * u - max(part - 0.8, 0.0) * width), (part * width, groove + 0.02 * u)) for part in _SHADING]
    yield Lines("engraving", tuple(strokes))
    tip = width + 0.10 * u
    if not governor.is_magnified:  # without the scale beside it
        yield Polygon("pointer", ((tip, groove), (tip - 0.08 * u, groove + 0.034 * u), (tip - 0.08 * u, groove - 0.034 * u)))


_SHADING = (-0.93, 0.42, 0.57, 0.69, 0.79, 0.87, 0.94)
"""Places of the strokes that shade the drum, as fractions of its half width."""


def _lift_scale_shapes(governor: ParabolicProportions) -> list[DrawnShape]:
    """Return a scale (mm) of the lifts of the run at the pointer."""
    u, (width, depth) = governor.arm, governor.sleeve_size
    pointer = governor.zero_lift_height - depth + (FLANGE_HEIGHT + GROOVE_HEIGHT) * u
    ticks = parts.lift_ticks(governor.reading_range(parts.LIFT_READING), pointer, 0.05 * u, 0.14 * u)
    return parts.lift_scale_shapes(width + 0.12 * u, ticks, (0.07 * u, 0.04 * u, 0.09 * u, 0.5 * u))


def _spindle_foot(governor: ParabolicProportions) -> float:
    """Return the height (m) of the lower spindle collar, below the sleeve and what acts there."""
    u, gap = governor.arm, 0.10 * governor.arm
    if governor.find_lift_effect(DryFriction):
        gap += _SHOE_HEIGHT * u
    if governor.find_lift_effect(OutputSpring):
        gap += 0.40 * u
    stops = governor.find_lift_effect(Stops)
    low = governor.lug_height_range[0]
    if stops and math.isfinite(stops.low):
        low = min(low, governor.zero_lift_height + stops.low)
        gap = gap + _STOP_HEIGHT * u
    return low - governor.sleeve_size[1] - gap


def _stop_heights(governor: ParabolicProportions) -> Vec2:
    """Return the heights of the faces (m) that stop the sleeve: below its foot and above its neck; infinite without a stop."""
    stops = governor.find_lift_effect(Stops)
    if stops is None:
        return -math.inf, math.inf
    shoe = _SHOE_HEIGHT * governor.arm if governor.find_lift_effect(DryFriction) else 0.0
    low, high = (governor.zero_lift_height + limit for limit in (stops.low, stops.high))
    return low - governor.sleeve_size[1] - shoe, high + _EYE_RADIUS * governor.arm


def _fixed_effect_parts(governor: ParabolicProportions) -> Iterator[Attached]:
    """Yield the effects on the sleeve that are fixed to the frame: stops, spring seat and dashpot cylinder."""
    u = governor.arm
    w = governor.spindle_ratio * governor.arm
    low, high = _stop_heights(governor)
    for face, bottom in ((low, low - _STOP_HEIGHT * u), (high, high)):
        if math.isfinite(face):
            stop = parts.hatched_pair_shapes("stop", (w, _STOP_WIDTH * u), (bottom, bottom + _STOP_HEIGHT * u), 0.03 * u)
            yield fixed(stop, turns=True)
    if governor.find_lift_effect(OutputSpring):
        y = _spindle_foot(governor)
        yield fixed([make_rectangle("seat", -0.17 * u, 0.17 * u, y - 0.03 * u, y)])
    yield fixed(parts.cylinder_shapes(governor))


def _moving_effect_parts(governor: ParabolicProportions) -> Iterator[DrawnPart]:
    """Yield the effects on the sleeve that move with it."""
    depth = governor.sleeve_size[1]
    yield from parts.piston_parts(governor, depth - 0.5 * FLANGE_HEIGHT * governor.arm)
    if governor.find_lift_effect(OutputSpring):
        yield Flexible(shapes_at=partial(_spring_shapes, governor))
    yield from parts.spindle_shoe_parts(governor, depth, (_SHOE_WIDTH, _SHOE_HEIGHT))


def _spring_shapes(governor: ParabolicProportions, moment: Moment) -> list[DrawnShape]:
    """Return the spring between its seat and the foot of the sleeve."""
    u = governor.arm
    seat = _spindle_foot(governor)
    base = governor.sleeve_axes(moment)[1] - governor.sleeve_size[1]
    return [Lines("spring", helical_spring_lines((0.0, seat), (0.0, base), 0.14 * u, governor.spindle_ratio * u))]


def _impact_shapes(governor: ParabolicProportions, height: float, time: float) -> Iterator[DrawnShape]:
    """Yield rays where the sleeve, with its eye at a height (m), has just struck a stop."""
    if not governor.find_lift_effect(Stops):
        return
    side = governor.struck_side(parts.LIFT_READING, time)
    low, high = _stop_heights(governor)
    y = low if side < 0 else high if side > 0 else height
    points = [(sign * _STOP_WIDTH * governor.arm, y) for sign in (-1.0, 1.0)] if side else []
    yield make_burst(points, 0.09 * governor.arm)
