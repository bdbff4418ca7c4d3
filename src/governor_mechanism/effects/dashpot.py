"""Effect `dashpot`: viscous and quadratic damping along a reading."""

from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.model.effect import Derivation, OutputForce
from governor_mechanism.units.fields import optional_size, require_valid_fields

DISCHARGE_COEFFICIENT = 0.62
"""Discharge coefficient of a sharp-edged orifice."""


def orifice_damping_coefficient(*, piston: float, hole: float, screw: float = 1.0, oil: float = 900.0) -> float:
    """Return the quadratic coefficient of a piston that forces oil through an orifice, rho A^3 / (2 (0.62 a)^2), N s2/m2.

    Parameters
    ----------
    piston
        Area of the piston A, m2.
    hole
        Area of the orifice, m2; smaller than the piston.
    screw
        Fraction of the orifice that an adjusting screw leaves open, above 0 and at most 1; a = screw * hole.
    oil
        Density of the oil rho, kg/m3.

    Returns
    -------
    float
        Quadratic damping coefficient, N s2/m2.

    Raises
    ------
    MechanismError
        If an argument is out of range.
    """
    for value, unit, name in ((piston, "m2", "piston"), (hole, "m2", "hole"), (oil, "kg/m3", "oil")):
        require_positive(value, unit, f"{name} of the dashpot")
    if not 0 < screw <= 1:
        raise MechanismError(f"screw of the dashpot must lie above 0 (shut) and at most at 1 (open); got {screw:g}")
    if hole >= piston:
        raise MechanismError(f"hole of the dashpot ({hole:g} m2) must be smaller than its piston ({piston:g} m2)")
    return oil * piston**3 / (2 * (DISCHARGE_COEFFICIENT * screw * hole) ** 2)


@dataclass(frozen=True, kw_only=True)
class Dashpot(OutputForce):
    """A dashpot along a reading, with the force -(linear * rate + quadratic * |rate| * rate).

    Attributes
    ----------
    linear
        Linear coefficient, N s/m or N m s/rad.
    quadratic
        Quadratic coefficient, as of oil forced through an orifice, N s2/m2 or N m s2/rad2.
    """

    key = "dashpot"
    value_fields = ("linear",)
    derivations = (
        Derivation(
            field="quadratic",
            function=orifice_damping_coefficient,
            kinds={"piston": "area", "hole": "area", "screw": "ratio", "oil": "density"},
            meanings={
                "piston": "area of the piston of an oil dashpot, instead of quadratic",
                "hole": "area of its orifice",
                "screw": "fraction of the orifice that the adjusting screw leaves open; 1 if left out",
                "oil": "density of the oil; 900 kg/m^3 if left out",
            },
        ),
    )
    law_name = "dashpots"
    dissipates = True

    linear: float = optional_size("damping", "torsion_damping", meaning="force per speed")
    quadratic: float = optional_size(
        "quadratic_damping", "quadratic_torsion_damping", meaning="force per squared speed, as of oil in an orifice"
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, f"the dashpot on {self.reading!r}")
        if self.linear == self.quadratic == 0.0:
            raise MechanismError(f"the dashpot on {self.reading!r} needs a linear or a quadratic part")

    @staticmethod
    def force(coefficients: Any, value: Any, rate: Any) -> Any:
        """Return the resistance of a dashpot with a linear and a quadratic coefficient."""
        return -(coefficients[0] + coefficients[1] * abs(rate)) * rate

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Linear and quadratic coefficient."""
        return self.linear, self.quadratic

    @property
    def linear_coefficients(self) -> tuple[float, ...]:
        """The linear coefficient alone."""
        return self.linear, 0.0
