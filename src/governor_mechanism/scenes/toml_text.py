"""A scene document as the text of a scene file."""

import json
import re
from collections.abc import Iterator, Mapping
from numbers import Integral, Real
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import format_value

_TABLES_OF_TABLES: Final = ("part", "coupling")
"""Tables of parts and couplings by name; each of them has a heading of its own, and so have the tables of a part."""

_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that TOML reads without quotation marks."""


def format_scene_toml(document: Mapping[str, Any], comment: str = "") -> str:
    """Return the document of a scene as the text of a TOML file.

    Result: the text. It is read back as an equal document. Raises MechanismError if a value has no form in
    TOML.
    """
    lines = [*(f"# {line}" for line in comment.splitlines()), *_format_tables("", document)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _format_tables(heading: str, table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table: its values, and then what has a heading of its own."""
    has_headings = not heading or heading in _TABLES_OF_TABLES or (heading.partition(".")[0] == "part" and heading.count(".") == 1)
    nested = {key: value for key, value in table.items() if has_headings and (isinstance(value, Mapping) or _is_table_list(value))}
    own_lines = [f"{_format_key(key)} = {format_toml_value(value)}" for key, value in table.items() if key not in nested]
    if heading and (own_lines or not nested):
        yield from ("", f"[{heading}]")
    yield from own_lines
    for key, value in nested.items():
        name = f"{heading}.{_format_key(key)}" if heading else _format_key(key)
        if isinstance(value, Mapping):
            yield from _format_tables(name, value)
            continue
        for item in value:
            yield from ("", f"[[{name}]]", *(f"{_format_key(one)} = {format_toml_value(inner)}" for one, inner in item.items()))


def _is_table_list(value: Any) -> bool:
    """Return whether a value is a list of tables, which is written with double brackets."""
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _format_key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _format_text(key)


def _format_text(text: str) -> str:
    """Return a text in quotation marks; TOML also escapes the character DEL, which JSON leaves as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def format_toml_value(value: Any) -> str:
    """Return a value as TOML in one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_format_key(key)} = {format_toml_value(item)}" for key, item in value.items()) + " }" if value else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(format_toml_value, value))}]"
    if isinstance(value, str):
        return _format_text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    raise MechanismError(f"a scene file cannot hold {format_value(value)}; it holds text, numbers, true, false, lists and tables")
