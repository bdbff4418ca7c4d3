"""Events of a run: time, kind and reading; and named crossings that a scene asks for."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.units.fields import entry

CROSSING_DIRECTIONS: Final = ("up", "down", "both")
"""Directions of a named crossing: the reading rises through the value, falls through it, or either."""


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
    CROSSING = "crossing"


@dataclass(frozen=True, kw_only=True)
class Event:
    """An event of a run."""

    time: float  # time of the event, s
    kind: EventKind  # kind of the event
    subject: str  # name of the reading, "the mechanism" for a change point, or the name of a crossing

    def __str__(self) -> str:
        if self.kind in (EventKind.TURNING_POINT, EventKind.CHANGE_POINT):
            return f"{self.kind} of {self.subject} at t = {self.time:.6g} s"
        if self.kind == EventKind.CROSSING:
            return f"{self.kind} {self.subject} at t = {self.time:.9g} s"
        return f"{self.subject} {self.kind} at t = {self.time:.9g} s"


@dataclass(frozen=True, kw_only=True)
class NamedCrossing:
    """A named event: a reading, or the speed of a shaft or spindle, passes through a value.

    The reading must lie beyond the value on both sides by more than the error of the run. So a reading that starts at the value, touches
    it, or reaches it and stays, does not cross it; one that leaves it to the other side after a rest crosses it when it leaves.
    """

    name: str  # name of the event
    # name of the reading or speed
    reading: str = entry("watched reading", meaning='the reading or speed that is watched, as "arm_angle" or "engine.shaft_speed"')
    # value that it passes, SI; an angle is continuous over full turns, as the run reports it
    value: float = entry("watched value", meaning='the value that the reading passes, as "20 mm"')
    # one of CROSSING_DIRECTIONS
    direction: str = entry(
        "choice", words=CROSSING_DIRECTIONS, default="both", meaning="whether the reading rises or falls through the value, or either"
    )

    def __post_init__(self) -> None:
        require_finite(self.value, "", f"value of the crossing {self.name!r}")
        if self.direction not in CROSSING_DIRECTIONS:
            allowed = ", ".join(CROSSING_DIRECTIONS)
            raise MechanismError(f"direction of the crossing {self.name!r} must be one of {allowed}; got {self.direction!r}")

    @property
    def n_per_period(self) -> int:
        """Number of crossings in a period: two where both directions count."""
        return 2 if self.direction == "both" else 1
