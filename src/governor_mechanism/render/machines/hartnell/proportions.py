"""Proportions of the drawing of a Hartnell governor, and positions of its balls, bell cranks and rollers."""

import math
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.machines.hartnell import LEFT_BALL, RIGHT_BALL
from governor_mechanism.render.geometry.attached import Frame, Moment, axes_along, once_per_moment
from governor_mechanism.render.geometry.primitives import Vec2, drawn_ball_radius
from governor_mechanism.render.machines.governor_parts import LIFT_READING, CylinderSizes, GovernorDrawing, PistonSizes
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

    @once_per_moment
    def sides_at(self, moment: Moment) -> list[HartnellSide]:
        """Return the left and the right half at a moment."""
        return self.sides(moment.pose)

    @cached_property
    def crank_axes(self) -> list[Frame]:
        """Axes of the left and the right bell crank, from the pivot to the ball."""
        return [axes_along(partial(self._crank_ends, number)) for number in (0, 1)]

    def _crank_ends(self, number: int, moment: Moment) -> tuple[Vec2, Vec2]:
        side = self.sides_at(moment)[number]
        return side.pivot, side.ball

    def sides(self, pose: FloatArray) -> list[HartnellSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        sides = []
        roller_x, roller_y = self.roller_position(float(self.arm_angles(pose)))
        for name, sign in ((LEFT_BALL, -1.0), (RIGHT_BALL, 1.0)):
            x, y, _ = pose[self.part.mechanism.body_index(name)].tolist()
            sides.append(HartnellSide(pivot=(sign * self.pivot_radius, 0.0), ball=(x, y), roller=(sign * roller_x, roller_y)))
        return sides
