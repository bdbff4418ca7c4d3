"""Marks of what a run passed: lines across its plots where they are few, a rug of ticks where they are many."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from governor_mechanism.model.events import Event
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.style import GREEN, INK, MUTED, SANS_FONT, SERIES_COLOURS, SKY, VERMILLION

_MAX_EVENT_LINES = 30
"""So many events are marked by a line each."""
_RUG_HEIGHT_RATIO = 0.09
"""Height of a rug's ticks, of the plot's."""
_MAX_NAMED_KINDS = 6
"""So many kinds are named."""

_EVENT_STYLES: dict[str, tuple[str, Any]] = {
    "sticks": (VERMILLION, (0, (4, 2))),
    "rests on its stop": (SERIES_COLOURS[3], (0, (1, 1.5))),
    "slips": (GREEN, (0, (4, 2))),
    "leaves its stop": (SKY, (0, (1, 1.5))),
    "strikes its stop": (INK, (0, (1, 2))),
}
_OTHER_EVENT_STYLE = (MUTED, (0, (5, 2, 1, 2)))
"""Colour and dashes of a kind's lines."""


def reported_events(run: Trajectory) -> list[Event]:
    """The events between a run's first reported time and its last one."""
    return [event for event in run.events if run.times[0] <= event.time <= run.times[-1]]


def draw_event_markers(axes: Axes, events: Sequence[Event]) -> None:
    """A mark at each event's time."""
    few = len(events) <= _MAX_EVENT_LINES
    for kind in dict.fromkeys(event.kind for event in events):
        colour, dashes = _EVENT_STYLES.get(kind, _OTHER_EVENT_STYLE)
        times = [event.time for event in events if event.kind == kind]
        lines = axes.vlines(times, 0.0, 1.0 if few else _RUG_HEIGHT_RATIO, transform=axes.get_xaxis_transform(), colors=colour)
        lines.set(linewidth=0.8, zorder=1, linestyle=dashes if few else "solid", gid=kind)


def draw_event_legend(figure: Figure, events: Sequence[Event], height: float) -> None:
    """A line of words on what the marks mean, `middle` of the figure's height up: each kind, and how many."""
    few, counts = len(events) <= _MAX_EVENT_LINES, Counter(event.kind for event in events)
    handles = []
    for kind, count in list(counts.items())[:_MAX_NAMED_KINDS]:
        colour, dashes = _EVENT_STYLES.get(kind, _OTHER_EVENT_STYLE)
        label = kind if count == 1 else f"{kind} ({count})"
        handles.append(Line2D([], [], color=colour, linestyle=dashes if few else "solid", linewidth=1.2, label=label))
    legend = figure.legend(
        handles=handles,
        loc="center left",
        bbox_to_anchor=(0.02, height),
        ncols=len(handles),
        frameon=False,
        borderpad=0.0,
        borderaxespad=0.0,
        handlelength=2.2,
        columnspacing=1.6,
        prop={"family": SANS_FONT, "size": 8},
    )
    for text in legend.get_texts():
        text.set_color(MUTED)
