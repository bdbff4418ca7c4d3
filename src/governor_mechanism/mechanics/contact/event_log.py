"""Event logs: compare those of two runs, and remove events that cancel each other or belong to the start."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.types import FloatArray


def compare_event_logs(
    better: Sequence[Event],
    worse: Sequence[Event],
    times: FloatArray,  # reported times common to both, s; shape (n,)
    time_tolerance: float,  # distance from an event within which states are not comparable, s
) -> tuple[float, NDArray[np.bool_]]:
    """Compare the contact events of two runs of one scene.

    Result: largest difference in time of corresponding events, s, and for each time whether it is too close
    to an event to be compared. An event missing in one run counts with the time to the nearest event of its
    kind and subject there, or to the end, whichever is less.
    """
    largest_delay, is_near_event = 0.0, np.zeros(len(times), dtype=np.bool_)
    end = float(times[-1]) if len(times) else 0.0
    for events, others in ((better, worse), (worse, better)):
        for event in events:
            if event.time > end:
                continue
            time_differences = [
                abs(event.time - other.time) for other in others if (event.kind, event.subject) == (other.kind, other.subject)
            ]
            largest_delay = max(largest_delay, min([*time_differences, max(end - event.time, time_tolerance)]))
            is_near_event |= np.abs(times - event.time) <= time_tolerance
    return largest_delay, is_near_event


def select_start_events(events: Sequence[Event]) -> list[Event]:
    """Return which events of the start of a motion happen to it: strikes, and rests on the stops that were struck.

    The others describe the state in which it starts: what rests or sticks there has not moved before.

    Result: those that happen, in the same order.
    """
    struck = {event.subject for event in events if event.kind == EventKind.IMPACT}
    return [event for event in events if event.subject in struck and event.kind in (EventKind.IMPACT, EventKind.REST)]


OPPOSITE_EVENTS = {EventKind.SLIP: EventKind.STICK, EventKind.SEPARATION: EventKind.REST}
OPPOSITE_EVENTS |= {opposite: kind for kind, opposite in OPPOSITE_EVENTS.items()}
"""Event that each kind of event reverses."""


def drop_cancelled_events(
    events: Sequence[Event],
    time_tolerance: float,  # times closer than this are the same, s
) -> tuple[Event, ...]:
    """Remove pairs of opposite events of one contact at the same time, as when one contact hands its load to another.

    Result: remaining events, in the same order.
    """
    remaining: list[Event] = []
    for event in events:
        cancelled = [
            index
            for index, other in enumerate(remaining)
            if other.subject == event.subject
            and other.kind == OPPOSITE_EVENTS.get(event.kind)
            and abs(event.time - other.time) <= time_tolerance
        ]
        if cancelled:
            del remaining[cancelled[-1]]
        else:
            remaining.append(event)
    return tuple(remaining)
