"""Proportions of the drawing of a pendulum governor, and positions of its arms, links and sleeve."""

import math
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.machines.pendulum.machine import LEFT_BALL, RIGHT_BALL, SLEEVE
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.render.geometry.attached import Frame, Moment, axes_along, axes_shifted, once_per_moment
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, Vec2, drawn_ball_radius
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
        c, s, centres = np.cos(angle), np.sin(angle), np.empty((*poses.shape[:-2], 2))
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

    @once_per_moment
    def sides_at(self, moment: Moment) -> list[PendulumSide]:
        """Return the left and the right half at a moment."""
        return self.sides(moment.pose)

    def place_of(self, number: int, joint: str, moment: Moment) -> Vec2:
        """Return where a joint of the left (0) or the right (1) half is at a moment (m)."""
        place: Vec2 = getattr(self.sides_at(moment)[number], joint)
        return place

    def axes_between(self, number: int, first: str, second: str) -> Frame:
        """Return axes from one joint to another of the left (0) or the right (1) half."""
        return axes_along(lambda moment: (self.place_of(number, first, moment), self.place_of(number, second, moment)))

    @cached_property
    def arm_axes(self) -> list[Frame]:
        """Axes of the left and the right arm, from the pivot to the ball."""
        return [self.axes_between(number, "arm_pivot", "ball") for number in (0, 1)]

    @cached_property
    def ball_axes(self) -> list[Frame]:
        """Axes that move with the left and the right ball and stay upright, as the light on them does."""
        return [axes_shifted(partial(self.place_of, number, "ball")) for number in (0, 1)]

    @cached_property
    def link_axes(self) -> list[Frame]:
        """Axes of the left and the right link, from the joint of the arm to the lug."""
        return [self.axes_between(number, "link_joint", "link_end") for number in (0, 1)]

    def pin_axes(self, number: int, joint: str) -> Frame:
        """Return axes that hold the pin of a joint of the left (0) or the right (1) half."""
        return (self.link_axes if joint == "link_end" else self.arm_axes)[number]

    def sides(self, pose: FloatArray) -> list[PendulumSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        height = float((self.taut_link_height if self.clearance else self.sleeve_height)(pose))
        joint_ratio, sides = self.arm_joint / self.arm, []
        for name, sign in ((LEFT_BALL, -1.0), (RIGHT_BALL, 1.0)):
            x, y = self.ball_centres(pose, name).tolist()
            pivot_x = sign * self.offset
            link_joint = (pivot_x + joint_ratio * (x - pivot_x), joint_ratio * y)
            link_end = (sign * self.lug_offset, height)
            sides.append(PendulumSide(arm_pivot=(pivot_x, 0.0), link_joint=link_joint, ball=(x, y), link_end=link_end))
        return sides
