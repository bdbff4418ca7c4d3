"""A sweep as a figure: curves over one key, heat maps over two, rows of heat maps over three."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.render.figures.sweep_heatmaps import Ruler, draw_maps, named
from governor_mechanism.render.film.reading_panel import limits_for, plain_numbers
from governor_mechanism.render.style import INK, PAPER, QUIET, RULE, SANS, SERIES, SERIF, VERMILLION
from governor_mechanism.studies.sweep.quantities import Quantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.types import FloatArray

DPI, WIDTH, PANEL = 100, 8.4, 2.9
"""Dots per inch; inches: width of a figure of curves, height of each of its panels."""

HEAD, FOOT = 0.75, 0.75
"""Inches above and below the panels."""

NAME_LETTERS = 20
"""So many of a curve's name stand in a line beside its panel."""

MOST_AXES = 3


def sweep_figure(sweep: Sweep, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of every quantity of a sweep over the keys that were varied, in everyday units.

    Rows that ended otherwise are marked by their outcomes. Returns the path. Raises MechanismError for a sweep over
    more than three keys.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    if len(sweep.axes) > MOST_AXES:
        raise MechanismError(
            f"a figure shows at most {MOST_AXES} keys, and this sweep varies {len(sweep.axes)}; "
            "draw none, or sweep over fewer"
        )
    figure = _curves(sweep) if len(sweep.axes) == 1 else draw_maps(sweep)
    with written_beside(target) as temporary:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target


def _curves(sweep: Sweep) -> Figure:
    """A panel for the quantities of each unit, a curve for each quantity."""
    ruler = Ruler.of(sweep.axes[0])
    groups: dict[str, list[Quantity]] = {}
    for one in sweep.quantities:
        groups.setdefault(one.everyday[1] or one.name, []).append(one)
    height = HEAD + FOOT + PANEL * len(groups)
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor=PAPER)
    grid = figure.add_gridspec(
        len(groups), 1, left=0.1, right=0.76, top=1 - (HEAD + 0.2) / height, bottom=FOOT / height, hspace=0.38
    )
    for k, group in enumerate(groups.values()):
        axes = figure.add_subplot(grid[k, 0])
        _panel(axes, sweep, ruler, group)
        if k == len(groups) - 1:
            axes.set_xlabel(ruler.label, color=INK, fontsize=10, fontfamily=SERIF)
    title = figure.text(0.02, 1 - 0.32 / height, sweep.title, fontsize=15, va="center")
    title.set(color=INK, fontfamily=SERIF, parse_math=False)
    return figure


DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1)))
"""For the first curves of a panel, and for those that have their colours again."""


def _panel(axes: Axes, sweep: Sweep, ruler: Ruler, group: Sequence[Quantity]) -> None:
    factor, unit = group[0].everyday
    dress(axes)
    handles = []
    shown: list[FloatArray] = []
    for k, one in enumerate(group):
        style = DASHES[k // len(SERIES) % len(DASHES)]
        values = sweep.column(one.name)[ruler.order] * factor
        marker = "o" if len(values) <= 60 else ""
        colour = SERIES[k % len(SERIES)]
        (line,) = axes.plot(
            ruler.places, values, linestyle=style if ruler.numeric else "", marker=marker, markersize=3.5, color=colour
        )
        line.set(linewidth=1.5, label=textwrap.fill(one.name.replace("_", " "), NAME_LETTERS))
        handles.append(line)
        shown.append(values[np.isfinite(values)])
    values = np.concatenate(shown)
    if values.size:
        axes.set_ylim(limits_for(values))
        plain_numbers(axes.yaxis, axes.get_ylim())
    ruler.set_along(axes, "x")
    handles += _mark_failures(axes, sweep, ruler)
    if len(handles) > 1:
        legend = axes.legend(
            handles=handles, loc="upper left", bbox_to_anchor=(1.015, 1.02), frameon=False, fontsize=8.5
        )
        for words in legend.get_texts():
            words.set(color=INK, fontfamily=SANS, parse_math=False)
    heading = named(group[0].name, unit) if len(group) == 1 else unit or "value"
    axes.text(0.0, 1.05, heading, transform=axes.transAxes, color=INK, fontsize=11, fontfamily=SERIF)


MARKS = ("x", "v", "s", "d", "P", "*")


def _mark_failures(axes: Axes, sweep: Sweep, ruler: Ruler) -> list[Line2D]:
    """A mark on the lower edge for each row that ended otherwise, by its outcome."""
    outcomes = np.array([row.outcome if not row.ok else "" for row in sweep.rows])[ruler.order]
    handles = []
    for outcome, mark in zip((name for name in sweep.outcomes if name in outcomes), cycle(MARKS), strict=False):
        here = ruler.places[outcomes == outcome]
        words = f"{outcome.replace('_', ' ')} ({len(here)})"
        (line,) = axes.plot(here, np.zeros(len(here)), transform=axes.get_xaxis_transform(), label=words, clip_on=False)
        line.set(linestyle="", marker=mark, markersize=5, color=VERMILLION, zorder=5)
        handles.append(line)
    return handles


def dress(axes: Axes) -> None:
    """The quiet look of axes."""
    axes.set_facecolor(PAPER)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, labelfontfamily=SANS)
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
