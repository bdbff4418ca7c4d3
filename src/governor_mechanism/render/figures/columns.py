"""The figure of a result without one of its own: its columns of numbers, as curves, or as bars beside its rows."""

import re
import textwrap
from collections.abc import Mapping
from numbers import Real
from typing import Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Column, Result
from governor_mechanism.render.figures.page import Page, Panel, format_plain_ticks
from governor_mechanism.render.shown_readings import READING_NOISE_RATIO, axis_limits_for, format_label
from governor_mechanism.render.style import BLUE, INK, RULE
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import display_unit

MAX_CURVES = 12
CURVES_IN_ROW = 3
CURVE_HEIGHT = 2.3
"""Largest number of curves, that of curves side by side, and height of one, inches; the first columns are drawn."""

MAX_BARS = 4
MAX_ROWS = 60
ROW_HEIGHT = 0.22
"""Largest numbers of columns and rows with bars, and height of a row, inches."""

MAX_MARKED: Final = 12
"""Largest number of points of a curve that are marked one by one."""

PAGE_WIDTH: Final = 10.0
"""Width of the page, inches."""

HEAD_HEIGHT, FOOT_HEIGHT = 0.6, 0.7
"""Heights above and below the panels, inches."""

MAX_LABEL_LENGTH: Final = 52
"""Largest length of the name of a row, letters."""


def columns_figure(result: Result) -> Page:
    """Draw the columns of a result; raise MechanismError if none has a number, or the rows have different units."""
    columns = {column.key: column for column in result.columns if column.key and (column.key in result.drawn or not result.drawn)}
    values = {key: _numbers(result.values_of(column)) for key, column in columns.items()}
    drawn = {key: numbers for key, numbers in values.items() if numbers is not None}
    over = drawn.pop(result.index, None)
    units = result.values_of(columns["unit"]) if "unit" in columns else None
    if not drawn or (isinstance(units, list) and len(set(units)) > 1):
        raise MechanismError(f"{type(result).__name__} has no column of numbers to draw; as_json() and to_dataframe() return its values")
    title = getattr(result, "title", "") or re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(result).__name__).capitalize()
    is_of_rows = getattr(result, "rows", None) is not None
    return _draw_bars(result, title, columns, drawn) if is_of_rows else _draw_curves(result, title, columns, drawn, over)


def _numbers(values: object) -> FloatArray | None:
    """Return the values of a column as numbers, NaN where there is none; None if they are no numbers, or none is finite."""
    array = np.asarray(values)
    if array.dtype.kind == "O" and all(one is None or (isinstance(one, Real) and not isinstance(one, bool)) for one in array.flat):
        array = array.astype(float)
    if array.dtype.kind not in "iuf" or array.ndim != 1 or not np.isfinite(array).any():
        return None
    return array.astype(float)


def _label(column: Column) -> tuple[str, float]:
    """Return the label of the axis of a column, and the factor from SI to its unit."""
    factor, unit = display_unit(column.unit)
    return format_label(column.key, unit), factor


def _draw_curves(
    result: Result, title: str, columns: Mapping[str, Column], drawn: Mapping[str, FloatArray], over: FloatArray | None
) -> Page:
    """Draw each column over the one that labels them, or over their number."""
    shown = dict(list(drawn.items())[:MAX_CURVES])
    n_lines = -(-len(shown) // CURVES_IN_ROW)
    page = Page(PAGE_WIDTH, HEAD_HEIGHT + n_lines * CURVE_HEIGHT + 0.2)
    _write_title(page, title)
    x_label, x_factor = ("number", 1.0) if over is None else _label(columns[result.index])
    n_across = min(CURVES_IN_ROW, len(shown))
    for number, (key, values) in enumerate(shown.items()):
        line, place = divmod(number, n_across)
        bottom = page.get_figheight() - HEAD_HEIGHT - (line + 1) * CURVE_HEIGHT + 0.55
        rect = (place / n_across + 0.085, bottom / page.get_figheight(), 1 / n_across - 0.1, (CURVE_HEIGHT - 0.7) / page.get_figheight())
        y_label, factor = _label(columns[key])
        panel = page.add_panel(rect, x_label if line == n_lines - 1 or number + n_across >= len(shown) else "", "", label_size=9.0)
        panel.write_heading(y_label, y=1.05, size=9.0)
        places = np.arange(len(values)) if over is None else over * x_factor
        shown_values = values * factor
        panel.plot(places, shown_values, color=BLUE, linewidth=1.3, marker="o" if len(values) <= MAX_MARKED else "", markersize=4)
        finite = shown_values[np.isfinite(shown_values)]
        panel.set_ylim(axis_limits_for(finite, READING_NOISE_RATIO * float(np.abs(finite).max())))
        format_plain_ticks(panel.yaxis, panel.get_ylim())
    _write_rest(page, len(drawn) - len(shown), "column")
    return page


def _draw_bars(result: Result, title: str, columns: Mapping[str, Column], drawn: Mapping[str, FloatArray]) -> Page:
    """Draw each column as bars beside the names of the rows."""
    shown = dict(list(drawn.items())[:MAX_BARS])
    names = _name_rows(result)
    page = Page(PAGE_WIDTH, HEAD_HEIGHT + ROW_HEIGHT * len(names) + FOOT_HEIGHT)
    _write_title(page, title)
    left = 0.03 + 0.0068 * max(map(len, names))
    width = (0.98 - left) / len(shown)
    for number, (key, values) in enumerate(shown.items()):
        rect = (left + number * width, FOOT_HEIGHT / page.get_figheight(), 0.93 * width, ROW_HEIGHT * len(names) / page.get_figheight())
        label, factor = _label(columns[key])
        panel = page.add_panel(rect, label, grid="x")
        _draw_column(panel, values[: len(names)] * factor)
        panel.set_yticks(range(len(names)), names if number == 0 else [""] * len(names))
        panel.tick_params(axis="y", length=0, labelcolor=INK)
    _write_rest(page, len(drawn) - len(shown), "column", len(next(iter(drawn.values()))) - len(names))
    return page


def _draw_column(panel: Panel, values: FloatArray) -> None:
    """Draw values as bars from zero, the first at the top; a bar without end stands for what is infinite."""
    finite = np.where(np.isfinite(values), values, 0.0)
    panel.barh(np.arange(len(values)), finite, height=0.6, color=BLUE)
    panel.axvline(0.0, color=RULE, linewidth=0.8)
    panel.set_ylim(len(values) - 0.5, -0.5)
    format_plain_ticks(panel.xaxis, panel.get_xlim())


def _name_rows(result: Result) -> list[str]:
    """Return the names of the rows: their texts before the first number, or their numbers."""
    names: list[list[str]] = []
    for column in result.columns:
        values = result.values_of(column) if column.key else []
        if not isinstance(values, list) or not values or not all(isinstance(one, str) for one in values):
            if names or column.key:
                break
            continue
        names.append(values)
    rows = [" ".join(parts) for parts in zip(*names, strict=True)] if names else [f"{k + 1}" for k in range(len(result.rows))]  # type: ignore[attr-defined]
    return [textwrap.shorten(row, MAX_LABEL_LENGTH, placeholder=" …") for row in rows[:MAX_ROWS]]


def _write_title(page: Page, title: str) -> None:
    page.write_title(title, y=1 - 0.3 / page.get_figheight(), size=13.0)


def _write_rest(page: Page, n_columns: int, noun: str, n_rows: int = 0) -> None:
    """State what is not drawn."""
    rest = [f"{count} {name}{'s' * (count > 1)}" for count, name in ((n_columns, noun), (n_rows, "row")) if count > 0]
    if rest:
        page.write_footnote(f"not drawn: {' and '.join(rest)}")
