"""What all designs have in common: records, printed texts and tables with named places, rules, and the scene from a template."""

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, ClassVar

from governor_mechanism.files.plain_values import plain_value
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.model.results.exported_result import ExportedResult
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.design.templates import fill_template, read_file
from governor_mechanism.units.places import fill_places
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

SPEED_CHANGE = 0.01
"""Relative change of speed for which effort and power are stated, as textbooks do."""

MASS_RATIO_CONSTANTS = (80.0, 15.0)
"""Zehnder's limits of the mass ratio m: w^2 / 80 - 1 to w^2 / 15 - 1, with the lowest speed w of the spindle in rad/s."""


class Recorded:
    """A dataclass with JSON of its fields and of some properties.

    Attributes
    ----------
    derived
        Names of the properties in the JSON, after the fields.
    hidden
        Names of fields that are not in it.
    """

    derived: ClassVar[tuple[str, ...]] = ()
    hidden: ClassVar[tuple[str, ...]] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the record as plain values in SI."""
        names = [one.name for one in fields(self) if one.name not in self.hidden]  # type: ignore[arg-type]  # any dataclass
        return {name: _plain(getattr(self, name)) for name in (*names, *self.derived)}


def _plain(value: Any) -> Any:
    if isinstance(value, Recorded | ExportedResult):
        return value.as_json()
    return [*map(_plain, value)] if isinstance(value, tuple) else plain_value(value)


Columns = Sequence[tuple[str, str]]
"""Headings of the columns of a table, and the place in the record of a row that each shows."""


def tabulate(columns: Columns, records: Iterable[object], justify: str) -> str:
    """Return records as the rows of a text table; a place without a value is an empty cell."""
    rows = [[fill_places(place, record) for _, place in columns] for record in records]
    return format_table([heading for heading, _ in columns], rows, justify)


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


class Design(Recorded, PrintedResult):
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
