"""Effect `dry_friction`: Coulomb friction along a reading."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.time_functions import InputFunction, TableFunction
from governor_mechanism.units.fields import entry


@dataclass(frozen=True, kw_only=True)
class DryFriction(OutputEffect):
    """Coulomb friction along a reading. It sticks against any force up to its limit and opposes sliding with it.

    Attributes
    ----------
    force
        Friction limit over time, N or N m; at least 0.
    """

    key = "dry_friction"
    value_fields = ("force",)

    force: InputFunction = entry(
        "load",
        "force",
        "torque",
        sign="not negative",
        reason=", because friction opposes the motion",
        default=InputFunction(),
        meaning="limit of the friction; it may change with time",
    )

    def __post_init__(self) -> None:
        if min(self.force.values) < 0:
            raise MechanismError(f"dry friction on {self.reading!r} must not be negative; got {min(self.force.values):g}")
        for function in (*self.force.functions, *self.force.factors):
            is_negative = min(function.values) < 0 if isinstance(function, TableFunction) else max(self.force.values) == 0.0
            if is_negative:
                raise MechanismError(
                    f"dry friction on {self.reading!r} that depends on {function.reading!r} must not become negative; "
                    "give it as a table of values that are not negative, or as a function that is added to a larger constant"
                )

    @property
    def contact(self) -> Mapping[str, Any]:
        """The friction limit."""
        return {"friction": self.force}
