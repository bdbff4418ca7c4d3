"""Hartung governor: two spring-loaded weights on bell cranks, with hangers to the sleeve.

A spring is described by its rate, by its wire, or by the equilibrium speeds at the ends of the stroke.

Geometry after Fr. Dubois, Dinglers Polytechnisches Journal 327 (1912), p. 618. The plane turns with the spindle: x is measured from the
spindle axis, y up from the cross axis of the governor. The lever angle is that of the weight's arm from the upright, positive toward the
spindle: it is largest when the weights are innermost. The axes of a bell crank with its weight are
parallel to those of the plane when the arm of the weight is upright.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Any, ClassVar, NamedTuple, Self

from governor_mechanism.effects.body_forces import DEFAULT_GRAVITY
from governor_mechanism.effects.holding import Stops
from governor_mechanism.effects.masses import BellCrankMasses
from governor_mechanism.effects.spring import helical_spring_rate
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import (
    Machine,
    MassElement,
    join_elements,
    rotate_point,
    sleeve_lift,
    slender_rod,
    travel_problems,
    unit_hint,
    x_coordinate,
)
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import Limit, LineAngle, Reading, SpringForce, StaticForce
from governor_mechanism.types import Vector2
from governor_mechanism.units.constants import TECHNICAL_ATMOSPHERE_1901
from governor_mechanism.units.fields import optional, quantity
from governor_mechanism.units.quantities import format_quantity

N_TRAVEL_SAMPLES = 720
"""Samples per quarter turn to bracket an end of the travel, before bisection."""

WIRE_DIMENSIONS = ("spring_wire", "spring_coil", "spring_turns", "spring_modulus")
SPEED_DIMENSIONS = ("inner_speed", "outer_speed")
SPRING_DESCRIPTIONS = (("spring_rate",), WIRE_DIMENSIONS, SPEED_DIMENSIONS)
"""Alternative descriptions of the spring; the first two do not determine its preload."""
PRELOAD_DIMENSION = "spring_preload"
PRELOAD_RADIUS_DIMENSION = "preload_radius"
STRESS_LIMIT_DIMENSION = "spring_stress_limit"
SPRING_DIMENSIONS = (*chain(*SPRING_DESCRIPTIONS), PRELOAD_DIMENSION, PRELOAD_RADIUS_DIMENSION, STRESS_LIMIT_DIMENSION)


class Failure(NamedTuple):
    """Why the governor does not work at a lever angle, and the cure."""

    sentence: str
    cure: str


ARMS_LEVEL_OUTERMOST = Failure("the weights' arms are horizontal, outermost (dead centre)", "keep outer_angle above -90 deg")
ARMS_LEVEL_INNERMOST = Failure("the weights' arms are horizontal, innermost (dead centre)", "keep inner_angle below 90 deg")
WEIGHTS_MEET = Failure("the weights meet on the spindle axis", "raise fulcrum_radius")
LEVER_DEAD_CENTRE = Failure(
    "the sleeve has a turning point: the lever no longer lifts it", "lower bell_crank_angle, lengthen the hanger where it has a length"
)
HANGER_TOO_SHORT = Failure("the hanger is too short: it is at 90 degrees to the spindle", "lengthen the hanger")


@dataclass(frozen=True, kw_only=True)
class LinearSpringLaw:
    """Linear law of one spring: it presses its weight inward with preload (N) at a radius (m), increasing with rate (N/m)."""

    rate: float
    preload: float
    radius: float

    def force(self, radius: float) -> float:
        """Return the force (N) for the weight at a radius (m)."""
        return self.preload + self.rate * (radius - self.radius)


@dataclass(frozen=True, kw_only=True)
class HartungDimensions(Machine):
    """Dimensions of a Hartung governor. Lengths in m, masses in kg, angles in rad, speeds in rad/s."""

    weight_arm: float = quantity("length", meaning="from the fulcrum of a bell crank to its weight's centre")
    sleeve_arm: float = quantity("length", meaning="from the fulcrum to the hanger")
    bell_crank_angle: float = quantity("angle", default=math.pi / 2, meaning="between its two arms, 90 to 180 deg")
    fulcrum_radius: float = quantity("length", meaning="of the fulcrum from the spindle axis")
    fulcrum_height: float | None = optional(
        "length", sign="any", meaning="of the fulcrum above the cross axis; as far below as weight_arm is long, if left out"
    )
    weight_mass: float = quantity("mass", meaning="of one weight; there are two")
    sleeve_mass: float = quantity("mass", meaning="of the whole sleeve and its load")
    hanger: float | None = optional("length", words=("vertical",), meaning="of the hangers, from bell crank to sleeve")
    lug_offset: float = quantity("length", sign="any", default=0.0, meaning="of the sleeve's lugs from the axis")
    inner_angle: float | None = optional("angle", sign="any", meaning="of the lever at the inner end of the stroke")
    outer_angle: float | None = optional("angle", sign="any", meaning="of the lever at the outer end of the stroke")
    spring_rate: float | None = optional("stiffness", meaning="of each spring")
    spring_preload: float | None = optional("force", sign="any", meaning="of each spring at preload_radius")
    preload_radius: float | None = optional(
        "length", meaning="of a weight where spring_preload is its spring's force; fulcrum_radius if left out"
    )
    spring_wire: float | None = optional("length", meaning="of each spring's wire, its diameter")
    spring_coil: float | None = optional("length", meaning="of each spring's coil, its mean diameter")
    spring_turns: float | None = optional("number", meaning="of each spring's active turns")
    spring_modulus: float | None = optional("modulus", meaning="of the springs' wire")
    spring_stress_limit: float | None = optional("pressure", meaning="that the springs' wire may bear")
    inner_speed: float | None = optional("angular_speed", meaning="that holds the weights at the inner end of the stroke")
    outer_speed: float | None = optional("angular_speed", meaning="that holds the weights at the outer end of the stroke")
    insensitivity: float = quantity("ratio", default=0.04, meaning="that the regulating force is computed with")

    @property
    def fulcrum_y(self) -> float:
        """Height of the fulcrum above the cross axis, m."""
        return -self.weight_arm if self.fulcrum_height is None else self.fulcrum_height

    @property
    def middle_angle(self) -> float:
        """Lever angle at mid stroke, rad; 0 without a stroke."""
        if self.inner_angle is None or self.outer_angle is None:
            return 0.0
        return 0.5 * (self.inner_angle + self.outer_angle)

    def weight_radius(self, lever_angle: float) -> float:
        """Return the distance of a weight's centre from the axis, m."""
        return self.fulcrum_radius - self.weight_arm * math.sin(lever_angle)

    def hanger_top(self, lever_angle: float) -> Vector2:
        """Return the upper end of the right hanger: distance from the axis and height above the fulcrum, m."""
        sleeve_arm_angle = self.bell_crank_angle + lever_angle
        return self.fulcrum_radius - self.sleeve_arm * math.sin(sleeve_arm_angle), self.sleeve_arm * math.cos(sleeve_arm_angle)

    def lug_height(self, lever_angle: float) -> float:
        """Return the height of the sleeve's lugs above the fulcrum, m; that of the hangers' upper ends for vertical hangers."""
        x, y = self.hanger_top(lever_angle)
        return y if self.hanger is None else y - math.sqrt(self.hanger**2 - (x - self.lug_offset) ** 2)

    def lift_derivative(self, lever_angle: float) -> float:
        """Return the derivative of the sleeve height with respect to the lever angle, m/rad."""
        sleeve_arm_angle = self.bell_crank_angle + lever_angle
        x, _ = self.hanger_top(lever_angle)
        hanger_tangent = 0.0
        if self.hanger is not None:
            reach = x - self.lug_offset
            hanger_tangent = reach / math.sqrt(self.hanger**2 - reach**2)
        return -self.sleeve_arm * (math.sin(sleeve_arm_angle) + math.cos(sleeve_arm_angle) * hanger_tangent)

    def failure_at(self, lever_angle: float) -> Failure | None:
        """Return why the governor does not work at a lever angle (rad), or None if it does."""
        if abs(lever_angle) >= math.pi / 2:
            return ARMS_LEVEL_INNERMOST if lever_angle > 0 else ARMS_LEVEL_OUTERMOST
        if self.weight_radius(lever_angle) <= 0:
            return WEIGHTS_MEET
        if self.hanger is not None and abs(self.hanger_top(lever_angle)[0] - self.lug_offset) >= self.hanger:
            return HANGER_TOO_SHORT
        return LEVER_DEAD_CENTRE if self.lift_derivative(lever_angle) >= 0 else None

    def first_failure(self, outer_angle: float, inner_angle: float) -> tuple[float, Failure] | None:
        """Return the first failing lever angle (rad) of a stroke from outer to inner end and its reason, or None."""
        n_samples = max(round((inner_angle - outer_angle) / (math.pi / 2) * N_TRAVEL_SAMPLES), 1)
        angles = (outer_angle + (inner_angle - outer_angle) * k / n_samples for k in range(n_samples + 1))
        return next(((angle, failure) for angle in angles if (failure := self.failure_at(angle))), None)

    def travel_limit(self) -> Limit:
        """Return the working range of the lever angle around mid stroke."""
        (low, low_message), (high, high_message) = (self._travel_end(side) for side in (-1.0, 1.0))
        return Limit(reading="lever_angle", low=low, high=high, low_message=low_message, high_message=high_message)

    def _travel_end(self, direction: float) -> tuple[float, str]:
        valid_angle = failing_angle = self.middle_angle
        while self.failure_at(failing_angle) is None:
            valid_angle = failing_angle
            failing_angle = failing_angle + direction * 0.5 * math.pi / N_TRAVEL_SAMPLES
        while (midpoint := 0.5 * (valid_angle + failing_angle)) not in (valid_angle, failing_angle):
            valid_angle, failing_angle = (midpoint, failing_angle) if self.failure_at(midpoint) is None else (valid_angle, midpoint)
        failure = self.failure_at(failing_angle)
        return valid_angle, failure.sentence if failure else ""

    def spring_problems(self) -> Iterator[str]:
        """Yield sentences about missing, multiple or contradictory descriptions of the springs."""
        given = [name for name in SPRING_DIMENSIONS if getattr(self, name) is not None]
        descriptions = [way for way in SPRING_DESCRIPTIONS if not set(way).isdisjoint(given)]
        if len(descriptions) != 1:
            names_found = " and ".join(next(name for name in way if name in given) for way in descriptions) or "none"
            yield (
                f"the springs need one description; found {names_found}; give spring_rate, or spring_wire with its coil, turns "
                "and modulus, or inner_speed and outer_speed"
            )
            return
        (required,) = descriptions
        missing = [name for name in required if name not in given]
        if missing:
            yield f"the description of the springs lacks {', '.join(missing)}; it needs {', '.join(required)}"
        if required == SPEED_DIMENSIONS:
            for name in (PRELOAD_DIMENSION, PRELOAD_RADIUS_DIMENSION):
                if name in given:
                    yield f"{name} cannot be combined with {' and '.join(SPEED_DIMENSIONS)}, which determine it; leave it out"
            if self.inner_angle is None and self.outer_angle is None:
                yield "inner_speed and outer_speed hold the ends of the stroke; give inner_angle and outer_angle"
        elif PRELOAD_DIMENSION not in given:
            yield f"{PRELOAD_DIMENSION} is missing; it is the force of each spring at preload_radius, or at fulcrum_radius"
        if required == WIRE_DIMENSIONS and not missing:
            try:
                self._wire_rate()
            except MechanismError as error:
                yield from error.problems
        if STRESS_LIMIT_DIMENSION in given and (required != WIRE_DIMENSIONS or self.outer_angle is None):
            yield (
                f"{STRESS_LIMIT_DIMENSION} needs springs described by their wire, and a stroke; give {', '.join(WIRE_DIMENSIONS)} and "
                "inner_angle and outer_angle, or leave it out"
            )

    def under_gravity(self, find_gravity: Callable[[], float]) -> Self:
        """Return the governor with the springs that hold the ends of the stroke under the gravity of a scene (m/s2)."""
        if self.inner_speed is None:
            return self
        law = self._spring_law_from_speeds(find_gravity())
        speeds: dict[str, Any] = dict.fromkeys(SPEED_DIMENSIONS)
        return replace(self, spring_rate=law.rate, spring_preload=law.preload, preload_radius=law.radius, **speeds)

    def spring_law(self) -> LinearSpringLaw:
        """Return the force of a spring over the radius of its weight for two speeds under 9.81 m/s2, or MechanismError."""
        if self.inner_speed is not None:
            return self._spring_law_from_speeds(DEFAULT_GRAVITY)
        rate = self._wire_rate() if self.spring_rate is None else self.spring_rate
        radius = self.fulcrum_radius if self.preload_radius is None else self.preload_radius
        return LinearSpringLaw(rate=rate, preload=self.spring_preload or 0.0, radius=radius)

    def _wire_rate(self) -> float:
        wire, coil, turns, modulus = (float(getattr(self, name)) for name in WIRE_DIMENSIONS)
        return helical_spring_rate(wire=wire, coil=coil, turns=turns, modulus=modulus)

    def _spring_law_from_speeds(self, gravity: float) -> LinearSpringLaw:
        """Return the linear law for equilibrium at both ends of the stroke, each at its speed (Doerfel)."""
        ends = ((self.inner_angle, self.inner_speed), (self.outer_angle, self.outer_speed))
        given_ends = [(angle, speed) for angle, speed in ends if angle is not None and speed is not None]
        inner_radius, outer_radius = (self.weight_radius(angle) for angle, _ in given_ends)
        inner_force, outer_force = (self._holding_force(angle, speed, gravity) for angle, speed in given_ends)
        if outer_force <= inner_force:
            raise MechanismError(
                f"inner_speed and outer_speed require spring forces of {inner_force:.6g} N at the inner and {outer_force:.6g} N at the "
                "outer outside; a spring presses harder outside; raise outer_speed"
            )
        return LinearSpringLaw(rate=(outer_force - inner_force) / (outer_radius - inner_radius), preload=inner_force, radius=inner_radius)

    def _holding_force(self, lever_angle: float, speed: float, gravity: float) -> float:
        """Return the spring force (N) for equilibrium of a weight, by virtual work."""
        mass, sleeve_mass = self.weight_mass, self.sleeve_mass
        outward_derivative = -self.weight_arm * math.cos(lever_angle)  # displacement of the weight per rad
        upward_derivative = -self.weight_arm * math.sin(lever_angle)
        gravity_work = gravity * (mass * upward_derivative + 0.5 * sleeve_mass * self.lift_derivative(lever_angle))
        return mass * speed**2 * self.weight_radius(lever_angle) - gravity_work / outward_derivative

    def stress_warnings(self) -> tuple[str, ...]:
        """Return a warning if the shear stress of the wire at the outer end of the stroke exceeds its limit."""
        wire = self.spring_wire
        coil = self.spring_coil
        outer_angle = self.outer_angle
        limit = self.spring_stress_limit
        if wire is None or coil is None or outer_angle is None or limit is None:
            return ()
        stress = 8 * self.spring_law().force(self.weight_radius(outer_angle)) * coil / (math.pi * wire**3)
        if stress <= limit:
            return ()
        return (
            f"the springs are stressed over their limit: {stress / TECHNICAL_ATMOSPHERE_1901:.4g} kgf/cm^2 ({stress / 1e6:.4g} MPa) at "
            f"the outer end of the stroke, allowed are {limit / TECHNICAL_ATMOSPHERE_1901:.4g} kgf/cm^2 ({limit / 1e6:.4g} MPa); take "
            "a thicker wire or a narrower coil",
        )


RIGHT_WEIGHT = "right weight"
LEFT_WEIGHT = "left weight"
SLEEVE = "sleeve"
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
        """Return one horizontal spring between the weights, of half the rate, since by symmetry it stretches twice as far as each."""
        law = self.governor.spring_law()
        left = self._weight_centre(LEFT_WEIGHT)
        right = self._weight_centre(RIGHT_WEIGHT)
        free_radius = law.radius - law.preload / law.rate
        return Spring(name=SPRING_NAME, first=left, second=right, stiffness=0.5 * law.rate, free_length=2.0 * free_radius)

    def _readings(self) -> tuple[Reading, ...]:
        """Return the readings; the sleeve lift is zero at the inner end of the stroke, or at the lever angle zero."""
        weight_centre = self._weight_centre(RIGHT_WEIGHT)
        zero = self._sleeve_height(self.governor.inner_angle or 0.0)
        return (
            LineAngle(name="lever_angle", quantity="angle", start=weight_centre, end=self._fulcrum(1.0)),
            x_coordinate("weight_radius", weight_centre),
            sleeve_lift(Point(body=SLEEVE), zero=zero),
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
        mass = self.governor.weight_mass
        a = self.governor.weight_arm
        b = self.governor.sleeve_arm
        cranks = self.bell_cranks
        if cranks is None:
            return MassElement(mass=mass, centre=(0.0, a))
        width = cranks.weight_width
        height = cranks.weight_height
        depth = cranks.weight_depth
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
