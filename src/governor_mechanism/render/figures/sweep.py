"""Figure of a sweep: curves over one key, heat maps over two, rows of heat maps over three."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figures.page import label_axes, new_figure, require_png, save_png, style_axes, write_heading, write_title
from governor_mechanism.render.figures.sweep_heatmaps import SweepAxisScale, draw_heatmaps, label_with_unit
from governor_mechanism.render.film.reading_panel import axis_limits_for, format_plain_ticks
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import INK, SANS_FONT, SERIES_COLOURS, VERMILLION
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.types import FloatArray

_FIGURE_WIDTH, _PANEL_HEIGHT = 8.4, 2.9
"""Width of a figure of curves and height of each panel, inches."""

_HEADER_HEIGHT, _FOOTER_HEIGHT = 0.75, 0.75
"""Heights above and below the panels, inches."""

_MAX_NAME_LETTERS = 20
"""Number of letters per line of a curve name in the legend."""

_MAX_SWEEP_AXES = 3


def sweep_figure(sweep: Sweep, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of every quantity of a sweep over the varied keys, in everyday units.

    Failed rows are marked by their outcomes. An exception leaves no file behind.

    Parameters
    ----------
    sweep
        Result of a sweep over one to three keys.
    path
        File to write; another ending than .png raises MechanismError.

    Returns
    -------
    Path
        The path of the file.

    Raises
    ------
    MechanismError
        If the sweep has more than three keys.
    """
    require_png(path)
    if len(sweep.axes) > _MAX_SWEEP_AXES:
        raise MechanismError(
            f"a figure shows at most {_MAX_SWEEP_AXES} keys, and this sweep varies {len(sweep.axes)}; sweep over fewer keys"
        )
    figure = _draw_curves(sweep) if len(sweep.axes) == 1 else draw_heatmaps(sweep)
    return save_png(figure, path)


def _draw_curves(sweep: Sweep) -> Figure:
    """Draw a panel for the quantities of each unit, with a curve for each quantity."""
    axis_scale = SweepAxisScale.from_axis(sweep.axes[0])
    groups: dict[str, list[RunQuantity]] = {}
    for quantity in sweep.quantities:
        groups.setdefault(quantity.display_unit[1] or quantity.name, []).append(quantity)
    height = _HEADER_HEIGHT + _FOOTER_HEIGHT + _PANEL_HEIGHT * len(groups)
    figure = new_figure(_FIGURE_WIDTH, height)
    grid = figure.add_gridspec(
        len(groups), 1, left=0.1, right=0.76, top=1 - (_HEADER_HEIGHT + 0.2) / height, bottom=_FOOTER_HEIGHT / height, hspace=0.38
    )
    for k, group in enumerate(groups.values()):
        axes = figure.add_subplot(grid[k, 0])
        _draw_panel(axes, sweep, axis_scale, group)
        if k == len(groups) - 1:
            label_axes(axes, axis_scale.label)
    write_title(figure, sweep.title, y=1 - 0.32 / height)
    return figure


_LINE_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1)))
"""Line styles of the curves of a panel; the next one begins when the colours repeat."""


def _draw_panel(axes: Axes, sweep: Sweep, axis_scale: SweepAxisScale, group: Sequence[RunQuantity]) -> None:
    factor, unit = group[0].display_unit
    style_axes(axes)
    handles = []
    finite_values: list[FloatArray] = []
    for k, quantity in enumerate(group):
        style = _LINE_STYLES[k // len(SERIES_COLOURS) % len(_LINE_STYLES)]
        values = sweep.column(quantity.name)[axis_scale.order] * factor
        marker = "o" if len(values) <= 60 else ""
        colour = SERIES_COLOURS[k % len(SERIES_COLOURS)]
        (line,) = axes.plot(
            axis_scale.positions, values, linestyle=style if axis_scale.is_numeric else "", marker=marker, markersize=3.5, color=colour
        )
        line.set(linewidth=1.5, label=textwrap.fill(format_name(quantity.name), _MAX_NAME_LETTERS))
        handles.append(line)
        finite_values.append(values[np.isfinite(values)])
    values = np.concatenate(finite_values)
    if values.size:
        axes.set_ylim(axis_limits_for(values))
        format_plain_ticks(axes.yaxis, axes.get_ylim())
    axis_scale.apply_to(axes, "x")
    handles += _mark_failures(axes, sweep, axis_scale)
    if len(handles) > 1:
        legend = axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.015, 1.02), frameon=False, fontsize=8.5)
        for text in legend.get_texts():
            text.set(color=INK, fontfamily=SANS_FONT, parse_math=False)
    heading = label_with_unit(group[0].name, unit) if len(group) == 1 else unit or "value"
    write_heading(axes, heading, y=1.05)


_FAILURE_MARKERS = ("x", "v", "s", "d", "P", "*")


def _mark_failures(axes: Axes, sweep: Sweep, axis_scale: SweepAxisScale) -> list[Line2D]:
    """Mark each failed row on the lower edge by its outcome."""
    outcomes = np.array([row.outcome if not row.ok else "" for row in sweep.rows])[axis_scale.order]
    handles = []
    for outcome, marker in zip((name for name in sweep.outcomes if name in outcomes), cycle(_FAILURE_MARKERS), strict=False):
        positions = axis_scale.positions[outcomes == outcome]
        text = f"{outcome.replace('_', ' ')} ({len(positions)})"
        (line,) = axes.plot(positions, np.zeros(len(positions)), transform=axes.get_xaxis_transform(), label=text, clip_on=False)
        line.set(linestyle="", marker=marker, markersize=5, color=VERMILLION, zorder=5)
        handles.append(line)
    return handles
