"""The value that a scene itself has at a key that a sweep varies."""

from collections.abc import Mapping
from typing import Any

from governor_mechanism.errors import MechanismError


def find_scene_value(
    document: Mapping[str, Any],
    key: str,  # dotted key; an item of a list is meant by its name or its number, counted from 1
    kind: str | None,  # kind of quantity; None if only words are allowed
) -> float | str | bool | None:
    """Return the value at a dotted key of a document.

    Result: a number in SI or a word; None if the document leaves the key out, or has something else there.
    """
    from governor_mechanism.scenes.quantities import parse_si

    value: Any = document
    for name in key.split("."):
        value = _find_item(value, name)
    if not isinstance(value, str | bool | int | float):
        return None
    if kind is None or isinstance(value, bool):
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
    try:
        return parse_si(value, kind, key)
    except MechanismError:  # a word that stands for a value, as "equilibrium"
        return value if isinstance(value, str) else None


def _find_item(table: Any, name: str) -> Any:
    """Return the value of a name in a table, or the item of a name or number in a list; None if there is none."""
    if isinstance(table, Mapping):
        return table.get(name)
    if not isinstance(table, list | tuple):
        return None
    if name.isdecimal() and 1 <= int(name) <= len(table):
        return table[int(name) - 1]
    return next((item for item in table if isinstance(item, Mapping) and item.get("name") == name), None)
