"""How a sweep is asked for: "key=first:last:count", "key=value,value,...", or a mapping of keys to lists of values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import shown

MOST_ROWS = 200_000
"""Rows of a sweep: more would be looked at by nobody, and hint at a slip."""

EXAMPLE = "dimensions.arm=200mm:400mm:50, or dimensions.arm=200mm,300mm"


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What is asked of one key: a list of values, or of a range both ends, with the count in `ends`."""

    key: str
    given: tuple[Any, ...]
    ends: int | None = None

    @property
    def first(self) -> Any:
        """The first value."""
        return self.given[0]


def asked_of(vary: Mapping[str, Any] | Sequence[str]) -> tuple[list[Asked], list[str]]:
    """What is asked of each key, and a sentence for each request that cannot be understood."""
    if isinstance(vary, str):
        vary = [vary]
    if not isinstance(vary, Mapping | Sequence) or not vary:
        return [], [f"vary: nothing to vary; name a key and its values, as in {EXAMPLE}; found {shown(vary)}"]
    asked: list[Asked] = []
    problems: list[str] = []
    for request in vary.items() if isinstance(vary, Mapping) else vary:
        try:
            asked.append(_from_text(request) if isinstance(request, str) else _from_pair(*request))
        except MechanismError as error:
            problems += [f"vary: {problem}" for problem in error.problems]
    counts = Counter(one.key for one in asked)
    problems += [
        f"vary: {key} stands {count} times; give all its values at once" for key, count in counts.items() if count > 1
    ]
    total = math.prod(len(one.given) if one.ends is None else one.ends for one in asked)
    if total > MOST_ROWS:
        problems.append(f"vary: {total:,} rows are too many (at most {MOST_ROWS:,}); take fewer values of a key")
    return [one for one in asked if counts[one.key] == 1], problems


def _from_text(text: str) -> Asked:
    key, equals, values = text.partition("=")
    if not equals or not values.strip():
        raise MechanismError(f"{shown(text)} names no values; write {EXAMPLE}")
    return _from_pair(key.strip(), values)


def _from_pair(key: Any, values: Any) -> Asked:
    if not isinstance(key, str) or not all(part.strip() for part in key.split(".")):
        raise MechanismError(f"{shown(key)} is no key of a scene; a key is a table and a name, as in dimensions.arm")
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if isinstance(values, str):
        if ":" in values:
            return _range(key, values)
        values = [_value(item.strip()) for item in values.split(",")]
    if not isinstance(values, list | tuple | range) or not len(values):
        raise MechanismError(f"{key} needs a list of values; found {shown(values)}; write {EXAMPLE}")
    given = [value.item() if isinstance(value, np.generic) else value for value in values]
    wrong = [value for value in given if not isinstance(value, str | int | float) or value == ""]
    if wrong:
        raise MechanismError(f"{key} takes numbers and text, one value each; found {shown(wrong[0])} in its list")
    return Asked(key=key, given=tuple(given))


def _range(key: str, text: str) -> Asked:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) != 3 or not all(parts):
        raise MechanismError(f"{key}={text} is no range; write first:last:count, as in {EXAMPLE.partition(',')[0]}")
    if not parts[2].isdecimal() or int(parts[2]) < 1:
        raise MechanismError(f"{key}={text}: the count must be a whole number of at least 1; found {shown(parts[2])}")
    count = int(parts[2])
    if count > MOST_ROWS:
        raise MechanismError(f"{key}={text}: {count:,} values are too many (at most {MOST_ROWS:,} rows)")
    if count == 1 and parts[0] != parts[1]:
        raise MechanismError(f"{key}={text}: one value cannot be both ends; write {key}={parts[0]}")
    return Asked(key=key, given=(_value(parts[0]), _value(parts[1])), ends=count)


def _value(text: str) -> Any:
    """A number, true or false as such; all else stays text."""
    if text in ("true", "false"):
        return text == "true"
    try:
        number = float(text)
    except ValueError:
        return text
    return number if math.isfinite(number) else text
