"""Effect `rods`: arms and links with mass, balls with a size."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import optional_size, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class RodMasses(Effect):
    """Arms and links as slender uniform rods, balls as solid spheres. The machine builds its bodies from them.

    A value of zero leaves the part unchanged.

    Attributes
    ----------
    arm_mass
        Mass of each arm, kg.
    link_mass
        Mass of each link, kg.
    ball_radius
        Radius of each ball, m.
    """

    key = "rods"
    changes_bodies_of = "a governor with arms and links"

    arm_mass: float = optional_size("mass", examples="0.6 kg", meaning="mass of each arm")
    link_mass: float = optional_size("mass", examples="0.5 kg", meaning="mass of each link")
    ball_radius: float = optional_size("length", meaning="radius of each ball")

    def __post_init__(self) -> None:
        require_valid_fields(self, "rods.")
        if self.arm_mass == self.link_mass == self.ball_radius == 0.0:
            raise MechanismError("rods need arm_mass, link_mass or ball_radius; leave the effect out if there are none")
