"""Figure of a sweep: curves over one key, heat maps over two, rows of heat maps over three."""

import textwrap
from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figures.page import Page, Panel, add_legend, axis_limits_for, format_plain_ticks
from governor_mechanism.render.figures.sweep_heatmaps import SweepAxisScale, draw_heatmaps, failure_counts, label_with_unit
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import INK, SANS_FONT, SERIES_COLOURS, VERMILLION
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.results import Sweep

_FIGURE_WIDTH, _PANEL_HEIGHT = 8.4, 2.9
"""Width of a figure of curves and height of each panel, inches."""

_HEADER_HEIGHT, _FOOTER_HEIGHT = 0.75, 0.75
"""Heights above and below the panels, inches."""

_MAX_NAME_LETTERS = 20
"""Number of letters per line of a curve name in the legend."""

_MAX_SWEEP_AXES = 3


def sweep_figure(sweep: Sweep) -> Page:
    """Draw every quantity of a sweep over the varied keys, in everyday units.

    Failed rows are marked by their outcomes. An exception leaves no file behind.

    Parameters
    ----------
    sweep
        Result of a sweep over one to three keys.

    Returns
    -------
    Page
        The figure; `save_png` writes it.

    Raises
    ------
    MechanismError
        If the sweep has more than three keys.
    """
    if len(sweep.axes) > _MAX_SWEEP_AXES:
        raise MechanismError(
            f"a figure shows at most {_MAX_SWEEP_AXES} keys, and this sweep varies {len(sweep.axes)}; sweep over fewer keys"
        )
    return _draw_curves(sweep) if len(sweep.axes) == 1 else draw_heatmaps(sweep)


def _draw_curves(sweep: Sweep) -> Page:
    """Draw a panel for the quantities of each unit, with a curve for each quantity."""
    axis_scale = SweepAxisScale(sweep.axes[0])
    groups: dict[str, list[RunQuantity]] = {}
    for quantity in sweep.quantities:
        groups.setdefault(quantity.display_unit[1] or quantity.name, []).append(quantity)
    height = _HEADER_HEIGHT + _FOOTER_HEIGHT + _PANEL_HEIGHT * len(groups)
    page = Page(_FIGURE_WIDTH, height)
    margins = {"left": 0.1, "right": 0.76, "top": 1 - (_HEADER_HEIGHT + 0.2) / height, "bottom": _FOOTER_HEIGHT / height}
    grid = page.add_gridspec(len(groups), 1, hspace=0.38, **margins)
    for k, group in enumerate(groups.values()):
        _draw_panel(page.add_panel(grid[k, 0], axis_scale.label if k == len(groups) - 1 else ""), sweep, axis_scale, group)
    page.write_title(sweep.title, y=1 - 0.32 / height)
    return page


_LINE_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1)))
"""Line styles of the curves of a panel; the next one begins when the colours repeat."""


def _draw_panel(panel: Panel, sweep: Sweep, axis_scale: SweepAxisScale, group: Sequence[RunQuantity]) -> None:
    factor, unit = group[0].display_unit
    columns = [sweep.column(quantity.name)[axis_scale.order] * factor for quantity in group]
    handles = []
    for k, (quantity, values) in enumerate(zip(group, columns, strict=True)):
        (line,) = panel.plot(axis_scale.positions, values, color=SERIES_COLOURS[k % len(SERIES_COLOURS)], linewidth=1.5, markersize=3.5)
        style = _LINE_STYLES[k // len(SERIES_COLOURS) % len(_LINE_STYLES)]
        line.set(linestyle=style if axis_scale.axis.is_numeric else "", marker="o" if len(values) <= 60 else "")
        line.set_label(textwrap.fill(format_name(quantity.name), _MAX_NAME_LETTERS))
        handles.append(line)
    finite_values = np.concatenate([values[np.isfinite(values)] for values in columns])
    if finite_values.size:
        panel.set_ylim(axis_limits_for(finite_values))
        format_plain_ticks(panel.yaxis, panel.get_ylim())
    axis_scale.apply_to(panel, "x")
    handles += _mark_failures(panel, sweep, axis_scale)
    if len(handles) > 1:
        text_style = {"color": INK, "fontfamily": SANS_FONT, "parse_math": False}
        add_legend(panel, text_style, handles=handles, loc="upper left", bbox_to_anchor=(1.015, 1.02), fontsize=8.5)
    panel.write_heading(label_with_unit(group[0].name, unit) if len(group) == 1 else unit or "value", y=1.05)


_FAILURE_MARKERS = ("x", "v", "s", "d", "P", "*")


def _mark_failures(panel: Panel, sweep: Sweep, axis_scale: SweepAxisScale) -> list[Line2D]:
    """Mark each failed row on the lower edge by its outcome."""
    outcomes = sweep.failures[axis_scale.order]
    handles = []
    for outcome, marker in zip(failure_counts(sweep), cycle(_FAILURE_MARKERS), strict=False):
        positions = axis_scale.positions[outcomes == outcome]
        text = f"{outcome.replace('_', ' ')} ({len(positions)})"
        (line,) = panel.plot(positions, np.zeros(len(positions)), transform=panel.get_xaxis_transform(), label=text, clip_on=False)
        line.set(linestyle="", marker=marker, markersize=5, color=VERMILLION, zorder=5)
        handles.append(line)
    return handles
