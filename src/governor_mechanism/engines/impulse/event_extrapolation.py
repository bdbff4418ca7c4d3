"""Richardson extrapolation of event times over runs of one scene, each with half the step of the one before."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise

import numpy as np

from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.types import BoolArray, FloatArray

MIN_EVENT_TIME_ERROR_RATIO = 0.05
"""Smallest error of an extrapolated time relative to the difference of the last two runs: a closer agreement can be chance."""

SAME_STEP_TOLERANCE, SAME_STEP_ERROR_RATIO = 1e-9, 0.01
"""Relative difference up to which runs have reached an event by the same step, and the error of such a step relative to its length."""


@dataclass(frozen=True)
class ExtrapolatedEvents:
    """Events at their extrapolated times, and the largest error of these times.

    `impact_intervals` (s) contain the time of each impact in all runs; `extrapolation_intervals` (s) lie between the time of each impact in
    the last run and its extrapolated time. `time_error` is in seconds; `is_matched` states whether all runs have the same events.
    """

    events: tuple[Event, ...] = ()
    impact_intervals: tuple[tuple[float, float], ...] = ()
    extrapolation_intervals: tuple[tuple[float, float], ...] = ()
    time_error: float = 0.0
    is_matched: bool = True

    def wrong_side_error(self, times: FloatArray) -> float:
        """Return the largest impact-time error (s) of the last run whose interval contains one of the times (n,) s.

        At such a time either the last run or the exact motion is past the impact and the other is not, so its values are not comparable.
        """
        return max((high - low for low, high in self.extrapolation_intervals if are_in_intervals(times, [(low, high)]).any()), default=0.0)


def extrapolate_events(
    event_logs: Sequence[Sequence[Event]],
    end_time: float,
    first_step: float,
    min_error_ratio: float = MIN_EVENT_TIME_ERROR_RATIO,
    settled_difference: float = math.inf,
) -> ExtrapolatedEvents:
    """Extrapolate each event of the last log from the nearest events of its kind in the other logs, up to `end_time` (s).

    The error of a time is at least `min_error_ratio` of the difference of the last two runs. Where that exceeds `settled_difference` (s),
    nothing is known of what follows.
    An event within the first step (s) of all runs is reached by one step of the same length in each: their agreement says nothing.
    """
    finest, time_error, is_matched = event_logs[-1], 0.0, len({len(log) for log in event_logs}) == 1
    events, impact_intervals, extrapolation_intervals = [], [], []
    for event in finest:
        known = [time for log in event_logs if (time := _nearest_event_time(event, log)) is not None]
        if len(known) < len(event_logs):
            time_error, is_matched = max(time_error, end_time - event.time), False
        extrapolated = [fine + (fine - coarse) / 3 for coarse, fine in pairwise(known)]
        best_time = extrapolated[-1] if extrapolated else event.time
        events.append(replace(event, time=best_time))
        if event.kind == EventKind.IMPACT:
            impact_intervals.append((min(known), max(known)))
            extrapolation_intervals.append((min(event.time, best_time), max(event.time, best_time)))
        if len(known) > 1 and event.time < first_step and max(known) - min(known) <= SAME_STEP_TOLERANCE * event.time:
            time_error = max(time_error, SAME_STEP_ERROR_RATIO * event.time)
        if len(known) > 1 and abs(known[-1] - known[-2]) > settled_difference:
            time_error = max(time_error, end_time - event.time)
        if len(extrapolated) > 1:
            time_error = max(time_error, abs(extrapolated[-1] - extrapolated[-2]), min_error_ratio * abs(known[-1] - known[-2]))
    for event in chain.from_iterable(log for log in event_logs if len(log) != len(finest)):
        time = _nearest_event_time(event, finest)
        time_error = max(time_error, end_time - event.time if time is None else abs(time - event.time))
    return ExtrapolatedEvents(tuple(events), tuple(impact_intervals), tuple(extrapolation_intervals), time_error, is_matched)


def _nearest_event_time(event: Event, others: Sequence[Event]) -> float | None:
    """Return the time (s) of the nearest event of the same kind and subject, or None."""
    times = [other.time for other in others if (other.kind, other.subject) == (event.kind, event.subject)]
    return min(times, key=lambda time: abs(time - event.time), default=None)


def are_in_intervals(times: FloatArray, intervals: Iterable[tuple[float, float]]) -> BoolArray:
    """Return a mask of the times (n,) s that lie in any of the intervals (s)."""
    is_inside = np.zeros(len(times), dtype=np.bool_)
    for low, high in intervals:
        is_inside |= (times >= low) & (times <= high)
    return is_inside
