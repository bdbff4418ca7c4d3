"""Results as a notebook shows them: a row for each quantity, or the text that they print."""

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from governor_mechanism.notebook.html import draw_small_curve, format_html_table, format_paragraph, format_printed
from governor_mechanism.units.short_repr import summarise

MAX_NAMED_ITEMS = 20
"""Largest number of bodies, joints or the like that are listed by name."""

CONSTANT_RATIO = 1e-9
"""Change relative to the largest value below which an array is drawn as constant: rounding."""


def result_html(result: Any) -> str:
    """Return a result as HTML: the text that it prints, with its columns aligned, or else its fields.

    Result: of the fields, a table of names, small curves of arrays over one axis, and values or their range.
    """
    if "__str__" in {name for owner in type(result).__mro__[:-1] for name in vars(owner)}:
        return format_printed(str(result))
    title = f"{type(result).__name__} (SI units)"
    rows = [row for field in dataclasses.fields(result) if field.repr for row in _field_rows(field.name, getattr(result, field.name))]
    return format_paragraph(title, is_bold=True) + format_html_table((), rows, n_text_columns=3)


def _field_rows(name: str, value: Any) -> Iterator[tuple[str, str, str]]:
    """Yield the cells of a field: one row for each entry of a mapping, else one."""
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _field_rows(f"{name}: {key}", entry)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            if field.repr:
                yield from _field_rows(f"{name}: {field.name}", getattr(value, field.name))
    elif not (value is None or (isinstance(value, str | tuple) and not value)):
        yield name.replace("_", " "), _curve_of(value), _text_of(value)


def _curve_of(value: Any) -> str:
    """Return a small curve of an array over one axis, or an empty cell."""
    is_curve = isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind == "f"
    return draw_small_curve(value, CONSTANT_RATIO * float(np.max(np.abs(value), initial=0.0))) if is_curve else ""


def _text_of(value: Any) -> str:
    """Return a value in words, of many values their range, of parts with names these names."""
    if isinstance(value, np.ndarray) and value.size and value.dtype.kind == "b":
        return f"{value.mean():.1%} true"
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size and value.dtype.kind in "fi":
        return " to ".join(dict.fromkeys([f"{value.min():.6g}", f"{value.max():.6g}"]))
    if isinstance(value, tuple) and value and all(hasattr(item, "name") for item in value):
        names = [str(item.name) for item in value[:MAX_NAMED_ITEMS]]
        return ", ".join([*names, *(["..."] if len(value) > MAX_NAMED_ITEMS else [])])
    if isinstance(value, tuple) and any(map(dataclasses.is_dataclass, value)):
        return f"{len(value)}"
    return str(value) if isinstance(value, str) else summarise(value)
