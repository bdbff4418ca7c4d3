"""The quantities of a scene that a person may change, as the scene file writes them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

WRITTEN_QUANTITY: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*)?")
"""A number, and the unit behind it."""

FIXED_TABLES: Final = ("law", "readings")
"""Tables whose numbers state what a scene is, and not how large it is."""

WORDS: Final = (
    "title",
    "name",
    "machine",
    "type",
    "first",
    "second",
    "engine",
    "assembly",
    "plane",
    "accuracy",
    "output_interval",
    "reactions",
)
"""Keys that hold words, or how exactly a run is computed."""

COORDINATES: Final = {"1": "x", "2": "y"}
"""Names of the values of a position."""

POINT_WORDS: Final = {"1": "time", "2": "value"}
"""Names of both numbers of a point of a function of time, in front of its number."""

TABLE: Final = "table"
TABLE_WORDS: Final = {"1": "reading", "2": "value"}
"""Key of a function of a reading, and the names of both numbers of its points."""

PLACES: Final = ("ground", "at", "points")
"""Keys under which lists are positions."""

LAST_GROUPS: Final = ("run", "events")
"""Groups that come after the mechanism itself."""

RANGE_FACTOR: Final = 2.0
"""Factor between a value and the ends of its slider."""


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number of a scene file with its unit."""

    key: str  # dotted key; items of lists by name, or by number from 1
    group: str  # table that it belongs to
    words: str  # what it is
    value: float  # value in its unit
    unit: str  # unit as written; empty for a number in SI
    # low, high: ends of its slider
    low: float
    high: float

    def write(self, value: float) -> float | str:
        """Return a value as the scene file writes it."""
        return f"{value:.12g} {self.unit}" if self.unit else float(f"{value:.12g}")


def find_quantities(
    document: Mapping[str, Any],
    length_scale: float,  # half of the range of a coordinate that is zero, m
) -> dict[str, Quantity]:
    """Return the quantities of a document by key, in its order, those of the run last."""
    found = [_read(key, value, length_scale) for key, value in _leaves(document)]
    quantities = sorted((one for one in found if one is not None), key=lambda one: one.group in LAST_GROUPS)
    return {one.key: one for one in quantities}


def split_quantity(value: object) -> tuple[float, str] | None:
    """Return number and unit of a written quantity; None if it is none."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), ""
    match = WRITTEN_QUANTITY.fullmatch(value) if isinstance(value, str) else None
    return (float(match[1]), match[2].strip()) if match and match[2] else None


def _leaves(table: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield path and value of everything in a document that is no table and no list."""
    if isinstance(table, Mapping):
        items: Sequence[tuple[str, Any]] = [(key, value) for key, value in table.items() if key not in WORDS]
    elif isinstance(table, list | tuple):
        items = [(name_of_item(item, number), item) for number, item in enumerate(table, start=1)]
    else:
        yield path, table
        return
    for key, value in items:
        if path or key not in FIXED_TABLES:
            yield from _leaves(value, (*path, key))


def name_of_item(item: Any, number: int) -> str:
    """Return how a dotted key names an item of a list."""
    name = item.get("name") if isinstance(item, Mapping) else None
    return name if isinstance(name, str) and "." not in name else str(number)


def _read(path: tuple[str, ...], value: Any, length_scale: float) -> Quantity | None:
    """Return the quantity at a path; None if there is none."""
    written = split_quantity(value)
    if written is None or any("." in key for key in path):
        return None
    number, unit = written
    is_place = path[-1] in COORDINATES and bool(set(PLACES) & set(path[:-1]))
    n_group = 2 if path[0] == "part" else 1
    is_point = len(path) > n_group + 1 and path[-1] in POINT_WORDS and path[-2].isdecimal() and not is_place
    names = [*path[n_group:-1], COORDINATES[path[-1]]] if is_place else [*path[n_group:]]
    if is_point:
        words = TABLE_WORDS if path[-3] == TABLE else POINT_WORDS
        names = [*path[n_group:-2], words[path[-1]], path[-2]]
    half = RANGE_FACTOR * length_scale if is_place and not unit else 1.0
    low, high = (number / RANGE_FACTOR, number * RANGE_FACTOR) if number else (-half, half)
    return Quantity(
        key=".".join(path),
        group=path[n_group - 1],
        words=" ".join(names or path).replace("_", " "),
        value=number,
        unit=unit,
        low=min(low, high),
        high=max(low, high),
    )
