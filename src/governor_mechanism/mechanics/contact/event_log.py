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
    """Return the largest difference in time (s) of events of two runs, and which times are too close to an event to be compared."""
    # An event missing in one run counts with the time to the nearest event of its kind and subject
    # there, or to the end, whichever is less.
    largest_delay, is_near_event = 0.0, np.zeros(len(times), dtype=np.bool_)
    end = float(times[-1]) if len(times) else 0.0
    for events, others in ((better, worse), (worse, better)):
        counted = [event for event in events if event.time <= end]
        other_times = _times_by_kind(others)
        if not counted:
            continue
        for kind, event_times in _times_by_kind(counted).items():
            delays = _distances_to_nearest(event_times, other_times.get(kind, np.empty(0)))
            largest_delay = max(largest_delay, float(np.max(np.minimum(delays, np.maximum(end - event_times, time_tolerance)))))
        is_near_event |= _distances_to_nearest(times, np.sort([event.time for event in counted])) <= time_tolerance
    return largest_delay, is_near_event


def _times_by_kind(events: Sequence[Event]) -> dict[tuple[EventKind, str], FloatArray]:
    """Return the times (s) of the events of each kind and subject, in ascending order."""
    times: dict[tuple[EventKind, str], list[float]] = {}
    for event in events:
        times.setdefault((event.kind, event.subject), []).append(event.time)
    return {kind: np.sort(values) for kind, values in times.items()}


def _distances_to_nearest(times: FloatArray, others: FloatArray) -> FloatArray:
    """Return the distance of each time from the nearest of others in ascending order; infinity if there is none."""
    bounded = np.concatenate([[-np.inf], others, [np.inf]])
    behind = np.searchsorted(bounded, times)
    distances: FloatArray = np.minimum(bounded[behind] - times, times - bounded[behind - 1])
    return distances


def select_start_events(events: Sequence[Event]) -> list[Event]:
    """Return in their order the events of the start that happen to a motion: strikes, and rests on the stops that were struck."""
    # The others describe the state in which it starts: what rests or sticks there has not moved before.
    struck = {event.subject for event in events if event.kind == EventKind.IMPACT}
    return [event for event in events if event.subject in struck and event.kind in (EventKind.IMPACT, EventKind.REST)]


OPPOSITE_EVENTS = {EventKind.SLIP: EventKind.STICK, EventKind.SEPARATION: EventKind.REST}
OPPOSITE_EVENTS |= {opposite: kind for kind, opposite in OPPOSITE_EVENTS.items()}
"""Event that each kind of event reverses."""


def drop_cancelled_events(
    events: Sequence[Event],
    time_tolerance: float,  # times closer than this are the same, s
) -> tuple[Event, ...]:
    """Drop pairs of opposite events of one contact at the same time, as when one contact hands its load to another."""
    remaining: dict[int, Event] = {}
    numbers: dict[tuple[EventKind, str], list[int]] = {}
    for number, event in enumerate(events):
        opposite = numbers.get((OPPOSITE_EVENTS.get(event.kind, event.kind), event.subject), [])
        is_cancelled = event.kind in OPPOSITE_EVENTS and opposite and abs(event.time - remaining[opposite[-1]].time) <= time_tolerance
        if is_cancelled:
            del remaining[opposite.pop()]
        else:
            remaining[number] = event
            numbers.setdefault((event.kind, event.subject), []).append(number)
    return tuple(remaining.values())
