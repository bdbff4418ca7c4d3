"""Proportions of the drawing of a Hartung governor, and positions of its weights, bell cranks and hangers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.machines.hartung.bodies import LEFT_WEIGHT, RIGHT_WEIGHT, SLEEVE
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, Vec2
from governor_mechanism.render.machines.governor_parts import GovernorProportions
from governor_mechanism.types import FloatArray

HARTUNG_SPINDLE_HALF_WIDTH = 0.115
"""Half width of the spindle, as a fraction of the weight arm."""
_NOMINAL_LEVER_SINE = 0.26
"""Sine of the lever angle for which weights and springs are proportioned."""


@dataclass(frozen=True, kw_only=True)
class HartungProportions(GovernorProportions):
    """Dimensions of the drawing in m, kg and rad; `hanger_length` is infinite if the hangers stay vertical.

    `half_width` and `half_height` are those of a weight. `weights_rotate` is true if the weights rotate with their arms.
    `spring_seat_radius` is the distance of the outer spring ends from the axis.
    """

    sleeve_arm: float
    bell_crank_angle: float
    fulcrum: Vec2
    hanger_length: float
    lug_offset: float
    sleeve_mass: float
    half_width: float
    half_height: float
    weights_rotate: bool
    spring_seat_radius: float

    @property
    def bore_half_height(self) -> float:
        """Half height of the bore that holds the spring of a weight (m)."""
        return 0.48 * self.half_height

    @property
    def sleeve_size(self) -> Vec2:
        """Half width, and depth below the lugs (m), of a cast-iron sleeve with the given mass, within the limits of a clear drawing."""
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON_DENSITY))
        min_radius = abs(self.lug_offset) + 0.22 * self.arm
        if math.isinf(self.hanger_length):
            angles = (self.bell_crank_angle + lever for lever in self.lever_angle_range)
            ends = (self.fulcrum[0] - self.sleeve_arm * math.sin(angle) for angle in angles)
            min_radius = max(0.42 * self.arm, *(abs(end) + 0.11 * self.arm for end in ends))
        radius = max(min(max(radius, 0.45 * self.arm), 1.1 * self.arm), min_radius)
        return radius, 0.2 * self.arm + 1.0 * radius

    @property
    def lever_angle_range(self) -> Vec2:
        """Smallest and largest lever angle of the run (rad)."""
        return self.effect_state.reading_ranges.get("lever_angle", (0.0, 0.0))

    def weight_radius(self, lever_angle: float) -> float:
        """Return the distance of a weight centre from the axis (m) at a lever angle (rad)."""
        return self.fulcrum[0] - self.arm * math.sin(lever_angle)


@dataclass(frozen=True, kw_only=True)
class HartungSide:
    """One half of the governor at one pose: its sign (-1 left, 1 right), lever angle (rad), and the positions of its joints (m)."""

    sign: float
    lever_angle: float
    fulcrum: Vec2
    weight: Vec2
    sleeve_arm_end: Vec2
    lug: Vec2


def hartung_proportions(part: Part, effect_state: EffectState = NO_EFFECTS) -> HartungProportions:
    """Return the proportions of the drawing of a part."""
    dimensions, cranks = part.dimensions, effect_state.find_effect(BellCrankMasses)
    arm, radius, mass = dimensions["weight_arm"], dimensions["fulcrum_radius"], dimensions["weight_mass"]
    half_width = 0.83 * max(radius - _NOMINAL_LEVER_SINE * arm, 0.3 * arm)
    # A block of cast iron with equal depth and height.
    half_height = 0.5 * math.sqrt(mass / (CAST_IRON_DENSITY * 2 * half_width))
    half_height = min(max(half_height, 0.45 * arm), 0.82 * arm)
    if cranks and cranks.weight_width and cranks.weight_height:
        half_width, half_height = cranks.weight_width / 2, cranks.weight_height / 2
    outermost = max(effect_state.reading_ranges.get("weight_radius", (0.0, 0.0))[1], radius + _NOMINAL_LEVER_SINE * arm)
    lift = part.mechanism.reading("sleeve_lift")
    return HartungProportions(
        arm=arm,
        **{name: dimensions[name] for name in ("sleeve_arm", "bell_crank_angle", "lug_offset", "sleeve_mass")},
        fulcrum=(radius, dimensions["fulcrum_height"]),
        hanger_length=dimensions["hanger"],
        half_width=half_width,
        half_height=half_height,
        weights_rotate=bool(cranks and (cranks.weight_width or cranks.weight_height)),
        spring_seat_radius=outermost + half_width + 0.22 * arm,
        zero_lift_height=lift.zero if isinstance(lift, PointCoordinate) else 0.0,
        effect_state=effect_state,
    )


def hartung_sleeve_height(part: Part, poses: FloatArray) -> FloatArray:
    """Return the height (...) of the sleeve lugs (m) at poses (..., bodies, 3)."""
    height: FloatArray = poses[..., part.mechanism.body_index(SLEEVE), 1]
    return height


def hartung_weight_centres(governor: HartungProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Return the centre (..., 2) (m) of the right weight at poses (..., bodies, 3)."""
    lever_angle, (x, y) = poses[..., part.mechanism.body_index(RIGHT_WEIGHT), 2], governor.fulcrum
    centres: FloatArray = np.stack([x - governor.arm * np.sin(lever_angle), y + governor.arm * np.cos(lever_angle)], axis=-1)
    return centres


def hartung_sides(governor: HartungProportions, part: Part, pose: FloatArray) -> list[HartungSide]:
    """Return the left and the right half at a pose (bodies, 3)."""
    height, sides = float(hartung_sleeve_height(part, pose)), []
    for name, sign in ((LEFT_WEIGHT, -1.0), (RIGHT_WEIGHT, 1.0)):
        lever_angle = sign * float(pose[part.mechanism.body_index(name), 2])
        (x, y), angle = governor.fulcrum, governor.bell_crank_angle + lever_angle
        sleeve_arm_end = (x - governor.sleeve_arm * math.sin(angle), y + governor.sleeve_arm * math.cos(angle))
        lug = (sleeve_arm_end[0] if math.isinf(governor.hanger_length) else governor.lug_offset, height)
        right_points = ((x, y), (governor.weight_radius(lever_angle), y + governor.arm * math.cos(lever_angle)), sleeve_arm_end, lug)
        fulcrum, weight, sleeve_arm_end, lug = ((sign * px, py) for px, py in right_points)
        sides.append(
            HartungSide(sign=sign, lever_angle=lever_angle, fulcrum=fulcrum, weight=weight, sleeve_arm_end=sleeve_arm_end, lug=lug)
        )
    return sides
