"""Hartung governor: two spring-loaded weights on bell cranks, with hangers to the sleeve.

Geometry after Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), p. 618. The plane turns with the spindle: x is measured from the
spindle axis, y up from the cross axis of the governor. The lever angle is that of the weight's arm from the upright, positive toward the
spindle: it is largest when the weights are innermost. The axes of a bell crank with its weight are
parallel to those of the plane when the arm of the weight is upright.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.stops import Stops
from governor_mechanism.machines.base import rotate_point, travel_problems, unit_hint, x_coordinate, y_coordinate
from governor_mechanism.machines.hartung.dimensions import SPEED_DIMENSIONS, STRESS_LIMIT_DIMENSION, WIRE_DIMENSIONS, HartungDimensions
from governor_mechanism.machines.mass_elements import MassElement, join_elements, slender_rod
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import LineAngle, Reading, SpringForce, StaticForce
from governor_mechanism.types import Vector2
from governor_mechanism.units.quantities import format_quantity

RIGHT_WEIGHT, LEFT_WEIGHT, SLEEVE = "right weight", "left weight", "sleeve"
SPRING_NAME = "springs"


SIDE_SIGNS = {RIGHT_WEIGHT: 1.0, LEFT_WEIGHT: -1.0}


@dataclass(frozen=True, kw_only=True)
class HartungBuilder:
    """Builder of the mechanism. Without bell-crank masses, the weights are points on massless levers."""

    governor: HartungDimensions
    bell_cranks: BellCrankMasses | None

    def mechanism(self) -> Mechanism:
        """Return the mechanism."""
        governor = self.governor
        return Mechanism(
            bodies=self._bodies(),
            joints=self._joints(),
            readings=self._readings(),
            # of each spring, at the sleeve, and the regulating force
            derived_readings=(
                SpringForce(name="spring_force", spring=SPRING_NAME),
                StaticForce(name="static_sleeve_force", reading="sleeve_lift"),
                StaticForce(name="regulating_force", reading="sleeve_lift", fraction=governor.insensitivity),
            ),
            coordinate="lever_angle",
            length_scale=max(governor.weight_arm, governor.sleeve_arm),
            initial_guess=self._poses(governor.middle_angle),
            limits=(governor.travel_limit(),),
            force_elements=(self._spring(),),
            notes=governor.stress_warnings(),
        )

    def _bodies(self) -> tuple[Body, ...]:
        """Return the weights with their bell cranks, and the sleeve."""
        crank = self._right_crank
        left_moments = replace(crank.moments, xy=0.0 - crank.moments.xy)
        sides = ((RIGHT_WEIGHT, crank.moments), (LEFT_WEIGHT, left_moments))
        weights = (Body(name=name, mass=crank.mass, second_moments=moments) for name, moments in sides)
        return *weights, Body(name=SLEEVE, mass=self.governor.sleeve_mass, can_rotate=False)

    def _joints(self) -> tuple[Joint, ...]:
        """Return fulcrums, hangers, and the guide of the sleeve."""
        joints: list[Joint] = []
        for name, sign in SIDE_SIGNS.items():
            side = name.split()[0]
            joints.append(Pin(name=f"{side} fulcrum", first=self._fulcrum(sign), second=self._point_on_crank(name, (0.0, 0.0))))
            joints.append(self._hanger(f"{side} hanger", name, sign))
        joints.append(Slider(name="spindle guide", first=Point(body=GROUND), second=Point(body=SLEEVE), angle=math.pi / 2))
        return tuple(joints)

    def _spring(self) -> Spring:
        """Return one horizontal spring between the weights that replaces both springs.

        By symmetry it stretches twice as far as each spring, so it has half the rate.
        """
        law = self.governor.spring_law()
        left, right = self._weight_centre(LEFT_WEIGHT), self._weight_centre(RIGHT_WEIGHT)
        free_radius = law.radius - law.preload / law.rate
        return Spring(name=SPRING_NAME, first=left, second=right, stiffness=0.5 * law.rate, free_length=2.0 * free_radius)

    def _readings(self) -> tuple[Reading, ...]:
        """Return the readings; the sleeve lift is zero at the inner end of the stroke, or at the lever angle zero."""
        weight_centre = self._weight_centre(RIGHT_WEIGHT)
        zero = self._sleeve_height(self.governor.inner_angle or 0.0)
        return (
            LineAngle(name="lever_angle", quantity="angle", start=weight_centre, end=self._fulcrum(1.0)),
            x_coordinate("weight_radius", weight_centre),
            y_coordinate("sleeve_lift", Point(body=SLEEVE), zero=zero),
        )

    def _poses(self, lever_angle: float) -> tuple[tuple[float, float, float], ...]:
        """Return the poses of all bodies at a lever angle (rad)."""
        x, y = rotate_point(*self._right_crank.centre, lever_angle)
        x, y = self.governor.fulcrum_radius + x, self.governor.fulcrum_y + y
        return (x, y, lever_angle), (-x, y, -lever_angle), (0.0, self._sleeve_height(lever_angle), 0.0)

    def _sleeve_height(self, lever_angle: float) -> float:
        """Return the height of the sleeve above the cross axis at a lever angle (rad), m."""
        return self.governor.fulcrum_y + self.governor.lug_height(lever_angle) - self._sleeve_drop

    @property
    def _sleeve_drop(self) -> float:
        """Distance of the sleeve below the upper ends of vertical hangers, m. Its motion does not depend on it."""
        return 1.5 * self.governor.weight_arm if self.governor.hanger is None else 0.0

    def _fulcrum(self, sign: float) -> Point:
        return Point(body=GROUND, x=sign * self.governor.fulcrum_radius, y=self.governor.fulcrum_y)

    def _weight_centre(self, name: str) -> Point:
        return self._point_on_crank(name, (0.0, self.governor.weight_arm))

    def _point_on_crank(self, name: str, position: Vector2) -> Point:
        """Return a point on a body from its position relative to the fulcrum in the axes of the crank (m)."""
        x, y = self._right_crank.centre
        return Point(body=name, x=position[0] - SIDE_SIGNS[name] * x, y=position[1] - y)

    @property
    def _hanger_top(self) -> Vector2:
        """Position of the right hanger's upper end relative to the fulcrum, m."""
        angle, arm = self.governor.bell_crank_angle, self.governor.sleeve_arm
        return -arm * math.sin(angle), arm * math.cos(angle)

    @cached_property
    def _right_crank(self) -> MassElement:
        """The right weight, a block, on the two slender arms of its bell crank, with the fulcrum in the origin."""
        mass, a, b, cranks = self.governor.weight_mass, self.governor.weight_arm, self.governor.sleeve_arm, self.bell_cranks
        if cranks is None:
            return MassElement(mass=mass, centre=(0.0, a))
        width, height, depth = cranks.weight_width, cranks.weight_height, cranks.weight_depth
        moments = SecondMoments(xx=mass * width**2 / 12, yy=mass * height**2 / 12, zz=mass * depth**2 / 12)
        elements = [MassElement(mass=mass, centre=(0.0, a), moments=moments)]
        if cranks.mass:
            elements += [slender_rod(cranks.mass * a / (a + b), (0.0, a)), slender_rod(cranks.mass * b / (a + b), self._hanger_top)]
        return join_elements(elements)

    def _hanger(self, name: str, weight: str, sign: float) -> Joint:
        """Return a rod to the lug of the sleeve. With a vertical hanger, bell crank and sleeve have equal vertical displacements."""
        x, y = self._hanger_top
        top = self._point_on_crank(weight, (sign * x, y))
        if self.governor.hanger is None:
            return Slider(name=name, first=Point(body=SLEEVE, y=self._sleeve_drop), second=top, angle=0.0)
        return Distance(name=name, first=top, second=Point(body=SLEEVE, x=sign * self.governor.lug_offset), length=self.governor.hanger)


@dataclass(frozen=True, kw_only=True)
class HartungGovernor(HartungDimensions):
    """Two weights as points on massless bell cranks, unless an effect gives these mass, and a sleeve on hangers.

    Lengths in m, masses in kg, angles in rad, speeds in rad/s. A horizontal spring presses each weight inward at its centre. It is given by
    its force at a radius and its rate or its wire, or by the two equilibrium speeds at the ends of the stroke, under the gravity of the
    scene (`under_gravity`), or under 9.81 m/s2 without a scene.
    """

    name: ClassVar[str] = "hartung"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "lever_angle": "angle of the weight arms of the bell cranks from the upright, positive inward",
        "weight_radius": "distance of the centre of the right weight from the spindle axis",
        "sleeve_lift": "height of the sleeve above its position at the inner end of the stroke, or with upright weight arms",
        "spring_force": "force of the spring between the weights, positive in tension",
        "static_sleeve_force": "force on the sleeve, upward, that balances springs and weights without rotation",
        "regulating_force": "the share insensitivity of static_sleeve_force",
    }
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (BellCrankMasses,)

    def dimension_problems(self) -> list[str]:
        """Return sentences about angles, stroke and springs."""
        return [*self._angle_problems(), *self._stroke_problems(), *self.spring_problems()]

    def mechanism(self, bell_cranks: BellCrankMasses | None = None) -> Mechanism:
        """Build weights, sleeve, hangers and springs; with bell-crank masses, levers and weights have mass and size."""
        return HartungBuilder(governor=self, bell_cranks=bell_cranks).mechanism()

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI: the spring by its rate and its force at preload_radius, a vertical hanger as infinite."""
        spring = self.spring_law()
        replaced = {"spring_rate": spring.rate, "spring_preload": spring.preload, "preload_radius": spring.radius}
        values = super().dimensions() | replaced | {"fulcrum_height": self.fulcrum_y}
        left_out = {"inner_angle", "outer_angle", *WIRE_DIMENSIONS, STRESS_LIMIT_DIMENSION, *SPEED_DIMENSIONS}
        return {name: value for name, value in values.items() if name not in left_out}

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start angle outside the travel."""
        return travel_problems(values, self.travel_limit(), math.pi / 2, "10 deg")

    def _angle_problems(self) -> list[str]:
        degrees = math.degrees(self.bell_crank_angle)
        if 90.0 - 1e-9 <= degrees <= 180.0:
            return []
        return [
            f"bell_crank_angle ({degrees:.6g} deg) must lie between 90 deg, Hartung's old right angle, and 180 deg, an "
            "arm in line with the other: outside this range the sleeve does not rise as the weights move outward"
            f"{unit_hint(self.bell_crank_angle, math.tau, '132 deg')}"
        ]

    def _stroke_problems(self) -> list[str]:
        """Return sentences about a reversed stroke or one that lever or hanger cannot complete."""
        if self.inner_angle is None or self.outer_angle is None:
            missing = [name for name in ("inner_angle", "outer_angle") if getattr(self, name) is None]
            stroke = [] if len(missing) == 2 else [f"{missing[0]} is missing; a stroke needs both of its ends"]
            return [*stroke, *self._reach_problems(0.0, 0.0)]
        if self.outer_angle >= self.inner_angle:
            return [
                f"inner_angle ({format_quantity(self.inner_angle, 'rad')}) must exceed outer_angle "
                f"({format_quantity(self.outer_angle, 'rad')}): the lever angle is positive toward the spindle; exchange them"
            ]
        return self._reach_problems(self.outer_angle, self.inner_angle)

    def stop_problems(self, effects: Iterable[Effect]) -> list[str]:
        """Return sentences about stops that the lever cannot reach."""
        problems = []
        for stops in (one for one in effects if isinstance(one, Stops) and one.reading == "lever_angle"):
            ends = [self.middle_angle, *filter(math.isfinite, (stops.low, stops.high))]
            if failure := self.first_failure(min(ends), max(ends)):
                location = f"at {format_quantity(failure[0], 'rad')} {failure[1].sentence}"
                problems.append(f"the stops of 'lever_angle' are too far apart: {location}; move them nearer")
        return problems

    def _reach_problems(self, outer_angle: float, inner_angle: float) -> list[str]:
        failure = None if self._angle_problems() else self.first_failure(outer_angle, inner_angle)
        if failure is None:
            return []
        lever_angle, (sentence, cure) = failure
        hint = unit_hint(max(inner_angle, -outer_angle), math.pi / 2, "15 deg") or f"; {cure}, or shorten the stroke"
        return [
            f"the stroke, lever_angle from {format_quantity(outer_angle, 'rad')} to {format_quantity(inner_angle, 'rad')}, "
            f"is not possible: at {format_quantity(lever_angle, 'rad')} {sentence}{hint}"
        ]
