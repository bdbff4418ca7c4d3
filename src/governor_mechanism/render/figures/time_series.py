"""Figure of all readings of a run over time."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.page import (
    READING_NOISE_RATIO,
    Page,
    Panel,
    add_legend,
    axis_limits_for,
    format_plain_ticks,
    use_plain_decades,
)
from governor_mechanism.render.number_format import display_unit_of, format_closing_lines, format_name, format_rounded_up
from governor_mechanism.render.shown_readings import ShownReading, chosen_readings, shown_readings
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SANS_FONT, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.types import FloatArray

_FIGURE_WIDTH, _ROW_HEIGHT, _ONLY_PLOT_HEIGHT, _BORDER_HEIGHT = 9.6, 1.9, 3.2, 0.85
"""Width of the figure, height of a row of plots and of an only plot, height of title and footer together, inches."""
_LEGEND_HEIGHT = 0.24
"""Height of the event legend, inches."""
_MIN_PLOTTED_ERROR = 1e-18
"""Lower bound of plotted errors, because a logarithmic axis has no zero."""
_MAX_FOOTER_LETTERS = 140
"""Largest number of letters in a footer line."""

_MAX_EVENT_LINES = 30
"""Largest number of events with a line each."""
_RUG_HEIGHT_RATIO = 0.09
"""Height of the rug ticks, as a fraction of the plot."""
_MAX_NAMED_KINDS = 6
"""Largest number of event kinds in the legend."""

_EVENT_STYLES: dict[EventKind, tuple[str, Any]] = {
    EventKind.STICK: (VERMILLION, (0, (4, 2))),
    EventKind.REST: (SERIES_COLOURS[3], (0, (1, 1.5))),
    EventKind.SLIP: (GREEN, (0, (4, 2))),
    EventKind.SEPARATION: (SKY, (0, (1, 1.5))),
    EventKind.IMPACT: (INK, (0, (1, 2))),
}
_OTHER_EVENT_STYLE = (MUTED, (0, (5, 2, 1, 2)))
"""Colour and dashes of the lines of other event kinds."""


def readings_figure(run: Trajectory, chosen: Sequence[str] = ()) -> Page:
    """Draw every reading over time, in everyday units, with the joint gap and the energy drift below; or chosen readings alone.

    Events such as impacts against stops are marked in the plots: few by a line each, many by a rug of ticks.

    Parameters
    ----------
    run
        Finished run with at least one reported time.
    chosen
        Names of readings, or "rate of ..." for their rates; all readings, joint gap and energy drift if empty.

    Returns
    -------
    Page
        The figure; `save_png` writes it.

    Raises
    ------
    MechanismError
        If the run has no reported time, or no such reading.
    """
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to plot; its message: {run.message}")
    readings = chosen_readings(run, chosen) if chosen else shown_readings(run)
    n_columns = 1 if len(readings) == 1 else 2
    reading_rows = math.ceil(len(readings) / n_columns)
    events = [event for event in run.events if run.times[0] <= event.time <= run.times[-1]]
    rows = reading_rows if chosen else reading_rows + 1
    header_height = 0.75 + (_LEGEND_HEIGHT if events else 0.0)
    height = (_ONLY_PLOT_HEIGHT if chosen and len(readings) == 1 else rows * _ROW_HEIGHT) + _BORDER_HEIGHT + header_height - 0.75
    page = Page(_FIGURE_WIDTH, height)
    margins = {"left": 0.075, "right": 0.975, "top": 1 - header_height / height, "bottom": 0.75 / height}
    grid = page.add_gridspec(rows, n_columns, hspace=0.62, wspace=0.17, **margins)
    for k, (name, reading) in enumerate(readings.items()):
        panel = _plot_reading(page, grid[divmod(k, n_columns)], run.times, name, reading)
        _draw_event_markers(panel, events)
        if chosen and k + n_columns >= len(readings):
            _label_time(panel)
    if events:
        _draw_event_legend(page, events, 1 - 0.55 / height)
    if not chosen:
        _plot_checks(page, grid[rows - 1, 0], grid[rows - 1, 1], run)
    page.write_title(run.scene.title, y=1 - 0.27 / height)
    lines, is_failure = format_closing_lines(run, _MAX_FOOTER_LETTERS)
    for text, y in zip(lines, (0.16,) if len(lines) == 1 else (0.26, 0.10), strict=True):
        page.write_footnote(text, y=y / height, size=8.5, va="center", color=VERMILLION if is_failure else MUTED)
    return page


def _plot_reading(page: Page, cell: SubplotSpec, times: FloatArray, name: str, reading: ShownReading) -> Panel:
    """Plot one reading with its error estimate."""
    unit, factor = display_unit_of(reading.unit)
    unit = unit.replace("°", "deg")
    panel = _add_panel(page, cell, f"{format_name(name)}, {unit}" if unit else format_name(name))
    panel.plot(times, reading.values * factor, color=GREEN if name.rpartition(".")[2].startswith("spindle") else BLUE, linewidth=1.3)
    panel.set_ylim(axis_limits_for(reading.values * factor, READING_NOISE_RATIO * reading.scale * factor))
    format_plain_ticks(panel.yaxis, panel.get_ylim())
    if reading.error > 0:
        _write_side_note(panel, f"error estimate {format_rounded_up(reading.error * factor)} {unit}".rstrip())
    return panel


def _plot_checks(page: Page, left: SubplotSpec, right: SubplotSpec, run: Trajectory) -> None:
    """Plot the joint gap and the energy drift of a run."""
    drift = np.abs(run.energy.jacobi - run.energy.jacobi[0]) / run.energy.scale
    unit, factor = display_unit_of("m")
    size_in_units = max(part.mechanism.length_scale for part in run.scene.parts) * factor
    _plot_error(page, left, run.times, run.joint_gap * factor, f"widest joint gap, {unit}", size_in_units)
    _plot_error(page, right, run.times, drift, "energy drift, of the energy scale", 1.0)


def _label_time(panel: Panel) -> None:
    panel.label("time, s", color=MUTED, fontsize=8, fontfamily=SANS_FONT)


def _plot_error(page: Page, cell: SubplotSpec, times: FloatArray, values: FloatArray, heading: str, reference_scale: float) -> None:
    """Plot a quantity that is zero in an exact run on a logarithmic axis; below 4 machine epsilons of the reference scale it is zero."""
    panel = _add_panel(page, cell, heading)
    _label_time(panel)
    if values.max() <= 4 * np.finfo(float).eps * reference_scale:
        panel.set(xlim=(times[0], max(times[-1], times[0] + 1e-9)), yticks=[])
        note = panel.write_note("zero to rounding", (0.5, 0.5), xycoords="axes fraction", fontsize=9, ha="center", va="center")
        note.set(color=MUTED, backgroundcolor=PAPER)
        return
    panel.set_yscale("log")
    panel.plot(times, np.maximum(values, _MIN_PLOTTED_ERROR), color=VERMILLION, linewidth=0.9)
    low, high = (10.0 ** math.floor(math.log10(max(v, _MIN_PLOTTED_ERROR))) for v in (np.percentile(values, 5), values.max()))
    panel.set_ylim(low, 10 * high)
    panel.yaxis.set_major_locator(LogLocator(numticks=5))
    panel.yaxis.set_minor_locator(NullLocator())
    use_plain_decades(panel.yaxis)  # powers of ten as formulas take longer than the rest of the figure
    _write_side_note(panel, f"at most {format_rounded_up(float(values.max()))}")


def _write_side_note(panel: Panel, text: str) -> None:
    panel.write_note(text, (1.0, 1.06), xycoords="axes fraction", color=MUTED, fontsize=8, ha="right")


def _add_panel(page: Page, cell: SubplotSpec, heading: str) -> Panel:
    panel = page.add_panel(cell)
    panel.set_axisbelow("line")
    panel.margins(x=0)
    panel.write_heading(heading, y=1.06)
    return panel


def _draw_event_markers(panel: Panel, events: Sequence[Event]) -> None:
    """Draw a marker at the time of each event."""
    height = 1.0 if len(events) <= _MAX_EVENT_LINES else _RUG_HEIGHT_RATIO
    for (label, colour, dashes), times in _times_by_style(events).items():
        lines = panel.vlines(times, 0.0, height, transform=panel.get_xaxis_transform(), colors=colour)
        lines.set(linewidth=0.8, zorder=1, linestyle=dashes, gid=label)


def _draw_event_legend(page: Page, events: Sequence[Event], height: float) -> None:
    """Draw a one-line legend of the event kinds and named crossings with their numbers at a height, as a fraction of the figure."""
    handles = [
        Line2D([], [], color=colour, linestyle=dashes, linewidth=1.2, label=name if len(times) == 1 else f"{name} ({len(times)})")
        for (name, colour, dashes), times in list(_times_by_style(events).items())[:_MAX_NAMED_KINDS]
    ]
    position: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (0.02, height), "ncols": len(handles)}
    spacing = {"borderpad": 0.0, "borderaxespad": 0.0, "handlelength": 2.2, "columnspacing": 1.6}
    add_legend(page, {"color": MUTED}, handles=handles, prop={"family": SANS_FONT, "size": 8}, **position, **spacing)


def _times_by_style(events: Sequence[Event]) -> dict[tuple[str, str, Any], list[float]]:
    """Return the times, s, of the events by label, colour and dashes: those of the kind, and of each named crossing its own.

    Many events have solid lines.
    """
    names = list(dict.fromkeys(event.subject for event in events if event.kind == EventKind.CROSSING))
    times: dict[tuple[str, str, Any], list[float]] = {}
    for event in events:
        if event.kind == EventKind.CROSSING:
            style = event.subject, SERIES_COLOURS[names.index(event.subject) % len(SERIES_COLOURS)], "solid"
        else:
            colour, dashes = _EVENT_STYLES.get(event.kind, _OTHER_EVENT_STYLE)
            style = event.kind.value, colour, dashes if len(events) <= _MAX_EVENT_LINES else "solid"
        times.setdefault(style, []).append(event.time)
    return times
