"""What a run says of itself, as a record and as text, and results as JSON, CSV files and data frames, by what their classes declare."""

import math
import os
import platform
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.netcdf import run_attributes, run_variables, write_netcdf
from governor_mechanism.files.writing import finite_or_none, number_or_text, plain_value, save_json, save_table
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.results.result import Column, Recorded, Result
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.types import DataFrame, Dataset
from governor_mechanism.units.problems import PATH, check_arguments
from governor_mechanism.units.quantities import format_quantity, format_reading_name
from governor_mechanism.units.text_table import format_table, summarise


def make_data_frame(
    columns: Mapping[str, NDArray[Any] | Sequence[Any]],  # columns by name; shape (n,) each
    *,
    index: str | None = None,  # name of the column that labels the rows; numbers from 0 if None
    # units of columns by name, which `attrs["units"]` of the table holds
    units: Mapping[str, str] | None = None,
) -> DataFrame:
    """Return columns as a table of pandas; raise MechanismError if pandas is not installed."""
    pandas = _require("pandas", "a table")
    table = pandas.DataFrame(dict(columns))
    table = table if index is None else table.set_index(index)
    table.attrs["units"] = dict(units or {})
    return table


def make_xarray_dataset(run: Trajectory) -> Dataset:
    """Return all arrays of a run as a data set of xarray: the same that `xarray.open_dataset` reads from its netCDF file."""
    xarray = _require("xarray", "a data set")
    variables = {one.name: (one.dimensions, one.values, dict(one.attributes)) for one in run_variables(run)}
    labels = variables.get("event_time", ((), None, {}))[2].pop("coordinates", "").split()
    return xarray.Dataset(variables, attrs=run_attributes(run)).set_coords(labels)


def _require(package: str, what: str) -> Any:
    """Return a package, or refuse if it is not installed."""
    try:
        return import_module(package)
    except ImportError as missing:
        raise MechanismError(f"{what} of {package} needs this package: pip install 'governor-mechanism[{package}]'") from missing


def record_result(result: Recorded) -> dict[str, Any]:
    """Return what the class of a result records, in the types of JSON; rows, all or one, have the values of their columns."""
    names = result.record or [name for name in _field_names(result) if name not in result.hidden]
    columns = result.columns if isinstance(result, Result) else ()
    rows: Sequence[object] = getattr(result, "rows", ()) if columns else ()
    record: dict[str, Any] = {}
    for name, attribute, value in _named_values(result, (*names, *result.derived)):
        if name in result.optional and not value:
            continue
        if columns and attribute == "rows":
            record[name] = record_rows(columns, value)
        else:
            is_row = len(rows) > 0 and is_dataclass(value) and isinstance(value, type(rows[0]))
            record[name] = record_rows(columns, [value])[0] if is_row else json_value(value)
    return record


def record_rows(columns: Iterable[Column], rows: Iterable[object]) -> list[dict[str, Any]]:
    """Return rows in the types of JSON: the values of their columns by key."""
    recorded = [column for column in columns if column.key and column.in_json]
    return [{column.key: json_value(column.value_of(row)) for column in recorded} for row in rows]


def json_value(value: object) -> Any:
    """Return a value in the types of JSON, with None for a number that is not finite."""
    if isinstance(value, Recorded):
        return value.as_json()
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {key: json_value(one) for key, one in value.items()}
    if is_dataclass(value):
        return {field.name: json_value(getattr(value, field.name)) for field in fields(value)}
    plain = value if isinstance(value, list | tuple) else plain_value(value)
    if isinstance(plain, list | tuple):
        return [json_value(one) for one in plain]
    return None if isinstance(plain, float) and not math.isfinite(plain) else plain


def tabulate_result(
    result: Result,
    further: Iterable[Column] = (),  # columns after those that the result declares
) -> DataFrame:
    """Return the columns of a result as a table of pandas, other numbers in its `attrs`; MechanismError without pandas."""
    # A result without columns or arrays has one row with all its plain values, in which a list is one
    # cell.
    columns, others = column_values(result)
    further = list(further)
    columns |= {column.key: result.values_of(column) for column in further}
    table = make_data_frame(columns, index=result.index or None, units=_units([*result.columns, *further]))
    table.attrs |= others | {name: value for name, _, value in _named_values(result, result.attributes)}
    return table


@check_arguments(path=PATH)
def save_record(result: Result, path: str | os.PathLike[str]) -> Path:
    """Write the plain values of a result as a JSON file; raise MechanismError if the path is none."""
    return save_json(result.as_json(), Path(path))


@check_arguments(path=PATH)
def save_columns(result: Result, path: str | os.PathLike[str]) -> Path:
    """Write the table of a result as a CSV file: a comment with the units, if they are known, a header, and the rows."""
    columns, _ = column_values(result)
    units = _units(result.columns)
    comment = "" if result.has_units_in_header else "; ".join(f"{name} {unit}" for name, unit in units.items())
    names = [f"{name} [{units[name]}]" if result.has_units_in_header and units.get(name) else name for name in columns]
    cells = [values.tolist() if isinstance(values, np.ndarray) else values for values in columns.values()]
    rows = ([None if cell != cell else cell for cell in row] for row in zip(*cells, strict=True))  # a NaN
    return save_table(names, rows, Path(path), comment=f"units: {comment}" if comment else "")


MAX_PRINTED_ROWS = 12
"""Largest number of rows of a table that are printed; of more, the first and the last."""


def format_result(result: Result) -> str:
    """Return the columns of a result as a text table, or a single row as names, values and units."""
    columns, _ = column_values(result)
    units = {name: unit for name, unit in _units(result.columns).items() if unit != "1"}
    n_rows = max(map(len, columns.values()), default=0)
    if n_rows == 1:
        return format_table([], [(name, format_cell(values[0]), units.get(name, "")) for name, values in columns.items()])
    names = [f"{name}, {units[name]}" if name in units else name for name in columns]
    half = MAX_PRINTED_ROWS // 2
    is_long = n_rows > MAX_PRINTED_ROWS
    shown = [*range(half), *range(n_rows - half, n_rows)] if is_long else range(n_rows)
    rows = [[format_cell(values[row]) for values in columns.values()] for row in shown]
    return format_table(names, [*rows[:half], ["..."] * len(names), *rows[half:]] if is_long else rows, "r")


def format_cell(value: object) -> str:
    """Return a value of a column as text; nothing for none."""
    if isinstance(value, np.generic):
        value = value.item()
    return "" if value is None else value if isinstance(value, str) else summarise(value)


def column_values(result: Result) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the columns of a result by name, and what is in none of them."""
    columns = [column for column in result.columns if column.key and column.in_table]
    if columns:
        return {column.key: result.values_of(column) for column in columns}, {}
    values = {name: getattr(result, name) for name in _field_names(result)}
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray) and value.ndim == 1}
    record = dict(_flatten(result.as_json(), ""))
    if len({len(array) for array in arrays.values()}) == 1:
        return arrays, {name: value for name, value in record.items() if name not in arrays}
    return {name: [value] for name, value in record.items()}, {}


def _units(columns: Iterable[Column]) -> dict[str, str]:
    """Return the units that are stated; "1" is one."""
    return {column.key: column.unit for column in columns if column.key and column.unit and column.in_table}


def _named_values(result: Recorded, entries: Iterable[str]) -> Iterator[tuple[str, str, Any]]:
    """Yield name, attribute and value of entries "name" or "name=attribute"."""
    for entry in entries:
        name, _, attribute = entry.partition("=")
        yield name, attribute or name, attrgetter(attribute or name)(result)


def _field_names(result: Recorded) -> list[str]:
    return [one.name for one in fields(result) if one.repr]  # type: ignore[arg-type]  # any dataclass


def _flatten(record: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield names with dots and values of nested plain values."""
    for name, value in record.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


REPORTED_PACKAGES = ("governor-mechanism", "pymunk", "numpy", "scipy")


def save_netcdf(run: Trajectory, path: Path) -> None:
    """Write all arrays of a run as netCDF-3 by the CF conventions, with all that `gm.open_run` needs to read the run back."""
    write_netcdf(run, run_record(run), path)


def run_record(run: Trajectory) -> dict[str, Any]:
    """Return what of a run is no array, as plain JSON values; `files.netcdf` makes the run of it and of the arrays."""
    names = {"readings": list(run.readings), "rates": list(run.rates), "bodies": run.body_names, "joints": list(run.reactions)}
    scales = {"scales": run.scales, "energy_scale": run.energy.scale}
    summary = {name: value for name, value in summarise_run(run).items() if name != "document"}  # the scene has a place of its own
    return summary | scales | {"detail": run.detail, "names": names, "run_settings": run.scene.run}


def summarise_run(run: Trajectory) -> dict[str, Any]:
    """Return the summary of a run as plain JSON values."""
    summary = {
        "scene": Path(run.scene.source).name,  # a record goes to others, whom the folders of this machine do not concern
        "title": run.scene.title,
        "outcome": run.outcome.name.lower(),
        "message": run.message,
        "engine": run.cost.engine,
        "settings": run.settings,
        "error_estimate": None if run.error_estimate is None else number_or_text(run.error_estimate),
        "reading_errors": {name: number_or_text(error) for name, error in run.reading_errors.items()},
        "joint_gap": float(np.max(run.joint_gap, initial=0.0)),
        "energy_drift": run.energy.drift,
        "dissipated": float(run.energy.dissipated_energy[-1]) if len(run.times) else None,
        "n_excluded": run.n_excluded,
        "reported_times": len(run.times),
        "end_time": float(run.times[-1]) if len(run.times) else None,
        "final": {name: finite_or_none(float(values[-1])) for name, values in run.readings.items() if len(values)},
        "units": run.units,
        "mobility": run.mobility,
        "events": run.events,
        "speed_fluctuations": {angle: extremes.as_json() for angle, extremes in run.speed_fluctuations.items()},
        "recurrences": run.recurrences,
        "largest_joint_forces": {name: finite_or_none(float(np.max(one.magnitude, initial=0.0))) for name, one in run.reactions.items()},
        "notes": (*run.notes, *run.event_notes),
        "cost": run.cost,
        "versions": package_versions(),
        "document": run.scene.document,
    }
    return {name: plain_value(value) for name, value in summary.items()}


def package_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    versions = {"python": platform.python_version()}
    for name in REPORTED_PACKAGES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:  # run from a source tree that was not installed
            versions[name] = "not installed"
    return versions


EVENT_NOUNS = {
    EventKind.CROSSING: "crossing",
    EventKind.STICK: "sticking",
    EventKind.SLIP: "slipping",
    EventKind.IMPACT: "impact",
    EventKind.REST: "rest on a stop",
    EventKind.SEPARATION: "departure from a stop",
    EventKind.SLACK: "slackening",
    EventKind.TAUT: "tightening",
    EventKind.CHANGE_POINT: "change point",
    EventKind.TURNING_POINT: "turning point",
}
"""Nouns of events, those first that a reader looks for first."""

_PLURALS = {"rest on a stop": "rests on stops", "departure from a stop": "departures from stops"}
"""Plurals of nouns that do not end in s."""


def summarise_in_lines(result: Trajectory) -> list[str]:
    """Return a run in lines: what ran, how it ended, what happened, and what recurred."""
    cost, estimate = result.cost, result.error_estimate
    end_time = result.times[-1] if len(result.times) else 0.0
    accuracy = (
        "" if estimate is None or not len(result.times) else f"; accurate to {estimate:.1g} (requested {result.requested_accuracy:.1g})"
    )
    n_notes = len(result.notes) + len(result.event_notes)
    notes = f"; {n_notes} note{'s' * (n_notes > 1)}, see --verbose" if n_notes else ""
    return [
        f"{result.scene.title}: {end_time:g} s with engine {cost.engine}",
        f"{result.message}{accuracy}; computed in {cost.wall_time + cost.setup_time:.2g} s{notes}",
        count_events(result.events),
        *_format_recurrences(result),
    ]


def count_events(events: Sequence[Event]) -> str:
    """Return the number of events of each kind, with the first crossing that the scene names."""
    counts = Counter(event.kind for event in events)
    words = [f"{counts[kind]} {_plural(noun, counts[kind])}" for kind, noun in EVENT_NOUNS.items() if counts[kind]]
    first = next((f"; first {event}" for event in events if event.kind is EventKind.CROSSING), "")
    return f"events: {', '.join(words)}{first}" if words else "no events"


def _plural(noun: str, count: int) -> str:
    return noun if count == 1 else _PLURALS.get(noun, f"{noun}s")


def format_run(result: Trajectory) -> str:
    """Return a run with its final readings, events, losses and cost."""
    cost = result.cost
    estimate = result.error_estimate
    accuracy_clause = (
        "" if estimate is None or not len(result.times) else f"accurate to {estimate:.1g} (requested {result.requested_accuracy:.1g}); "
    )
    last_values = {name: format_quantity(values[-1], result.units[name], ".4f") for name, values in result.readings.items() if len(values)}
    final = ", ".join(f"{format_reading_name(name)} {value}" for name, value in last_values.items())
    joint_gap = result.joint_gap.max(initial=0.0)
    evaluation_counts = ", ".join(f"{name} {count:,}" for name, count in cost.evaluations.items())
    setup_clause = f" plus {cost.setup_time:.1g} s for its tables" if cost.setup_time else ""
    return "\n".join(
        [
            result.scene.title,
            result.message,
            *result.notes,
            *result.event_notes,
            f"{accuracy_clause}joints closed to {joint_gap:.1e} m, energy drift {result.energy.drift:.1e}",
            f"at {result.times[-1] if len(result.times) else 0:g} s: {final}",
            f"{_format_mobility(result)}; {_format_events(result)}",
            *_format_recurrences(result),
            *(f"speed of {angle}: {extremes}" for angle, extremes in result.speed_fluctuations.items()),
            *_format_losses(result),
            f"engine {cost.engine} ({cost.reason}): {cost.runs} runs, {cost.steps:,} steps, simulated in "
            f"{cost.wall_time:.2g} s{setup_clause}{f', {cost.method}' if cost.method else ''}",
            f"force law evaluations: {evaluation_counts or 'none'}",
        ]
    )


def _format_recurrences(result: Trajectory) -> list[str]:
    """Return a line for each named crossing that recurs."""
    return [f"{name}: {recurrence}" for name, recurrence in result.recurrences.items()]


def _format_losses(result: Trajectory) -> list[str]:
    """Return the dissipated energy and the number of samples too close to an event, each only if it is positive."""
    dissipated_energy = float(result.energy.dissipated_energy[-1]) if len(result.times) else 0.0
    lines = [f"friction, dashpots and stops dissipated {dissipated_energy:.4g} J"] * (dissipated_energy > 0.0)
    return lines + [f"{result.n_excluded} samples are too close to an event for the promised accuracy"] * (result.n_excluded > 0)


def _format_mobility(result: Trajectory) -> str:
    n_drivers = sum(part.mechanism.count_drivers() for part in result.scene.parts)
    return f"mobility {result.mobility}" + (f", {n_drivers} driver{'s' * (n_drivers > 1)}" if n_drivers else "")


MAX_LISTED_EVENTS = 3
"""Maximum number of events listed one by one, those that the scene names first."""


def _format_events(result: Trajectory) -> str:
    """Return the events and the largest joint force with the time at which it acts."""
    named_first = sorted(result.events, key=lambda event: event.kind is not EventKind.CROSSING)  # stable: in order of time otherwise
    listed_events = [str(event) for event in named_first[:MAX_LISTED_EVENTS]]
    n_more = len(result.events) - len(listed_events)
    events = "; ".join(listed_events + [f"and {n_more} more events"] * (n_more > 0)) or "no events"
    forces = {name: reaction.magnitude for name, reaction in result.reactions.items()}
    largest = max(forces, key=lambda name: forces[name].max(initial=0.0), default=None)
    if largest is None or not len(result.times):
        return events
    index = int(forces[largest].argmax())
    indeterminate_joints = ", ".join(repr(name) for name, reaction in result.reactions.items() if not reaction.determined.all())
    largest_force_clause = f"largest joint force {forces[largest][index]:.4g} N in {largest!r} at {result.times[index]:.4g} s"
    redundancy_clause = f"; statically indeterminate joint forces: {indeterminate_joints}" if indeterminate_joints else ""
    return f"{events}\n{largest_force_clause}{redundancy_clause}"
