"""Effect `bell_cranks`: bell cranks with mass and weights of finite size."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import optional_size, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class BellCrankMasses(Effect):
    """Bell cranks with mass and weights of finite size. The machine builds its bodies from them; zero leaves a body unchanged.

    A bell crank is two slender arms of equal section. A weight is a block fixed to its arm.

    Attributes
    ----------
    mass
        Mass of each bell crank, kg.
    weight_width
        Size of a weight across its arm, m.
    weight_height
        Size of a weight along its arm, m.
    weight_depth
        Size of a weight normal to the plane, m.
    """

    key = "bell_cranks"
    changes_bodies_of = "a Hartung governor"

    mass: float = optional_size("mass", examples="6 kg", meaning="mass of each bell crank")
    weight_width: float = optional_size("length", examples="150 mm", meaning="size of a weight across its arm")
    weight_height: float = optional_size("length", examples="200 mm", meaning="size of a weight along its arm")
    weight_depth: float = optional_size("length", meaning="size of a weight normal to the plane")

    def __post_init__(self) -> None:
        sizes = ("weight_width", "weight_height", "weight_depth")
        require_valid_fields(self, "bell_cranks.")
        if self.mass == self.weight_width == self.weight_height == self.weight_depth == 0.0:
            raise MechanismError(f"bell_cranks need mass, {', '.join(sizes[:2])} or {sizes[2]}; leave the effect out if there are none")
        if self.weight_depth > 0.0 and self.mass == self.weight_width == self.weight_height == 0.0:
            raise MechanismError(
                "bell_cranks.weight_depth alone leaves a weight without moment of inertia in the plane; "
                "give weight_width or weight_height as well"
            )
