"""Measured readings, and the result of a fit to them."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.sweep.quantities import find_reading_units
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, display_unit, format_quantity, format_value, parse_quantity

TIME: Final = "time"
"""Name of the column of the times."""

_HEADING = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
"""Heading of a column: a name, and a unit in brackets."""

MAX_DATA_SIZE = 50_000_000
"""Largest file of data, bytes."""

_KINDS_BY_UNIT: Final = {
    "m": "length",
    "rad": "angle",
    "rad/s": "angular_speed",
    "N": "force",
    "N m": "torque",
    "Pa": "pressure",
    "1": "ratio",
}
"""Kinds of the quantities that are measured, by the SI unit of the reading."""


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """One measured reading.

    Attributes
    ----------
    reading
        Name of the reading.
    unit
        SI unit.
    times
        Times, s, ascending; shape (n,).
    values
        Measured values, SI; shape (n,).
    noise
        Standard deviation of a value, SI; None where it is not known.
    """

    reading: str
    unit: str
    times: FloatArray
    values: FloatArray
    noise: float | None = None


def read_measurements(scene: Scene, data: Any, noise: Any, without: Sequence[Sequence[Any]]) -> tuple[Measurement, ...]:
    """Return measured readings of a file, a table or a mapping, with noise, all or by reading; MechanismError lists all mistakes."""
    # `without` are intervals of time that do not count.
    columns = _read_columns(data)
    collector = ProblemCollector()
    units, found = find_reading_units(scene), {}
    for heading, values in columns.items():
        with collector.at(""):
            name, factor = _read_heading(heading, units)
            if name in found:
                raise MechanismError(f"data: {name} has two columns; leave one out")
            found[name] = _read_values(name, values, factor)
    if TIME not in found and not collector.has_failed:
        raise MechanismError(f"data: no column {TIME!r}; the columns are {', '.join(map(str, columns))}")
    measured = {name: values for name, values in found.items() if name != TIME}
    if not measured and not collector.has_failed:
        raise MechanismError(f"data: no column has the name of a reading; readings are {', '.join(units)}")
    intervals = collector.attempt("", _read_intervals, without) or []
    levels = collector.attempt("", _read_noise, noise, measured, units) or {}
    if times_problem := _find_times_problem(found.get(TIME)):
        collector.collect(MechanismError(times_problem), "")
    collector.raise_if_failed()
    return tuple(_select(name, units[name], found[TIME], values, intervals, levels.get(name)) for name, values in measured.items())


def _read_columns(data: Any) -> dict[str, Sequence[Any]]:
    """Return the values of the columns by their headings."""
    if isinstance(data, str | Path):
        return _read_csv(Path(data))
    if isinstance(data, Mapping):
        return {str(name): np.atleast_1d(np.asarray(values)).tolist() for name, values in data.items()}
    if not hasattr(data, "columns") or not hasattr(data, "index"):
        raise MechanismError(f"data: give the path of a CSV file, a table of pandas or values by name; found {format_value(data)}")
    units = data.attrs.get("units", {})
    columns = {} if TIME in data.columns else {TIME: data.index.tolist()}
    for name in data.columns:
        values = data[name].tolist()
        columns[f"{name} [{units[name]}]" if name in units and "[" not in str(name) else str(name)] = [_blank(one) for one in values]
    return columns


def _blank(value: Any) -> Any:
    """Return a value of a table, in which NaN stands for a missing one."""
    return "" if value is None or (isinstance(value, float) and math.isnan(value)) else value


def _read_csv(path: Path) -> dict[str, Sequence[Any]]:
    """Return the columns of a CSV file; lines that begin with # are comments, but for the units of files of this package."""
    try:
        if path.stat().st_size > MAX_DATA_SIZE:
            raise MechanismError(f"{path}: larger than {MAX_DATA_SIZE:,} bytes; give fewer times")
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise MechanismError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise MechanismError(f"{path}: is not UTF-8 text; save the table as CSV") from error
    units = dict(pair.rsplit(" ", 1) for line in lines if line.startswith("# units:") for pair in _split_units(line))
    rows = [row for row in csv.reader(line for line in lines if not line.startswith("#")) if row]
    if len(rows) < 2:
        raise MechanismError(f"{path}: a table needs a line of headings, as 'time [s],sleeve_lift [mm]', and lines of values")
    heading, *values = rows
    lengths = [number for number, row in enumerate(values, start=2) if len(row) != len(heading)]
    if lengths:
        raise MechanismError(f"{path}: row {lengths[0]} has {len(values[lengths[0] - 2])} values, and there are {len(heading)} headings")
    headings = [f"{name} [{units[name]}]" if name in units else name for name in map(str.strip, heading)]
    return {name: [row[k] for row in values] for k, name in enumerate(headings)}


def _split_units(line: str) -> Iterable[str]:
    """Yield "name unit" of the comment on units in files of this package; what has no unit is left out."""
    pairs = line.removeprefix("# units:").split(";")
    return (pair.strip() for pair in pairs if " " in pair.strip())


def _read_heading(heading: str, units: Mapping[str, str]) -> tuple[str, float]:
    """Return the name of a column, and the SI value of its unit."""
    parts = _HEADING.fullmatch(heading)
    name, unit = (parts[1], parts[2]) if parts else (heading, None)
    if name != TIME and name not in units:
        raise MechanismError(
            f"data: {format_value(name)} is no reading; readings are {', '.join(units)}.{did_you_mean(name, [TIME, *units])}"
        )
    si_unit = "s" if name == TIME else units[name]
    if not unit or unit == si_unit:
        return name, 1.0
    return name, parse_quantity(f"1 {unit}", "time" if name == TIME else _kind_of(si_unit), f"data: one unit of {name}")


def _kind_of(si_unit: str) -> str:
    """Return the kind of quantity that has an SI unit."""
    named = _KINDS_BY_UNIT.get(si_unit)
    return named or next(
        (name for name, kind in QUANTITY_KINDS.items() if kind.si_unit.replace("^", "") == si_unit.replace("^", "")), "ratio"
    )


def _read_values(name: str, values: Sequence[Any], factor: float) -> FloatArray:
    """Return the values of a column in SI; NaN where a cell is empty."""
    numbers = np.full(len(values), np.nan)
    for k, value in enumerate(values):
        if isinstance(value, str) and not value.strip():
            continue
        try:
            numbers[k] = factor * float(value)
        except (TypeError, ValueError):
            raise MechanismError(f"data: {name}, value {k + 1}: {format_value(value)} is no number; leave the cell empty") from None
        if not math.isfinite(numbers[k]):
            raise MechanismError(f"data: {name}, value {k + 1}: {format_value(value)} is not finite; leave the cell empty")
    return numbers


def _find_times_problem(times: FloatArray | None) -> str:
    """Return what is wrong with the times; empty if nothing is."""
    if times is None:
        return ""
    if np.isnan(times).any():
        return f"data: time {int(np.argmax(np.isnan(times))) + 1} is missing; each row needs a time"
    if times[0] < 0.0:
        return f"data: the first time is {times[0]:g} s; a run begins at 0"
    steps = np.diff(times)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        what = "stands twice" if steps[k] == 0.0 else f"stands after {times[k]:g} s"
        return f"data: the times must ascend; {times[k + 1]:g} s, time {k + 2}, {what}; sort the rows, and keep one of equal times"
    return ""


def _read_intervals(without: Sequence[Sequence[Any]]) -> list[tuple[float, float]]:
    """Return the intervals, s, that do not count."""
    intervals = []
    if isinstance(without, str | bytes) or not isinstance(without, Sequence):
        raise MechanismError(f"without: give intervals of time, as [('2 s', '3 s')]; found {format_value(without)}")
    for interval in without:
        if isinstance(interval, str) or not isinstance(interval, Sequence) or len(interval) != 2:
            raise MechanismError(f"without: an interval has a start and an end, as ('2 s', '3 s'); found {format_value(interval)}")
        start, end = (parse_quantity(one, "time", "without") for one in interval)
        if not start < end:
            raise MechanismError(f"without: the interval from {start:g} s to {end:g} s has no length; swap its ends")
        intervals.append((start, end))
    return intervals


def _read_noise(noise: Any, measured: Iterable[str], units: Mapping[str, str]) -> dict[str, float]:
    """Return the standard deviation of each reading for which it is given, SI."""
    names = list(measured)
    if noise is None:
        return {}
    levels = noise if isinstance(noise, Mapping) else dict.fromkeys(names, noise)
    if not levels:
        raise MechanismError("noise: no reading has one; leave it out if it is not known")
    if unknown := [name for name in levels if name not in names]:
        raise MechanismError(f"noise: {format_value(unknown[0])} is not measured; measured are {', '.join(names)}")
    found = {name: parse_quantity(one, _kind_of(units[name]), f"noise of {name}") for name, one in levels.items()}
    if wrong := [name for name, one in found.items() if not one > 0.0]:
        raise MechanismError(f"noise of {wrong[0]} must be positive; leave it out if it is not known")
    return found


def _select(
    name: str, unit: str, times: FloatArray, values: FloatArray, intervals: Sequence[tuple[float, float]], noise: float | None
) -> Measurement:
    """Return the measurement of a reading without empty cells and intervals that do not count."""
    counts = np.isfinite(values)
    for start, end in intervals:
        counts &= (times < start) | (times > end)
    return Measurement(reading=name, unit=unit, times=times[counts], values=values[counts], noise=noise)


CONFIDENCE = 0.95
"""Probability with which an interval holds the true value."""


@dataclass(frozen=True, kw_only=True)
class FittedValue(Recorded):
    """Value of an unknown that fits best.

    Attributes
    ----------
    key
        Key of the scene.
    value
        Value, SI.
    unit
        SI unit.
    standard_error
        Standard error, SI; None where the data do not determine the value.
    low, high
        Ends of the 95 % interval, SI; None where the data do not determine the value.
    bounds
        Bounds of the search, SI.
    at_bound
        Whether the value lies at one of them.
    by_profile
        Whether the interval is that of the profile of the likelihood, and not of the standard error.
    """

    key: str
    value: float
    unit: str
    standard_error: float | None
    low: float | None
    high: float | None
    bounds: tuple[float, float]
    at_bound: bool
    by_profile: bool = False


def _format_value(row: FittedValue) -> str:
    return _round(row, row.value)


def _format_error(row: FittedValue) -> str:
    return "not determined" if row.standard_error is None else f"± {_round(row, row.standard_error)}"


def _round(row: FittedValue, value: float) -> str:
    """Return a value with the digits that two digits of its standard error allow."""
    factor, unit = display_unit(row.unit)
    if not row.standard_error:
        return format_quantity(value, row.unit)
    decimals = max(0, 1 - math.floor(math.log10(row.standard_error * factor)))
    return f"{value * factor:.{decimals}f} {unit}".rstrip()


def _format_interval(row: FittedValue) -> str:
    notes = ["at a bound"] * row.at_bound + ["profile"] * row.by_profile
    ends = [] if row.low is None or row.high is None else [f"{_round(row, row.low)} to {_round(row, row.high)}"]
    return "; ".join([*ends, *notes])


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit(Result):
    """Values of unknowns that fit measured readings best.

    Attributes
    ----------
    title
        Title of the scene.
    rows
        The values.
    correlation_matrix
        Correlations of the errors of the values; shape (unknowns, unknowns). Zero for those that the data do not determine.
    not_identifiable
        A sentence for each combination of unknowns that the data do not determine.
    measurements
        The data.
    noise
        Standard deviation of a measured value by reading, SI: as given, or estimated from the residuals.
    is_noise_given
        Whether the noise was given.
    residuals
        Measured less computed values by reading, SI, at the times that the run reaches; shape (n,).
    scene
        The scene with the fitted values.
    run
        Certified run of that scene, at the times of the data.
    n_runs
        Number of runs.
    n_starts
        Number of starts of the search.
    seed
        Seed of the random starts.
    converged
        Whether the search ended at a minimum.
    outcome
        How it ended, in a sentence.
    notes
        Further sentences.
    """

    title: str
    rows: tuple[FittedValue, ...]
    correlation_matrix: FloatArray
    not_identifiable: tuple[str, ...]
    measurements: tuple[Measurement, ...]
    noise: Mapping[str, float]
    is_noise_given: bool
    residuals: Mapping[str, FloatArray]
    scene: Scene
    run: Trajectory
    n_runs: int
    n_starts: int
    seed: int
    converged: bool
    outcome: str
    notes: tuple[str, ...] = ()

    hidden = ("measurements", "scene", "run", "residuals")
    columns: ClassVar[tuple[Column, ...]] = (
        Column("key", "key"),
        Column("value", "value", _format_value, side="r"),
        Column("standard_error", "standard error", _format_error, side="r"),
        Column("", "95 % interval", _format_interval),
        Column("unit"),
        Column("low"),
        Column("high"),
        Column("at_bound"),
    )
    index: ClassVar[str] = "key"
    figure: ClassVar[str] = "render.figures.optimum.fit_figure"
    data_files: ClassVar[tuple[str, ...]] = ("csv", "json")

    @property
    def ok(self) -> bool:
        """Whether the search converged."""
        return self.converged

    @property
    def values(self) -> dict[str, float]:
        """The values by key, SI."""
        return {row.key: row.value for row in self.rows}

    @property
    def standard_errors(self) -> dict[str, float | None]:
        """The standard errors by key, SI; None where the data do not determine the value."""
        return {row.key: row.standard_error for row in self.rows}

    @property
    def intervals(self) -> dict[str, tuple[float, float] | None]:
        """The 95 % intervals by key, SI; None where the data do not determine the value."""
        return {row.key: None if row.low is None or row.high is None else (row.low, row.high) for row in self.rows}

    @property
    def correlations(self) -> dict[tuple[str, str], float]:
        """The correlations of the errors by two keys."""
        keys = [row.key for row in self.rows]
        return {(one, other): float(self.correlation_matrix[i, k]) for i, one in enumerate(keys) for k, other in enumerate(keys) if i < k}

    def __str__(self) -> str:
        return "\n".join([f"{self.title}: {self.outcome}", format_columns(self.columns, self.rows), *self._closing_lines()])

    def _closing_lines(self) -> list[str]:
        """Return noise, strong correlations, what is not identifiable, and notes."""
        kind = "given" if self.is_noise_given else "estimated"
        units = {one.reading: one.unit for one in self.measurements}
        lines = [f"noise of {name}: {format_quantity(level, units[name])} ({kind})" for name, level in self.noise.items()]
        strong = {pair: value for pair, value in self.correlations.items() if abs(value) > 0.9}
        lines += [f"correlation of {one} and {other}: {value:.3f}" for (one, other), value in strong.items()]
        return [*lines, *self.not_identifiable, *self.notes, f"{self.n_runs} runs from {self.n_starts} starts, seed {self.seed}"]


def root_mean_square(values: Sequence[float] | FloatArray) -> float:
    """Return the root mean square of values."""
    return float(np.sqrt(np.mean(np.square(values))))
