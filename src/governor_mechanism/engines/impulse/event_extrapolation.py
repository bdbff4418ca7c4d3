"""Events of marches of one scene, each with half the step of the one before, compared and extrapolated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.events import STRIKES, Event
from governor_mechanism.types import FloatArray

DOUBT = 0.01
"""Of the difference between the last two marches: what extrapolated times may agree in by chance."""


@dataclass(frozen=True)
class Happened:
    """Events at their extrapolated times, and how late (s) they may be.

    strikes: between which times (s) the marches passed each strike; passed: between that of the last march, and the
    extrapolated one.
    """

    events: tuple[Event, ...] = ()
    strikes: tuple[tuple[float, float], ...] = ()
    passed: tuple[tuple[float, float], ...] = ()
    late: float = 0.0

    def near(self, times: FloatArray, apart: float) -> NDArray[np.bool_]:
        """Which times (n,) s lie within `apart` (s) of an event."""
        found = np.zeros(len(times), dtype=np.bool_)
        for event in self.events:
            found |= np.abs(times - event.time) <= apart
        return found

    def early(self, times: FloatArray) -> float:
        """How far (s) the last march is off at a strike that it, or the motion, is beyond at one of these times (n,) s
        and the other is not: what is told of that time is of the wrong side."""
        return max((high - low for low, high in self.passed if np.any((times >= low) & (times <= high))), default=0.0)

    def between(self, times: FloatArray) -> NDArray[np.bool_] | None:
        """Which times (n,) s lie where some marches have struck a stop and others not yet; None for none."""
        found = np.zeros(len(times), dtype=np.bool_)
        for low, high in self.strikes:
            found |= (times >= low) & (times <= high)
        return found if found.any() else None


def compare(marches: Sequence[Sequence[Event]], end: float) -> Happened:
    """The events of the last march up to `end` (s), extrapolated from the nearest of their kind in those before."""
    finest, late = marches[-1], 0.0
    found, strikes, passed = [], [], []
    for event in finest:
        times = [_nearest(event, others) for others in marches]
        known = [time for time in times if time is not None]
        if event.kind == STRIKES:
            strikes.append((min(known), max(known)))
        if len(known) < len(marches):
            late = max(late, end - event.time)
        extrapolated = [fine + (fine - coarse) / 3 for coarse, fine in pairwise(known)]
        if event.kind == STRIKES and extrapolated:
            passed.append((min(known[-1], extrapolated[-1]), max(known[-1], extrapolated[-1])))
        found.append(replace(event, time=extrapolated[-1] if extrapolated else event.time))
        if len(extrapolated) > 1:
            late = max(late, abs(extrapolated[-1] - extrapolated[-2]), DOUBT * abs(known[-1] - known[-2]))
    for others in marches[:-1]:
        for event in others:
            time = _nearest(event, finest)
            if len(others) != len(finest):
                late = max(late, end - event.time if time is None else abs(time - event.time))
    return Happened(tuple(found), tuple(strikes), tuple(passed), late)


def _nearest(event: Event, others: Sequence[Event]) -> float | None:
    """The time (s) of the nearest event of the same kind about the same reading."""
    times = [other.time for other in others if (other.kind, other.subject) == (event.kind, event.subject)]
    return min(times, key=lambda time: abs(time - event.time), default=None)
