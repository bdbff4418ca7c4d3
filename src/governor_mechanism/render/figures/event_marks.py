"""Marks of events in figures over time: lines through the panels, or a strip with a row for each kind."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D

from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.render.figures.page import SERIES_LINE_STYLES, Page, Panel
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import GREEN, INK, MUTED, SERIES_COLOURS, SKY, VERMILLION
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
