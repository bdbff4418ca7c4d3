"""Event markers on time axes: a line per event, or a rug of ticks for many events."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.render.figures.page import add_legend
from governor_mechanism.render.style import GREEN, INK, MUTED, SANS_FONT, SERIES_COLOURS, SKY, VERMILLION

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


def draw_event_markers(axes: Axes, events: Sequence[Event]) -> None:
    """Draw a marker at the time of each event."""
    height = 1.0 if len(events) <= _MAX_EVENT_LINES else _RUG_HEIGHT_RATIO
    for (label, colour, dashes), times in _times_by_style(events).items():
        lines = axes.vlines(times, 0.0, height, transform=axes.get_xaxis_transform(), colors=colour)
        lines.set(linewidth=0.8, zorder=1, linestyle=dashes, gid=label)


def draw_event_legend(figure: Figure, events: Sequence[Event], height: float) -> None:
    """Draw a one-line legend of the event kinds and named crossings with their numbers at a height, as a fraction of the figure."""
    handles = [
        Line2D([], [], color=colour, linestyle=dashes, linewidth=1.2, label=name if len(times) == 1 else f"{name} ({len(times)})")
        for (name, colour, dashes), times in list(_times_by_style(events).items())[:_MAX_NAMED_KINDS]
    ]
    position: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (0.02, height), "ncols": len(handles)}
    spacing = {"borderpad": 0.0, "borderaxespad": 0.0, "handlelength": 2.2, "columnspacing": 1.6}
    add_legend(figure, {"color": MUTED}, handles=handles, prop={"family": SANS_FONT, "size": 8}, **position, **spacing)


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
