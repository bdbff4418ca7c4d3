"""Effect `centrifugal`: centrifugal load in a plane that turns with the spindle."""

from dataclasses import dataclass

from governor_mechanism.model.effect import Effect


@dataclass(frozen=True, kw_only=True)
class Centrifugal(Effect):
    """Centrifugal load on bodies whose plane turns with the spindle."""

    key = "centrifugal"
    loads_turning_bodies = True
