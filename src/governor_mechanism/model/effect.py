"""The base classes of physical effects. Each effect has a file of its own in `effects/`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Something the engines add to the bare linkage. A scene asks each of its effects for what it contributes."""

    @property
    def gravity(self) -> float:
        """Gravitational acceleration along -y that it adds, m/s2."""
        return 0.0

    @property
    def loads_turning_bodies(self) -> bool:
        """Whether bodies in a turning plane carry a centrifugal load."""
        return False

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """What it does along single readings."""
        return ()


@dataclass(frozen=True, kw_only=True)
class OutputEffect(Effect):
    """An effect that acts along one reading."""

    reading: str

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """Itself."""
        return (self,)
