"""Bodies, joints, springs and readings of a Hartung governor.

The axes of a bell crank with its weight are parallel to those of the plane when the arm of the weight is upright.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.machines.base import rotate_point
from governor_mechanism.machines.hartung.dimensions import HartungDimensions
from governor_mechanism.machines.hartung.spring import build_spring_law
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import DerivedForce, LineAngle, PointCoordinate, Reading, SpringForce, StaticForce
from governor_mechanism.types import Vector2

RIGHT_WEIGHT, LEFT_WEIGHT, SLEEVE = "right weight", "left weight", "sleeve"
SPRING_NAME = "springs"


@dataclass(frozen=True, kw_only=True)
class HartungBuilder:
    """Builder of the mechanism. Without bell-crank masses, the weights are points on massless levers."""

    governor: HartungDimensions
    bell_cranks: BellCrankMasses | None = None

    def bodies(self) -> tuple[Body, ...]:
        """Return the weights with their bell cranks, and the sleeve."""
        mass = self.governor.weight_mass + self._crank_mass
        right, left = (Body(name=name, mass=mass, second_moments=self._second_moments(sign)) for name, sign in SIDE_SIGNS)
        return right, left, Body(name=SLEEVE, mass=self.governor.sleeve_mass, can_rotate=False)

    def joints(self) -> tuple[Joint, ...]:
        """Return fulcrums, hangers, and the guide of the sleeve."""
        joints: list[Joint] = []
        for name, sign in SIDE_SIGNS:
            side = name.split()[0]
            fulcrum = Point(body=GROUND, x=sign * self.governor.fulcrum_radius, y=self.governor.fulcrum_y)
            joints.append(Pin(name=f"{side} fulcrum", first=fulcrum, second=self.point_on_crank(name, (0.0, 0.0))))
            joints.append(self._hanger(side, name, sign))
        ground, sleeve = Point(body=GROUND), Point(body=SLEEVE)
        joints.append(Slider(name="spindle guide", first=ground, second=sleeve, angle=math.pi / 2))
        return tuple(joints)

    def spring(self) -> Spring:
        """Return one horizontal spring between the weights that replaces both springs.

        By symmetry it stretches twice as far as each spring, so it has half the rate.
        """
        spring_law = build_spring_law(self.governor)
        ends = (self.weight_centre(name) for name, _ in reversed(SIDE_SIGNS))
        return Spring(
            name=SPRING_NAME, first=next(ends), second=next(ends), stiffness=0.5 * spring_law.rate, free_length=2.0 * spring_law.free_radius
        )

    def readings(self, zero_lift_angle: float) -> tuple[Reading, ...]:
        """Return the readings; the sleeve lift is zero at the lever angle zero_lift_angle (rad)."""
        fulcrum = Point(body=GROUND, x=self.governor.fulcrum_radius, y=self.governor.fulcrum_y)
        return (
            LineAngle(name="lever_angle", quantity="angle", start=self.weight_centre(RIGHT_WEIGHT), end=fulcrum),
            PointCoordinate(
                name="weight_radius", quantity="length", point=self.weight_centre(RIGHT_WEIGHT), direction_x=1.0, direction_y=0.0
            ),
            PointCoordinate(
                name="sleeve_lift",
                quantity="length",
                point=Point(body=SLEEVE),
                direction_x=0.0,
                direction_y=1.0,
                zero=self.sleeve_height(zero_lift_angle),
            ),
        )

    def outputs(self) -> tuple[DerivedForce, ...]:
        """Return the derived forces: of each spring, at the sleeve, and the regulating force."""
        return (
            SpringForce(name="spring_force", spring=SPRING_NAME),
            StaticForce(name="static_sleeve_force", reading="sleeve_lift"),
            StaticForce(name="regulating_force", reading="sleeve_lift", fraction=self.governor.insensitivity),
        )

    def poses(self, lever_angle: float) -> tuple[tuple[float, float, float], ...]:
        """Return the poses of all bodies at a lever angle (rad)."""
        x, y = rotate_point(*self._mass_centre(1.0), lever_angle)
        right = (self.governor.fulcrum_radius + x, self.governor.fulcrum_y + y, lever_angle)
        return right, (-right[0], right[1], -lever_angle), (0.0, self.sleeve_height(lever_angle), 0.0)

    def sleeve_height(self, lever_angle: float) -> float:
        """Return the height of the sleeve above the cross axis at a lever angle (rad), m."""
        return self.governor.fulcrum_y + self.governor.lever_geometry.lug_height(lever_angle) - self.sleeve_drop

    @property
    def sleeve_drop(self) -> float:
        """Distance of the sleeve below the upper ends of vertical hangers, m. Its motion does not depend on it."""
        return 1.5 * self.governor.weight_arm if self.governor.hanger is None else 0.0

    def weight_centre(self, name: str) -> Point:
        """Return the centre of a weight on its body."""
        return self.point_on_crank(name, (0.0, self.governor.weight_arm))

    def hanger_top(self, name: str) -> Point:
        """Return the upper end of a hanger on its bell crank."""
        sign, (x, y) = dict(SIDE_SIGNS)[name], self._hanger_top
        return self.point_on_crank(name, (sign * x, y))

    def point_on_crank(self, name: str, position: Vector2) -> Point:
        """Return a point on a body from its position relative to the fulcrum in the axes of the crank (m)."""
        x, y = self._mass_centre(dict(SIDE_SIGNS)[name])
        return Point(body=name, x=position[0] - x, y=position[1] - y)

    @property
    def _crank_mass(self) -> float:
        return self.bell_cranks.mass if self.bell_cranks else 0.0

    @property
    def _hanger_top(self) -> Vector2:
        """Position of the right hanger's upper end relative to the fulcrum, m."""
        angle, arm = self.governor.bell_crank_angle, self.governor.sleeve_arm
        return -arm * math.sin(angle), arm * math.cos(angle)

    def _arm_masses(self) -> list[tuple[float, Vector2]]:
        """Return masses (kg, in proportion to length) and ends (m) of the arms of the right bell crank; both start at the fulcrum."""
        a, b = self.governor.weight_arm, self.governor.sleeve_arm
        return [(self._crank_mass * a / (a + b), (0.0, a)), (self._crank_mass * b / (a + b), self._hanger_top)]

    def _mass_centre(self, sign: float) -> Vector2:
        """Return the mass centre of weight and bell crank relative to the fulcrum, m."""
        mass, a = self.governor.weight_mass, self.governor.weight_arm
        total_mass = mass + self._crank_mass
        x = sum(rod * end[0] / 2 for rod, end in self._arm_masses()) / total_mass
        y = (mass * a + sum(rod * end[1] / 2 for rod, end in self._arm_masses())) / total_mass
        return sign * x, y

    def _second_moments(self, sign: float) -> SecondMoments:
        """Return the second moments of a block and two slender arms about their mass centre."""
        if self.bell_cranks is None:
            return SecondMoments()
        bell_cranks = self.bell_cranks
        mass, a, (x, y) = self.governor.weight_mass, self.governor.weight_arm, self._mass_centre(1.0)
        total_mass = mass + self._crank_mass
        # About the fulcrum, a rod from there to (u, v) has the second moment m u^2 / 3, and so on.
        xx = mass * bell_cranks.weight_width**2 / 12 + sum(rod * end[0] ** 2 / 3 for rod, end in self._arm_masses())
        yy = mass * (a**2 + bell_cranks.weight_height**2 / 12) + sum(rod * end[1] ** 2 / 3 for rod, end in self._arm_masses())
        xy = sum(rod * end[0] * end[1] / 3 for rod, end in self._arm_masses())
        return SecondMoments(
            xx=xx - total_mass * x**2,
            yy=yy - total_mass * y**2,
            xy=sign * (xy - total_mass * x * y),
            zz=mass * bell_cranks.weight_depth**2 / 12,
        )

    def _hanger(self, side: str, name: str, sign: float) -> Joint:
        """Return a rod to the lug of the sleeve. With a vertical hanger, bell crank and sleeve have equal vertical displacements."""
        hanger_top, length = self.hanger_top(name), self.governor.hanger
        if length is None:
            sleeve_point = Point(body=SLEEVE, y=self.sleeve_drop)
            return Slider(name=f"{side} hanger", first=sleeve_point, second=hanger_top, angle=0.0)
        lug = Point(body=SLEEVE, x=sign * self.governor.lug_offset)
        return Distance(name=f"{side} hanger", first=hanger_top, second=lug, length=length)


SIDE_SIGNS = ((RIGHT_WEIGHT, 1.0), (LEFT_WEIGHT, -1.0))
