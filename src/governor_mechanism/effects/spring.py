"""Effect `spring`: a linear spring along a reading."""

import math
from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.model.effect import Derivation, OutputForce
from governor_mechanism.units.fields import entry, quantity, require_valid_fields


def helical_spring_rate(*, wire: float, coil: float, turns: float, modulus: float) -> float:
    """Return the rate of a helical spring, G d^4 / (8 D^3 n), N/m.

    Parameters
    ----------
    wire
        Diameter of the wire d, m.
    coil
        Mean diameter of the coil D, m; larger than the wire.
    turns
        Number of active turns n.
    modulus
        Shear modulus G, Pa.

    Returns
    -------
    float
        Rate, N/m.

    Raises
    ------
    MechanismError
        If an argument is not positive, or the coil is not wider than the wire.
    """
    for value, unit, name in ((wire, "m", "wire"), (coil, "m", "coil"), (turns, "", "turns"), (modulus, "Pa", "modulus")):
        require_positive(value, unit, f"{name} of the spring")
    if coil <= wire:
        raise MechanismError(f"coil of the spring ({coil:g} m) must be wider than its wire ({wire:g} m)")
    return modulus * wire**4 / (8 * coil**3 * turns)


@dataclass(frozen=True, kw_only=True)
class OutputSpring(OutputForce):
    """A linear spring along a reading, with the force -(preload + rate * (value - zero)).

    Attributes
    ----------
    rate
        Stiffness, N/m or N m/rad; positive.
    preload
        Force at the value `zero`, N or N m.
    zero
        Reference value of the reading, m or rad.
    one_sided
        Whether the spring only pulls and is slack where preload + rate * (value - zero) is negative.
    """

    key = "spring"
    derivations = (
        Derivation(
            field="rate",
            function=helical_spring_rate,
            kinds={"wire": "length", "coil": "length", "turns": "number", "modulus": "modulus"},
            meanings={
                "wire": "diameter of the wire of a helical spring, instead of rate",
                "coil": "mean diameter of its coil",
                "turns": "number of its active turns",
                "modulus": "shear modulus of the wire",
            },
        ),
    )
    law_name = "springs on readings"
    dissipates = False

    rate: float = quantity("stiffness", "torsion_stiffness", built=True)
    preload: float = quantity("force", "torque", sign="any", built=True, default=0.0, meaning="force at the value zero")
    zero: float = quantity(
        "length", "angle", sign="any", built=True, default=0.0, meaning="value of the reading at which the spring has its preload"
    )
    one_sided: bool = entry("flag", default=False, meaning="whether the spring only pulls, and is slack otherwise")

    def __post_init__(self) -> None:
        require_valid_fields(self, f"the spring on {self.reading!r}")

    @property
    def free_value(self) -> float:
        """Value of the reading at zero force."""
        return self.zero - self.preload / self.rate

    @staticmethod
    def force(coefficients: Any, value: Any, rate: Any) -> Any:
        """Return the restoring force of a spring with a rate and a free value."""
        return -coefficients[0] * (value - coefficients[1])

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Rate and free value."""
        return self.rate, self.free_value

    @property
    def slack_below(self) -> float:
        """The free value of a spring that only pulls."""
        return self.free_value if self.one_sided else -math.inf

    @staticmethod
    def potential(coefficients: Any, value: Any) -> tuple[Any, Any, Any]:
        """Return the energy of a spring with a rate and a free value, and its derivatives."""
        elongation = value - coefficients[1]
        return 0.5 * coefficients[0] * elongation**2, coefficients[0] * elongation, coefficients[0] + 0.0 * value
