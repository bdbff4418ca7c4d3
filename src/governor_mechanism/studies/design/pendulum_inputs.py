"""Inputs of the design of a pendulum governor: Zehnder's kinds, what they leave open, and what contradicts."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from governor_mechanism.studies.design.skeleton import GOVERNED, Bounds, require_valid
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM
from governor_mechanism.units.fields import entry, optional, quantity
from governor_mechanism.units.text_table import fill_places

_SPEEDS = Bounds(
    lowest=1 * RPM, highest=10_000 * RPM, rule="{lowest:.6g rpm} to {highest:.6g rpm}", found="{value:.6g rpm}"
)  # a speed outside has a wrong unit


class GovernorKind(StrEnum):
    """Zehnder's kinds of pendulum governors, which are cases of one calculation."""

    WATT = "watt"
    IMPROVED_WATT = "improved-watt"
    PORTER = "porter"


@dataclass(frozen=True, kw_only=True)
class PendulumInputs:
    """Inputs of a design in SI; None stands for what follows from the kind or from the other inputs.

    Without arm and offset, Watt's governor hangs on the axis, and the arms of the others are as long as the radius of curvature.
    """

    kind: str = entry(
        "choice",
        default="porter",
        words=tuple(map(str, GovernorKind)),
        meaning="watt: no load on the sleeve, arms shorter than the radius of curvature; improved-watt: the same with arms as long as this "
        "radius, which cross; porter: with a load on the sleeve",
    )
    lowest_speed: float | None = optional("angular_speed", meaning="speed of rest n1 in the lowest position", bounds=_SPEEDS)
    highest_speed: float | None = optional("angular_speed", meaning="speed of rest n2 in the highest position", bounds=_SPEEDS)
    mass_ratio: float | None = optional("ratio", meaning="mass m of the sleeve over the mass of a ball at the joint", sign="not negative")
    insensitivity: float = quantity(
        "ratio", default=0.04, meaning="range of speed in which the resistance holds the sleeve", bounds=GOVERNED
    )
    speed_fluctuation: float = quantity(
        "ratio", default=0.025, meaning="coefficient of speed fluctuation that the flywheel leaves", sign="not negative", bounds=GOVERNED
    )
    resistance: float | None = optional("force", meaning="resistance W at the sleeve; 6 kgf, or 1 kgf for Watt's governors")
    arm: float | None = optional("length", meaning="length l of the arms up to the balls; it gives the offset, or the offset gives it")
    offset: float | None = optional("length", meaning="distance of the suspension from the axis; negative for crossed arms", sign="any")
    joint_ratio: float = quantity(
        "ratio",
        default=1.0,
        meaning="distance of the joint of arm and link from the suspension over the arm; 1 for links at the balls",
        bounds=Bounds(highest=1.0, rule="at most 1: the joint of arm and link is not beyond the ball", found="{value:g}"),
    )
    start_radius: float | None = optional("length", meaning="distance x1 of the balls from the axis in the lowest position")
    gravity: float = quantity("acceleration", default=9.81, meaning="gravitational acceleration")


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
    """Return the inputs with the values of their kind, and the requirement from which the procedure starts."""
    kind = GovernorKind(inputs.kind)
    porter = {"lowest_speed": 120 * RPM, "highest_speed": 126 * RPM, "mass_ratio": 4.0, "resistance": 6 * KILOGRAM_FORCE_1853}
    watt = {"lowest_speed": 60 * RPM, "highest_speed": 63 * RPM, "mass_ratio": 0.0, "resistance": KILOGRAM_FORCE_1853}
    defaults = porter if kind is GovernorKind.PORTER else watt
    given = {name: getattr(inputs, name) for name in defaults if getattr(inputs, name) is not None}
    values: dict[str, Any] = defaults | given
    resolved = replace(inputs, **values)
    require_valid(resolved, _contradictions)
    return resolved, Requirement(kind=kind, **values)


def _contradictions(inputs: PendulumInputs) -> Iterator[str]:
    """Yield a sentence for each input at odds with another; a load on the sleeve belongs to a Porter governor."""
    if inputs.lowest_speed >= inputs.highest_speed:  # type: ignore[operator]  # resolved
        speeds = "lowest_speed ({lowest_speed:.6g rpm}), at the lowest position, must be below highest_speed ({highest_speed:.6g rpm})"
        yield fill_places(f"{speeds}, or no position holds itself", inputs)
    if inputs.kind == GovernorKind.PORTER and inputs.mass_ratio == 0:
        yield "mass_ratio of a Porter governor must be above 0; one without a load on its sleeve is kind=watt or kind=improved-watt"
    if inputs.kind != GovernorKind.PORTER and inputs.mass_ratio != 0:
        rule = "mass_ratio of a {kind} governor must be 0: its sleeve carries no load; got {mass_ratio:g}; with a load it is kind=porter"
        yield fill_places(rule, inputs)
    if inputs.arm is not None and inputs.offset is not None:
        yield "arm and offset are given, but each follows from the other and the start radius; give only one of them"
