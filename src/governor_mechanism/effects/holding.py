"""Effects `dry_friction`, `stops` and `clearance`, which hold a reading."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.time_functions import InputFunction, TableFunction
from governor_mechanism.units.fields import entry, quantity


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
