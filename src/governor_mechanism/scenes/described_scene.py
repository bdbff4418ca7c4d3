"""A scene in words: the values that describe it, as text and as JSON."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, ClassVar

from governor_mechanism.model.results.result import Column, Recorded, Result
from governor_mechanism.model.time_functions import (
    AngleHarmonic,
    Harmonic,
    HarmonicFunction,
    InputFunction,
    LinearFunction,
    PrescribedMotion,
    ReadingFunction,
    TableFunction,
)
from governor_mechanism.units.quantities import format_quantity
from governor_mechanism.units.text_table import format_table

MAX_WRITTEN_POINTS = 6
"""Largest number of points of a program or table that are written out; of a longer one, the ends."""

NEAT_UNITS = {"m2": "m^2", "m^2": "m^2", "1": ""}
"""Units that are written differently in scene files."""

QUANTITY_UNITS = {"angle": "rad", "length": "m", "angular_speed": "rad/s", "ratio": ""}
"""Unit of a reading by its quantity."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class DescribedValue(Recorded):
    """A named value with its unit."""

    name: str  # name, as in a scene file
    value: float | str | None  # number in SI, word, text of a function, or None for a value that is left out
    unit: str = ""  # SI unit; empty for a number without one
    meaning: str = ""  # what it is; may be empty
    key: str = ""  # dotted key by which it is changed and varied; empty where the scene file does not give it by itself

    optional = ("meaning", "key")

    @property
    def is_absent(self) -> bool:
        """Whether it is left out, zero or switched off, and says nothing of an effect."""
        return self.value in (None, 0.0, "false")

    @property
    def text(self) -> str:
        """The value with a customary unit."""
        if self.value is None:
            return "left out"
        return self.value if isinstance(self.value, str) else format_number(self.value, self.unit)


def format_number(
    value: float,
    unit: str,  # SI unit
) -> str:
    """Return a number with a customary unit, as scene files write it ("300 mm"); "none" for an infinite one."""
    return "none" if math.isinf(value) else format_quantity(value, NEAT_UNITS.get(unit, unit))


def describe_value(
    name: str,
    value: Any,  # a number in SI, None, a flag, a word, a function or a motion
    unit: str,  # SI unit of the number or of the values of the function
    meaning: str = "",
) -> DescribedValue:
    """Return a value of a description with its name; that of a function is a text."""
    if isinstance(value, InputFunction):
        is_plain = value.is_constant
        return DescribedValue(name=name, value=value.values[0] if is_plain else describe_input(value, unit), unit=unit, meaning=meaning)
    if isinstance(value, PrescribedMotion):
        return DescribedValue(name=name, value=_describe_points(value.times, value.values, unit), unit=unit, meaning=meaning)
    if isinstance(value, bool):
        return DescribedValue(name=name, value=str(value).lower(), meaning=meaning)
    is_left_out = value is None or (isinstance(value, float) and math.isinf(value))
    return DescribedValue(name=name, value=None if is_left_out else value, unit="" if isinstance(value, str) else unit, meaning=meaning)


def describe_input(
    function: InputFunction,  # value over time, with the functions of readings that are added and multiplied
    unit: str,  # SI unit of the value
) -> str:
    """Return an input in words, as "300 N m at 0 s, 150 N m at 6 s, times a table of governor.sleeve_lift"."""
    has_zero = len(function.times) == 1 and not function.values[0] and bool(function.functions or function.harmonics)
    terms = [] if has_zero else [_describe_points(function.times, function.values, unit)]
    for one in function.harmonics:
        terms.append(f"{'plus ' if terms else ''}{_describe_harmonic(one, format_number(one.frequency, 'Hz'), unit)}")
    terms += [f"{'plus ' if terms else ''}{describe_reading_function(one, unit)}" for one in function.functions]
    terms += [f"times {describe_reading_function(one, '')}" for one in function.factors]
    return ", ".join(terms)


def describe_reading_function(function: ReadingFunction, unit: str) -> str:
    """Return a function of a reading in words; `unit` is the SI unit of its value."""
    reading, own_unit = function.reading, QUANTITY_UNITS.get(function.quantity, "")
    lag = f", with a lag of {format_number(function.lag, 's')}" if function.lag else ""
    if isinstance(function, LinearFunction):
        about = f" about {format_number(function.about, own_unit)}" if function.about else ""
        gain_unit = f" {unit} per {own_unit}" if own_unit else " in SI"
        return f"{function.gain:.6g}{gain_unit} of {reading}{about}{lag}"
    if isinstance(function, TableFunction):
        return f"a table of {reading}: {_describe_points(function.positions, function.values, unit, own_unit)}{lag}"
    if isinstance(function, HarmonicFunction):
        return ", plus ".join(_describe_harmonic(one, f"order {one.order:g}", unit) for one in function.harmonics) + f" in {reading}{lag}"
    return f"a function of {reading}{lag}"


def _describe_harmonic(harmonic: Harmonic | AngleHarmonic, frequency: str, unit: str) -> str:
    """Return a sine in words; `frequency` is its frequency or order."""
    phase = f" at a phase of {format_number(harmonic.phase, 'rad')}" if harmonic.phase else ""
    return f"a sine of {format_number(harmonic.amplitude, unit)} and {frequency}{phase}"


def _describe_points(positions: tuple[float, ...], values: tuple[float, ...], unit: str, position_unit: str = "s") -> str:
    """Return values at positions, which are times by default; of many, the first and the last."""
    if len(positions) == 1:
        return format_number(values[0], unit)
    points = [f"{format_number(y, unit)} at {format_number(x, position_unit)}" for x, y in zip(positions, values, strict=True)]
    return ", ".join(points) if len(points) <= MAX_WRITTEN_POINTS else f"{len(points)} points from {points[0]} to {points[-1]}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class DescribedItem(Recorded):
    """Something that a scene lists: an effect, a force element, a coupling, an event."""

    name: str  # name in messages and results
    kind: str  # what it is, as "gear"
    text: str  # the rest in words
    values: tuple[DescribedValue, ...] = ()  # its numbers, if it has any
    key: str = ""  # dotted key of its value or table in the scene file; empty if it is not stated

    optional = ("values", "key")


@dataclasses.dataclass(frozen=True, kw_only=True)
class DescribedPart(Recorded):
    """One part of a scene in words."""

    name: str  # name of the part
    machine: str  # name of the machine in scene files
    plane: str  # "turning" or "fixed"
    spindle: str  # how its spindle turns, in words; empty in a fixed plane
    dimensions: tuple[DescribedValue, ...]  # dimensions in SI
    effects: tuple[DescribedItem, ...]  # effects
    # bodies, joints: names of the bodies, and of the joints of the mechanism
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    coordinate: str  # name of the leading coordinate
    law: str = ""  # the law that it proves, in words; empty without one
    key: str = ""  # start of the dotted keys of its tables, as "part.engine."; empty in a scene of one part


@dataclasses.dataclass(frozen=True, kw_only=True)
class EngineAnswer:
    """What an engine says about a scene."""

    name: str  # name of the engine
    supported: bool  # whether it can run the scene
    reason: str  # why not, or why "auto" takes it; empty for the others
    is_chosen: bool  # whether "auto" takes it

    def __str__(self) -> str:
        if self.is_chosen:
            return f'runs it with engine = "auto"{f": {self.reason}" if self.reason else ""}'
        return "can run it" if self.supported else f"refuses: {self.reason}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class SceneDescription(Result):
    """A scene in words; it prints as text, and its table has the readings.

    Attributes
    ----------
    title
        Title of the scene.
    source
        Name of the scene file; empty without one.
    parts
        Its parts.
    force_elements
        Springs, dampers, forces, torques and gas, with what they depend on.
    couplings
        Couplings of parts, and the load.
    events
        Crossings that the events of a run name.
    readings
        Readings of a run with their units; the value is that at the start, or None where it is not known before a run.
    degrees_of_freedom
        Degrees of freedom that joints and drivers leave.
    drivers
        Number of drivers.
    run
        Settings of a run.
    engines
        What each engine says.
    problem
        Why the scene has no start; empty if it has one.
    """

    title: str
    source: str
    parts: tuple[DescribedPart, ...]
    force_elements: tuple[DescribedItem, ...]
    couplings: tuple[DescribedItem, ...]
    events: tuple[DescribedItem, ...]
    readings: tuple[DescribedValue, ...]
    degrees_of_freedom: int
    drivers: int
    run: tuple[DescribedValue, ...]
    engines: tuple[EngineAnswer, ...]
    problem: str = ""

    columns: ClassVar[tuple[Column, ...]] = (
        Column("name", ""),
        Column("unit", "", lambda one: NEAT_UNITS.get(one.unit, one.unit) or "-"),
        Column("value", "", lambda one: "" if one.value is None else one.text),
    )

    @property
    def rows(self) -> tuple[DescribedValue, ...]:
        """Rows of the table: the readings."""
        return self.readings

    def __repr__(self) -> str:
        """Return the text, which an interactive session shows."""
        return str(self)

    def __str__(self) -> str:
        drivers = f", {self.drivers} driver{'s' * (self.drivers > 1)}" if self.drivers else ""
        lines = [f"{self.title}{f' ({self.source})' if self.source else ''}"]
        for part in self.parts:
            lines += _part_lines(part, has_name=len(self.parts) > 1)
        start = "value at the start" if not self.problem else ""
        lines += _section("Force elements", [(one.name, one.kind, one.text) for one in self.force_elements])
        lines += _section("Couplings and loads", [(one.name, one.kind, one.text) for one in self.couplings])
        lines += _section("Events", [(one.name, one.text) for one in self.events])
        readings = [[column.cell_of(one) for column in self.columns] for one in self.rows]
        lines += _section(f"Readings, SI unit{f', {start}' if start else ''}", readings)
        lines += ["", f"Degrees of freedom: {self.degrees_of_freedom}{drivers}"]
        lines += _section("Run", [(one.name, one.text) for one in self.run])
        lines += _section("Engines", [(one.name, str(one)) for one in self.engines])
        return "\n".join([*lines, *(["", f"No run is possible: {self.problem}"] if self.problem else [])])


def _part_lines(part: DescribedPart, *, has_name: bool) -> list[str]:
    """Return the lines of a part: machine, spindle, dimensions, effects, bodies and joints."""
    name = f"Part {part.name}: " if has_name else ""
    lines = [
        "",
        f"{name}{'machine' if name else 'Machine'} {part.machine}, {part.spindle or 'in a fixed plane'}; coordinate {part.coordinate}",
    ]
    lines += _section(
        f"Dimensions, with the keys {part.key}dimensions.NAME", [(one.name, one.text, one.meaning) for one in part.dimensions]
    )
    lines += _section("Effects, with their keys", _effect_rows(part.effects)) or ["", "Effects: none"]
    lines += ["", f"Law: {part.law}"] if part.law else []
    return [*lines, "", f"Bodies: {'; '.join(part.bodies)}", f"Joints: {'; '.join(part.joints) or 'none'}"]


def _effect_rows(effects: Sequence[DescribedItem]) -> list[tuple[str, str]]:
    """Return what can be changed by a key of its own in a row of its own, and every other effect in words."""
    rows = []
    for effect in effects:
        own = [(value.key, value.text) for value in effect.values if value.key]
        others = ", ".join(f"{value.name} {value.text}" for value in effect.values if not value.key and not value.is_absent)
        rows += [*own, *([(effect.key, others)] if others else [])] if own else [(effect.key or effect.name, effect.text)]
    return rows


def _section(heading: str, rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a heading with a table under it; nothing without rows."""
    return ["", heading, *(f"  {line}" for line in format_table([], rows).splitlines())] if rows else []
