"""True errors: of every engine against the hard parameter of a hard case, and of a user's kernel over an input."""

import math
import textwrap
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from governor_mechanism.render.figures.page import DASHED, DOTTED, Page, Panel, PanelRect, add_legend, use_plain_decades
from governor_mechanism.render.shown_readings import format_label
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, RULE, VERMILLION
from governor_mechanism.studies.hard_cases.case import HardCase
from governor_mechanism.studies.hard_cases.study import ROUNDING_ERROR, HardCaseRow, HardCasesReport, Verdict
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import display_unit
from governor_mechanism.verification.user_kernel_comparison import KernelReport, format_percent

_ENGINE_STYLES = {"reduced": (GREEN, "o"), "multibody": (BLUE, "s"), "impulse": (VERMILLION, "^"), "every": (INK, "D")}
"""Colour and marker of each engine."""

_ESTIMATE_STYLE: Mapping[str, Any] = {"markerfacecolor": "none", "linewidth": 0.9, "linestyle": (0, (4, 2))}
"""How estimates differ from errors: hollow and dashed."""
_OUTCOME_SIZE = 7.5
_OUTCOME_LINE_LENGTH = 125
_ROW_PITCH = 0.068
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
    """Draw true errors and error estimates of a hard case; `save` writes it."""
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


_MAX_TITLE_LETTERS = 84
"""Number of letters of a title that fit on the page."""

_MAX_FOOTNOTE_LETTERS = 135
"""Number of letters of a line of the footnote."""

_MAX_SHOWN_EXCESS = 1.0
"""How far results of the kernel beyond those of the simulation are shown, in ranges of the simulation or of a tenth of its size."""

_MAX_INPUTS = 3
"""Largest number of inputs over which the errors of random samples are drawn."""

_MIN_SHOWN_KERNEL_ERROR = 1e-17
"""Smallest estimated error on the logarithmic axis."""


def kernel_errors_figure(report: KernelReport) -> Page:
    """Draw the results and the relative errors of a kernel over what varies, with the tolerance and the error of the simulation."""
    title = textwrap.shorten(f"kernel {report.against} against the simulation: {report.title}", _MAX_TITLE_LETTERS, placeholder=" …")
    page = Page(8.4, 6.0, title, _subtitle(report), subtitle_y=0.897)
    inputs = _varying_inputs(report)
    if len(inputs) == 1:
        _draw_results(page, report, (0.11, 0.50, 0.85, 0.35), inputs[0])
        _draw_errors(page, report, (0.11, 0.155, 0.85, 0.265), inputs[0])
        page.axes[0].tick_params(labelbottom=False)
    else:
        _draw_agreement(page, report, (0.11, 0.56, 0.85, 0.28))
        width = (0.85 - 0.06 * (len(inputs) - 1)) / max(len(inputs), 1)
        for index, name in enumerate(inputs):
            _draw_errors(page, report, (0.11 + index * (width + 0.06), 0.155, width, 0.285), name, is_first=index == 0)
    worst = textwrap.shorten(report.describe_worst(with_call=False), 2 * _MAX_FOOTNOTE_LETTERS - 10, placeholder=" …")
    page.write_footnote(textwrap.fill(worst, _MAX_FOOTNOTE_LETTERS), y=0.012)
    return page


def _subtitle(report: KernelReport) -> str:
    n_failed = sum(not row.passed for row in report.rows)
    verdict = f"{n_failed} of {len(report.rows)} points disagree" if n_failed else f"all {len(report.rows)} points agree"
    worst = "at the worst it gave no number" if report.worst.problem else f"worst {format_percent(report.worst.relative_error)}"
    return f"{report.quantity.replace('_', ' ')}: {verdict}; {worst}"


def _varying_inputs(report: KernelReport) -> list[str]:
    """Return the names of the inputs that vary, or the first input."""
    names = list(report.rows[0].inputs)
    varying = [name for name in names if len({row.inputs[name][0] for row in report.rows}) > 1]
    return varying[:_MAX_INPUTS] or names[:1]


def _input_column(report: KernelReport, name: str) -> tuple[FloatArray, str]:
    """Return the values (n,) of an input in a customary unit, and its label."""
    unit = report.rows[0].inputs[name][1]
    factor, shown = display_unit(unit)
    values = np.array([row.inputs[name][0] for row in report.rows])
    return factor * values, format_label(name, shown)


def _columns(report: KernelReport) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return simulated results, results of the kernel, relative errors and relative errors of the simulation; (n,) each."""
    rows = report.rows
    simulated, expected = (np.array([getattr(row, name) for row in rows]) for name in ("simulated", "expected"))
    own = np.array([row.error_estimate / row.scale if row.scale else math.nan for row in rows])
    return simulated, expected, np.array([row.relative_error for row in rows]), own


def _result_label(report: KernelReport) -> str:
    return format_label(report.quantity, report.unit)


def _draw_results(page: Page, report: KernelReport, place: PanelRect, name: str) -> None:
    """Draw both results over an input."""
    values, _ = _input_column(report, name)
    simulated, expected, _, _ = _columns(report)
    panel = page.add_panel(place, "", _result_label(report))
    order = np.argsort(values, kind="stable")
    marker = "o" if len(values) <= 60 else ""
    panel.plot(values[order], simulated[order], color=BLUE, linewidth=2.2, alpha=0.75, label="simulation")
    line = "none" if marker else DASHED
    panel.plot(values[order], expected[order], color=VERMILLION, linestyle=line, marker=marker, markersize=4.0, label=report.against)
    limits = _shown_limits(simulated, expected)
    panel.set_ylim(limits)
    add_legend(panel, fontsize=8.5, loc="best")
    n_outside = int(np.sum((expected < limits[0]) | (expected > limits[1])))
    if n_outside:
        text = f"{n_outside} of {len(expected)} results of {report.against} lie outside"
        panel.write_note(text, (0.99, 0.03), xycoords="axes fraction", ha="right", color=VERMILLION)


def _shown_limits(simulated: FloatArray, expected: FloatArray) -> tuple[float, float]:
    """Return limits of an axis for all simulated results and those of the kernel that are not far off."""
    low, high = float(simulated.min()), float(simulated.max())
    excess = _MAX_SHOWN_EXCESS * max(high - low, 0.1 * max(abs(low), abs(high)), np.finfo(float).tiny)
    shown = expected[(expected >= low - excess) & (expected <= high + excess)]
    low, high = min([low, *shown.tolist()]), max([high, *shown.tolist()])
    margin = 0.06 * (high - low) or excess
    return low - margin, high + margin


def _draw_agreement(page: Page, report: KernelReport, place: PanelRect) -> None:
    """Draw the results of the kernel against those of the simulation, with the line on which they agree."""
    simulated, expected, _, _ = _columns(report)
    panel = page.add_panel(place, format_label(f"simulated {report.quantity}", report.unit), format_label(report.against, report.unit))
    limits = _shown_limits(simulated, expected)
    panel.set(xlim=_shown_limits(simulated, simulated), ylim=limits)
    panel.plot(limits, limits, color=BLUE, linewidth=1.4, label="agreement")
    panel.plot(simulated, expected, color=VERMILLION, linestyle="none", marker="o", markersize=4.0, label=report.against)
    add_legend(panel, fontsize=8.5, loc="upper left")


def _draw_errors(page: Page, report: KernelReport, place: PanelRect, name: str, *, is_first: bool = True) -> None:
    """Draw the magnitudes of the relative errors over an input; points without a number at the top."""
    values, label = _input_column(report, name)
    _, _, errors, own = _columns(report)
    panel = page.add_panel(place, label, "Relative difference [1]" if is_first else "")
    panel.set_yscale("log")
    magnitudes = np.where(errors == 0.0, np.nan, np.abs(errors))  # an exact agreement has no logarithm
    order = np.argsort(values, kind="stable")
    line = "-" if len(_varying_inputs(report)) == 1 else "none"
    shown: dict[str, Any] = {
        "linestyle": line,
        "marker": "o" if len(values) <= 60 or line == "none" else "",
        "markersize": 4.0,
        "linewidth": 1.3,
    }
    panel.plot(values[order], magnitudes[order], color=VERMILLION, label=f"{report.against}", **shown)
    shown_own = np.maximum(own, _MIN_SHOWN_KERNEL_ERROR)[order]
    panel.plot(values[order], shown_own, color=GREEN, linewidth=1.2, linestyle=DOTTED if line == "-" else "none",
               marker="" if line == "-" else ".", markersize=3.0, label="estimated error of the simulation")  # fmt: skip
    panel.axhline(report.tolerance, color=INK, linewidth=1.0, linestyle=DASHED, label="tolerance")
    finite = np.concatenate([magnitudes[np.isfinite(magnitudes)], shown_own[np.isfinite(shown_own)], [report.tolerance]])
    low = math.floor(math.log10(finite.min()) - 0.3)
    high = math.ceil(math.log10(finite.max()) + 0.3)
    panel.set_ylim(10.0**low, 10.0**high)
    missing = np.array([bool(row.problem) for row in report.rows])
    if missing.any():
        top = np.full(int(missing.sum()), 10.0 ** (low + 0.93 * (high - low)))
        panel.plot(values[missing], top, color=VERMILLION, linestyle="none", marker="x", markersize=6.0, label="no number")
    panel.yaxis.set_major_locator(LogLocator(numticks=6))
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.tick_params(axis="y", labelcolor=MUTED)
    if is_first:
        add_legend(panel, fontsize=8.0, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.1, columnspacing=1.4)
