"""Effect `masses`: masses of the parts of a slider crank."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import optional_size, quantity, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class CrankMasses(Effect):
    """Masses of the parts of a slider crank. The machine builds its bodies from them.

    Attributes
    ----------
    crank
        Mass of the crank, kg; positive.
    crank_centre
        Position of the crank's mass centre from the shaft toward the crank pin, m; negative for a counterweight.
    rod
        Mass of the connecting rod, kg; 0 for a massless rod.
    rod_centre
        Distance of the rod's mass centre from the crank pin, m; the middle of the rod if None.
    rod_inertia
        Moment of inertia of the rod about its mass centre, kg m2; that of a slender uniform rod if None.
    crosshead
        Mass of the crosshead, kg; 0 for none.
    """

    key = "masses"
    changes_bodies_of = "a slider crank"

    crank: float = quantity("mass", built=True, examples="80 kg", meaning="the mass of the crank (rod and crosshead may have none)")
    crank_centre: float = quantity(
        "length",
        sign="any",
        built=True,
        default=0.0,
        meaning="mass centre of the crank from the shaft toward the crank pin; negative for a counterweight",
    )
    rod: float = optional_size("mass", examples="70 kg", meaning="mass of the connecting rod")
    rod_centre: float | None = quantity(
        "length", sign="not negative", built=True, default=None, meaning="mass centre of the rod from the crank pin; its middle if left out"
    )
    rod_inertia: float | None = quantity(
        "moment_of_inertia",
        built=True,
        default=None,
        meaning="moment of inertia of the rod about its mass centre; that of a slender rod if left out",
    )
    crosshead: float = optional_size("mass", examples="110 kg", meaning="mass of the crosshead")

    def __post_init__(self) -> None:
        require_valid_fields(self, "masses.")
        if self.rod == 0.0 and (self.rod_centre is not None or self.rod_inertia is not None):
            raise MechanismError("masses.rod_centre and rod_inertia need a rod with mass; give masses.rod as well")
        _require_comparable_masses({"crank": self.crank, "rod": self.rod, "crosshead": self.crosshead})


MIN_MASS_RATIO = 1e-4
"""Smallest ratio of two masses: a lighter part is practically massless and makes the equations ill-conditioned."""


def _require_comparable_masses(masses: dict[str, float]) -> None:
    heaviest = max(masses, key=lambda name: masses[name])
    for name, mass in masses.items():
        if 0.0 < mass < MIN_MASS_RATIO * masses[heaviest]:
            hint = "" if name == "crank" else ", or leave it out"
            raise MechanismError(
                f"masses.{name} ({mass:g} kg) is negligible compared to masses.{heaviest} ({masses[heaviest]:g} kg); "
                f"give it {MIN_MASS_RATIO * masses[heaviest]:g} kg at least{hint}"
            )
