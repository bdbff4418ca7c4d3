"""The bodies, joints, springs and readings of a Hartung governor, as its dimensions and its bell cranks make them.

Axes of a bell crank with its weight: those of the plane where the weights' arm stands upright.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import (
    Body,
    Coordinate,
    LineAngle,
    Output,
    Reading,
    SecondMoments,
    SpringForce,
    StaticForce,
)

if TYPE_CHECKING:
    from governor_mechanism.machines.hartung.machine import HartungGovernor

RIGHT, LEFT, SLEEVE = "right weight", "left weight", "sleeve"
SPRING = "springs"

Pair = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Parts:
    """What a governor is put together from; without cranks its weights are points on massless levers."""

    governor: HartungGovernor
    cranks: BellCranks | None = None

    def bodies(self) -> tuple[Body, ...]:
        """The weights with their bell cranks, and the sleeve."""
        mass = self.governor.weight_mass + self._crank_mass
        right, left = (Body(name=name, mass=mass, moments=self._moments(sign)) for name, sign in SIDES)
        return right, left, Body(name=SLEEVE, mass=self.governor.sleeve_mass, turns=False)

    def joints(self) -> tuple[Joint, ...]:
        """Fulcrums, hangers, and the sleeve's guide on the spindle."""
        joints: list[Joint] = []
        for name, sign in SIDES:
            side = name.split()[0]
            fixed = Point(body=GROUND, x=sign * self.governor.fulcrum_radius, y=self.governor.fulcrum)
            joints.append(Pin(name=f"{side} fulcrum", first=fixed, second=self.on_crank(name, (0.0, 0.0))))
            joints.append(self._hanger(side, name, sign))
        ground, sleeve = Point(body=GROUND), Point(body=SLEEVE)
        joints.append(Slider(name="spindle guide", first=ground, second=sleeve, angle=math.pi / 2))
        return tuple(joints)

    def spring(self) -> Spring:
        """Both springs in one, from weight to weight: level, and on each weight the force of its own.

        The weights stand even about the axis, so a spring of half the rate between them is stretched by twice as much.
        """
        line = self.governor.spring()
        ends = (self.weight(name) for name, _ in reversed(SIDES))
        return Spring(
            name=SPRING,
            first=next(ends),
            second=next(ends),
            stiffness=0.5 * line.rate,
            free_length=2.0 * line.free_radius,
        )

    def readings(self, down: float) -> tuple[Reading, ...]:
        """What the governor tells; the sleeve's lift is counted from its place at the lever angle `down` (rad)."""
        fixed = Point(body=GROUND, x=self.governor.fulcrum_radius, y=self.governor.fulcrum)
        return (
            LineAngle(name="lever_angle", quantity="angle", start=self.weight(RIGHT), end=fixed),
            Coordinate(name="weight_radius", quantity="length", point=self.weight(RIGHT), along_x=1.0, along_y=0.0),
            Coordinate(
                name="sleeve_lift",
                quantity="length",
                point=Point(body=SLEEVE),
                along_x=0.0,
                along_y=1.0,
                zero=self.sleeve_height(down),
            ),
        )

    def outputs(self) -> tuple[Output, ...]:
        """Forces that follow from the pose: of each spring, at the sleeve, and what the governor can shift there."""
        return (
            SpringForce(name="spring_force", spring=SPRING),
            StaticForce(name="static_sleeve_force", reading="sleeve_lift"),
            StaticForce(name="regulating_force", reading="sleeve_lift", part=self.governor.insensitivity),
        )

    def poses(self, lever: float) -> tuple[tuple[float, float, float], ...]:
        """Of all bodies, at a lever angle (rad)."""
        x, y = _turned(self._centre(1.0), lever)
        right = (self.governor.fulcrum_radius + x, self.governor.fulcrum + y, lever)
        return right, (-right[0], right[1], -lever), (0.0, self.sleeve_height(lever), 0.0)

    def sleeve_height(self, lever: float) -> float:
        """Of the sleeve above the cross axis at a lever angle (rad), m."""
        return self.governor.fulcrum + self.governor.way.lug_height(lever) - self.drop

    @property
    def drop(self) -> float:
        """How far below the upper ends of vertical hangers the sleeve is drawn (m); it moves alike at any length."""
        return 1.5 * self.governor.weight_arm if self.governor.hanger is None else 0.0

    def weight(self, name: str) -> Point:
        """The centre of a weight, on its body."""
        return self.on_crank(name, (0.0, self.governor.weight_arm))

    def foot(self, name: str) -> Point:
        """The upper end of a hanger, on its bell crank."""
        sign, (x, y) = dict(SIDES)[name], self._foot
        return self.on_crank(name, (sign * x, y))

    def on_crank(self, name: str, place: Pair) -> Point:
        """A point so far from the fulcrum (m, in the crank's axes), on its body."""
        x, y = self._centre(dict(SIDES)[name])
        return Point(body=name, x=place[0] - x, y=place[1] - y)

    @property
    def _crank_mass(self) -> float:
        return self.cranks.mass if self.cranks else 0.0

    @property
    def _foot(self) -> Pair:
        """The right hanger's upper end from the fulcrum (m)."""
        angle, arm = self.governor.bell_crank_angle, self.governor.sleeve_arm
        return -arm * math.sin(angle), arm * math.cos(angle)

    def _rods(self) -> list[tuple[float, Pair]]:
        """The arms of the right bell crank: masses, shared by length, and ends; both start at the fulcrum."""
        a, b = self.governor.weight_arm, self.governor.sleeve_arm
        return [(self._crank_mass * a / (a + b), (0.0, a)), (self._crank_mass * b / (a + b), self._foot)]

    def _centre(self, sign: float) -> Pair:
        """The common mass centre of weight and bell crank, from the fulcrum (m)."""
        mass, a = self.governor.weight_mass, self.governor.weight_arm
        whole = mass + self._crank_mass
        x = sum(rod * end[0] / 2 for rod, end in self._rods()) / whole
        y = (mass * a + sum(rod * end[1] / 2 for rod, end in self._rods())) / whole
        return sign * x, y

    def _moments(self, sign: float) -> SecondMoments:
        """Of the weight as a block and two slender arms, about their common mass centre."""
        if self.cranks is None:
            return SecondMoments()
        cranks = self.cranks
        mass, a, (x, y) = self.governor.weight_mass, self.governor.weight_arm, self._centre(1.0)
        whole = mass + self._crank_mass
        # About the fulcrum: a rod from there to (u, v) has m u^2 / 3 and so on.
        xx = mass * cranks.weight_width**2 / 12 + sum(rod * end[0] ** 2 / 3 for rod, end in self._rods())
        yy = mass * (a**2 + cranks.weight_height**2 / 12) + sum(rod * end[1] ** 2 / 3 for rod, end in self._rods())
        xy = sum(rod * end[0] * end[1] / 3 for rod, end in self._rods())
        return SecondMoments(
            xx=xx - whole * x**2,
            yy=yy - whole * y**2,
            xy=sign * (xy - whole * x * y),
            zz=mass * cranks.weight_depth**2 / 12,
        )

    def _hanger(self, side: str, name: str, sign: float) -> Joint:
        """A rod to the sleeve's lug; where it always hangs vertical, bell crank and sleeve move up and down alike."""
        foot, length = self.foot(name), self.governor.hanger
        if length is None:
            over = Point(body=SLEEVE, y=self.drop)
            return Slider(name=f"{side} hanger", first=over, second=foot, angle=0.0)
        lug = Point(body=SLEEVE, x=sign * self.governor.lug_offset)
        return Distance(name=f"{side} hanger", first=foot, second=lug, length=length)


SIDES = ((RIGHT, 1.0), (LEFT, -1.0))


def _turned(place: Pair, angle: float) -> Pair:
    c, s = math.cos(angle), math.sin(angle)
    return c * place[0] - s * place[1], s * place[0] + c * place[1]
