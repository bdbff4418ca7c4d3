"""What all designs have in common: records, printed texts and tables with named places, rules, and the scene from a template."""

import os
import re
import tomllib
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import Any, ClassVar

from governor_mechanism.effects.body_forces import DEFAULT_GRAVITY
from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import save_scene_text
from governor_mechanism.model.results.result import Column, Recorded, Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import format_scene_toml, format_toml_value
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.quantities import format_quantity
from governor_mechanism.units.text_table import NoValueError, Places, fill_places, format_table, short_repr

MAX_RATIO = 0.5
"""Largest droop, speed fluctuation and insensitivity: what changes its speed by more is not governed."""

GOVERNED = (0.0, MAX_RATIO)
"""Limits of ratios of speeds that a governor keeps."""


def require_valid(
    machine: str,  # the machine whose table "limits" has the sentences about inputs beyond their limits
    inputs: Any,
    # function that yields sentences about inputs at odds with each other; it is called if each has its sign
    relations: Callable[[Any], Iterable[str]] = lambda _: (),
    *,
    # function that yields sentences about inputs of which one follows from the other, whatever their signs
    alternatives: Callable[[Any], Iterable[str]] = lambda _: (),
) -> None:
    """Raise MechanismError, with a sentence per mistake, for inputs that are not valid."""
    quantities = [(name, getattr(inputs, name), declared) for name, declared in fields_of(type(inputs)).items() if declared.kinds]
    given = [(name, value, declared) for name, value, declared in quantities if value is not None]
    wrong_signs = {name: problem for name, value, declared in given if (problem := _sign_problem(name, value, declared))}
    beyond = {name: one.limits for name, value, one in given if one.limits and name not in wrong_signs and not one.admits(value)}
    texts = read_tables(machine).get("limits", {})
    out_of_limits = [fill_places(texts[name], inputs, lowest=low, highest=high) for name, (low, high) in beyond.items()]
    problems = [*wrong_signs.values(), *out_of_limits, *alternatives(inputs), *(() if wrong_signs else relations(inputs))]
    if problems:
        raise MechanismError(*problems)


def _sign_problem(name: str, value: float, declared: Declaration) -> str:
    """Return a sentence about an input with a wrong sign; empty if it is right."""
    if declared.sign == "any" or value > 0 or (value == 0 and declared.sign == "not negative"):
        return ""
    rule = declared.hint or ("be positive" if declared.sign == "positive" else "not be negative")
    return f"{name} must {rule}; got {format_quantity(value, declared.unit).strip()}"


DAMPING_RATIO = 0.7
"""Damping ratio of the dashpots half way up: the sleeve follows the speed without much overshoot."""

SPEED_MARGIN_RATIO = 0.02
"""Distance of the simulated speeds from the wanted ones, relative to their difference; at these the sleeve would be at its stops."""


@cache
def read_file(name: str) -> str:
    """Return the text of a template."""
    return resources.files(__package__).joinpath("templates", name).read_text(encoding="utf-8")


_LONE_PLACE = re.compile(r"\{([^{}:]+)\}")
"""A cell that is a place without a format: its row has the value itself."""


@cache
def read_tables(machine: str) -> Mapping[str, Any]:
    """Return the tables of a machine as its file has them."""
    return tomllib.loads(read_file(f"tables/{machine}.toml"))


def sentences(
    machine: str,
    record: object,
    cases: Mapping[str, bool],  # whether the case of a sentence holds, by the name of the sentence
    **values: object,  # values of places that are no attributes of the record
) -> list[str]:
    """Return the sentences of a machine whose case holds, with their places filled."""
    texts = read_tables(machine)["sentences"]
    return [fill_places(texts[name], record, **values) for name, holds in cases.items() if holds]


def refuse(machine: str, record: object, cases: Mapping[str, bool], **values: object) -> None:
    """Raise MechanismError with the sentences whose case holds, if any."""
    if problems := sentences(machine, record, cases, **values):
        raise MechanismError(*problems)


def fill_rows(machine: str, table: str, record: object, **values: object) -> list[Any]:
    """Return the rows, lists or fields of records, of a table of a machine with places filled, also by `values`; none with a None."""
    rows = list[Any]()
    for row in read_tables(machine).get(table, []):
        with suppress(NoValueError):
            if isinstance(row, dict):
                rows.append({key: _fill_cell(cell, record, values) for key, cell in row.items()})
            else:
                rows.append([_fill_cell(cell, record, values) for cell in row])
    return rows


def _fill_cell(cell: Any, record: object, values: Mapping[str, object]) -> Any:
    """Return a cell with its places filled: the value of a place alone, or text."""
    if not isinstance(cell, str):
        return cell
    if not (lone := _LONE_PLACE.fullmatch(cell)):
        return Places().vformat(cell, (record,), values)
    value = Places().get_field(lone[1], (record,), values)[0]
    if value is None:
        raise NoValueError
    return value


def format_rows(machine: str, table: str, record: object, justify: str, **values: object) -> str:
    """Return a table of a machine as text, its first row as the headings; the letters are those of `format_table`."""
    headings, *rows = fill_rows(machine, table, record, **values)
    return format_table(headings, rows, justify)


class _ScenePlaces(Places):
    """Places of a scene file: one without a format has the value as TOML writes it."""

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a value as text."""
        return format_toml_value(value) if value is not None and not format_spec else super().format_field(value, format_spec)


def scene_comment(machine: str) -> str:
    """Return the comment with which the scene files of a machine begin."""
    lines = read_file(f"{machine}.toml").splitlines()
    return "\n".join(line.removeprefix("# ") for line in lines if line.startswith("#"))


def speed_steps(times: Iterable[float], speeds: Iterable[float], digits: int = 15) -> list[tuple[float, str]]:
    """Return a program of the speed (rad/s) over times (s) as a scene has it."""
    return [(float(round(time, 6)), f"{speed / RPM:.{digits}g} rpm") for time, speed in zip(times, speeds, strict=True)]


def run_up_steps(times: Sequence[float], lowest: float, highest: float, digits: int = 15) -> list[tuple[float, str]]:
    """Return a program of the speed (rad/s) that is constant before, between and after two rises: six times (s)."""
    fractions = (SPEED_MARGIN_RATIO, SPEED_MARGIN_RATIO, 0.5, 0.5, 1 - SPEED_MARGIN_RATIO, 1 - SPEED_MARGIN_RATIO)
    return speed_steps(times, (lowest + fraction * (highest - lowest) for fraction in fractions), digits)


def sleeve_damping(inertia: float, frequency: float, lift_derivative: float) -> float:
    """Return the damping (N s/m) c of the dashpot at a sleeve: c z'^2 = 2 D I w for a damping ratio D."""
    # I is the inertia of the angle of the arms (kg m2), w the frequency of small oscillations (rad/s),
    # z' the derivative of the lift by the angle (m/rad).
    return 2 * DAMPING_RATIO * inertia * frequency / lift_derivative**2


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
    """Result of a design: its templates are `MACHINE.txt`, the text that it prints, and `MACHINE.toml`, its scene, both with places."""

    machine: ClassVar[str]
    warning_start: ClassVar[str] = ""
    inputs: Any
    figure_set = "render.figures.designs.simulated_figures"

    __repr__ = short_repr

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, one sentence each; a design without rules has them as a field."""
        return ()

    @property
    def warnings_text(self) -> str | None:
        """All warnings, a line each; None without any."""
        return "\n".join(f"{self.warning_start}{sentence}" for sentence in self.warnings) or None

    def __str__(self) -> str:
        """Return the design as text in workshop units."""
        return fill_places(read_file(f"{self.machine}.txt"), self)

    @property
    def scene_gravity(self) -> bool | str | None:
        """The gravity as a scene has it: true if it is the usual one, and no value if there is none."""
        gravity = self.inputs.gravity
        return None if gravity == 0 else True if gravity == DEFAULT_GRAVITY else f"{gravity:.15g} m/s^2"

    @abstractmethod
    def scene_values(self) -> Mapping[str, object]:
        """Return the values of places of the scene that are no attributes of the design; options of a design give variants."""

    def fill_scene(self, values: Mapping[str, object]) -> Mapping[str, object]:
        """Return the document of the scene with the values of its places; the line of one that is None is left out."""
        return tomllib.loads(fill_places(read_file(f"{self.machine}.toml"), self, _ScenePlaces(), **values))

    @cached_property
    def scene_document(self) -> Mapping[str, Any]:
        """The document of a runnable scene of the design."""
        return self.fill_scene(self.scene_values())

    @property
    def scene(self) -> Scene:
        """The scene of that document."""
        return parse_scene_document(self.scene_document)

    def save_scene(self, path: str | os.PathLike[str]) -> Path:
        """Write the scene as a scene file, with a comment on how it was designed; its name ends in .toml."""
        return save_scene_text(format_scene_toml(self.scene_document, scene_comment(self.machine)), path)


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


class Cause(StrEnum):
    """Why something printed is not right; `CAUSE_MEANINGS` of the errata defines each cause."""

    ERROR = "error"
    CONSEQUENCE = "consequence"
    MISPRINT = "misprint"
    SLIP = "slip"
    ROUNDING = "rounding"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class PrintedNumber:
    """One number of a paper in `unit`, printed and recomputed; if it is not right, the cause, and a remark on it."""

    quantity: str
    unit: str
    printed: float
    recomputed: float
    cause: Cause | None = None
    remark: str = ""

    @property
    def mark(self) -> str:
        """Cause and remark; empty if the number is right."""
        return f"{self.cause.upper()}: {self.remark}" if self.cause else ""


@dataclass(frozen=True, kw_only=True)
class PrintedNumbers(Recorded):
    """The numbers of a paper in its order; a subclass has others in further fields."""

    numbers: tuple[PrintedNumber, ...]

    derived: ClassVar[tuple[str, ...]] = ("deviations=deviating_quantities",)

    @property
    def deviations(self) -> tuple[PrintedNumber, ...]:
        """The numbers that are not right, in the paper's order."""
        groups = (value for one in fields(self) if isinstance(value := getattr(self, one.name), tuple))
        return select_deviations(number for group in groups for number in group if isinstance(number, PrintedNumber))

    @property
    def deviating_quantities(self) -> list[str]:
        """Names of those numbers."""
        return [number.quantity for number in self.deviations]


def find_checks(machine: str, record: object, *tables: str, **values: object) -> tuple[Check, ...]:
    """Return the rules in tables of a machine, with the numbers of a design in their places."""
    return tuple(Check(**row) for table in tables for row in fill_rows(machine, table, record, **values))


def printed_numbers(machine: str, table: str, **values: object) -> tuple[PrintedNumber, ...]:
    """Return the printed numbers of a table of a machine, with the recomputed ones in their places."""
    rows = fill_rows(machine, table, None, **values)
    return tuple(PrintedNumber(*row[:4], *map(Cause, row[4:5]), *row[5:]) for row in rows)


PRINTED_COLUMNS = (
    Column("quantity", "quantity"),
    Column("unit", "unit"),
    Column("printed", "printed", ".6g"),
    Column("recomputed", "recomputed", ".7g"),
    Column("mark", ""),
)
"""Columns of a table of printed numbers."""


def select_deviations(numbers: Iterable[PrintedNumber]) -> tuple[PrintedNumber, ...]:
    """Return the numbers that do not agree with the recomputed ones, in their order."""
    return tuple(number for number in numbers if number.cause)
