"""The spring of a Hartung governor: by its rate, its wire, or the two speeds that hold the ends of the stroke."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from governor_mechanism.effects.gravity import STANDARD_GRAVITY
from governor_mechanism.effects.spring import wire_spring_rate
from governor_mechanism.errors import MechanismError

if TYPE_CHECKING:
    from governor_mechanism.machines.hartung.machine import HartungGovernor

WIRE = ("spring_wire", "spring_coil", "spring_turns", "spring_modulus")
SPEEDS = ("inner_speed", "outer_speed")
WAYS = (("spring_rate",), WIRE, SPEEDS)
"""To describe a spring; the first two leave its force open."""
PRELOAD, RADIUS, LIMIT = "spring_preload", "preload_radius", "spring_stress_limit"
PASCAL_PER_AT = 98066.5
"""Pa in a kilogram-force on a square centimetre, which engineers of the time reckoned stress in."""


@dataclass(frozen=True, kw_only=True)
class SpringLine:
    """One spring presses its weight inward with preload (N) at a radius (m), and with rate (N/m) more beyond."""

    rate: float
    preload: float
    radius: float

    def force(self, radius: float) -> float:
        """With the weight at a radius (m), N."""
        return self.preload + self.rate * (radius - self.radius)

    @property
    def free_radius(self) -> float:
        """Where it would press no longer (m)."""
        return self.radius - self.preload / self.rate


def spring_problems(governor: HartungGovernor) -> list[str]:
    """Sentences about a spring that a governor's dimensions do not describe, or twice, or by what would say nothing."""
    given = _given(governor)
    ways = [way for way in WAYS if given & set(way)]
    if len(ways) != 1:
        found = " and ".join(next(name for name in way if name in given) for way in ways) or "none"
        return [
            f"the springs need one description; found {found}; give spring_rate, or spring_wire with its coil, turns "
            "and modulus, or inner_speed and outer_speed"
        ]
    (needed,) = ways
    missing = [name for name in needed if name not in given]
    problems = []
    if missing:
        problems.append(f"the springs lack {', '.join(missing)}; to describe them takes {', '.join(needed)}")
    if needed == SPEEDS:
        problems += [
            f"{name} cannot stand beside {' and '.join(SPEEDS)}, from which it follows; leave it out"
            for name in (PRELOAD, RADIUS)
            if name in given
        ]
        if governor.inner_angle is None and governor.outer_angle is None:
            problems.append("inner_speed and outer_speed hold the ends of the stroke; give inner_angle and outer_angle")
    elif PRELOAD not in given:
        problems.append(f"{PRELOAD} is missing; it is the force of each spring at preload_radius, or at fulcrum_radius")
    if needed == WIRE and not missing:
        try:
            _wire_rate(governor)
        except MechanismError as error:
            problems += error.problems
    if LIMIT in given and (needed != WIRE or governor.outer_angle is None):
        problems.append(
            f"{LIMIT} is that of springs described by their wire, at the end of a stroke; give {', '.join(WIRE)} and "
            "inner_angle and outer_angle, or leave it out"
        )
    return problems


def spring_line(governor: HartungGovernor) -> SpringLine:
    """The spring that a governor's dimensions describe. Raises MechanismError where two speeds describe none."""
    if governor.inner_speed is not None:
        return _through_speeds(governor)
    rate, preload = governor.spring_rate, governor.spring_preload
    if rate is None:
        rate = _wire_rate(governor)
    radius = governor.fulcrum_radius if governor.preload_radius is None else governor.preload_radius
    return SpringLine(rate=rate, preload=preload or 0.0, radius=radius)


def _given(governor: HartungGovernor) -> set[str]:
    """What stands in a governor's dimensions of its springs."""
    names = (*(name for way in WAYS for name in way), PRELOAD, RADIUS, LIMIT)
    return {name for name in names if getattr(governor, name) is not None}


def _wire_rate(governor: HartungGovernor) -> float:
    wire, coil, turns, modulus = (float(getattr(governor, name)) for name in WIRE)
    return wire_spring_rate(wire=wire, coil=coil, turns=turns, modulus=modulus)


def _through_speeds(governor: HartungGovernor) -> SpringLine:
    """Doerfel's line: what holds the weights at the ends of the stroke, each at its speed."""
    ends = governor.inner_angle, governor.outer_angle
    first, last = (governor.way.weight_radius(end) for end in ends if end is not None)
    inner, outer = (
        _holding_force(governor, end, speed)
        for end, speed in zip(ends, (governor.inner_speed, governor.outer_speed), strict=True)
        if end is not None and speed is not None
    )
    if outer <= inner:
        raise MechanismError(
            f"inner_speed and outer_speed ask for springs that press with {inner:.6g} N inside and {outer:.6g} N "
            "outside; a spring presses harder outside; raise outer_speed"
        )
    return SpringLine(rate=(outer - inner) / (last - first), preload=inner, radius=first)


def _holding_force(governor: HartungGovernor, lever: float, speed: float) -> float:
    """The force (N) that holds a weight, from the work in a small turn of the lever: that of all forces is nought."""
    way, mass = governor.way, governor.weight_mass
    outward = -governor.weight_arm * math.cos(lever)  # of the weight, for a turn of 1
    upward = -governor.weight_arm * math.sin(lever)
    weights = mass * STANDARD_GRAVITY * upward + 0.5 * governor.sleeve_mass * STANDARD_GRAVITY * way.lift_slope(lever)
    return mass * speed**2 * way.weight_radius(lever) - weights / outward


def outer_stress(governor: HartungGovernor) -> float | None:
    """Shear stress (Pa) in the springs' wire at the outer end of the stroke; None where wire or stroke is not given."""
    if governor.spring_wire is None or governor.spring_coil is None or governor.outer_angle is None:
        return None
    force = governor.spring().force(governor.way.weight_radius(governor.outer_angle))
    return 8 * force * governor.spring_coil / (math.pi * governor.spring_wire**3)


def stress_note(governor: HartungGovernor) -> str:
    """A warning of a spring that is stressed over its limit at the outer end of the stroke; empty where it is not."""
    stress, limit = outer_stress(governor), governor.spring_stress_limit
    if stress is None or limit is None or stress <= limit:
        return ""
    return (
        f"the springs are stressed over their limit: {stress / PASCAL_PER_AT:.4g} kgf/cm^2 ({stress / 1e6:.4g} MPa) at "
        f"the outer end of the stroke, allowed are {limit / PASCAL_PER_AT:.4g} kgf/cm^2 ({limit / 1e6:.4g} MPa); take "
        "a thicker wire or a narrower coil"
    )
