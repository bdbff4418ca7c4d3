"""Proportions of the drawing of a pendulum governor, and positions of its arms, links and sleeve."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.machines.pendulum.bodies import LEFT_BALL, RIGHT_BALL, RIGHT_LINK, SLEEVE
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import FollowerHeight, LineAngle, PointCoordinate
from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState, clearance_of
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, Vec2, drawn_ball_radius
from governor_mechanism.render.machines.governor_parts import GovernorProportions
from governor_mechanism.types import FloatArray

PENDULUM_SPINDLE_HALF_WIDTH = 0.030
"""Half width of the spindle, as a fraction of the arm."""
ARM_WIDTH, LINK_WIDTH, PIVOT_RADIUS = 0.058, 0.042, 0.021
GROOVE_RATIO = 0.62
"""Half width of the groove of a light sleeve, as a fraction of the half width of the sleeve."""


@dataclass(frozen=True, kw_only=True)
class PendulumProportions(GovernorProportions):
    """Dimensions of the drawing in m and kg; `has_sleeve_body` is true if the sleeve is a body of the mechanism.

    `ball_centre` is the centre of the ball on the body of its arm. `has_link_bodies` is true if the links have mass.
    `clearance` is the width of the slot in the sleeve (m).
    """

    offset: float
    joint_distance: float
    link_length: float
    lug_offset: float
    sleeve_mass: float
    has_sleeve_body: bool
    ball_radius: float
    ball_centre: Point
    has_link_bodies: bool
    clearance: float = 0.0

    @property
    def sleeve_size(self) -> Vec2:
        """Half width, and depth below the lugs (m), of a cast-iron drum with the mass of the sleeve, or of a light collar."""
        u = self.arm
        if not self.has_sleeve_body:
            return max(0.115 * u, abs(self.lug_offset) + 0.06 * u), 0.24 * u
        # A cylinder with a height of 1.3 radii has this radius; very heavy or very light drums are drawn at a limit.
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON_DENSITY))
        radius = min(max(radius, 0.16 * u), 0.38 * u)
        return max(radius, abs(self.lug_offset) + 0.06 * u), 0.09 * u + 1.3 * radius


@dataclass(frozen=True, kw_only=True)
class PendulumSide:
    """One half of the governor at one pose: its sign (-1 left, 1 right) and the positions of its joints (m).

    The lug of the sleeve is at `link_end`, except for the clearance.
    """

    sign: float
    arm_pivot: Vec2
    link_joint: Vec2
    ball: Vec2
    link_end: Vec2


def pendulum_proportions(part: Part, effect_state: EffectState = NO_EFFECTS) -> PendulumProportions:
    """Return the proportions of the drawing of a part."""
    dimensions = part.dimensions
    arm, offset = dimensions["arm"], dimensions.get("offset", 0.0)
    joint_distance = dimensions.get("arm_joint", arm)
    names = [body.name for body in part.mechanism.bodies]
    angle, lift = part.mechanism.reading("arm_angle"), part.mechanism.reading("sleeve_lift")
    rods, clearance = effect_state.find_effect(RodMasses), clearance_of(part, effect_state)
    given_ball_radius = rods.ball_radius if rods else 0.0
    return PendulumProportions(
        arm=arm,
        offset=offset,
        joint_distance=joint_distance,
        link_length=dimensions.get("link", joint_distance),
        lug_offset=dimensions.get("lug_offset", offset),
        sleeve_mass=dimensions.get("sleeve_mass", 0.0),
        has_sleeve_body=SLEEVE in names,
        ball_radius=given_ball_radius or drawn_ball_radius(dimensions["ball_mass"], arm),
        ball_centre=angle.end if isinstance(angle, LineAngle) else Point(body=RIGHT_BALL),
        has_link_bodies=RIGHT_LINK in names,
        zero_lift_height=lift.zero if isinstance(lift, PointCoordinate | FollowerHeight) else 0.0,
        effect_state=effect_state,
        clearance=clearance.width if clearance else 0.0,
    )


def pendulum_ball_centres(governor: PendulumProportions, part: Part, poses: FloatArray, name: str = RIGHT_BALL) -> FloatArray:
    """Return the centre of a ball (..., 2) (m) at poses (..., bodies, 3); the mass centre of its body may be elsewhere."""
    x, y, angle = np.moveaxis(poses[..., part.mechanism.body_index(name), :], -1, 0)
    ball_centre, c, s = governor.ball_centre, np.cos(angle), np.sin(angle)
    centres: FloatArray = np.stack([x + c * ball_centre.x - s * ball_centre.y, y + s * ball_centre.x + c * ball_centre.y], axis=-1)
    return centres


def pendulum_arm_angles(governor: PendulumProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Return the angle of the right arm from the vertical (...) (rad)."""
    x, y = np.moveaxis(pendulum_ball_centres(governor, part, poses), -1, 0)
    angles: FloatArray = np.arctan2(x - governor.offset, -y)
    return angles


def taut_link_height(governor: PendulumProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Return the lug height (...) (m) without clearance, from the links, at poses (..., bodies, 3)."""
    x, y = np.moveaxis(pendulum_ball_centres(governor, part, poses), -1, 0)
    joint_ratio = governor.joint_distance / governor.arm
    lateral_distance = governor.offset + joint_ratio * (x - governor.offset) - governor.lug_offset
    height: FloatArray = joint_ratio * y - np.sqrt(np.maximum(governor.link_length**2 - lateral_distance**2, 0.0))
    return height


def pendulum_sleeve_height(governor: PendulumProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Return the lug height (...) (m) at poses (..., bodies, 3), of the sleeve body or of a massless sleeve."""
    if governor.has_sleeve_body:
        height: FloatArray = poses[..., part.mechanism.body_index(SLEEVE), 1]
        return height
    return taut_link_height(governor, part, poses)


def pendulum_sides(governor: PendulumProportions, part: Part, pose: FloatArray) -> list[PendulumSide]:
    """Return the left and the right half at a pose (bodies, 3)."""
    height = float((taut_link_height if governor.clearance else pendulum_sleeve_height)(governor, part, pose))
    joint_ratio, sides = governor.joint_distance / governor.arm, []
    for name, sign in ((LEFT_BALL, -1.0), (RIGHT_BALL, 1.0)):
        x, y = pendulum_ball_centres(governor, part, pose, name).tolist()
        arm_pivot = (sign * governor.offset, 0.0)
        link_joint = (arm_pivot[0] + joint_ratio * (x - arm_pivot[0]), arm_pivot[1] + joint_ratio * (y - arm_pivot[1]))
        sides.append(
            PendulumSide(sign=sign, arm_pivot=arm_pivot, link_joint=link_joint, ball=(x, y), link_end=(sign * governor.lug_offset, height))
        )
    return sides
