"""Figure of all readings of a run over time."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.event_markers import draw_event_legend, draw_event_markers, reported_events
from governor_mechanism.render.figures.page import (
    label_axes,
    new_figure,
    require_png,
    save_png,
    style_axes,
    write_footnote,
    write_heading,
    write_title,
)
from governor_mechanism.render.film.reading_panel import READING_NOISE_RATIO, axis_limits_for, format_plain_ticks
from governor_mechanism.render.number_format import display_unit_of, format_closing_lines, format_name, format_rounded_up
from governor_mechanism.render.shown_readings import ShownReading, shown_readings
from governor_mechanism.render.style import BLUE, GREEN, MUTED, PAPER, SANS_FONT, VERMILLION
from governor_mechanism.types import FloatArray

_FIGURE_WIDTH, _ROW_HEIGHT, _BORDER_HEIGHT = 9.6, 1.9, 0.85
"""Width of the figure, height of a row of plots, height of title and footer together, inches."""
_LEGEND_HEIGHT = 0.24
"""Height of the event legend, inches."""
_MIN_PLOTTED_ERROR = 1e-18
"""Lower bound of plotted errors, because a logarithmic axis has no zero."""
_MAX_FOOTER_LETTERS = 140
"""Largest number of letters in a footer line."""


def readings_figure(run: Trajectory, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of every reading over time, in everyday units, with the joint gap and the energy drift below.

    Events such as impacts against stops are marked in the plots: few by a line each, many by a rug of ticks.
    An exception leaves no file behind.

    Parameters
    ----------
    run
        Finished run with at least one reported time.
    path
        File to write; another ending than .png raises MechanismError.

    Returns
    -------
    Path
        The path of the file.

    Raises
    ------
    MechanismError
        If the run has no reported time.
    """
    require_png(path)
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to plot; its message: {run.message}")
    return save_png(_draw_readings(run), path)


def _draw_readings(run: Trajectory) -> Figure:
    readings = shown_readings(run)
    rows = math.ceil(len(readings) / 2) + 1
    events = reported_events(run)
    header_height = 0.75 + (_LEGEND_HEIGHT if events else 0.0)
    height = rows * _ROW_HEIGHT + _BORDER_HEIGHT + header_height - 0.75
    figure = new_figure(_FIGURE_WIDTH, height)
    grid = figure.add_gridspec(
        rows, 2, left=0.075, right=0.975, top=1 - header_height / height, bottom=0.75 / height, hspace=0.62, wspace=0.17
    )
    for k, (name, reading) in enumerate(readings.items()):
        axes = figure.add_subplot(grid[k // 2, k % 2])
        _plot_reading(axes, run.times, name, reading)
        draw_event_markers(axes, events)
    if events:
        draw_event_legend(figure, events, 1 - 0.55 / height)
    drift = np.abs(run.energy.jacobi - run.energy.jacobi[0]) / run.energy.scale
    unit, factor = display_unit_of("m")
    size_in_units = max(part.mechanism.length_scale for part in run.scene.parts) * factor
    gap_axes = figure.add_subplot(grid[rows - 1, 0])
    _plot_error(gap_axes, run.times, run.joint_gap * factor, ("widest joint gap", unit), size_in_units)
    _plot_error(figure.add_subplot(grid[rows - 1, 1]), run.times, drift, ("energy drift", "of the energy scale"), 1.0)
    for axes in figure.axes[-2:]:
        label_axes(axes, "time, s", color=MUTED, fontsize=8, fontfamily=SANS_FONT)
    write_title(figure, run.scene.title, y=1 - 0.27 / height)
    lines, is_failure = format_closing_lines(run, _MAX_FOOTER_LETTERS)
    for text, y in zip(lines, (0.16,) if len(lines) == 1 else (0.26, 0.10), strict=True):
        write_footnote(figure, text, y=y / height, size=8.5, va="center", color=VERMILLION if is_failure else MUTED)
    return figure


def _plot_reading(axes: Axes, times: FloatArray, name: str, reading: ShownReading) -> None:
    """Plot one reading with its error estimate."""
    unit, factor = display_unit_of(reading.unit)
    unit = unit.replace("°", "deg")
    _style_axes(axes, format_name(name), unit)
    axes.plot(times, reading.values * factor, color=GREEN if name.rpartition(".")[2].startswith("spindle") else BLUE, linewidth=1.3)
    axes.set_ylim(axis_limits_for(reading.values * factor, READING_NOISE_RATIO * reading.scale * factor))
    format_plain_ticks(axes.yaxis, axes.get_ylim())
    if reading.error > 0:
        _write_side_note(axes, f"error estimate {format_rounded_up(reading.error * factor)} {unit}")


def _plot_error(axes: Axes, times: FloatArray, values: FloatArray, heading: tuple[str, str], reference_scale: float) -> None:
    """Plot a quantity that is zero in an exact run on a logarithmic axis; below 4 machine epsilons of the reference scale it is zero."""
    _style_axes(axes, *heading)
    if values.max() <= 4 * np.finfo(float).eps * reference_scale:
        axes.set(xlim=(times[0], max(times[-1], times[0] + 1e-9)), yticks=[])
        note = axes.text(0.5, 0.5, "zero to rounding", transform=axes.transAxes, fontsize=9, fontfamily=SANS_FONT)
        note.set(color=MUTED, ha="center", va="center", backgroundcolor=PAPER)
        return
    axes.set_yscale("log")
    axes.plot(times, np.maximum(values, _MIN_PLOTTED_ERROR), color=VERMILLION, linewidth=0.9)
    low, high = (10.0 ** math.floor(math.log10(max(v, _MIN_PLOTTED_ERROR))) for v in (np.percentile(values, 5), values.max()))
    axes.set_ylim(low, 10 * high)
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_locator(NullLocator())
    _write_side_note(axes, f"at most {format_rounded_up(float(values.max()))}")


def _write_side_note(axes: Axes, text: str) -> None:
    axes.text(1.0, 1.06, text, transform=axes.transAxes, color=MUTED, fontsize=8, ha="right", va="baseline", fontfamily=SANS_FONT)


def _style_axes(axes: Axes, name: str, unit: str) -> None:
    style_axes(axes, is_grid_below=False)
    axes.margins(x=0)
    write_heading(axes, f"{name}, {unit}", y=1.06)
