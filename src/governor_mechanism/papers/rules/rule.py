"""A rule of a paper, what the simulation shows of it, and the verdict."""

from abc import ABC, abstractmethod
from enum import Enum
from typing import Any, ClassVar


class Verdict(Enum):
    """What a simulation says about a rule. Each value is a phrase for the user."""

    HOLDS = "holds"
    CONDITIONAL = "holds with a condition"
    FAILS = "does not hold"


class RuleCheck(ABC):
    """A rule and the simulations that test it; the verdict and the finding follow from the numbers."""

    title: ClassVar[str]
    """Short name of the rule."""

    source: ClassVar[str]
    """Who states it, and where."""

    statement: ClassVar[str]
    """What the paper says, as one sentence."""

    @property
    @abstractmethod
    def verdict(self) -> Verdict:
        """Whether the rule holds in the simulation."""

    @property
    @abstractmethod
    def finding(self) -> str:
        """What the simulation shows, with its numbers."""

    @property
    def condition(self) -> str:
        """The condition in a few words, if the rule holds with one; else empty."""
        return ""

    @property
    def verdict_text(self) -> str:
        """The verdict with its condition."""
        return f"{self.verdict.value}: {self.condition}" if self.verdict is Verdict.CONDITIONAL and self.condition else self.verdict.value

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Return the measured values as plain values in SI, by names with their units."""
