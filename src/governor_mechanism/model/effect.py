"""Base classes of physical effects. Each effect has its own file in `effects/`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Effect:
    """A physical effect beyond the bare linkage. A scene asks each effect for its contribution."""

    @property
    def gravity(self) -> float:
        """Gravitational acceleration that the effect adds along -y, m/s2."""
        return 0.0

    @property
    def loads_turning_bodies(self) -> bool:
        """Whether bodies in a turning plane carry a centrifugal load."""
        return False

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """Effects along single readings that this effect consists of."""
        return ()


@dataclass(frozen=True, kw_only=True)
class OutputEffect(Effect):
    """An effect along one reading.

    A force (N) acts on a length and a moment (N m) on an angle. Both are positive toward larger values of the reading.

    Attributes
    ----------
    reading
        Name of the reading.
    """

    reading: str

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """The effect itself."""
        return (self,)
