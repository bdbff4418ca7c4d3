"""Still figures of runs, off-screen."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.event_markers import events_within, mark_events, name_events
from governor_mechanism.render.film.reading_panel import NOISE, limits_for, plain_numbers
from governor_mechanism.render.number_format import closing_lines, everyday, rounded_up
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, RULE, SANS, SERIF, VERMILLION
from governor_mechanism.types import FloatArray

WIDTH, ROW, BORDER = 9.6, 1.9, 0.85
"""Inches: of the figure, of a row of plots, of title and footer together."""
LEGEND = 0.24
"""Inches: of the line on what the marks of events mean."""
DPI = 100
ROUNDING = 1e-18
"""What is drawn for a zero on a logarithmic axis."""
CLOSING_LETTERS = 140
"""So many fit in the last line."""


def readings_figure(run: Trajectory, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of every reading over time, in everyday units, with the joint gap and the energy drift below them.

    What the run passed, such as blows against stops, is marked in them: by a line each, or many by a rug of ticks.

    Returns the path. An exception leaves no file behind.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    if not len(run.times):
        raise MechanismError(f"the run holds no reported time, so there is nothing to show; it says: {run.message}")
    figure = _draw(run)
    with written_beside(target) as temporary:
        # Without the name of the program, equal runs give equal files.
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target


def _draw(run: Trajectory) -> Figure:
    rows = math.ceil(len(run.readings) / 2) + 1
    events = events_within(run)
    head = 0.75 + (LEGEND if events else 0.0)
    height = rows * ROW + BORDER + head - 0.75
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor=PAPER)
    grid = figure.add_gridspec(
        rows, 2, left=0.075, right=0.975, top=1 - head / height, bottom=0.75 / height, hspace=0.62, wspace=0.17
    )
    for k, (name, values) in enumerate(run.readings.items()):
        axes = figure.add_subplot(grid[k // 2, k % 2])
        _reading(axes, run, name, values)
        mark_events(axes, events)
    if events:
        name_events(figure, events, 1 - 0.55 / height)
    drift = np.abs(run.energy.jacobi - run.energy.jacobi[0]) / run.energy.scale
    unit, factor = everyday("m")
    size = max(part.mechanism.size for part in run.scene.parts) * factor
    gap = figure.add_subplot(grid[rows - 1, 0])
    _errors(gap, run.times, run.joint_gap * factor, ("widest joint gap", unit), size)
    _errors(figure.add_subplot(grid[rows - 1, 1]), run.times, drift, ("energy drift", "of the energy scale"), 1.0)
    for axes in figure.axes[-2:]:
        axes.set_xlabel("time, s", color=QUIET, fontsize=8, fontfamily=SANS)
    title = figure.text(0.02, 1 - 0.27 / height, run.scene.title, fontsize=15, va="center")
    title.set(color=INK, fontfamily=SERIF, parse_math=False)
    _closing(figure, run, height)
    return figure


def _closing(figure: Figure, run: Trajectory, height: float) -> None:
    """How accurate the run is, or why it ended early; height (in) of the figure."""
    lines, bad = closing_lines(run, CLOSING_LETTERS)
    colour = VERMILLION if bad else QUIET
    middles = (0.16,) if len(lines) == 1 else (0.26, 0.10)
    for words, y in zip(lines, middles, strict=True):
        text = figure.text(0.02, y / height, words, color=colour, fontsize=8.5, va="center", fontfamily=SANS)
        text.set_parse_math(False)


def _reading(axes: Axes, run: Trajectory, name: str, values: FloatArray) -> None:
    """One reading, with the error that the run promises for it."""
    unit, factor = everyday(run.units.get(name, ""))
    unit = unit.replace("°", "deg")
    _dress(axes, name.replace("_", " "), unit)
    axes.plot(run.times, values * factor, color=GREEN if name.startswith("spindle") else BLUE, linewidth=1.3)
    error = run.reading_errors.get(name, 0.0)
    axes.set_ylim(limits_for(values * factor, NOISE * run.scales.get(name, 0.0) * factor))
    plain_numbers(axes.yaxis, axes.get_ylim())
    if error > 0:
        _aside(axes, f"error estimate {rounded_up(error * factor)} {unit}")


def _errors(axes: Axes, times: FloatArray, values: FloatArray, heading: tuple[str, str], whole: float) -> None:
    """A quantity that an exact run keeps at zero, on a logarithmic axis; a few last bits of `whole` are nothing."""
    _dress(axes, *heading)
    if values.max() <= 4 * np.finfo(float).eps * whole:
        axes.set(xlim=(times[0], max(times[-1], times[0] + 1e-9)), yticks=[])
        words = axes.text(0.5, 0.5, "zero to rounding", transform=axes.transAxes, fontsize=9, fontfamily=SANS)
        words.set(color=QUIET, ha="center", va="center", backgroundcolor=PAPER)
        return
    axes.set_yscale("log")
    axes.plot(times, np.maximum(values, ROUNDING), color=VERMILLION, linewidth=0.9)
    low, high = (10.0 ** math.floor(math.log10(max(v, ROUNDING))) for v in (np.percentile(values, 5), values.max()))
    axes.set_ylim(low, 10 * high)
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_locator(NullLocator())
    _aside(axes, f"at most {rounded_up(float(values.max()))}")


def _aside(axes: Axes, words: str) -> None:
    axes.text(
        1.0, 1.06, words, transform=axes.transAxes, color=QUIET, fontsize=8, ha="right", va="baseline", fontfamily=SANS
    )


def _dress(axes: Axes, name: str, unit: str) -> None:
    axes.set_facecolor(PAPER)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, labelfontfamily=SANS)
    axes.grid(color=RULE, linewidth=0.6)
    axes.margins(x=0)
    axes.text(0.0, 1.06, f"{name}, {unit}", transform=axes.transAxes, color=INK, fontsize=11, fontfamily=SERIF)
