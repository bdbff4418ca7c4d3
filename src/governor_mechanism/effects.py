"""The physical effects a scene may ask for. One frozen description each; the laws are in `equations/forces.py`."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import require_positive

STANDARD_GRAVITY = 9.81
"""m/s2: what `gravity = true` means."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Something the engines add to the bare linkage."""


@dataclass(frozen=True, kw_only=True)
class Gravity(Effect):
    """A uniform pull along -y, in m/s2."""

    acceleration: float = STANDARD_GRAVITY

    def __post_init__(self) -> None:
        require_positive(self.acceleration, "m/s2", "gravity")


@dataclass(frozen=True, kw_only=True)
class Centrifugal(Effect):
    """The centrifugal load on bodies whose plane turns with the spindle."""
