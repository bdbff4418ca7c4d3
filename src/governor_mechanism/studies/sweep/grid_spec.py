"""Axes of a sweep as requested: "key=first:last:count", "key=value,value,...", or a mapping of keys to values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import format_value

MAX_SWEEP_ROWS = 200_000
"""Maximum number of rows of a sweep; a larger number suggests a slip."""

AXIS_EXAMPLE = "dimensions.arm=200mm:400mm:50, or dimensions.arm=200mm,300mm"
"""Example of two axes in messages."""


@dataclass(frozen=True, kw_only=True)
class AxisRequest:
    """Requested values of one key; for a range `values` holds both ends and `range_count` the number of values."""

    key: str
    values: tuple[Any, ...]
    range_count: int | None = None

    @property
    def first_value(self) -> Any:
        """First value as written."""
        return self.values[0]


def parse_axis_requests(vary: Mapping[str, Any] | Sequence[str]) -> tuple[list[AxisRequest], list[str]]:
    """Return the requested axes, and a message for each request that is not understood."""
    if isinstance(vary, str):
        vary = [vary]
    if not isinstance(vary, Mapping | Sequence) or not vary:
        return [], [f"vary: nothing to vary; name a key and its values, as in {AXIS_EXAMPLE}; found {format_value(vary)}"]
    requests: list[AxisRequest] = []
    problems: list[str] = []
    for request in vary.items() if isinstance(vary, Mapping) else vary:
        try:
            requests.append(_parse_request_text(request) if isinstance(request, str) else _parse_request(*request))
        except MechanismError as error:
            problems += [f"vary: {problem}" for problem in error.problems]
    counts = Counter(one.key for one in requests)
    problems += [f"vary: {key} is given {count} times; give all its values at once" for key, count in counts.items() if count > 1]
    n_rows = math.prod(len(one.values) if one.range_count is None else one.range_count for one in requests)
    if n_rows > MAX_SWEEP_ROWS:
        problems.append(f"vary: {n_rows:,} rows are too many (at most {MAX_SWEEP_ROWS:,}); take fewer values of a key")
    return [one for one in requests if counts[one.key] == 1], problems


def _parse_request_text(text: str) -> AxisRequest:
    key, separator, values = text.partition("=")
    if not separator or not values.strip():
        raise MechanismError(f"{format_value(text)} has no values; write {AXIS_EXAMPLE}")
    return _parse_request(key.strip(), values)


def _parse_request(key: Any, values: Any) -> AxisRequest:
    if not isinstance(key, str) or not all(part.strip() for part in key.split(".")):
        raise MechanismError(f"{format_value(key)} is not a key of a scene; a key is a table and a name, as in dimensions.arm")
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if isinstance(values, str):
        if ":" in values:
            return _parse_range(key, values)
        values = [_parse_plain_value(item.strip()) for item in values.split(",")]
    if not isinstance(values, list | tuple | range) or not len(values):
        raise MechanismError(f"{key} needs a list of values; found {format_value(values)}; write {AXIS_EXAMPLE}")
    plain_values = [value.item() if isinstance(value, np.generic) else value for value in values]
    invalid_values = [value for value in plain_values if not isinstance(value, str | int | float) or value == ""]
    if invalid_values:
        raise MechanismError(f"{key} takes a list of numbers and texts; found {format_value(invalid_values[0])}")
    return AxisRequest(key=key, values=tuple(plain_values))


def _parse_range(key: str, text: str) -> AxisRequest:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) != 3 or not all(parts):
        raise MechanismError(f"{key}={text} is not a range; write first:last:count, as in {AXIS_EXAMPLE.partition(',')[0]}")
    if not parts[2].isdecimal() or int(parts[2]) < 1:
        raise MechanismError(f"{key}={text}: the count must be a whole number of at least 1; found {format_value(parts[2])}")
    count = int(parts[2])
    if count > MAX_SWEEP_ROWS:
        raise MechanismError(f"{key}={text}: {count:,} values are too many (at most {MAX_SWEEP_ROWS:,} rows)")
    if count == 1 and parts[0] != parts[1]:
        raise MechanismError(f"{key}={text}: one value cannot be both ends of a range; write {key}={parts[0]}")
    return AxisRequest(key=key, values=(_parse_plain_value(parts[0]), _parse_plain_value(parts[1])), range_count=count)


def _parse_plain_value(text: str) -> Any:
    """Return a number, true or false as such, and any other text unchanged."""
    if text in ("true", "false"):
        return text == "true"
    try:
        number = float(text)
    except ValueError:
        return text
    return number if math.isfinite(number) else text
