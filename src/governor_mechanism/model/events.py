"""Events of a run: time, kind and reading."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class EventKind(StrEnum):
    """Kind of an event. Each value is a predicate whose subject is the reading."""

    STICK = "sticks"
    SLIP = "slips"
    IMPACT = "strikes its stop"
    REST = "rests on its stop"
    SEPARATION = "leaves its stop"
    SLACK = "goes slack"
    TAUT = "pulls again"
    TURNING_POINT = "turning point"
    CHANGE_POINT = "change point"


@dataclass(frozen=True, kw_only=True)
class Event:
    """An event of a run.

    Attributes
    ----------
    time
        Time of the event, s.
    kind
        Kind of the event.
    subject
        Name of the reading, or "the mechanism" for a change point.
    """

    time: float
    kind: EventKind
    subject: str

    def __str__(self) -> str:
        if self.kind in (EventKind.TURNING_POINT, EventKind.CHANGE_POINT):
            return f"{self.kind} of {self.subject} at t = {self.time:.6g} s"
        return f"{self.subject} {self.kind} at t = {self.time:.9g} s"
