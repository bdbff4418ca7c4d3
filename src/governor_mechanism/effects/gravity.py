"""Uniform gravity."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import require_positive
from governor_mechanism.model.effect import Effect

DEFAULT_GRAVITY = 9.81
"""m/s2: what `gravity = true` means."""


@dataclass(frozen=True, kw_only=True)
class Gravity(Effect):
    """A uniform pull along -y, in m/s2."""

    acceleration: float = DEFAULT_GRAVITY

    def __post_init__(self) -> None:
        require_positive(self.acceleration, "m/s2", "gravity")

    @property
    def gravity(self) -> float:
        """Gravitational acceleration along -y, m/s2."""
        return self.acceleration
