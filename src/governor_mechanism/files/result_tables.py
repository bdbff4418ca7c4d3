"""Results as records of plain values and as tables: JSON, CSV files and data frames of pandas, by what their classes declare."""

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.netcdf import run_attributes, run_variables
from governor_mechanism.files.writing import plain_value, save_json, save_table
from governor_mechanism.model.results.result import Column, Recorded, Result
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.types import DataFrame, Dataset
from governor_mechanism.units.problems import PATH, check_arguments


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
    """Return a result as a table of pandas: its columns, and the numbers that are in none of them in the `attrs` of the table.

    A result without columns or arrays has one row with all its plain values, in which a list is one cell. Raises MechanismError if pandas
    is not installed.
    """
    columns, others = _column_values(result)
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
    columns, _ = _column_values(result)
    units = _units(result.columns)
    comment = "" if result.has_units_in_header else "; ".join(f"{name} {unit}" for name, unit in units.items())
    names = [f"{name} [{units[name]}]" if result.has_units_in_header and units.get(name) else name for name in columns]
    cells = [values.tolist() if isinstance(values, np.ndarray) else values for values in columns.values()]
    rows = ([None if cell != cell else cell for cell in row] for row in zip(*cells, strict=True))  # a NaN
    return save_table(names, rows, Path(path), comment=f"units: {comment}" if comment else "")


def _column_values(result: Result) -> tuple[dict[str, Any], dict[str, Any]]:
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
