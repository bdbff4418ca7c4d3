"""Proportions of the drawing of a parabolic governor: guides, crosshead, and the lazy tongs that lift the sleeve twice as far as the balls.

The machine gives the sleeve's lift, not what lifts it. Lazy tongs of equal cells between a pivot on the spindle, the crosshead of the balls
and the sleeve have exactly this motion: half of their cells are above the crosshead, so that the sleeve is the image of the pivot.
"""

import math
from functools import cached_property

import numpy as np

from governor_mechanism.machines.parabolic import LEFT_BALL, RIGHT_BALL, SLEEVE
from governor_mechanism.render.geometry.attached import Moment, once_per_moment
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, Vec2, drawn_ball_radius
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents
from governor_mechanism.render.machines.governor_parts import CylinderSizes, GovernorDrawing, PistonSizes
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.types import FloatArray

N_CELLS = 4
"""Number of cells of the lazy tongs; the crosshead holds their middle."""
_LINK_RATIO = 1.10
"""Half length of a bar of the lazy tongs, as a multiple of the half height of their cells where they are stretched most."""
_HUB_CLEARANCE = 0.30
"""Distance of the sleeve's eye at its highest below the vertex of the parabola, as a fraction of the outer radius."""
NECK_HALF_WIDTH, DRUM_TOP, FLANGE_HEIGHT, GROOVE_HEIGHT = 0.085, -0.085, 0.045, 0.07
"""Half width of the sleeve's neck; top of its drum above the eye; heights of flange and groove, as fractions of the outer radius."""


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

    def balls(self, pose: FloatArray) -> tuple[Vec2, Vec2]:
        """Return the centres of the left and the right ball (m) at a pose (bodies, 3)."""
        left, right = (pose[self.part.mechanism.body_index(name), :2].tolist() for name in (LEFT_BALL, RIGHT_BALL))
        return (left[0], left[1]), (right[0], right[1])

    def ball_at(self, number: int, moment: Moment) -> Vec2:
        """Return the centre of the left (0) or the right (1) ball at a moment (m)."""
        return self.balls(moment.pose)[number]

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
