"""Proportions of the drawing of a Hartung governor, and positions of its weights, bell cranks and hangers."""

import math
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.machines.hartung.machine import LEFT_WEIGHT, RIGHT_WEIGHT, SLEEVE
from governor_mechanism.render.geometry.attached import Frame, Moment, axes_along, once_per_moment
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, PoseTuple, Vec2
from governor_mechanism.render.machines.governor_parts import CylinderSizes, GovernorDrawing, PistonSizes
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
        x, y = self.fulcrum_radius - self.arm * np.sin(lever_angle), self.fulcrum_height + self.arm * np.cos(lever_angle)
        return np.stack([x, y], axis=-1)

    @once_per_moment
    def sides_at(self, moment: Moment) -> list[HartungSide]:
        """Return the left and the right half at a moment."""
        return self.sides(moment.pose)

    def _axes_between(self, number: int, first: str, second: str) -> Frame:
        """Return axes from one joint to another of the left (0) or the right (1) half."""

        def ends_at(moment: Moment) -> tuple[Vec2, Vec2]:
            side = self.sides_at(moment)[number]
            return getattr(side, first), getattr(side, second)

        return axes_along(ends_at)

    @cached_property
    def crank_axes(self) -> list[Frame]:
        """Axes of the left and the right bell crank, from the fulcrum to the weight."""
        return [self._axes_between(number, "fulcrum", "weight") for number in (0, 1)]

    @cached_property
    def hanger_axes(self) -> list[Frame]:
        """Axes of the left and the right hanger, from the bell crank to the sleeve."""
        return [self._axes_between(number, "sleeve_arm_end", "lug") for number in (0, 1)]

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
        height, y, sides = float(self.sleeve_height(pose)), self.fulcrum_height, []
        for name, sign in ((LEFT_WEIGHT, -1.0), (RIGHT_WEIGHT, 1.0)):
            lever_angle = sign * float(pose[self.part.mechanism.body_index(name), 2])
            weight = self.weight_radius(lever_angle), y + self.arm * math.cos(lever_angle)
            arm_end = self._sleeve_arm_end(lever_angle)
            lug = arm_end[0] if math.isinf(self.hanger) else self.lug_offset, height
            fulcrum, weight, arm_end, lug = ((sign * px, py) for px, py in ((self.fulcrum_radius, y), weight, arm_end, lug))
            sides.append(HartungSide(sign=sign, lever_angle=lever_angle, fulcrum=fulcrum, weight=weight, sleeve_arm_end=arm_end, lug=lug))
        return sides
