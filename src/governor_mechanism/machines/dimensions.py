"""What every machine shares: how it declares its dimensions, and what it must be able to build."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from governor_mechanism.effects import Effect, Play, Rods
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanism import Mechanism

SMALLEST, LARGEST = 1e-9, 1e9
"""Sizes of dimensions in SI beyond which a number is a slip, and double precision ends."""


def dimension(kind: str, meaning: str, *, default: Any = dataclasses.MISSING, signed: bool = False) -> Any:
    """Declare one dimension of a machine: its kind of quantity ('length', 'mass', ...) and what it means.

    A `signed` dimension may be zero or negative; the others must be positive. A default makes it optional.
    """
    return dataclasses.field(default=default, metadata={"kind": kind, "meaning": meaning, "signed": signed})


@dataclasses.dataclass(frozen=True, kw_only=True)
class Machine(ABC):
    """A machine's dimensions in SI, checked when it is made."""

    name: ClassVar[str]
    plane: ClassVar[str]

    def __post_init__(self) -> None:
        problems = []
        for field in dataclasses.fields(self):
            value, signed = getattr(self, field.name), field.metadata["signed"]
            if value is None:
                continue
            if not (SMALLEST <= (abs(value) or SMALLEST) <= LARGEST and (signed or value > 0)):
                wanted = "a finite" if signed else "a positive"
                problems.append(
                    f"{field.name} must be {wanted} number between {SMALLEST:g} and {LARGEST:g} in SI; got {value:g}"
                )
        if problems:
            raise MechanismError(*problems)

    @abstractmethod
    def mechanism(self) -> Mechanism:
        """The bodies, joints and readings of this machine."""

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """Sentences about effects that the bodies of no such machine can have."""
        return foreign_effects(cls.name, effects)

    def mechanism_with(self, effects: Iterable[Effect]) -> Mechanism:
        """The mechanism with those of a scene's effects that bodies are built from; other effects leave it as it is.

        Raises MechanismError for rods and play of a machine that has none.
        """
        problems = self.effect_problems(effects)
        if problems:
            raise MechanismError(*problems)
        return self.mechanism()

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Sentences about start values at which this machine cannot be assembled."""
        return ()

    @abstractmethod
    def dimensions(self) -> dict[str, float]:
        """All dimensions by name, in SI, those left out filled with what they stand for."""


def foreign_effects(machine: str, effects: Iterable[Effect]) -> tuple[str, ...]:
    """Sentences about rods and play, for a machine whose bodies do not follow from them."""
    known = {
        Rods: "rods are those of a governor with arms and links",
        Play: "play is that of a sleeve on links",
    }
    return tuple(
        f"{known[type(effect)]}; machine {machine!r} has none, its bodies have their own masses; leave the effect out"
        for effect in effects
        if type(effect) in known
    )
