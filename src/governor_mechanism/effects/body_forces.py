"""Effects `gravity` and `centrifugal`: forces on masses."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import require_positive
from governor_mechanism.model.effect import Effect
from governor_mechanism.units.fields import quantity
from governor_mechanism.units.quantities import require_plausible

DEFAULT_GRAVITY = 9.81
"""Gravitational acceleration for `gravity = true`, m/s2."""


@dataclass(frozen=True, kw_only=True)
class Gravity(Effect):
    """Uniform gravity along -y.

    Attributes
    ----------
    acceleration
        Gravitational acceleration, m/s2; positive.
    """

    key = "gravity"
    value_fields = ("acceleration",)

    acceleration: float = quantity("acceleration", default=DEFAULT_GRAVITY, meaning="gravitational acceleration along -y")

    def __post_init__(self) -> None:
        require_positive(self.acceleration, "m/s2", "gravity")
        require_plausible(self.acceleration, "acceleration", "gravity")

    @property
    def gravity(self) -> float:
        """Gravitational acceleration along -y, m/s2."""
        return self.acceleration


@dataclass(frozen=True, kw_only=True)
class Centrifugal(Effect):
    """Centrifugal load on bodies whose plane turns with the spindle."""

    key = "centrifugal"
    loads_turning_bodies = True
