"""Figures of what was searched: an optimum before and after, a trade-off, dimensions for a path, and a fit with its residuals."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from governor_mechanism.render.figures.page import DASHED, MM_PER_M, Page, Panel, add_legend, format_plain_ticks
from governor_mechanism.render.shown_readings import axis_limits_for, display_unit_of, format_label, format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, VERMILLION
from governor_mechanism.units.quantities import format_quantity

if TYPE_CHECKING:
    from governor_mechanism.studies.fitting.results import Fit
    from governor_mechanism.studies.optimisation.results import OptimisedQuantity, Optimum, TradeOff
    from governor_mechanism.studies.synthesis.dimensions import DimensionSynthesis

_WIDTH = 8.6
_LINE = 0.42
_PANEL = 2.6
_HEADER = 0.95
_FOOTER = 0.6
"""Width of the page, heights of an unknown, of a panel, and of the rooms above and below, inches."""

_LEFT, _RIGHT = 0.30, 0.95
"""Ends of the panel of the unknowns, in fractions of the page."""


def optimum_figure(optimum: Optimum) -> Page:
    """Draw the unknowns between their bounds, before and after, and below quantities with several values, or the course of the search."""
    several = [one for one in optimum.quantities if len(one.after) > 1]
    above, below = max(_LINE * len(optimum.rows), 0.7), _PANEL
    height = _HEADER + above + 0.75 + below + _FOOTER
    objective = optimum.objective
    page = Page(
        _WIDTH, height, optimum.title, f"{objective.name} {objective.role}: {optimum.outcome}", subtitle_y=1 - 0.7 * _HEADER / height
    )
    top = 1 - _HEADER / height
    _draw_values(page.add_panel((_LEFT, top - above / height, _RIGHT - _LEFT, above / height), grid="x"), optimum)
    place = (0.11, _FOOTER / height, 0.86, below / height)
    if several:
        _draw_several(page.add_panel(place), several[0])
    else:
        _draw_course(page.add_panel(place), optimum)
    return page


def _draw_values(panel: Panel, optimum: Optimum) -> None:
    """Draw each unknown between its bounds."""
    for k, row in enumerate(optimum.rows):
        before, after = ((one - row.low) / (row.high - row.low) for one in (row.before, row.value))
        panel.plot([0.0, 1.0], [k, k], color=MUTED, linewidth=0.8)
        panel.plot([before, after], [k, k], color=BLUE, linewidth=2.0)
        panel.plot(before, k, "o", color=INK, markerfacecolor="none", clip_on=False, label="before" if not k else None)
        panel.plot(after, k, "o", color=BLUE, clip_on=False, zorder=5, label="after" if not k else None)
        panel.write_note(format_quantity(row.value, row.unit), (after, k), (0, 6), ha="center", color=INK)
    panel.set(ylim=(len(optimum.rows) - 0.4, -0.75), xlim=(0.0, 1.0), xticks=(0.0, 1.0), xticklabels=("lower bound", "upper bound"))
    panel.set_yticks(range(len(optimum.rows)), ["\n".join(textwrap.wrap(row.key, 34)) for row in optimum.rows])
    add_legend(panel, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)


def _draw_several(panel: Panel, quantity: OptimisedQuantity) -> None:
    """Draw the values of a quantity that has several, before and after."""
    unit, factor = display_unit_of(quantity.unit)
    panel.label("number of the value", format_label(quantity.name, unit))
    numbers = 1 + np.arange(len(quantity.after))
    if quantity.before is not None:
        panel.plot(numbers, np.array(quantity.before) * factor, "o--", color=INK, markerfacecolor="none", linewidth=1.0, label="before")
    panel.plot(numbers, np.array(quantity.after) * factor, "o-", color=BLUE, label="after")
    panel.set_xticks(numbers)
    add_legend(panel)


def _draw_course(panel: Panel, optimum: Optimum) -> None:
    """Draw the best objective so far over the number of scenes tried, and what it was before, on a scale that shows the change."""
    unit, factor = display_unit_of(optimum.objective.unit)
    panel.label("scenes tried", format_label(optimum.objective.name, unit))
    if len(optimum.history):
        counts = np.append(optimum.history[:, 0], optimum.n_evaluations)
        values = np.append(optimum.history[:, 1], optimum.history[-1, 1]) * factor
        panel.step(counts, values, where="post", color=BLUE, label="best so far")
        before = np.array(optimum.objective.before or ()) * factor
        for value in before:
            panel.axhline(value, color=INK, linewidth=1.0, linestyle=DASHED, label="before")
        limits = axis_limits_for(np.concatenate([values, before]))
        panel.set_ylim(limits)
        format_plain_ticks(panel.yaxis, limits)
        panel.set_xlim(0, optimum.n_evaluations)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
        add_legend(panel)


def trade_off_figure(result: TradeOff) -> Page:
    """Draw the first objective over the second, with the scene itself."""
    page = Page(6.4, 4.8, result.title, f"what the best {result.names[0]} costs in {result.names[1]}", subtitle_y=0.895)
    (first_unit, first_factor), (second_unit, second_factor) = map(display_unit_of, result.units)
    panel = page.add_panel((0.13, 0.13, 0.83, 0.7), format_label(result.names[1], second_unit), format_label(result.names[0], first_unit))
    first, second = (np.array([getattr(row, name) for row in result.rows]) for name in ("first", "second"))
    panel.plot(second * second_factor, first * first_factor, "o-", color=BLUE, label="best")
    panel.plot(result.start[1] * second_factor, result.start[0] * first_factor, "D", color=VERMILLION, label="the scene itself")
    add_legend(panel)
    return page


def dimension_figure(result: DimensionSynthesis) -> Page:
    """Draw the given points with the path of the best dimensions and that of the scene itself, to one scale."""
    best = result.rows[0]
    subtitle = f"path of {result.point}: root mean square distance {format_quantity(best.distance, 'm', '.4g')}"
    page = Page(6.8, 6.0, result.title, subtitle, subtitle_y=0.905)
    panel = page.add_panel((0.12, 0.1, 0.84, 0.75), "x [mm]", "y [mm]")
    curves = {"before": (result.before, "--", MUTED), "after": (best.curve, "-", BLUE)}
    for label, (curve, style, colour) in curves.items():
        panel.plot(*(MM_PER_M * curve).T, style, color=colour, linewidth=1.2, label=label)
    panel.plot(*(MM_PER_M * result.path).T, "o", color=VERMILLION, markersize=4, label="given points")
    shown = MM_PER_M * np.vstack([result.path, best.curve, result.before])
    panel.show_points(shown, margin=0.1, min_half_width=1e-6)
    add_legend(panel)
    return page


_FIT_WIDTH = 8.0
_READING_HEIGHT = 3.6
_FIT_HEADER = 0.9
_FIT_FOOTER = 0.6
"""Width of the page of a fit, height for each reading, and heights above and below, inches."""


def _describe_fit(fit: Fit) -> str:
    """Return what was fitted to what, in a line."""
    n_values = sum(len(one.values) for one in fit.measurements)
    n_unknowns = len(fit.rows)
    return f"{n_unknowns} value{'s' * (n_unknowns > 1)} fitted to {n_values} measured ones; band: two standard deviations of the noise"


def fit_figure(fit: Fit) -> Page:
    """Draw measured and fitted values over time, and the residuals with two standard deviations of the noise."""
    height = _FIT_HEADER + _FIT_FOOTER + _READING_HEIGHT * len(fit.measurements)
    page = Page(_FIT_WIDTH, height, fit.title, _describe_fit(fit), subtitle_y=1 - 0.7 * _FIT_HEADER / height)
    ratios = [2.4, 1.0] * len(fit.measurements)
    margins = {"left": 0.11, "right": 0.97, "top": 1 - _FIT_HEADER / height, "bottom": _FIT_FOOTER / height}
    grid = page.add_gridspec(2 * len(fit.measurements), 1, height_ratios=ratios, hspace=0.3, **margins)
    for k, one in enumerate(fit.measurements):
        unit, factor = display_unit_of(one.unit)
        panel = page.add_panel(grid[2 * k, 0], "", f"{format_name(one.reading)} [{unit}]")
        panel.plot(one.times, one.values * factor, ".", color=MUTED, markersize=3, label="measured")
        panel.plot(fit.run.times, fit.run.readings[one.reading] * factor, color=BLUE, linewidth=1.4, label="fitted run")
        panel.legend(loc="best", frameon=False, fontsize=8)
        below = page.add_panel(grid[2 * k + 1, 0], "time [s]", f"residual [{unit}]", label_size=9)
        below.set_xlim(panel.get_xlim())
        limit = 2.0 * fit.noise[one.reading] * factor
        below.axhspan(-limit, limit, color=BLUE, alpha=0.12, linewidth=0)
        below.axhline(0.0, color=INK, linewidth=0.6)
        residuals = fit.residuals[one.reading] * factor
        below.plot(one.times[: len(residuals)], residuals, ".", color=VERMILLION, markersize=2.5)
    return page
