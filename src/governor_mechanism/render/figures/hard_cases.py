"""Figure of a hard case: true error and estimate of every engine against the hard parameter."""

import math
import textwrap
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from governor_mechanism.render.figures.page import Page, Panel, add_legend, use_plain_decades
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, RULE, VERMILLION
from governor_mechanism.studies.hard_cases.case import HardCase
from governor_mechanism.studies.hard_cases.results import HardCaseRow, HardCasesReport, Verdict
from governor_mechanism.studies.hard_cases.study import ROUNDING_ERROR

_ENGINE_STYLES = {"reduced": (GREEN, "o"), "multibody": (BLUE, "s"), "impulse": (VERMILLION, "^"), "every": (INK, "D")}
"""Colour and marker of each engine."""

_ESTIMATE_STYLE: Mapping[str, Any] = {"markerfacecolor": "none", "linewidth": 0.9, "linestyle": (0, (4, 2))}
"""How estimates differ from errors: hollow and dashed."""
_OUTCOME_SIZE, _OUTCOME_LINE_LENGTH, _ROW_PITCH = 7.5, 125, 0.068
"""Font size (points) of the outcomes above the panel, number of letters in a line of its width, and height of an engine's row in it."""

_MIN_SHOWN_ERROR, _MAX_SHOWN_ERROR = 1e-17, 10.0
"""Limits of the axis of errors."""

_UNITS = ("m", "m/s", "N m", "rad/s", "rad/s2", "s")
"""Units of the parameters."""

_MIN_VALUE_RATIO = 2.0
"""Smallest ratio of neighbouring values of the parameter with which its axis is logarithmic."""


def hard_case_figures(report: HardCasesReport) -> Mapping[str, Page]:
    """Draw every case, by the end of the name of its file."""
    return {f"_{case.name}": hard_case_figure(report, case) for case in report.cases}


def hard_case_figure(report: HardCasesReport, case: HardCase) -> Page:
    """Draw true errors and error estimates of a hard case.

    Result: the figure; `save` writes it.
    """
    rows = report.rows_of(case)
    engines = [name for name in _ENGINE_STYLES if any(row.engine == name for row in rows)]
    page = Page(8.4, 5.2 + 0.22 * len(engines))
    page.write_title(case.title)
    page.write_title("Above: outcomes of runs that do not reach their end", y=0.893, size=9.5, colour=MUTED)
    values = sorted({row.value for row in rows}, key=lambda value: (math.isnan(value), value))
    panel = page.add_panel(
        (0.115, 0.155, 0.855, 0.555), _parameter_label(case.parameter), "Error of a reading [its scale]", tick_colour=INK, which="both"
    )
    places = _choose_places(panel, values)
    panel.set(yscale="log", ylim=(_MIN_SHOWN_ERROR, _MAX_SHOWN_ERROR))
    panel.yaxis.set_major_locator(LogLocator(numticks=12))
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.axhspan(_MIN_SHOWN_ERROR, ROUNDING_ERROR, color=RULE, alpha=0.45, linewidth=0)
    panel.write_note("rounding", (1.0, ROUNDING_ERROR), (-4, -11), xycoords=("axes fraction", "data"), color=MUTED, fontsize=8, ha="right")
    for line, engine in enumerate(engines):
        _draw_engine(panel, places, [row for row in rows if row.engine == engine], line)
    handles, _ = panel.get_legend_handles_labels()
    kinds = (("true error", {"markerfacecolor": INK, "linewidth": 1.3}), ("its estimate", _ESTIMATE_STYLE))
    handles += [Line2D([], [], color=INK, marker="o", markersize=5, label=name, **style) for name, style in kinds]
    place = {"loc": "lower left", "bbox_to_anchor": (0.085, 0.0)}
    add_legend(page, {"fontsize": 9, "color": INK}, handles=handles, ncols=len(handles), **place)
    return page


def _parameter_label(parameter: str) -> str:
    """Return the label of the axis of a parameter, "name, unit; remark", as Name [unit]; a number has the unit 1."""
    quantity, _, remark = parameter.partition("; ")
    name, _, unit = quantity.rpartition(", ")
    label = f"{name} [{unit.replace('s2', 's²')}]" if unit in _UNITS else f"{quantity} [1]"
    return label[:1].upper() + label[1:] + (f"; {remark}" if remark else "")


def _choose_places(panel: Panel, values: list[float]) -> dict[float, float]:
    """Return the place of each value on the axis: the value itself on a wide range, else its number, with the value as a label."""
    is_positive = all(value > 0 and math.isfinite(value) for value in values)
    if is_positive and len(values) > 1 and all(high / low >= _MIN_VALUE_RATIO for low, high in pairwise(values)):
        margin = max(2.0, (values[-1] / values[0]) ** 0.09)  # for the outcomes, which are centred at their values
        panel.set(xscale="log", xlim=(values[0] / margin, values[-1] * margin))
        use_plain_decades(panel.xaxis)
        return {value: value for value in values}
    panel.set(xlim=(-0.5, len(values) - 0.5))
    panel.set_xticks(range(len(values)), [f"{value:.10g}" for value in values])
    return {value: float(place) for place, value in enumerate(values)}


def _draw_engine(panel: Panel, places: dict[float, float], rows: list[HardCaseRow], line: int) -> None:
    """Draw the rows of one engine; `line` is the line above the panel in which its outcomes are written."""
    colour, marker = _ENGINE_STYLES[rows[0].engine]
    x = np.array([places.get(row.value, places[next(iter(places))]) for row in rows])
    errors = np.array([_shown(row.error) for row in rows])
    estimates = np.array([_shown(row.estimate) if row.error is not None else math.nan for row in rows])
    panel.plot(x, errors, color=colour, marker=marker, markersize=5, linewidth=1.3, zorder=3, label=rows[0].engine)
    panel.plot(x, estimates, color=colour, marker=marker, markersize=5, zorder=2, **_ESTIMATE_STYLE)
    height = 1.05 + _ROW_PITCH * line
    line_length = int(_OUTCOME_LINE_LENGTH * _smallest_distance(panel, list(places.values())))
    named = [row for row in rows if row.verdict is not Verdict.WITHIN_ESTIMATE]
    if named:
        panel.write_note(rows[0].engine, (-0.012, height), xycoords="axes fraction", color=colour, fontsize=_OUTCOME_SIZE, ha="right")
    for row, place in zip(rows, x, strict=True):
        if row.verdict is Verdict.WITHIN_ESTIMATE:
            continue
        words = row.outcome.lower().replace("_", " ") if row.verdict is Verdict.NAMED_END else row.verdict.value
        weight = "normal" if row.verdict.passed else "bold"
        text = textwrap.fill(words, max(line_length, 9))
        position = (place, height)
        note = panel.write_note(text, position, xycoords=("data", "axes fraction"), color=colour, fontsize=_OUTCOME_SIZE, ha="center")
        note.set(fontweight=weight, linespacing=0.95)


def _smallest_distance(panel: Panel, places: list[float]) -> float:
    """Return the smallest distance of neighbouring places on the axis, relative to its length."""
    fractions = sorted(panel.transLimits.transform(panel.transScale.transform([(place, 1.0) for place in places]))[:, 0].tolist())
    return min((high - low for low, high in pairwise(fractions)), default=1.0)


def _shown(error: float | None) -> float:
    """Return an error within the limits of the axis."""
    return math.nan if error is None else min(max(error, _MIN_SHOWN_ERROR * 2), _MAX_SHOWN_ERROR / 2)
