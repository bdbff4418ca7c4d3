"""Effect `piston_masses`: masses of the reciprocating parts of an engine with a flywheel."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import optional_size, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class PistonMasses(Effect):
    """Masses of the pistons and connecting rods of an engine. The machine builds bodies of those that are not zero.

    Attributes
    ----------
    piston
        Mass of the piston with piston rod and crosshead, kg; with an infinite connecting rod, that of the yoke too.
    connecting_rod
        Mass of the connecting rod, kg; a slender uniform rod.
    pump_piston
        Mass of the pump piston with its rod and crosshead, kg.
    pump_connecting_rod
        Mass of the connecting rod of the pump, kg; a slender uniform rod.
    """

    key = "piston_masses"
    changes_bodies_of = "an engine with a flywheel"

    piston: float = optional_size("mass", examples="120 kg", meaning="mass of the piston with piston rod and crosshead")
    connecting_rod: float = optional_size("mass", examples="60 kg", meaning="mass of the connecting rod")
    pump_piston: float = optional_size("mass", examples="120 kg", meaning="mass of the pump piston with its rod and crosshead")
    pump_connecting_rod: float = optional_size("mass", examples="60 kg", meaning="mass of the connecting rod of the pump")

    def __post_init__(self) -> None:
        require_valid_fields(self, "piston_masses.")
        if not (self.piston or self.pump_piston):
            raise MechanismError("piston_masses need piston or pump_piston; leave the effect out if there are none")
        for rod, piston in (("connecting_rod", "piston"), ("pump_connecting_rod", "pump_piston")):
            if getattr(self, rod) and not getattr(self, piston):
                raise MechanismError(f"piston_masses.{rod} has a mass and its piston has none; give piston_masses.{piston} as well")
