"""Events of marches of one scene, each with half the step of the one before, compared and extrapolated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.types import FloatArray

MIN_EVENT_TIME_ERROR_RATIO = 0.01
"""Of the difference between the last two marches: what extrapolated times may agree in by chance."""


@dataclass(frozen=True)
class ExtrapolatedEvents:
    """Events at their extrapolated times, and how late (s) they may be.

    strikes: between which times (s) the marches passed each strike; passed: between that of the last march, and the
    extrapolated one.
    """

    events: tuple[Event, ...] = ()
    impact_intervals: tuple[tuple[float, float], ...] = ()
    extrapolation_intervals: tuple[tuple[float, float], ...] = ()
    time_error: float = 0.0

    def are_near_events(self, times: FloatArray, tolerance: float) -> NDArray[np.bool_]:
        """Which times (n,) s lie within `apart` (s) of an event."""
        near = np.zeros(len(times), dtype=np.bool_)
        for event in self.events:
            near |= np.abs(times - event.time) <= tolerance
        return near

    def wrong_side_error(self, times: FloatArray) -> float:
        """How far (s) the last march is off at a strike that it, or the motion, is beyond at one of these times (n,) s
        and the other is not: what is told of that time is of the wrong side."""
        return max((high - low for low, high in self.extrapolation_intervals if np.any((times >= low) & (times <= high))), default=0.0)

    def are_between_impacts(self, times: FloatArray) -> NDArray[np.bool_] | None:
        """Which times (n,) s lie where some marches have struck a stop and others not yet; None for none."""
        between = np.zeros(len(times), dtype=np.bool_)
        for low, high in self.impact_intervals:
            between |= (times >= low) & (times <= high)
        return between if between.any() else None


def extrapolate_events(event_logs: Sequence[Sequence[Event]], end_time: float) -> ExtrapolatedEvents:
    """The events of the last march up to `end` (s), extrapolated from the nearest of their kind in those before."""
    finest, time_error = event_logs[-1], 0.0
    events, impact_intervals, extrapolation_intervals = [], [], []
    for event in finest:
        times = [_nearest_event_time(event, coarser) for coarser in event_logs]
        known = [time for time in times if time is not None]
        if event.kind == EventKind.IMPACT:
            impact_intervals.append((min(known), max(known)))
        if len(known) < len(event_logs):
            time_error = max(time_error, end_time - event.time)
        extrapolated = [fine + (fine - coarse) / 3 for coarse, fine in pairwise(known)]
        if event.kind == EventKind.IMPACT and extrapolated:
            extrapolation_intervals.append((min(known[-1], extrapolated[-1]), max(known[-1], extrapolated[-1])))
        events.append(replace(event, time=extrapolated[-1] if extrapolated else event.time))
        if len(extrapolated) > 1:
            time_error = max(time_error, abs(extrapolated[-1] - extrapolated[-2]), MIN_EVENT_TIME_ERROR_RATIO * abs(known[-1] - known[-2]))
    for coarser in event_logs[:-1]:
        for event in coarser:
            time = _nearest_event_time(event, finest)
            if len(coarser) != len(finest):
                time_error = max(time_error, end_time - event.time if time is None else abs(time - event.time))
    return ExtrapolatedEvents(tuple(events), tuple(impact_intervals), tuple(extrapolation_intervals), time_error)


def _nearest_event_time(event: Event, others: Sequence[Event]) -> float | None:
    """The time (s) of the nearest event of the same kind about the same reading."""
    times = [other.time for other in others if (other.kind, other.subject) == (event.kind, event.subject)]
    return min(times, key=lambda time: abs(time - event.time), default=None)
