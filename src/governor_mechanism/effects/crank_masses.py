"""Masses of the parts of a slider crank."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_not_negative, require_positive
from governor_mechanism.model.effect import Effect


@dataclass(frozen=True, kw_only=True)
class CrankMasses(Effect):
    """Masses (kg) of the parts of a slider crank: the crank, and rod and crosshead where they have some.

    crank_centre (m) is where the crank's mass lies, from the shaft toward the crank pin, negative for a counterweight.
    The rod's lies rod_centre (m) from the crank pin, in the middle if left out, and has rod_inertia (kg m2) about that
    centre, that of a slender uniform rod if left out. The machine builds its bodies from them.
    """

    crank: float
    crank_centre: float = 0.0
    rod: float = 0.0
    rod_centre: float | None = None
    rod_inertia: float | None = None
    crosshead: float = 0.0

    def __post_init__(self) -> None:
        require_positive(self.crank, "kg", "masses.crank")
        for name in ("rod", "crosshead"):
            require_not_negative(getattr(self, name), "kg", f"masses.{name}")
        require_finite(self.crank_centre, "m", "masses.crank_centre")
        if self.rod_centre is not None:
            require_not_negative(self.rod_centre, "m", "masses.rod_centre")
        if self.rod_inertia is not None:
            require_positive(self.rod_inertia, "kg m2", "masses.rod_inertia")
        if self.rod == 0.0 and (self.rod_centre is not None or self.rod_inertia is not None):
            raise MechanismError("masses.rod_centre and rod_inertia are of a rod with mass; give masses.rod as well")
        _require_comparable_masses({"crank": self.crank, "rod": self.rod, "crosshead": self.crosshead})


MIN_MASS_RATIO = 1e-4
"""A part so much lighter than another is as good as massless, and rigid bodies so unlike are not solved well."""


def _require_comparable_masses(masses: dict[str, float]) -> None:
    heaviest = max(masses, key=lambda name: masses[name])
    for name, mass in masses.items():
        if 0.0 < mass < MIN_MASS_RATIO * masses[heaviest]:
            hint = "" if name == "crank" else ", or leave it out"
            raise MechanismError(
                f"masses.{name} ({mass:g} kg) is nothing beside masses.{heaviest} ({masses[heaviest]:g} kg); "
                f"give it {MIN_MASS_RATIO * masses[heaviest]:g} kg at least{hint}"
            )
