"""Figures of a run over time: its readings, and what is zero in an exact run."""

import math
import textwrap
from collections.abc import Mapping, Sequence
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
    SERIES_LINE_STYLES,
    Page,
    Panel,
    add_legend,
    axis_limits_for,
    format_plain_ticks,
    use_plain_decades,
)
from governor_mechanism.render.number_format import display_unit_of, format_closing_lines, format_label, format_name, format_rounded_up
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
_HEADER_HEIGHT, _STRIP_BORDER_HEIGHT, _STRIP_ROW_HEIGHT, _EVENT_NAME_WIDTH = 0.75, 0.1, 0.2, 0.85
"""Height above the plots without further lines, of the strip of events without its rows and of a row, and width of their names, inches."""
_MAX_NAMED_KINDS = 6
"""Largest number of event kinds in the legend."""

_EVENT_STYLES: dict[EventKind, tuple[str, Any]] = {
    EventKind.STICK: (VERMILLION, (0, (4, 2))),
    EventKind.REST: (SERIES_COLOURS[3], (0, (1, 1.5))),
    EventKind.SLIP: (GREEN, (0, (7, 1.5, 1.5, 1.5))),
    EventKind.SEPARATION: (SKY, (0, (1, 1.5))),
    EventKind.IMPACT: (INK, (0, (1, 2))),
}
_OTHER_EVENT_STYLE = (MUTED, (0, (5, 2, 1, 2)))
"""Colour and dashes of the lines of other event kinds."""


def readings_figure(run: Trajectory, chosen: Sequence[str] = ()) -> Page:
    """Draw every reading over time, in everyday units, or chosen readings alone.

    What stays constant stands in a line of its own instead of a panel, unless it is chosen. Few events, such as impacts against stops, are
    marked by a line each through the panels; many by a tick each in a strip below, with a row for each kind. Turning points are seen in the
    curves.

    Parameters
    ----------
    run
        Finished run with at least one reported time.
    chosen
        Names of readings, or "rate of ..." for their rates; all readings if empty.

    Returns
    -------
    Page
        The figure; `save` writes it.

    Raises
    ------
    MechanismError
        If the run has no reported time, or no such reading.
    """
    _check_times(run)
    readings = chosen_readings(run, chosen) if chosen else shown_readings(run)
    constants = {} if chosen else {name: one for name, one in readings.items() if _is_constant(one)}
    moving = {name: one for name, one in readings.items() if name not in constants} or readings
    events = [event for event in run.events if event.kind != EventKind.TURNING_POINT and run.times[0] <= event.time <= run.times[-1]]
    strip = _times_by_style(events) if len(events) > _MAX_EVENT_LINES else {}
    n_columns = 1 if len(moving) == 1 else 2
    n_rows = math.ceil(len(moving) / n_columns)
    panel_heights = [_ONLY_PLOT_HEIGHT if len(moving) == 1 else _ROW_HEIGHT] * n_rows
    strip_heights = [_STRIP_BORDER_HEIGHT + _STRIP_ROW_HEIGHT * len(strip)] if strip else []
    has_legend = bool(events) and not strip
    header = _HEADER_HEIGHT + _LEGEND_HEIGHT * has_legend + _LEGEND_HEIGHT * (len(moving) < len(readings))
    height = sum(panel_heights) + sum(strip_heights) + _BORDER_HEIGHT + header - _HEADER_HEIGHT
    page = Page(_FIGURE_WIDTH, height)
    margins = {"left": 0.075, "right": 0.975, "top": 1 - header / height, "bottom": 0.75 / height}
    grid = page.add_gridspec(n_rows + len(strip_heights), n_columns, hspace=0.62, wspace=0.17, **margins)
    grid.set_height_ratios([*panel_heights, *strip_heights])
    for k, (name, reading) in enumerate(moving.items()):
        row, column = divmod(k, n_columns)
        cell = grid[row, column:] if k == len(moving) - 1 else grid[row, column]  # the last one fills its row
        panel = _plot_reading(page, cell, run.times, name, reading)
        if not strip:
            _draw_event_markers(panel, events)
        if row == n_rows - 1:
            _label_time(panel)
    if strip:
        _draw_event_strip(page, grid[n_rows, :], run.times, strip)
    line_height = height - 0.55
    if len(moving) < len(readings):
        _write_constants(page, constants, line_height / height)
        line_height -= _LEGEND_HEIGHT
    if has_legend:
        _draw_event_legend(page, events, line_height / height)
    _write_closing_lines(page, run, height)
    return page


def diagnostics_figure(run: Trajectory) -> Page:
    """Draw what is zero in an exact run: the widest joint gap, and the change of the energy that is not explained by work and losses.

    Parameters
    ----------
    run
        Finished run with at least one reported time.

    Returns
    -------
    Page
        The figure; `save` writes it.

    Raises
    ------
    MechanismError
        If the run has no reported time.
    """
    _check_times(run)
    height = 2 * _ROW_HEIGHT + _BORDER_HEIGHT
    page = Page(_FIGURE_WIDTH, height)
    grid = page.add_gridspec(2, 1, hspace=0.62, left=0.075, right=0.975, top=1 - _HEADER_HEIGHT / height, bottom=0.75 / height)
    drift = np.abs(run.energy.jacobi - run.energy.jacobi[0]) / run.energy.scale
    unit, factor = display_unit_of("m")
    size_in_units = max(part.mechanism.length_scale for part in run.scene.parts) * factor
    _plot_error(page, grid[0, 0], run.times, run.joint_gap * factor, f"Widest joint gap [{unit}]", size_in_units)
    _label_time(_plot_error(page, grid[1, 0], run.times, drift, "Energy drift, relative to the energy scale", 1.0))
    _write_closing_lines(page, run, height)
    return page


def _check_times(run: Trajectory) -> None:
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to plot; its message: {run.message}")


def _is_constant(reading: ShownReading) -> bool:
    return bool(np.ptp(reading.values) <= READING_NOISE_RATIO * reading.scale)


def _write_constants(page: Page, constants: Mapping[str, ShownReading], height: float) -> None:
    """Write the readings that stay constant, with their values, in a line at a height, as a fraction of the figure."""
    values = []
    for name, reading in constants.items():
        unit, factor = display_unit_of(reading.unit)
        values.append(f"{format_name(name)} {reading.values[0] * factor:.6g} {unit}".rstrip())
    text = textwrap.shorten("constant: " + ", ".join(values), _MAX_FOOTER_LETTERS, placeholder=" …")
    page.write_footnote(text, y=height, size=8.5, va="center")


def _write_closing_lines(page: Page, run: Trajectory, height: float) -> None:
    """Write the title of the scene above, and outcome and accuracy below, on a page of a height, inches."""
    page.write_title(run.scene.title, y=1 - 0.27 / height)
    lines, is_failure = format_closing_lines(run, _MAX_FOOTER_LETTERS)
    for text, y in zip(lines, (0.16,) if len(lines) == 1 else (0.26, 0.10), strict=True):
        page.write_footnote(text, y=y / height, size=8.5, va="center", color=VERMILLION if is_failure else MUTED)


def _plot_reading(page: Page, cell: SubplotSpec, times: FloatArray, name: str, reading: ShownReading) -> Panel:
    """Plot one reading with its error estimate."""
    unit, factor = display_unit_of(reading.unit)
    unit = unit.replace("°", "deg")
    panel = _add_panel(page, cell, format_label(name, unit))
    panel.plot(times, reading.values * factor, color=GREEN if name.rpartition(".")[2].startswith("spindle") else BLUE, linewidth=1.3)
    panel.set_ylim(axis_limits_for(reading.values * factor, READING_NOISE_RATIO * reading.scale * factor))
    format_plain_ticks(panel.yaxis, panel.get_ylim())
    if reading.error > 0:
        _write_side_note(panel, f"error estimate {format_rounded_up(reading.error * factor)} {unit}".rstrip())
    return panel


def _label_time(panel: Panel) -> None:
    panel.label("Time [s]", color=MUTED, fontsize=8, fontfamily=SANS_FONT)


def _plot_error(page: Page, cell: SubplotSpec, times: FloatArray, values: FloatArray, heading: str, reference_scale: float) -> Panel:
    """Plot a quantity that is zero in an exact run on a logarithmic axis; below 4 machine epsilons of the reference scale it is zero."""
    panel = _add_panel(page, cell, heading)
    if values.max() <= 4 * np.finfo(float).eps * reference_scale:
        panel.set(xlim=(times[0], max(times[-1], times[0] + 1e-9)), yticks=[])
        note = panel.write_note("zero to rounding", (0.5, 0.5), xycoords="axes fraction", fontsize=9, ha="center", va="center")
        note.set(color=MUTED, backgroundcolor=PAPER)
        return panel
    panel.set_yscale("log")
    panel.plot(times, np.maximum(values, _MIN_PLOTTED_ERROR), color=VERMILLION, linewidth=0.9)
    low, high = (10.0 ** math.floor(math.log10(max(v, _MIN_PLOTTED_ERROR))) for v in (np.percentile(values, 5), values.max()))
    panel.set_ylim(low, 10 * high)
    panel.yaxis.set_major_locator(LogLocator(numticks=5))
    panel.yaxis.set_minor_locator(NullLocator())
    use_plain_decades(panel.yaxis)  # powers of ten as formulas take longer than the rest of the figure
    _write_side_note(panel, f"at most {format_rounded_up(float(values.max()))}")
    return panel


def _write_side_note(panel: Panel, text: str) -> None:
    panel.write_note(text, (1.0, 1.06), xycoords="axes fraction", color=MUTED, fontsize=8, ha="right")


def _add_panel(page: Page, cell: SubplotSpec, heading: str) -> Panel:
    panel = page.add_panel(cell)
    panel.set_axisbelow("line")
    panel.margins(x=0)
    panel.write_heading(heading, y=1.06)
    return panel


def _draw_event_markers(panel: Panel, events: Sequence[Event]) -> None:
    """Draw a line at the time of each event."""
    for (label, colour, dashes), times in _times_by_style(events).items():
        lines = panel.vlines(times, 0.0, 1.0, transform=panel.get_xaxis_transform(), colors=colour)
        lines.set(linewidth=0.8, zorder=1, linestyle=dashes, gid=label)


def _draw_event_strip(page: Page, cell: SubplotSpec, times: FloatArray, strip: Mapping[tuple[str, str, Any], Sequence[float]]) -> None:
    """Draw a tick at the time of each event, in a row for each kind, whose name and number stand before it."""
    place = cell.get_position(page)
    left = place.x0 + _EVENT_NAME_WIDTH / _FIGURE_WIDTH
    panel = page.add_panel((left, place.y0, place.x1 - left, place.height), grid="x")
    for row, ((name, colour, _), event_times) in enumerate(strip.items()):
        panel.vlines(event_times, row - 0.36, row + 0.36, colors=colour, linewidth=1.0).set_gid(name)
    labels = [f"{name} ({len(event_times)})" for (name, _, _), event_times in strip.items()]
    panel.set_yticks(range(len(strip)), labels)
    panel.tick_params(axis="y", length=0.0)
    panel.set(xlim=(times[0], times[-1]), ylim=(len(strip) - 0.4, -0.6))
    _label_time(panel)


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
    """Return the times, s, of the events by label, colour and dashes: those of the kind, and of each named crossing its own."""
    names = list(dict.fromkeys(event.subject for event in events if event.kind == EventKind.CROSSING))
    times: dict[tuple[str, str, Any], list[float]] = {}
    for event in events:
        if event.kind == EventKind.CROSSING:
            number = names.index(event.subject) % len(SERIES_COLOURS)
            style = format_name(event.subject), SERIES_COLOURS[number], SERIES_LINE_STYLES[number]
        else:
            colour, dashes = _EVENT_STYLES.get(event.kind, _OTHER_EVENT_STYLE)
            style = event.kind.value, colour, dashes
        times.setdefault(style, []).append(event.time)
    return times
