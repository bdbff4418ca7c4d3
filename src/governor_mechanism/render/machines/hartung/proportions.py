"""The sizes of a Hartung governor's drawing, and where its weights, bell cranks and hangers stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.machines.hartung.machine import LEFT, RIGHT, SLEEVE
from governor_mechanism.model.mechanism import Coordinate
from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.geometry.primitives import CAST_IRON, Pair
from governor_mechanism.types import FloatArray

# What the scene does not say is drawn in a proportion to the weights' arm, below called u.
SPINDLE = 0.115
"""half width"""
NOMINAL = 0.26
"""sine of the lever's swing that weights and springs are laid out for"""


@dataclass(frozen=True, kw_only=True)
class Governor:
    """The dimensions a drawing needs, in m, kg and rad; hanger is infinite where it is always vertical.

    half_width and half_height are those of a weight, turning tells whether it turns with its arm. seat is where the
    springs end, from the axis; zero the height at which the lift is nought. acting is what the scene lists.
    """

    arm: float
    sleeve_arm: float
    angle: float
    fulcrum: Pair
    hanger: float
    lug: float
    sleeve_mass: float
    half_width: float
    half_height: float
    turning: bool
    seat: float
    zero: float
    acting: Acting = NOTHING

    @property
    def bore(self) -> float:
        """Half height of the bore that holds a weight's spring (m)."""
        return 0.48 * self.half_height

    @property
    def load(self) -> Pair:
        """Half width and depth below the lugs (m) of a sleeve of cast iron with its mass, as far as it looks well."""
        radius = math.cbrt(self.sleeve_mass / (1.3 * math.pi * CAST_IRON))
        reach = abs(self.lug) + 0.22 * self.arm
        if math.isinf(self.hanger):
            feet = (self.fulcrum[0] - self.sleeve_arm * math.sin(self.angle + lever) for lever in self.swing)
            reach = max(0.42 * self.arm, *(abs(foot) + 0.11 * self.arm for foot in feet))
        radius = max(min(max(radius, 0.45 * self.arm), 1.1 * self.arm), reach)
        return radius, 0.2 * self.arm + 1.0 * radius

    @property
    def swing(self) -> Pair:
        """Between what lever angles the run goes (rad)."""
        return self.acting.ranges.get("lever_angle", (0.0, 0.0))

    def radius(self, lever: float) -> float:
        """Of a weight's centre from the axis (m)."""
        return self.fulcrum[0] - self.arm * math.sin(lever)


@dataclass(frozen=True, kw_only=True)
class Side:
    """One half at one pose: its sign (-1 left, 1 right), lever angle (rad), and where its joints are (m)."""

    sign: float
    lever: float
    fulcrum: Pair
    weight: Pair
    foot: Pair
    lug: Pair


def governor_of(part: Part, acting: Acting = NOTHING) -> Governor:
    """What the drawing of a part needs to know of it."""
    given, cranks = part.dimensions, acting.one(BellCranks)
    arm, radius, mass = given["weight_arm"], given["fulcrum_radius"], given["weight_mass"]
    half_width = 0.83 * max(radius - NOMINAL * arm, 0.3 * arm)
    # A block of cast iron, as deep as it is high.
    half_height = 0.5 * math.sqrt(mass / (CAST_IRON * 2 * half_width))
    half_height = min(max(half_height, 0.45 * arm), 0.82 * arm)
    if cranks and cranks.weight_width and cranks.weight_height:
        half_width, half_height = cranks.weight_width / 2, cranks.weight_height / 2
    outermost = max(acting.ranges.get("weight_radius", (0.0, 0.0))[1], radius + NOMINAL * arm)
    lift = part.mechanism.reading("sleeve_lift")
    return Governor(
        arm=arm,
        sleeve_arm=given["sleeve_arm"],
        angle=given["bell_crank_angle"],
        fulcrum=(radius, given["fulcrum_height"]),
        hanger=given["hanger"],
        lug=given["lug_offset"],
        sleeve_mass=given["sleeve_mass"],
        half_width=half_width,
        half_height=half_height,
        turning=bool(cranks and (cranks.weight_width or cranks.weight_height)),
        seat=outermost + half_width + 0.22 * arm,
        zero=lift.zero if isinstance(lift, Coordinate) else 0.0,
        acting=acting,
    )


def sleeve_height(part: Part, poses: FloatArray) -> FloatArray:
    """Height (...) of the sleeve's lugs (m) at poses (..., bodies, 3)."""
    height: FloatArray = poses[..., part.mechanism.body_index(SLEEVE), 1]
    return height


def weight_spots(governor: Governor, part: Part, poses: FloatArray) -> FloatArray:
    """Where the right weight's centre stands (..., 2) (m) at poses (..., bodies, 3)."""
    lever, (x, y) = poses[..., part.mechanism.body_index(RIGHT), 2], governor.fulcrum
    spots: FloatArray = np.stack([x - governor.arm * np.sin(lever), y + governor.arm * np.cos(lever)], axis=-1)
    return spots


def sides_of(governor: Governor, part: Part, pose: FloatArray) -> list[Side]:
    """The left half and the right one at a pose (bodies, 3)."""
    height, found = float(sleeve_height(part, pose)), []
    for name, sign in ((LEFT, -1.0), (RIGHT, 1.0)):
        lever = sign * float(pose[part.mechanism.body_index(name), 2])
        x, y = governor.fulcrum
        turn = governor.angle + lever
        foot = x - governor.sleeve_arm * math.sin(turn), y + governor.sleeve_arm * math.cos(turn)
        lug = (foot[0] if math.isinf(governor.hanger) else governor.lug, height)
        spots = ((x, y), (governor.radius(lever), y + governor.arm * math.cos(lever)), foot, lug)
        fulcrum, weight, foot, lug = ((sign * px, py) for px, py in spots)
        found.append(Side(sign=sign, lever=lever, fulcrum=fulcrum, weight=weight, foot=foot, lug=lug))
    return found
