"""What every machine shares: how it declares its dimensions, and what it must be able to build."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, ClassVar

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Mechanism

MIN_DIMENSION, MAX_DIMENSION = 1e-9, 1e9
"""Sizes of dimensions in SI beyond which a number is a slip, and double precision ends."""


BODY_EFFECTS = (RodMasses, Clearance, CrankMasses, BellCrankMasses)
"""Effects that change the bodies of a mechanism."""

CHOICE_KIND = "choice"
"""The kind of a dimension that is one of several words."""


def choice_field(words: tuple[str, ...], meaning: str) -> Any:
    """Declare something about a machine that is one of several words; the first one if left out."""
    return dataclasses.field(default=words[0], metadata={"kind": CHOICE_KIND, "meaning": meaning, "words": words})


def dimension_field(
    kind: str,
    meaning: str,
    *,
    default: Any = dataclasses.MISSING,
    signed: bool = False,
    max_size: float = MAX_DIMENSION,
    omission_word: str = "",
) -> Any:
    """Declare one dimension of a machine: its kind of quantity ('length', 'mass', ...) and what it means.

    A `signed` dimension may be zero or negative; the others must be positive. A default makes it optional; `word` is
    what a scene file may write to leave it out. `most` (SI) is the largest size that is no slip.
    """
    metadata = {"kind": kind, "meaning": meaning, "signed": signed, "most": max_size, "word": omission_word}
    return dataclasses.field(default=default, metadata=metadata)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Machine(ABC):
    """A machine's dimensions in SI, checked when it is made."""

    name: ClassVar[str]
    plane: ClassVar[str]
    driver_dimensions: ClassVar[tuple[str, ...]] = ()
    """The dimensions that say how fast and from where a driven machine moves; none where [start] sets it going."""

    def __post_init__(self) -> None:
        problems = []
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if value is None:
                continue
            if field.metadata["kind"] == CHOICE_KIND:
                words = field.metadata["words"]
                if value not in words:
                    problems.append(f"{field.name} must be one of {', '.join(map(repr, words))}; got {value!r}")
                continue
            signed, max_size = field.metadata["signed"], field.metadata["most"]
            if not (MIN_DIMENSION <= (abs(value) or MIN_DIMENSION) <= max_size and (signed or value > 0)):
                required = "a finite" if signed else "a positive"
                problems.append(f"{field.name} must be {required} number between {MIN_DIMENSION:g} and {max_size:g} in SI; got {value:g}")
        if problems:
            raise MechanismError(*problems)

    @abstractmethod
    def mechanism(self) -> Mechanism:
        """The bodies, joints and readings of this machine."""

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """Sentences about effects that the bodies of no such machine can have."""
        return unsupported_effect_messages(cls.name, effects)

    def mechanism_with_effects(self, effects: Iterable[Effect]) -> Mechanism:
        """The mechanism with those of a scene's effects that bodies are built from; other effects leave it as it is.

        Raises MechanismError for rods and play of a machine that has none.
        """
        problems = self.effect_problems(effects)
        if problems:
            raise MechanismError(*problems)
        return self.mechanism()

    def stop_problems(self, effects: Iterable[Effect]) -> Sequence[str]:
        """Return sentences about stops that this machine cannot reach."""
        return ()

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Sentences about start values at which this machine cannot be assembled."""
        return ()

    @abstractmethod
    def dimensions(self) -> dict[str, float]:
        """All dimensions by name, in SI, those left out filled with what they stand for."""


def unsupported_effect_messages(machine: str, effects: Iterable[Effect], supported: tuple[type[Effect], ...] = ()) -> tuple[str, ...]:
    """Sentences about effects that bodies are built from, for a machine that has none of them but those it `has`."""
    explanations = {
        RodMasses: "rods are those of a governor with arms and links",
        Clearance: "play is that of a sleeve on links",
        CrankMasses: "masses are those of a slider crank",
        BellCrankMasses: "bell_cranks are those of a Hartung governor",
    }
    return tuple(
        f"{explanations[type(effect)]}; machine {machine!r} has none, its bodies have their own masses; leave the effect out"
        for effect in effects
        if type(effect) in explanations and type(effect) not in supported
    )
