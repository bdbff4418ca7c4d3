"""Files of points: CSV with units in the header, or TOML with further keys; rows of quantities given in Python are read the same."""

from __future__ import annotations

import csv
import io
import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, parse_quantity

_HEADING: Final = re.compile(r"\s*(\w+)\s*(?:[\[(]\s*(.*?)\s*[\])])?\s*$")

PointSource = str | os.PathLike[str] | Sequence[Sequence[float | str]] | FloatArray
"""Points: the path of a file, or rows of numbers in SI or texts with a unit."""


def read_points(
    source: object,  # path of a CSV or TOML file, or rows
    columns: Mapping[str, str],  # kinds of quantity by the names of the columns
    keys: Sequence[str] = (),  # further keys that a TOML file may have
    optional: Mapping[str, str] | None = None,  # columns after these, which are all there or all missing
) -> tuple[FloatArray | None, dict[str, Any]]:
    """Return points (n, columns), SI, or None, and the further keys of a file; MechanismError lists all mistakes."""
    rows, where = source, ""
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
            raise MechanismError(f"the file of points {str(path)!r} cannot be read: {reason}") from None
        if path.suffix.lower() == ".toml":
            return _read_toml(text, str(path), columns, keys, optional or {})
        rows, where = _read_csv(text, str(path), columns, optional or {}), f"{path}: "
    return _parse_rows(rows, columns, where, optional or {}), {}


def _read_toml(
    text: str, path: str, columns: Mapping[str, str], keys: Sequence[str], optional: Mapping[str, str]
) -> tuple[FloatArray | None, dict[str, Any]]:
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise MechanismError(f"{path} is no TOML: {error}") from None
    known = ["points", *keys]
    unknown = [
        f"{path}: there is no key {key!r}; keys are {', '.join(known)}.{did_you_mean(key, known)}" for key in document if key not in known
    ]
    if unknown:
        raise MechanismError(*unknown)
    rows = document.pop("points", None)
    return (None if rows is None else _parse_rows(rows, columns, f"{path}: ", optional)), document


def _read_csv(text: str, path: str, columns: Mapping[str, str], optional: Mapping[str, str]) -> list[list[str]]:
    """Return the cells of a CSV file with the units of its header, in the order of the columns."""
    lines = [row for row in csv.reader(io.StringIO(text)) if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")]
    example = ",".join(f"{name} [{QUANTITY_KINDS[kind].units[0]}]" for name, kind in columns.items())
    if not lines:
        raise MechanismError(f"{path} is empty; its first line names the columns, as {example}")
    headings = [_HEADING.match(cell) for cell in lines[0]]
    names = [one.group(1) if one else cell.strip() for one, cell in zip(headings, lines[0], strict=True)]
    if set(names) & set(optional):
        columns = {**columns, **optional}
    if sorted(names) != sorted(columns):
        also = f" (and {', '.join(optional)})" if optional else ""
        raise MechanismError(f"{path}: the columns must be {', '.join(columns)}{also}, as {example}; found {', '.join(names)}")
    units = [(one.group(2) or "") if one else "" for one in headings]
    wrong = [
        f"{path}: line {k} has {len(row)} cells; the header has {len(names)}"
        for k, row in enumerate(lines[1:], 2)
        if len(row) != len(names)
    ]
    if wrong:
        raise MechanismError(*wrong)
    order = [names.index(name) for name in columns]
    return [[f"{row[k].strip()} {units[k]}".strip() for k in order] for row in lines[1:]]


def _parse_rows(rows: Any, columns: Mapping[str, str], where: str, optional: Mapping[str, str]) -> FloatArray:
    """Return rows of quantities in SI; raise MechanismError with all mistakes."""
    table = rows.tolist() if isinstance(rows, np.ndarray) else rows
    if isinstance(table, list | tuple) and table and isinstance(table[0], list | tuple) and len(table[0]) > len(columns):
        columns = {**columns, **optional}
    names = list(columns)
    if not isinstance(table, list | tuple) or not all(isinstance(row, list | tuple) and len(row) == len(names) for row in table):
        raise MechanismError(f"{where}points must be rows of {', '.join(names)}; found {format_value(rows)}")
    collector = ProblemCollector()
    values = np.zeros((len(table), len(names)))
    for k, row in enumerate(table):
        for column, (name, kind) in enumerate(columns.items()):
            with collector.at(f"{where}point {k + 1}"):
                values[k, column] = parse_quantity(_number(row[column]), kind, f"{where}{name} of point {k + 1}")
    collector.raise_if_failed()
    return values


def _number(cell: Any) -> Any:
    """Return a text without a unit as the number that it is, which is in SI."""
    try:
        return float(cell) if isinstance(cell, str) else cell
    except ValueError:
        return cell


def parse_pair(value: object, kind: str, what: str) -> tuple[float, float]:
    """Return two quantities in SI."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(
            f"{what} must be two values, as [{', '.join([QUANTITY_KINDS[kind].written_example] * 2)}]; found {format_value(value)}"
        )
    return parse_quantity(value[0], kind, what), parse_quantity(value[1], kind, what)


def parse_pivots(name: str, value: object) -> tuple[complex, complex]:
    """Return two points that differ, m."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(f'{name} must be two points, as [[0, 0], ["100 mm", 0]]')
    first, second = (complex(*parse_pair(point, "length", f"point {k} of {name}")) for k, point in enumerate(value, start=1))
    if first == second:
        raise MechanismError(f"the two points of {name} coincide")
    return first, second


def require_count(points: FloatArray, counts: Sequence[int], what: str, hint: str = "", *, is_path: bool = False) -> None:
    """Raise MechanismError for another number of points than is allowed, or points that coincide; of a path neighbours and ends."""
    if len(points) not in counts:
        numbers = [str(count) for count in counts] if len(counts) < 10 else [f"{counts[0]} to {counts[-1]}"]
        allowed = " or ".join([", ".join(numbers[:-1]), numbers[-1]] if len(numbers) > 1 else numbers)
        raise MechanismError(f"{what} must be {allowed}; found {len(points)}{hint}")
    scale = float(np.ptp(points, axis=0).max())
    for first in range(len(points)):
        for second in ((first - 1) % len(points),) if is_path else range(first):
            if np.abs(points[first] - points[second]).max() <= 1e-9 * scale:
                low, high = sorted((first, second))
                raise MechanismError(f"{what}: {low + 1} and {high + 1} coincide; leave one out")
