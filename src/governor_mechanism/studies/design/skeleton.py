"""What all designs have in common: records, printed texts and tables with named places, rules, and the scene from a template."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from governor_mechanism.model.results.result import Recorded, Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.design.templates import fill_template, read_file
from governor_mechanism.units.places import fill_places
from governor_mechanism.units.short_repr import short_repr

SPEED_CHANGE = 0.01
"""Relative change of speed for which effort and power are stated, as textbooks do."""

MASS_RATIO_CONSTANTS = (80.0, 15.0)
"""Zehnder's limits of the mass ratio m: w^2 / 80 - 1 to w^2 / 15 - 1, with the lowest speed w of the spindle in rad/s."""


@dataclass(frozen=True)
class Check(Recorded):
    """A rule that a design should keep: the value found, its limits (None if there is none), and what to do if it is not kept."""

    rule: str
    found: float
    lowest: float | None = None
    highest: float | None = None
    cure: str = ""

    derived = ("ok",)

    @property
    def ok(self) -> bool:
        """Whether the rule is kept."""
        return (self.lowest is None or self.found >= self.lowest) and (self.highest is None or self.found <= self.highest)

    def __str__(self) -> str:
        """Return the rule with its numbers, and the cure if it is not kept."""
        bounds = (("at least", self.lowest), ("at most", self.highest))
        limits = [f"{words} {limit:.4g}" for words, limit in bounds if limit is not None]
        text = f"{self.rule}: {self.found:.4g}, {' and '.join(limits)}"
        return f"kept: {text}" if self.ok else f"not kept: {text}; {self.cure}"


class Design(Result):
    """Result of a design: its files are `MACHINE.txt`, the text that it prints, and `MACHINE.toml`, its scene, both with places."""

    machine: ClassVar[str]
    warning_start: ClassVar[str] = ""

    __repr__ = short_repr

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, one sentence each; a design without rules has them as a field."""
        return ()

    @property
    def warnings_text(self) -> str | None:
        """All warnings, a line each; None without any."""
        return "\n".join(f"{self.warning_start}{sentence}" for sentence in self.warnings) or None

    def summary_lines(self) -> list[str]:
        """Return the design as text in workshop units."""
        return fill_places(read_file(f"{self.machine}.txt"), self).splitlines()

    def __str__(self) -> str:
        """Return the design as text."""
        return "\n".join(self.summary_lines())

    @abstractmethod
    def scene_values(self) -> Mapping[str, object]:
        """Return the values of places of the scene that are no attributes of the design; options of a design give variants."""

    def fill_scene(self, values: Mapping[str, object]) -> Mapping[str, object]:
        """Return the document of the scene with the values of its places."""
        return fill_template(self.machine, self, values)

    @cached_property
    def scene_document(self) -> Mapping[str, Any]:
        """The document of a runnable scene of the design."""
        return self.fill_scene(self.scene_values())

    @property
    def scene(self) -> Scene:
        """The scene of that document."""
        return parse_scene_document(self.scene_document)


class CheckedDesign(Design):
    """Result of a design with rules that it should keep."""

    checks: tuple[Check, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for each rule that is not kept."""
        return tuple(str(check) for check in self.checks if not check.ok)

    @property
    def checks_text(self) -> str:
        """All rules, a line each."""
        return "\n".join(map(str, self.checks))


def relative_range(limits: tuple[float, float]) -> float:
    """Return the range of two values over their mean: droop or sensitiveness of two speeds."""
    low, high = limits
    return (high - low) / ((high + low) / 2)


def mass_ratio_limits(speed: float) -> tuple[float, float]:
    """Return Zehnder's smallest and largest mass ratio at a speed of the spindle (rad/s)."""
    low, high = (speed**2 / constant - 1 for constant in MASS_RATIO_CONSTANTS)
    return low, high
