"""Effect `link_masses`: masses of the parts of a link gear."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import optional_size, quantity, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class LinkMasses(Effect):
    """Masses of link, eccentric rods and valve. The machine builds its bodies from them; a value of zero leaves a part massless.

    Attributes
    ----------
    link
        Mass of the link, kg; a thin uniform arc between the rod pins.
    eccentric_rod
        Mass of each eccentric rod, kg; a slender uniform rod.
    valve
        Mass of the valve with its spindle and the die block, kg.
    shaft_inertia
        Moment of inertia of the shaft with crank and eccentrics, kg m2; None for a massless shaft.
    """

    key = "link_masses"
    changes_bodies_of = "a gear with a link"

    link: float = optional_size("mass", examples="25 kg", meaning="mass of the link, a thin arc between the rod pins")
    eccentric_rod: float = optional_size("mass", examples="15 kg", meaning="mass of each eccentric rod")
    valve: float = optional_size("mass", examples="60 kg", meaning="mass of the valve with its spindle and the die block")
    shaft_inertia: float | None = quantity(
        "moment_of_inertia",
        built=True,
        default=None,
        meaning="moment of inertia of the shaft with crank and eccentrics; massless if left out",
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, "link_masses.")
        if self.link == self.eccentric_rod == self.valve == 0.0 and self.shaft_inertia is None:
            raise MechanismError("link_masses need link, eccentric_rod, valve or shaft_inertia; leave the effect out if there are none")
