"""What a drawing is told of a scene's effects: which there are, what sticks, and what has just struck a stop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from governor_mechanism.effects.clearance import PLAY, Play
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import Effect, OnReading
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Part
from governor_mechanism.model.trajectory import Trajectory

E = TypeVar("E", bound=Effect)
On = TypeVar("On", bound=OnReading)

HOLDS = {"sticks": True, "rests on its stop": True, "slips": False, "leaves its stop": False}
STRIKES = "strikes its stop"
FLASH = 0.25
"""Seconds of film that a strike is seen."""


@dataclass(frozen=True, kw_only=True)
class Strike:
    """A blow against a stop at a time (s): the high one, or the low one."""

    time: float
    high: bool


@dataclass(frozen=True, kw_only=True)
class Acting:
    """The effects of a scene, and what happened to what they act on.

    By reading: held tells when (s) it was held and when let go; strikes are the blows against its stops; ranges its
    least and largest value over the run. A blow is shown for `flash` seconds of the run.
    """

    effects: tuple[Effect, ...] = ()
    held: Mapping[str, tuple[tuple[float, bool], ...]] = field(default_factory=dict)
    strikes: Mapping[str, tuple[Strike, ...]] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    flash: float = FLASH

    def one(self, kind: type[E]) -> E | None:
        """The effect of that kind, where the scene lists it."""
        return next((effect for effect in self.effects if isinstance(effect, kind)), None)

    def on(self, kind: type[On], *readings: str) -> On | None:
        """The effect of that kind on one of these readings, where the scene lists it."""
        return next((each for each in self.effects if isinstance(each, kind) and each.reading in readings), None)

    def sticks(self, reading: str, time: float) -> bool:
        """Whether dry friction or a stop holds a reading at a time (s)."""
        changes = self.held.get(reading, ())
        if not changes:
            low, high = self.ranges.get(reading, (0.0, 0.0))
            return high - low <= 1e-9 * max(abs(low), abs(high))
        before = [holds for when, holds in changes if when <= time]
        return before[-1] if before else not changes[0][1]

    def struck(self, reading: str, time: float) -> Strike | None:
        """The last blow that a time (s) still shows."""
        recent = [blow for blow in self.strikes.get(reading, ()) if 0.0 <= time - blow.time < self.flash]
        return recent[-1] if recent else None


NOTHING = Acting()


def acting_of(run: Trajectory, slow: float = 1.0) -> Acting:
    """What acts in a run whose seconds take `slow` seconds of film each."""
    effects = run.scene.effects
    ranges = {name: (float(values.min()), float(values.max())) for name, values in run.readings.items()}
    if not any(isinstance(effect, DryFriction | Stops | Play) for effect in effects):
        return Acting(effects=effects, ranges=ranges)
    ends = {each.reading: (each.low, each.high) for each in run.scene.acting if isinstance(each, Stops)}
    held: dict[str, list[tuple[float, bool]]] = {}
    strikes: dict[str, list[Strike]] = {}
    for event in run.events:
        if event.kind in HOLDS:
            held.setdefault(event.subject, []).append((event.time, HOLDS[event.kind]))
        elif event.kind == STRIKES and event.subject in ends:
            strikes.setdefault(event.subject, []).append(_strike(run, event, ends[event.subject]))
    return Acting(
        effects=effects,
        held={name: tuple(changes) for name, changes in held.items()},
        strikes={name: tuple(blows) for name, blows in strikes.items()},
        ranges=ranges,
        flash=FLASH / slow,
    )


def _strike(run: Trajectory, event: Event, ends: tuple[float, float]) -> Strike:
    value = float(np.interp(event.time, run.times, run.readings[event.subject]))
    return Strike(time=event.time, high=abs(value - ends[1]) < abs(value - ends[0]))


def slot_of(part: Part, acting: Acting) -> Play | None:
    """The play of a part that has some."""
    known = any(reading.name == PLAY for reading in part.mechanism.readings)
    return acting.one(Play) if known else None
