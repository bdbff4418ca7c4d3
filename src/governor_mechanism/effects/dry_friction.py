"""Dry friction along a reading."""

from __future__ import annotations

from dataclasses import dataclass, field

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.time_functions import InputFunction


@dataclass(frozen=True, kw_only=True)
class DryFriction(OutputEffect):
    """Dry friction along a reading: it holds against any force up to `force` (N, or N m), and opposes motion with it.

    force is a program of time, so that friction may be relieved now and then.
    """

    force: InputFunction = field(default_factory=InputFunction)

    def __post_init__(self) -> None:
        if min(self.force.values) < 0:
            raise MechanismError(f"dry friction on {self.reading!r} must not be negative; got {min(self.force.values):g}")
