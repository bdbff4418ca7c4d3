"""Results of the public functions as plain values, as a table of one row, and as JSON and CSV files."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.files.plain_values import finite_or_none, plain_value, save_json
from governor_mechanism.files.table import make_data_frame
from governor_mechanism.model.results.exported_result import ExportedResult
from governor_mechanism.types import DataFrame
from governor_mechanism.units.arguments import PATH, check_arguments


def record_result(
    # an instance of a dataclass; fields that its representation hides, as functions, are left out. Names in
    # `exported_properties` of its class are added
    result: ExportedResult,
) -> dict[str, Any]:
    """Return the public fields of a result, in the types of JSON.

    Result: values by name; numbers that are not finite are None.
    """
    names = [one.name for one in fields(result) if one.repr]  # type: ignore[arg-type]  # any dataclass
    names += getattr(result, "exported_properties", ())
    return {name: _plain(getattr(result, name)) for name in names}


def tabulate_record(result: ExportedResult) -> DataFrame:
    """Return a result as a table of pandas: its arrays (n,) as columns, and the other numbers in the `attrs` of the table.

    A result without such arrays has one row with all its plain values.

    Result: the table. In a single row, a list is one cell. Raises MechanismError if pandas is not installed.
    """
    values = {one.name: getattr(result, one.name) for one in fields(result) if one.repr}  # type: ignore[arg-type]  # any dataclass
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray) and value.ndim == 1}
    record = dict(_flatten(result.as_json(), ""))
    if len({len(array) for array in arrays.values()}) != 1:
        return make_data_frame({name: [value] for name, value in record.items()})
    table = make_data_frame(arrays)
    table.attrs |= {name: value for name, value in record.items() if name not in arrays}
    return table


@check_arguments(path=PATH)
def save_record(result: ExportedResult, path: str | os.PathLike[str]) -> Path:
    """Write the plain values of a result as a JSON file.

    Raises MechanismError if the path is none.
    """
    return save_json(result.as_json(), Path(path))


@check_arguments(path=PATH)
def save_columns(result: ExportedResult, path: str | os.PathLike[str]) -> Path:
    """Write the table of a result as a CSV file: a comment with the units, if they are known, a header, and the rows.

    Raises MechanismError if the path is none, or pandas is not installed.
    """
    table = result.to_dataframe()
    units = "; ".join(f"{name} {unit}" for name, unit in table.attrs.get("units", {}).items())
    text = table.to_csv(index=table.index.name is not None)
    with atomic_write(Path(path)) as temporary:
        temporary.write_text(f"# units: {units}\n{text}" if units else text, encoding="utf-8")
    return Path(path)


def _plain(value: object) -> Any:
    """Return a value in the types of JSON, with None for a number that is not finite."""
    if isinstance(value, ExportedResult):
        return value.as_json()
    return _with_none(plain_value(value))


def _with_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_none(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_with_none(one) for one in value]
    return finite_or_none(value) if isinstance(value, float) else value


def _flatten(record: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield names with dots and values of nested plain values."""
    for name, value in record.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
