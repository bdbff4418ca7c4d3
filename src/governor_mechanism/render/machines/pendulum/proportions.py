"""The sizes of a pendulum governor's drawing, and where its arms, links and sleeve stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.machines.pendulum.bodies import LEFT_BALL, RIGHT_BALL, RIGHT_LINK, SLEEVE
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import FollowerHeight, LineAngle, PointCoordinate
from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState, clearance_of
from governor_mechanism.render.geometry.primitives import CAST_IRON_DENSITY, Vec2, drawn_ball_radius
from governor_mechanism.types import FloatArray

# All as fractions of the arm: what the scene does not say is drawn in a proportion to it.
PENDULUM_SPINDLE_HALF_WIDTH = 0.030
"""half width"""
ARM_WIDTH, LINK_WIDTH, PIVOT_RADIUS = 0.058, 0.042, 0.021
GROOVE_RATIO = 0.62
"""half width of a light sleeve's groove, as a fraction of the sleeve's"""


@dataclass(frozen=True, kw_only=True)
class PendulumProportions:
    """The dimensions a drawing needs, in m and kg; `loaded` tells whether the sleeve is a body of its own.

    ball is the ball's radius, end its centre on its arm's body; heavy_links are bodies; zero (m) is the height at which
    the lift is nought. acting is what the scene lists beside weights, and play how wide the sleeve's slot is (m).
    """

    arm: float
    offset: float
    joint_distance: float
    link_length: float
    lug_offset: float
    sleeve_mass: float
    has_sleeve_body: bool
    ball_radius: float
    ball_centre: Point
    has_link_bodies: bool
    zero_lift_height: float
    effect_state: EffectState = NO_EFFECTS
    clearance: float = 0.0

    @property
    def sleeve_size(self) -> Vec2:
        """Half width and depth below the lugs (m) of a drum of cast iron with the sleeve's mass, or a light collar."""
        u = self.arm
        if not self.has_sleeve_body:
            return max(0.115 * u, abs(self.lug_offset) + 0.06 * u), 0.24 * u
        # A cylinder 1.3 radii high has this radius; one too heavy or too light to be seen well is drawn at the limit.
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON_DENSITY))
        radius = min(max(radius, 0.16 * u), 0.38 * u)
        return max(radius, abs(self.lug_offset) + 0.06 * u), 0.09 * u + 1.3 * radius


@dataclass(frozen=True, kw_only=True)
class PendulumSide:
    """One half of the governor at one pose: its side (-1 left, 1 right) and where its joints are (m).

    The link ends in `ring`; the sleeve's lug is there too, but for play.
    """

    sign: float
    arm_pivot: Vec2
    link_joint: Vec2
    ball: Vec2
    link_end: Vec2


def pendulum_proportions(part: Part, effect_state: EffectState = NO_EFFECTS) -> PendulumProportions:
    """What the drawing of a part needs to know of it."""
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
    """Where a ball's centre stands (..., 2) (m) at poses (..., bodies, 3), wherever its body's mass centre is."""
    x, y, angle = np.moveaxis(poses[..., part.mechanism.body_index(name), :], -1, 0)
    ball_centre, c, s = governor.ball_centre, np.cos(angle), np.sin(angle)
    centres: FloatArray = np.stack([x + c * ball_centre.x - s * ball_centre.y, y + s * ball_centre.x + c * ball_centre.y], axis=-1)
    return centres


def pendulum_arm_angles(governor: PendulumProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Of the right arm from the vertical (...) (rad)."""
    x, y = np.moveaxis(pendulum_ball_centres(governor, part, poses), -1, 0)
    angles: FloatArray = np.arctan2(x - governor.offset, -y)
    return angles


def taut_link_height(governor: PendulumProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Height (...) (m) at which the links would hang the lugs, at poses (..., bodies, 3)."""
    x, y = np.moveaxis(pendulum_ball_centres(governor, part, poses), -1, 0)
    joint_ratio = governor.joint_distance / governor.arm
    lateral_distance = governor.offset + joint_ratio * (x - governor.offset) - governor.lug_offset
    height: FloatArray = joint_ratio * y - np.sqrt(np.maximum(governor.link_length**2 - lateral_distance**2, 0.0))
    return height


def pendulum_sleeve_height(governor: PendulumProportions, part: Part, poses: FloatArray) -> FloatArray:
    """Height (...) of the lugs (m) at poses (..., bodies, 3): the sleeve's own, or that of a sleeve without mass."""
    if governor.has_sleeve_body:
        height: FloatArray = poses[..., part.mechanism.body_index(SLEEVE), 1]
        return height
    return taut_link_height(governor, part, poses)


def pendulum_sides(governor: PendulumProportions, part: Part, pose: FloatArray) -> list[PendulumSide]:
    """The left half and the right one at a pose (bodies, 3)."""
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
