"""Spring of a Hartung governor: by its rate, by its wire, or by the equilibrium speeds at the ends of the stroke."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

from governor_mechanism.effects.gravity import DEFAULT_GRAVITY
from governor_mechanism.effects.spring import helical_spring_rate
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.hartung.dimensions import HartungDimensions

WIRE_DIMENSIONS = ("spring_wire", "spring_coil", "spring_turns", "spring_modulus")
SPEED_DIMENSIONS = ("inner_speed", "outer_speed")
SPRING_DESCRIPTIONS = (("spring_rate",), WIRE_DIMENSIONS, SPEED_DIMENSIONS)
"""Alternative descriptions of the spring; the first two do not determine its preload."""
PRELOAD_DIMENSION, PRELOAD_RADIUS_DIMENSION, STRESS_LIMIT_DIMENSION = ("spring_preload", "preload_radius", "spring_stress_limit")
SPRING_DIMENSIONS = (*chain(*SPRING_DESCRIPTIONS), PRELOAD_DIMENSION, PRELOAD_RADIUS_DIMENSION, STRESS_LIMIT_DIMENSION)
PASCAL_PER_KGF_CM2 = 98066.5
"""Pa per kgf/cm2, the unit of stress of the period."""


@dataclass(frozen=True, kw_only=True)
class LinearSpringLaw:
    """Linear law of one spring: it presses its weight inward with preload (N) at a radius (m), increasing with rate (N/m)."""

    rate: float
    preload: float
    radius: float

    def force(self, radius: float) -> float:
        """Return the force (N) for the weight at a radius (m)."""
        return self.preload + self.rate * (radius - self.radius)

    @property
    def free_radius(self) -> float:
        """Radius at zero force, m."""
        return self.radius - self.preload / self.rate


def spring_problems(governor: HartungDimensions) -> Iterator[str]:
    """Yield sentences about missing, multiple or contradictory descriptions of the springs."""
    given = [name for name in SPRING_DIMENSIONS if getattr(governor, name) is not None]
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
        if governor.inner_angle is None and governor.outer_angle is None:
            yield "inner_speed and outer_speed hold the ends of the stroke; give inner_angle and outer_angle"
    elif PRELOAD_DIMENSION not in given:
        yield f"{PRELOAD_DIMENSION} is missing; it is the force of each spring at preload_radius, or at fulcrum_radius"
    if required == WIRE_DIMENSIONS and not missing:
        try:
            _wire_rate(governor)
        except MechanismError as error:
            yield from error.problems
    if STRESS_LIMIT_DIMENSION in given and (required != WIRE_DIMENSIONS or governor.outer_angle is None):
        yield (
            f"{STRESS_LIMIT_DIMENSION} needs springs described by their wire, and a stroke; give {', '.join(WIRE_DIMENSIONS)} and "
            "inner_angle and outer_angle, or leave it out"
        )


def build_spring_law(governor: HartungDimensions) -> LinearSpringLaw:
    """Return the spring law of a governor. Raise MechanismError if no spring satisfies the two speeds."""
    if governor.inner_speed is not None:
        return _spring_law_from_speeds(governor)
    rate = _wire_rate(governor) if governor.spring_rate is None else governor.spring_rate
    radius = governor.fulcrum_radius if governor.preload_radius is None else governor.preload_radius
    return LinearSpringLaw(rate=rate, preload=governor.spring_preload or 0.0, radius=radius)


def _wire_rate(governor: HartungDimensions) -> float:
    wire, coil, turns, modulus = (float(getattr(governor, name)) for name in WIRE_DIMENSIONS)
    return helical_spring_rate(wire=wire, coil=coil, turns=turns, modulus=modulus)


def _spring_law_from_speeds(governor: HartungDimensions) -> LinearSpringLaw:
    """Return the linear law for equilibrium at both ends of the stroke, each at its speed (Doerfel)."""
    ends = ((governor.inner_angle, governor.inner_speed), (governor.outer_angle, governor.outer_speed))
    given_ends = [(angle, speed) for angle, speed in ends if angle is not None and speed is not None]
    inner_radius, outer_radius = (governor.weight_radius(angle) for angle, _ in given_ends)
    inner_force, outer_force = (_holding_force(governor, angle, speed) for angle, speed in given_ends)
    if outer_force <= inner_force:
        raise MechanismError(
            f"inner_speed and outer_speed require spring forces of {inner_force:.6g} N at the inner and {outer_force:.6g} N at the outer "
            "outside; a spring presses harder outside; raise outer_speed"
        )
    return LinearSpringLaw(rate=(outer_force - inner_force) / (outer_radius - inner_radius), preload=inner_force, radius=inner_radius)


def _holding_force(governor: HartungDimensions, lever_angle: float, speed: float) -> float:
    """Return the spring force (N) for equilibrium of a weight, by virtual work."""
    mass, sleeve_mass = governor.weight_mass, governor.sleeve_mass
    outward_derivative = -governor.weight_arm * math.cos(lever_angle)  # displacement of the weight per rad
    upward_derivative = -governor.weight_arm * math.sin(lever_angle)
    gravity_work = mass * DEFAULT_GRAVITY * upward_derivative + 0.5 * sleeve_mass * DEFAULT_GRAVITY * governor.lift_derivative(lever_angle)
    return mass * speed**2 * governor.weight_radius(lever_angle) - gravity_work / outward_derivative


def stress_warnings(governor: HartungDimensions) -> tuple[str, ...]:
    """Return a warning if the shear stress of the wire at the outer end of the stroke exceeds its limit."""
    wire, coil, outer_angle, limit = governor.spring_wire, governor.spring_coil, governor.outer_angle, governor.spring_stress_limit
    if wire is None or coil is None or outer_angle is None or limit is None:
        return ()
    stress = 8 * build_spring_law(governor).force(governor.weight_radius(outer_angle)) * coil / (math.pi * wire**3)
    if stress <= limit:
        return ()
    return (
        f"the springs are stressed over their limit: {stress / PASCAL_PER_KGF_CM2:.4g} kgf/cm^2 ({stress / 1e6:.4g} MPa) at "
        f"the outer end of the stroke, allowed are {limit / PASCAL_PER_KGF_CM2:.4g} kgf/cm^2 ({limit / 1e6:.4g} MPa); take "
        "a thicker wire or a narrower coil",
    )
