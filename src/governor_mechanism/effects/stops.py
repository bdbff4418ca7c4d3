"""Effect `stops`: hard stops of a reading."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.units.fields import entry, quantity


@dataclass(frozen=True, kw_only=True)
class Stops(OutputEffect):
    """Hard stops at the low and the high end of a reading.

    Attributes
    ----------
    low, high
        Positions of the stops, m or rad; infinite for none.
    restitution
        Coefficient of restitution, 0 to 1.
    """

    key = "stops"
    value_fields = ("low", "high")
    common_keys = ("restitution",)

    low: float = quantity(
        "length", "angle", sign="any", default=-math.inf, examples=("10 mm", "15 deg"), meaning="position of the low stop; none if left out"
    )
    high: float = quantity(
        "length", "angle", sign="any", default=math.inf, examples=("60 mm", "45 deg"), meaning="position of the high stop; none if left out"
    )
    restitution: float = entry("restitution", default=0.0, meaning="coefficient of restitution, 0 to 1")

    def __post_init__(self) -> None:
        if math.isnan(self.low) or math.isnan(self.high) or not self.low < self.high:
            raise MechanismError(f"stops of {self.reading!r}: the low end ({self.low:g}) must be below the high end ({self.high:g})")
        if math.isinf(self.low) and math.isinf(self.high):
            raise MechanismError(f"stops of {self.reading!r} need a low or a high end")
        if not 0 <= self.restitution <= 1:
            raise MechanismError(f"restitution of the stops must lie between 0 and 1; got {self.restitution:g}")

    @property
    def contact(self) -> Mapping[str, Any]:
        """The stops and their coefficient of restitution."""
        return {"low": self.low, "high": self.high, "restitution": self.restitution}
