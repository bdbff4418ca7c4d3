"""What a key of a scene file accepts, and its default, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

from generators.markdown import code, escape
from governor_mechanism.scenes.custom.field_types import MOTION, POINT
from governor_mechanism.scenes.quantities import NUMBER_OR_TEXT, Table, quantity_schema
from governor_mechanism.units.fields import Declaration
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

_SIGNS = {"exclusiveMinimum": "positive", "minimum": "not negative"}


@cache
def _kinds_by_hint() -> dict[str, str]:
    """Return the kind of quantity by the hint in its schema."""
    return {quantity_schema(kind)["description"]: kind for kind in reversed(list(QUANTITY_KINDS))}


def name_kind(kind: str) -> str:
    """Return the name of a kind of quantity with the unit of a bare number, as "length (m)"."""
    one = QUANTITY_KINDS[kind]
    name = one.name.partition(" ")[2] or one.name
    return f"{name} ({one.si_unit})" if one.units else "number"


def describe_schema(schema: Mapping[str, Any]) -> str:
    """Return what a JSON schema of the parser accepts, as Markdown of one line.

    Parameters
    ----------
    schema
        Schema of a key, as its validator declares it.

    Returns
    -------
    str
        Words such as "length (m), positive, or a list of [time, value]".
    """
    if "anyOf" in schema:
        return " or ".join(dict.fromkeys(describe_schema(one) for one in schema["anyOf"]))
    if "enum" in schema:
        return ", ".join(code(f'"{word}"') for word in schema["enum"])
    if "const" in schema:
        value = schema["const"]
        return code(str(value).lower() if isinstance(value, bool) else f'"{value}"')
    for known, words in ((POINT, "point"), (MOTION, "function of time"), (NUMBER_OR_TEXT, "number, or text with a unit")):
        if schema == known:
            return words
    kind = _kinds_by_hint().get(schema.get("description", ""))
    if kind and schema.get("type") == ["number", "string"]:
        return ", ".join([name_kind(kind), *(words for key, words in _SIGNS.items() if schema.get(key) == 0)])
    return _describe_type(schema)


def _describe_type(schema: Mapping[str, Any]) -> str:
    """Return what a schema without a kind of quantity accepts."""
    kind = schema.get("type")
    if kind == "array" and schema.get("minItems") == schema.get("maxItems") == 2:
        items = schema.get("items", {})
        return "two numbers" if isinstance(items, list) else f"list of two: {describe_schema(items)}"
    if kind == "array":
        is_program = isinstance(schema.get("items"), Mapping) and schema["items"].get("minItems") == 2
        return "list of [time, value]" if is_program else "sum of these" if "items" not in schema else "list of tables"
    if kind == "object":
        return "function of a reading" if schema.get("required") == ["reading"] else "table"
    return {"boolean": f"{code('true')} or {code('false')}", "string": "text"}.get(str(kind), "see there")


def describe_table(own: Table, *, leave_out: tuple[str, ...] = ()) -> list[list[str]]:
    """Return the rows of a table of keys: key, values, default, meaning.

    Parameters
    ----------
    own
        Table of a scene file.
    leave_out
        Keys without a row.

    Returns
    -------
    list of list of str
        Cells as Markdown.
    """
    rows = []
    for key, declared in own.fields_by_key.items():
        if key in leave_out:
            continue
        schema = own.types[declared.form].schema_of(declared)
        values = "table" if declared.content else describe_schema(schema) if schema else _plain(key)
        meaning = "" if declared.meaning.startswith("one of ") else declared.meaning  # the values are listed already
        default = "required" if declared.is_required else "" if "default" in meaning else _default_of(declared, schema)
        rows.append([code(key), values, default, escape(meaning)])
    return rows


def _plain(key: str) -> str:
    """Return what a key accepts whose validator declares no schema."""
    lists = {"body", "joint", "link", "force"}
    words = {"title": "text", "type": "text", "table": "list of [reading, value]", "gain": "quantity per unit of the reading"}
    words |= {"about": "quantity", "harmonics": "list of { amplitude, order, phase }", "lag": "time (s)", "machine": "text"}
    return words.get(key, "tables" if key in lists else "table")


def _default_of(declared: Declaration, schema: Mapping[str, Any]) -> str:
    """Return the default of a key; empty where it follows from other keys."""
    return "" if declared.follows else format_default(declared.default, schema)


def format_default(default: Any, schema: Mapping[str, Any]) -> str:
    """Return a default with its unit; empty for none, and for a number that stands for "not given"."""
    if isinstance(default, bool):
        return code(str(default).lower())
    if isinstance(default, str):
        return code(f'"{default}"') if default else ""
    kind = _kinds_by_hint().get(schema.get("description", ""))
    is_positive = schema.get("exclusiveMinimum") == 0
    if not isinstance(default, int | float) or math.isinf(default) or (is_positive and not default):
        return ""
    return code(format_quantity(float(default), QUANTITY_KINDS[kind].si_unit) if kind and QUANTITY_KINDS[kind].units else f"{default:g}")
