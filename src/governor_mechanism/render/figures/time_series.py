"""Figures of a run: its readings over time, and what is zero in an exact run."""

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.page import (
    FIGURE_DPI,
    LINE_WIDTH,
    SERIES_LINE_STYLES,
    Page,
    Panel,
    add_legend,
    band_handles,
    draw_range_band,
    format_plain_ticks,
    use_plain_decades,
)
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine
from governor_mechanism.render.machines.registry import find_drawing_class
from governor_mechanism.render.plot_panels import PanelCurve, PlotPanel
from governor_mechanism.render.range_bands import PlotSize, RangeBand, count_turns, note_coarse_turns, refine_curve
from governor_mechanism.render.shown_readings import (
    READING_NOISE_RATIO,
    ShownReading,
    axis_limits_for,
    choose_multiple,
    chosen_readings,
    display_unit_of,
    format_closing_lines,
    format_label,
    format_name,
    format_rounded_up,
    name_to_plot,
    shown_readings,
    turns_evenly,
)
from governor_mechanism.render.style import BLUE, CURVE_COLOURS, GREEN, INK, MUTED, PAPER, SANS_FONT, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.types import FloatArray

MAX_EVENT_LINES = 30
"""Largest number of events with a line each."""
STRIP_BORDER_HEIGHT, STRIP_ROW_HEIGHT = 0.1, 0.2
"""Height of the strip of events without its rows, and of a row, inches."""
_EVENT_NAME_WIDTH = 0.85
"""Width of the names of events before the strip, inches."""
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

EventTimes = Mapping[tuple[str, str, Any], Sequence[float]]
"""Times of events, s, by label, colour and dashes."""


def group_event_times(events: Sequence[Event]) -> EventTimes:
    """Return the times, s, of the events by label, colour and dashes: those of the kind, and of each named crossing its own."""
    names = list(dict.fromkeys(event.subject for event in events if event.kind == EventKind.CROSSING))
    times: dict[tuple[str, str, Any], list[float]] = {}
    for event in events:
        if event.kind == EventKind.CROSSING:
            number = names.index(event.subject) % len(SERIES_COLOURS)
            # From the last colour: the first one is that of the curves.
            style = format_name(event.subject), SERIES_COLOURS[-1 - number], SERIES_LINE_STYLES[number]
        else:
            colour, dashes = _EVENT_STYLES.get(event.kind, _OTHER_EVENT_STYLE)
            style = event.kind.value, colour, dashes
        times.setdefault(style, []).append(event.time)
    return times


def draw_event_lines(panel: Panel, event_times: EventTimes) -> None:
    """Draw a line at the time of each event."""
    for (label, colour, dashes), times in event_times.items():
        lines = panel.vlines(times, 0.0, 1.0, transform=panel.get_xaxis_transform(), colors=colour)
        lines.set(linewidth=0.8, zorder=1, linestyle=dashes, gid=label)


def draw_event_strip(page: Page, cell: SubplotSpec, times: FloatArray, event_times: EventTimes) -> Panel:
    """Draw a tick at the time of each event over the times (n,) s of a run, in a row for each kind, whose name and number precede it."""
    place = cell.get_position(page)
    left = place.x0 + _EVENT_NAME_WIDTH / page.get_figwidth()
    panel = page.add_panel((left, place.y0, place.x1 - left, place.height), grid="x")
    for row, ((name, colour, _), occurrences) in enumerate(event_times.items()):
        panel.vlines(occurrences, row - 0.36, row + 0.36, colors=colour, linewidth=1.0).set_gid(name)
    labels = [f"{name} ({len(occurrences)})" for (name, _, _), occurrences in event_times.items()]
    panel.set_yticks(range(len(event_times)), labels)
    panel.tick_params(axis="y", length=0.0)
    panel.set(xlim=(times[0], times[-1]), ylim=(len(event_times) - 0.4, -0.6))
    return panel


def event_handles(event_times: EventTimes) -> list[Artist]:
    """Return the entries of a legend of event kinds and named crossings with their numbers."""
    return [
        Line2D([], [], color=colour, linestyle=dashes, linewidth=1.2, label=name if len(times) == 1 else f"{name} ({len(times)})")
        for (name, colour, dashes), times in list(event_times.items())[:_MAX_NAMED_KINDS]
    ]


MAX_OVERVIEW_READINGS = 12
"""Largest number of readings in an overview: six rows of panels, which fill a page."""
FEW_READINGS = 8
"""Number of readings up to which all are shown: four rows of panels, which are seen at a glance."""
MIN_HEADLINES = 6
"""Number of headline readings from which on they make an overview without others."""

_ENGINE_READINGS = ("shaft_speed", "gas_torque", "load_torque", "throttle_opening", "cut_off")
"""Readings of a governed engine that show how it is regulated, by plain name; the governor's own reading comes first."""


def choose_overview(run: Trajectory, readings: Mapping[str, ShownReading]) -> dict[str, ShownReading]:
    """Return the readings, or an overview if more than FEW_READINGS, of MAX_OVERVIEW_READINGS at most, in their order."""
    # It has the headline readings: those that show how a governed engine is regulated, then those that
    # films show beside each machine, and the coordinates of the machines. Less than MIN_HEADLINES are
    # filled up by the other readings in their order. Of equal readings, such as the travels of two
    # pistons on one rod, it has the first.
    if len(readings) <= FEW_READINGS:
        return dict(readings)
    headlines = [name for name in dict.fromkeys(_headline_readings(run)) if name in readings]
    chosen: list[str] = []
    for name in headlines if len(headlines) >= MIN_HEADLINES else dict.fromkeys((*headlines, *readings)):
        if len(chosen) < MAX_OVERVIEW_READINGS and not any(_are_equal(readings[name], readings[one]) for one in chosen):
            chosen.append(name)
    return {name: one for name, one in readings.items() if name in chosen}


def _headline_readings(run: Trajectory) -> Iterator[str]:
    """Yield names of readings, the most telling first; not every run has all of them."""
    parts = run.scene.parts
    prefixes = [f"{part.name}." if len(parts) > 1 else "" for part in parts]
    if governed := find_governed_engine(run.scene):
        yield governed.governor_reading
        yield from (f"{governed.engine.name}.{name}" for name in _ENGINE_READINGS)
    for part, prefix in zip(parts, prefixes, strict=True):
        yield from (prefix + name for name in find_drawing_class(part).panel_readings)
    yield from (f"{prefix}{part.mechanism.coordinate}" for part, prefix in zip(parts, prefixes, strict=True))


def _are_equal(one: ShownReading, other: ShownReading) -> bool:
    """Return whether two readings would give the same panel."""
    noise = READING_NOISE_RATIO * max(one.scale, other.scale, float(np.ptp(one.values)))
    return one.unit == other.unit and bool(np.abs(one.values - other.values).max() <= noise)


_FIGURE_WIDTH = 9.6
_ROW_HEIGHT = 1.9
_ONLY_PLOT_HEIGHT = 3.2
"""Width of the figure, height of a row of plots and of an only plot, inches."""
_HEADER_HEIGHT = 0.75
_FOOTER_HEIGHT = 0.75
_LINE_HEIGHT = 0.24
"""Height above the plots with the title, below them with the time and the closing lines, and of each further line, inches."""
_LEFT = 0.075
_RIGHT = 0.975
_COLUMN_GAP = 0.17
_ROW_GAP = 0.62
"""Edges of the plots relative to the width, and their distances relative to the width and the height of a plot."""
_ROUNDING = 1e-12
"""Value relative to the scale of a reading below which it is zero but for rounding."""
_LETTER_PIXELS = 6.6
"""Mean width of a letter of a heading and of the note beside it."""
_MAX_FOOTER_LETTERS = 140
"""Largest number of letters in a footer line."""


ShownPanel = tuple[PlotPanel, RangeBand | None]
"""The panel of a reading, and the band of its curve."""


def readings_figure(
    run: Trajectory,
    chosen: Sequence[str] = (),  # names of readings, or "rate of ..." for their rates; an overview if empty
) -> Page:
    """Draw an overview of the readings over time, in everyday units, or chosen readings.

    What stays constant or turns evenly stands in a line of its own instead of a panel. Of many other readings those are drawn that tell
    most (`overview`), and a line below names the rest. Readings that are chosen all have a panel. A curve whose oscillations are too
    narrow to be resolved is drawn as its range and mean within a turn (`range_bands`). Few events, such as impacts against stops, are
    marked by a line each through the panels; many by a tick each in a strip below, with a row for each kind. Turning points are seen in
    the curves.

    Result: the figure; `save` writes it. Raises MechanismError if the run has no reported time, or no such
    reading.
    """
    _check_times(run)
    readings = chosen_readings(run, chosen) if chosen else shown_readings(run)
    constants = {} if chosen else {name: one for name, one in readings.items() if _is_constant(one)}
    even = {} if chosen else {name: one for name, one in readings.items() if turns_evenly(run.times, one.values, one.unit)}
    moving = {name: one for name, one in readings.items() if name not in constants | even} or readings
    drawn = moving if chosen else choose_overview(run, moving)
    panels = _make_panels(run, drawn)
    events = [event for event in run.events if event.kind != EventKind.TURNING_POINT and run.times[0] <= event.time <= run.times[-1]]
    event_times = group_event_times(events)
    has_strip = len(events) > MAX_EVENT_LINES
    above: list[str | list[Artist]] = [_list_unplotted(constants, even, run)] if len(moving) < len(readings) else []
    keys = ([] if has_strip else event_handles(event_times), band_handles([band for _, band in panels if band is not None]))
    above += [handles for handles in keys if handles]
    below = _list_others(run, [name for name in moving if name not in drawn])
    if any(band is None and panel.name not in run.rates for panel, band in panels):  # a rate rounds the curve between reports
        below = [*note_coarse_turns(run), *below]
    page = _draw_panels(run, panels, event_times, len(above), len(below), has_strip=has_strip)
    height = float(page.get_figheight())
    for number, line in enumerate(above):
        y = (height - 0.55 - number * _LINE_HEIGHT) / height
        if isinstance(line, str):
            page.write_footnote(line, y=y, size=8.5, va="center")
        else:
            _draw_key(page, line, y)
    _write_closing_lines(page, run, below)
    return page


def _make_panels(run: Trajectory, readings: Mapping[str, ShownReading]) -> list[ShownPanel]:
    """Return the panels of readings, with a band where the oscillations are too narrow for the narrowest panels of a figure."""
    n_columns = min(len(readings), 2)
    width = FIGURE_DPI * _FIGURE_WIDTH * (_RIGHT - _LEFT) / (n_columns + _COLUMN_GAP * (n_columns - 1))
    height = FIGURE_DPI * _row_height(len(readings)) / (1 + _ROW_GAP)
    turns = count_turns(run)
    panels = []
    for name, reading in readings.items():
        unit, factor = choose_multiple(reading.unit, reading.values)
        values = reading.values * factor
        limits = axis_limits_for(values, READING_NOISE_RATIO * reading.scale * factor)
        size = PlotSize(width=width, height=height, line_width=LINE_WIDTH * FIGURE_DPI / 72, limits=limits)
        colour = GREEN if name.rpartition(".")[2].startswith("spindle") else BLUE
        series, error = CURVE_COLOURS.index(colour), reading.error * factor
        curve = PanelCurve(name=name, times=run.times, values=values, series=series, turns=turns, error=error)
        band = curve.find_band(size)
        if band is None and reading.values is run.readings.get(name) and name in run.rates:
            times, refined = refine_curve(run.times, values, run.rates[name] * factor, size)
            curve = replace(curve, times=times, values=refined)
        panels.append((PlotPanel(name=name, unit=unit.replace("°", "deg"), curves=(curve,), limits=limits), band))
    return panels


def _row_height(n_panels: int) -> float:
    return _ONLY_PLOT_HEIGHT if n_panels == 1 else _ROW_HEIGHT


def _draw_panels(
    run: Trajectory, panels: Sequence[ShownPanel], event_times: EventTimes, n_above: int, n_below: int, *, has_strip: bool
) -> Page:
    """Return a page with the panels of readings and the events, with room for lines above and below."""
    n_columns = min(len(panels), 2)
    n_rows = math.ceil(len(panels) / n_columns)
    row_heights = [_row_height(len(panels))] * n_rows
    row_heights += [STRIP_BORDER_HEIGHT + STRIP_ROW_HEIGHT * len(event_times)] * has_strip
    header = _HEADER_HEIGHT + _LINE_HEIGHT * n_above
    footer = _FOOTER_HEIGHT + _LINE_HEIGHT * n_below
    # The gap below the last row of plots is part of the footer.
    height = sum(row_heights) + header + footer - 0.65
    page = Page(_FIGURE_WIDTH, height)
    margins = {"left": _LEFT, "right": _RIGHT, "top": 1 - header / height, "bottom": footer / height}
    grid = page.add_gridspec(len(row_heights), n_columns, hspace=_ROW_GAP, wspace=_COLUMN_GAP, height_ratios=row_heights, **margins)
    for k, shown in enumerate(panels):
        row, column = divmod(k, n_columns)
        cell = grid[row, column:] if k == len(panels) - 1 else grid[row, column]  # the last one fills its row
        panel = _plot_reading(page, cell, *shown)
        if not has_strip:
            draw_event_lines(panel, event_times)
        if row == n_rows - 1:
            _label_time(panel)
    if has_strip:
        _label_time(draw_event_strip(page, grid[n_rows, :], run.times, event_times))
    return page


def diagnostics_figure(run: Trajectory) -> Page:
    """Draw what is zero in an exact run: the widest joint gap, and the change of the energy that is not explained by work and losses."""
    _check_times(run)
    height = 2 * _ROW_HEIGHT + 0.85
    page = Page(_FIGURE_WIDTH, height)
    margins = {"left": _LEFT, "right": _RIGHT, "top": 1 - _HEADER_HEIGHT / height, "bottom": _FOOTER_HEIGHT / height}
    grid = page.add_gridspec(2, 1, hspace=_ROW_GAP, **margins)
    drift = np.abs(run.energy.jacobi - run.energy.jacobi[0]) / run.energy.scale
    unit, factor = display_unit_of("m")
    size_in_units = max(part.mechanism.length_scale for part in run.scene.parts) * factor
    _plot_error(page, grid[0, 0], run.times, run.joint_gap * factor, f"Widest joint gap [{unit}]", size_in_units)
    _label_time(_plot_error(page, grid[1, 0], run.times, drift, "Energy drift, relative to the energy scale", 1.0))
    _write_closing_lines(page, run)
    return page


def _check_times(run: Trajectory) -> None:
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to plot; its message: {run.message}")


def _is_constant(reading: ShownReading) -> bool:
    return bool(np.ptp(reading.values) <= READING_NOISE_RATIO * reading.scale)


def _list_unplotted(constants: Mapping[str, ShownReading], even: Mapping[str, ShownReading], run: Trajectory) -> str:
    """Return the readings that stay constant, with their values, and the angles that turn evenly, with their speeds, as a line."""
    values, (turning, rpm) = [], display_unit_of("rad/s")
    for name, reading in constants.items():
        unit, factor = display_unit_of(reading.unit)
        value = float(reading.values[0])
        is_zero = abs(value) <= max(_ROUNDING * reading.scale, reading.error)
        values.append(f"{format_name(name)} {0.0 if is_zero else value * factor:.6g} {unit}".rstrip())
    rates = {name: float(one.values[-1] - one.values[0]) / float(np.ptp(run.times)) for name, one in even.items()}
    speeds = [f"{format_name(name)} at {rate * rpm:.4g} {turning}" for name, rate in rates.items()]
    words = [f"{kind}: {', '.join(those)}" for kind, those in (("constant", values), ("turning evenly", speeds)) if those]
    return textwrap.shorten("; ".join(words), _MAX_FOOTER_LETTERS, placeholder=" …")


def _list_others(run: Trajectory, names: Sequence[str]) -> list[str]:
    """Return lines on readings that are not drawn, and on how they are; none without any."""
    if not names:
        return []
    plotted = [name_to_plot(run, name) for name in names]
    text = f'run.plot("{plotted[0]}") draws one '
    text += "more reading" if len(names) == 1 else f"of {len(names)} more readings: {', '.join(plotted)}"
    return textwrap.wrap(text, _MAX_FOOTER_LETTERS, max_lines=2, placeholder=" …")


def _draw_key(page: Page, handles: list[Artist], height: float) -> None:
    """Draw a legend in a line at a height, as a fraction of the figure."""
    position: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (0.02, height), "ncols": len(handles)}
    spacing = {"borderpad": 0.0, "borderaxespad": 0.0, "handlelength": 2.2, "columnspacing": 1.6}
    add_legend(page, {"color": MUTED}, handles=handles, prop={"family": SANS_FONT, "size": 8}, **position, **spacing)


def _write_closing_lines(page: Page, run: Trajectory, others: Sequence[str] = ()) -> None:
    """Write the title of the scene above, and other lines, outcome and accuracy below."""
    height = float(page.get_figheight())
    page.write_title(run.scene.title, y=1 - 0.27 / height)
    lines, is_failure = format_closing_lines(run, _MAX_FOOTER_LETTERS)
    y_positions = (0.16,) if len(lines) == 1 else (0.26, 0.10)
    for number, text in enumerate(reversed(others), start=1):
        page.write_footnote(text, y=(y_positions[0] + number * _LINE_HEIGHT) / height, size=8.5, va="center")
    for text, y in zip(lines, y_positions, strict=True):
        page.write_footnote(text, y=y / height, size=8.5, va="center", color=VERMILLION if is_failure else MUTED)


def _plot_reading(page: Page, cell: SubplotSpec, shown: PlotPanel, band: RangeBand | None) -> Panel:
    """Plot one reading with its error estimate."""
    (curve,) = shown.curves
    heading = format_label(shown.name, shown.unit)
    panel = _add_panel(page, cell, heading)
    if band is None:
        panel.plot(curve.times, curve.values, color=curve.colour, linewidth=LINE_WIDTH)
    else:
        draw_range_band(panel, band, curve.colour)
        panel.set_xlim(curve.times[0], curve.times[-1])
    panel.set_ylim(shown.limits)
    format_plain_ticks(panel.yaxis, shown.limits)
    if curve.error > 0:
        note = f"error estimate {format_rounded_up(curve.error)} {shown.unit}".rstrip()
        is_narrow = _LETTER_PIXELS * (len(heading) + len(note)) > panel.bbox.width
        _write_side_note(panel, note.replace("error estimate", "error") if is_narrow else note)
    return panel


def _label_time(panel: Panel) -> None:
    panel.label("Time [s]", color=MUTED, fontsize=8, fontfamily=SANS_FONT)


def _plot_error(page: Page, cell: SubplotSpec, times: FloatArray, values: FloatArray, heading: str, reference_scale: float) -> Panel:
    """Plot a quantity that is zero in an exact run on a logarithmic axis; below 4 machine epsilons of the reference scale it is zero."""
    panel = _add_panel(page, cell, heading)
    zero = 4 * np.finfo(float).eps * reference_scale
    if values.max() <= zero:
        panel.set(xlim=(times[0], max(times[-1], times[0] + 1e-9)), yticks=[])
        note = panel.write_note("zero to rounding", (0.5, 0.5), xycoords="axes fraction", fontsize=9, ha="center", va="center")
        note.set(color=MUTED, backgroundcolor=PAPER)
        return panel
    panel.set_yscale("log")
    panel.plot(times, np.maximum(values, zero), color=VERMILLION, linewidth=0.9)
    low, high = (10.0 ** math.floor(math.log10(max(v, zero))) for v in (np.percentile(values, 5), values.max()))
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
