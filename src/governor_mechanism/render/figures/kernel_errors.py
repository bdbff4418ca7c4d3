"""Error curve of a user's kernel: both results over an input, and their difference beside the error of the simulation."""

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from governor_mechanism.render.figures.page import DASHED, DOTTED, Page, PanelRect, add_legend
from governor_mechanism.render.number_format import format_label
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, VERMILLION
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import DISPLAY_UNITS
from governor_mechanism.verification.user_kernel.report import KernelReport, format_percent

_MAX_TITLE_LETTERS = 84
"""Number of letters of a title that fit on the page."""

_MAX_FOOTNOTE_LETTERS = 135
"""Number of letters of a line of the footnote."""

_MAX_SHOWN_EXCESS = 1.0
"""How far results of the kernel beyond those of the simulation are shown, in ranges of the simulation or of a tenth of its size."""

_MAX_INPUTS = 3
"""Largest number of inputs over which the errors of random samples are drawn."""

_MIN_SHOWN_ERROR = 1e-17
"""Smallest estimated error on the logarithmic axis."""


def kernel_errors_figure(report: KernelReport) -> Page:
    """Draw the results and the relative errors of a kernel over what varies, with the tolerance and the error of the simulation.

    Result: the figure; `save` writes it.
    """
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
    factor, shown = DISPLAY_UNITS.get(unit, (1.0, unit))
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
    shown_own = np.maximum(own, _MIN_SHOWN_ERROR)[order]
    panel.plot(values[order], shown_own, color=GREEN, linewidth=1.2, linestyle=DOTTED if line == "-" else "none",
               marker="" if line == "-" else ".", markersize=3.0, label="estimated error of the simulation")  # fmt: skip
    panel.axhline(report.tolerance, color=INK, linewidth=1.0, linestyle=DASHED, label="tolerance")
    finite = np.concatenate([magnitudes[np.isfinite(magnitudes)], shown_own[np.isfinite(shown_own)], [report.tolerance]])
    low, high = math.floor(math.log10(finite.min()) - 0.3), math.ceil(math.log10(finite.max()) + 0.3)
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
