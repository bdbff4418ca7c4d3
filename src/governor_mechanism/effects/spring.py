"""A spring along a reading."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.model.effect import OutputEffect


@dataclass(frozen=True, kw_only=True)
class OutputSpring(OutputEffect):
    """A spring along a reading: it pulls by -(preload + rate (value - zero)).

    rate in N/m or N m/rad, preload in N or N m, zero in m or rad. one_sided: it only ever pulls one way, and is slack
    where it would push (where that sum is below nought).
    """

    rate: float
    preload: float = 0.0
    zero: float = 0.0
    one_sided: bool = False

    def __post_init__(self) -> None:
        require_positive(self.rate, "N/m", f"rate of the spring on {self.reading!r}")
        for name in ("preload", "zero"):
            require_finite(getattr(self, name), "", f"{name} of the spring on {self.reading!r}")

    @property
    def free_value(self) -> float:
        """The value of the reading at which it pulls nothing."""
        return self.zero - self.preload / self.rate


def helical_spring_rate(*, wire: float, coil: float, turns: float, modulus: float) -> float:
    """Rate (N/m) of a helical spring: G d^4 / (8 D^3 n).

    wire d and coil D are diameters (m, of the coil's middle line), turns n those that work, modulus G (Pa) of shear.
    Raises MechanismError for what is not positive, and for a coil that is not wider than its wire.
    """
    for value, unit, name in ((wire, "m", "wire"), (coil, "m", "coil"), (turns, "", "turns"), (modulus, "Pa", "modulus")):
        require_positive(value, unit, f"{name} of the spring")
    if coil <= wire:
        raise MechanismError(f"coil of the spring ({coil:g} m) must be wider than its wire ({wire:g} m)")
    return modulus * wire**4 / (8 * coil**3 * turns)
