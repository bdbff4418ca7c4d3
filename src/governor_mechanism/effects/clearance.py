"""Effect `clearance`: clearance between links and sleeve."""

from dataclasses import dataclass

from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.units.fields import entry, quantity

CLEARANCE_READING = "sleeve_clearance"
"""Reading of the position of the sleeve within its clearance, m."""


@dataclass(frozen=True, kw_only=True)
class Clearance(Effect):
    """Clearance between links and sleeve: free travel of the sleeve before the links carry it along.

    The machine adds the reading `sleeve_clearance`, from -width / 2 to width / 2.

    Attributes
    ----------
    width
        Width of the clearance, m; positive.
    restitution
        Coefficient of restitution at its ends, 0 to 1.
    """

    key = "clearance"
    changes_bodies_of = "a sleeve on links"
    value_fields = ("width",)

    width: float = quantity(
        "length",
        built=True,
        hint="; write clearance = false if there is none",
        examples="0.5 mm",
        meaning="the distance that the sleeve may move between the links",
    )
    restitution: float = entry("restitution", default=0.0, meaning="coefficient of restitution, 0 to 1")

    def __post_init__(self) -> None:
        require_positive(self.width, "m", "clearance")
        if not 0 <= self.restitution <= 1:
            raise MechanismError(f"restitution of the clearance must lie between 0 and 1; got {self.restitution:g}")

    @property
    def stops(self) -> Stops:
        """The clearance as stops of its reading."""
        return Stops(reading=CLEARANCE_READING, low=-self.width / 2, high=self.width / 2, restitution=self.restitution)

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """The stops of its reading."""
        return (self.stops,)
