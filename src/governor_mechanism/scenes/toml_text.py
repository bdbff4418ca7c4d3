"""A scene document as the text of a scene file."""

import json
from collections.abc import Mapping
from typing import Any


def format_scene_toml(document: Mapping[str, Any], comment: str) -> str:
    """Return the document of a scene as the text of a TOML file that begins with a comment.

    Parameters
    ----------
    document
        The document of a scene.
    comment
        The first line, or lines.

    Returns
    -------
    str
        The text.
    """
    scalars = {key: value for key, value in document.items() if not isinstance(value, Mapping)}
    lines = [*(f"# {line}" for line in comment.splitlines()), *(f"{key} = {_format_toml(value)}" for key, value in scalars.items())]
    for name, table in document.items():
        if isinstance(table, Mapping):
            lines += _format_tables(name, table) if name in _TABLES_OF_TABLES else _format_table(name, table)
    return "\n".join(lines) + "\n"


_TABLES_OF_TABLES = ("part", "coupling")
"""Tables of parts and couplings by name; each of them has a heading of its own, and so have the tables of a part."""


def _format_tables(name: str, tables: Mapping[str, Any]) -> list[str]:
    """Return the lines of named tables, and of the tables in them."""
    lines = []
    for key, table in tables.items():
        inner = {inner_key: value for inner_key, value in table.items() if isinstance(value, Mapping)}
        lines += _format_table(f"{name}.{key}", {one: value for one, value in table.items() if one not in inner})
        for inner_key, value in inner.items():
            lines += _format_table(f"{name}.{key}.{inner_key}", value)
    return lines


def _format_table(name: str, table: Mapping[str, Any]) -> list[str]:
    """Return the lines of a table with its heading; tables in it are written inline."""
    return ["", f"[{name}]", *(f"{key} = {_format_toml(value)}" for key, value in table.items())]


def _format_toml(value: Any) -> str:
    """Return a value as TOML, which writes all but tables as JSON does."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_format_toml(item)}" for key, item in value.items()) + " }"
    return json.dumps(value, ensure_ascii=False)
