"""The sizes of a pendulum governor's drawing, and where its arms, links and sleeve stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.machines.pendulum.machine import LEFT, RIGHT, RIGHT_LINK, SLEEVE
from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Coordinate, FollowerHeight, LineAngle
from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting, slot_of
from governor_mechanism.render.geometry.primitives import CAST_IRON, Pair, ball_radius
from governor_mechanism.types import FloatArray

# All as fractions of the arm: what the scene does not say is drawn in a proportion to it.
SPINDLE = 0.030
"""half width"""
ARM, LINK, PIVOT = 0.058, 0.042, 0.021
GROOVE = 0.62
"""half width of a light sleeve's groove, as a fraction of the sleeve's"""


@dataclass(frozen=True, kw_only=True)
class Governor:
    """The dimensions a drawing needs, in m and kg; `loaded` tells whether the sleeve is a body of its own.

    ball is the ball's radius, end its centre on its arm's body; heavy_links are bodies; zero (m) is the height at which
    the lift is nought. acting is what the scene lists beside weights, and play how wide the sleeve's slot is (m).
    """

    arm: float
    offset: float
    joint: float
    link: float
    lug: float
    sleeve_mass: float
    loaded: bool
    ball: float
    end: Point
    heavy_links: bool
    zero: float
    acting: Acting = NOTHING
    play: float = 0.0

    @property
    def load(self) -> Pair:
        """Half width and depth below the lugs (m) of a drum of cast iron with the sleeve's mass, or a light collar."""
        u = self.arm
        if not self.loaded:
            return max(0.115 * u, abs(self.lug) + 0.06 * u), 0.24 * u
        # A cylinder 1.3 radii high has this radius; one too heavy or too light to be seen well is drawn at the limit.
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON))
        radius = min(max(radius, 0.16 * u), 0.38 * u)
        return max(radius, abs(self.lug) + 0.06 * u), 0.09 * u + 1.3 * radius


@dataclass(frozen=True, kw_only=True)
class Side:
    """One half of the governor at one pose: its side (-1 left, 1 right) and where its joints are (m).

    The link ends in `ring`; the sleeve's lug is there too, but for play.
    """

    sign: float
    top: Pair
    knee: Pair
    ball: Pair
    ring: Pair


def governor_of(part: Part, acting: Acting = NOTHING) -> Governor:
    """What the drawing of a part needs to know of it."""
    given = part.dimensions
    arm, offset = given["arm"], given.get("offset", 0.0)
    joint = given.get("arm_joint", arm)
    names = [body.name for body in part.mechanism.bodies]
    angle, lift = part.mechanism.reading("arm_angle"), part.mechanism.reading("sleeve_lift")
    rods, play = acting.one(Rods), slot_of(part, acting)
    told = rods.ball_radius if rods else 0.0
    return Governor(
        arm=arm,
        offset=offset,
        joint=joint,
        link=given.get("link", joint),
        lug=given.get("lug_offset", offset),
        sleeve_mass=given.get("sleeve_mass", 0.0),
        loaded=SLEEVE in names,
        ball=told or ball_radius(given["ball_mass"], arm),
        end=angle.end if isinstance(angle, LineAngle) else Point(body=RIGHT),
        heavy_links=RIGHT_LINK in names,
        zero=lift.zero if isinstance(lift, Coordinate | FollowerHeight) else 0.0,
        acting=acting,
        play=play.width if play else 0.0,
    )


def ball_spots(governor: Governor, part: Part, poses: FloatArray, name: str = RIGHT) -> FloatArray:
    """Where a ball's centre stands (..., 2) (m) at poses (..., bodies, 3), wherever its body's mass centre is."""
    x, y, turn = np.moveaxis(poses[..., part.mechanism.body_index(name), :], -1, 0)
    end, c, s = governor.end, np.cos(turn), np.sin(turn)
    spots: FloatArray = np.stack([x + c * end.x - s * end.y, y + s * end.x + c * end.y], axis=-1)
    return spots


def arm_angles(governor: Governor, part: Part, poses: FloatArray) -> FloatArray:
    """Of the right arm from the vertical (...) (rad)."""
    x, y = np.moveaxis(ball_spots(governor, part, poses), -1, 0)
    angles: FloatArray = np.arctan2(x - governor.offset, -y)
    return angles


def hung_height(governor: Governor, part: Part, poses: FloatArray) -> FloatArray:
    """Height (...) (m) at which the links would hang the lugs, at poses (..., bodies, 3)."""
    x, y = np.moveaxis(ball_spots(governor, part, poses), -1, 0)
    share = governor.joint / governor.arm
    reach = governor.offset + share * (x - governor.offset) - governor.lug
    hung: FloatArray = share * y - np.sqrt(np.maximum(governor.link**2 - reach**2, 0.0))
    return hung


def sleeve_height(governor: Governor, part: Part, poses: FloatArray) -> FloatArray:
    """Height (...) of the lugs (m) at poses (..., bodies, 3): the sleeve's own, or that of a sleeve without mass."""
    if governor.loaded:
        own: FloatArray = poses[..., part.mechanism.body_index(SLEEVE), 1]
        return own
    return hung_height(governor, part, poses)


def sides_of(governor: Governor, part: Part, pose: FloatArray) -> list[Side]:
    """The left half and the right one at a pose (bodies, 3)."""
    height = float((hung_height if governor.play else sleeve_height)(governor, part, pose))
    share, found = governor.joint / governor.arm, []
    for name, sign in ((LEFT, -1.0), (RIGHT, 1.0)):
        x, y = ball_spots(governor, part, pose, name).tolist()
        top = (sign * governor.offset, 0.0)
        knee = (top[0] + share * (x - top[0]), top[1] + share * (y - top[1]))
        found.append(Side(sign=sign, top=top, knee=knee, ball=(x, y), ring=(sign * governor.lug, height)))
    return found
