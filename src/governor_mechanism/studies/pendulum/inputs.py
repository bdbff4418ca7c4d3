"""The inputs of the design of a pendulum governor, and what makes them invalid."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum

from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.design_inputs import design_input, design_word, input_kinds
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

KILOGRAM_FORCE = 9.81
"""One kilogram-force in N, with the gravity of the design: a ball of 30 kgf has a mass of 30 kg."""

RPM = math.pi / 30
"""One revolution per minute in rad/s."""

MAX_RATIO = 0.5
"""Largest insensitivity and speed fluctuation: what changes its speed by more is not governed."""

SPEED_LIMITS = (1 * RPM, 10_000 * RPM)
"""Lowest and highest speed of a governor that can be designed, rad/s: a speed outside has a wrong unit."""

_MAY_BE_ZERO = ("speed_fluctuation", "mass_ratio")
_OF_ANY_SIGN = ("offset",)


class GovernorKind(StrEnum):
    """Zehnder's kinds of pendulum governors, which are cases of one calculation."""

    WATT = "watt"
    IMPROVED_WATT = "improved-watt"
    PORTER = "porter"


@dataclass(frozen=True, kw_only=True)
class PendulumInputs:
    """Inputs of a design in SI; None stands for what follows from the kind or from the other inputs.

    Attributes
    ----------
    kind
        "watt": no load on the sleeve, arms shorter than the radius of curvature; "improved-watt": the same with arms as long as this
        radius, which cross; "porter": with a load on the sleeve.
    lowest_speed, highest_speed
        Speeds of rest n1 and n2 in the lowest and the highest position, rad/s; 120 and 126 rpm, or 60 and 63 rpm for Watt's governors.
    mass_ratio
        Mass m of the sleeve over that of a ball at the joint; 4 for Porter's governor, 0 for Watt's.
    insensitivity
        Degree of insensitivity d: the range of speed in which the resistance holds the sleeve, over the speed.
    speed_fluctuation
        Coefficient of speed fluctuation e that the flywheel of the machine leaves.
    resistance
        Resistance W at the sleeve, N; 6 kgf, or 1 kgf for Watt's governors.
    arm
        Length l of the arms up to the balls, m. It gives the offset, or the offset gives it.
    offset
        Distance of the suspension from the spindle axis, m; negative for crossed arms. Without both, Watt's governor hangs on the axis,
        and the arms of the others are as long as the radius of curvature.
    joint_ratio
        Distance of the joint of arm and link from the suspension over the arm, l1 / l; 1 for links at the balls.
    start_radius
        Distance x1 of the balls from the axis in the lowest position, m; by the empirical rule if None.
    gravity
        Gravitational acceleration, m/s2.
    """

    kind: str = design_word("porter", tuple(GovernorKind))
    lowest_speed: float | None = design_input("angular_speed", None)
    highest_speed: float | None = design_input("angular_speed", None)
    mass_ratio: float | None = design_input("ratio", None)
    insensitivity: float = design_input("ratio", 0.04)
    speed_fluctuation: float = design_input("ratio", 0.025)
    resistance: float | None = design_input("force", None)
    arm: float | None = design_input("length", None)
    offset: float | None = design_input("length", None)
    joint_ratio: float = design_input("ratio", 1.0)
    start_radius: float | None = design_input("length", None)
    gravity: float = design_input("acceleration", 9.81)


DEFAULT_INPUTS = PendulumInputs()
"""A Porter governor for 120 to 126 rpm against 6 kgf."""


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """What the procedure starts from, with nothing left open but the geometry: speeds rad/s, resistance N."""

    kind: GovernorKind
    lowest_speed: float
    highest_speed: float
    mass_ratio: float
    resistance: float


def resolve_inputs(inputs: PendulumInputs) -> tuple[PendulumInputs, Requirement]:
    """Return the inputs with the values of their kind, and what the procedure starts from.

    Parameters
    ----------
    inputs
        The inputs.

    Returns
    -------
    tuple[PendulumInputs, Requirement]
        Inputs without None but for the geometry, and the requirement.

    Raises
    ------
    MechanismError
        With one sentence per mistake.
    """
    kind = GovernorKind(inputs.kind)
    is_porter = kind is GovernorKind.PORTER
    speeds = (120 * RPM, 126 * RPM) if is_porter else (60 * RPM, 63 * RPM)
    requirement = Requirement(
        kind=kind,
        lowest_speed=speeds[0] if inputs.lowest_speed is None else inputs.lowest_speed,
        highest_speed=speeds[1] if inputs.highest_speed is None else inputs.highest_speed,
        mass_ratio=(4.0 if is_porter else 0.0) if inputs.mass_ratio is None else inputs.mass_ratio,
        resistance=(6.0 if is_porter else 1.0) * KILOGRAM_FORCE if inputs.resistance is None else inputs.resistance,
    )
    names = ("lowest_speed", "highest_speed", "mass_ratio", "resistance")
    resolved = replace(inputs, **{name: getattr(requirement, name) for name in names})
    if problems := [*_sign_problems(resolved)] or [*_range_problems(resolved, requirement)]:
        raise MechanismError(*problems)
    return resolved, requirement


def _sign_problems(inputs: PendulumInputs) -> Iterator[str]:
    """Yield a sentence for each input that is not positive, or negative where 0 is allowed."""
    for name, kind in input_kinds(inputs).items():
        value = getattr(inputs, name)
        if value is None or name in _OF_ANY_SIGN or value > 0 or (name in _MAY_BE_ZERO and value == 0):
            continue
        found = format_quantity(value, QUANTITY_KINDS[kind].si_unit).strip()
        yield f"{name} must {'not be negative' if name in _MAY_BE_ZERO else 'be positive'}; got {found}"


def _range_problems(inputs: PendulumInputs, requirement: Requirement) -> Iterator[str]:
    """Yield a sentence for each input out of its range, or at odds with another."""
    low, high = (format_quantity(speed, "rad/s") for speed in (requirement.lowest_speed, requirement.highest_speed))
    limits = " to ".join(format_quantity(speed, "rad/s") for speed in SPEED_LIMITS)
    for name, found in (("lowest_speed", low), ("highest_speed", high)):
        if not SPEED_LIMITS[0] <= getattr(requirement, name) <= SPEED_LIMITS[1]:
            yield f"{name} must be {limits}; got {found}"
    if requirement.lowest_speed >= requirement.highest_speed:
        yield f"lowest_speed ({low}), at the lowest position, must be below highest_speed ({high}), or no position holds itself"
    yield from _mass_ratio_problems(requirement)
    for name in ("insensitivity", "speed_fluctuation"):
        if getattr(inputs, name) > MAX_RATIO:
            yield f"{name} must be at most {MAX_RATIO:.0%}, where nothing is governed; got {getattr(inputs, name):.4%}"
    if inputs.joint_ratio > 1:
        yield f"joint_ratio must be at most 1: the joint of arm and link is not beyond the ball; got {inputs.joint_ratio:g}"
    if inputs.arm is not None and inputs.offset is not None:
        yield "arm and offset are given, but each follows from the other and the start radius; give only one of them"


def _mass_ratio_problems(requirement: Requirement) -> Iterator[str]:
    """Yield a sentence if the load on the sleeve does not belong to the kind of governor."""
    ratio, kind = requirement.mass_ratio, requirement.kind
    if kind is GovernorKind.PORTER and ratio == 0:
        yield "mass_ratio of a Porter governor must be above 0; one without a load on its sleeve is kind=watt or kind=improved-watt"
    if kind is not GovernorKind.PORTER and ratio > 0:
        yield f"mass_ratio of a {kind} governor must be 0: its sleeve carries no load; got {ratio:g}; with a load it is kind=porter"
