"""Dimensions of a Hartung governor, positions of weights, hangers and sleeve over the lever angle, limits of the travel, and the spring.

A spring is described by its rate, by its wire, or by the equilibrium speeds at the ends of the stroke.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple, Self

from governor_mechanism.effects.gravity import DEFAULT_GRAVITY
from governor_mechanism.effects.spring import helical_spring_rate
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine
from governor_mechanism.model.output_variables import Limit
from governor_mechanism.types import Vector2
from governor_mechanism.units.constants import TECHNICAL_ATMOSPHERE_1901
from governor_mechanism.units.fields import optional, quantity

N_TRAVEL_SAMPLES = 720
"""Samples per quarter turn to bracket an end of the travel, before bisection."""

WIRE_DIMENSIONS = ("spring_wire", "spring_coil", "spring_turns", "spring_modulus")
SPEED_DIMENSIONS = ("inner_speed", "outer_speed")
SPRING_DESCRIPTIONS = (("spring_rate",), WIRE_DIMENSIONS, SPEED_DIMENSIONS)
"""Alternative descriptions of the spring; the first two do not determine its preload."""
PRELOAD_DIMENSION, PRELOAD_RADIUS_DIMENSION, STRESS_LIMIT_DIMENSION = ("spring_preload", "preload_radius", "spring_stress_limit")
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
        sleeve_arm_angle, (x, _) = self.bell_crank_angle + lever_angle, self.hanger_top(lever_angle)
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
            valid_angle, failing_angle = failing_angle, failing_angle + direction * 0.5 * math.pi / N_TRAVEL_SAMPLES
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

    def under_gravity(self, gravity: float) -> Self:
        """Return the governor with the springs that hold the ends of the stroke under a gravitational acceleration (m/s2)."""
        if self.inner_speed is None:
            return self
        law = self._spring_law_from_speeds(gravity)
        speeds: dict[str, Any] = dict.fromkeys(SPEED_DIMENSIONS)
        return replace(self, spring_rate=law.rate, spring_preload=law.preload, preload_radius=law.radius, **speeds)

    def spring_law(self) -> LinearSpringLaw:
        """Return the force of each spring over the radius of its weight, where two speeds determine it under 9.81 m/s2.

        Raise MechanismError if no spring satisfies the two speeds.
        """
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
        wire, coil, outer_angle, limit = self.spring_wire, self.spring_coil, self.outer_angle, self.spring_stress_limit
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
