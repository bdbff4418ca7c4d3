"""One part of a run, as its drawing needs it: poses, effects, ranges of readings, which contacts are held, and recent impacts."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray

T = TypeVar("T")
EffectT = TypeVar("EffectT", bound=Effect)

HOLD_EVENT_KINDS = {EventKind.STICK: True, EventKind.REST: True, EventKind.SLIP: False, EventKind.SEPARATION: False}
"""Events that begin (True) or end (False) the hold of a contact."""
FLASH_DURATION = 0.25
"""Duration (s of film) for which an impact is shown."""


@dataclass(frozen=True, kw_only=True)
class PartRun:
    """A part of a run whose seconds take `slow_down` seconds of film. Readings have their plain names, without that of the part.

    Positions of a run whose motion is magnified, by a factor other than 1, cannot be read off scales, which then are left out.
    """

    run: Trajectory
    part: Part
    slow_down: float = 1.0
    magnification: float = 1.0

    @property
    def is_magnified(self) -> bool:
        """Whether the motion is magnified."""
        return self.magnification != 1.0

    @property
    def _prefix(self) -> str:
        """Start of the names of the part in the run: empty for the only part, or "part."."""
        return f"{self.part.name}." if len(self.run.scene.parts) > 1 else ""

    def select_entries(self, entries: Mapping[str, T]) -> dict[str, T]:
        """Return the entries of the part from a mapping by name, by plain names."""
        return {name.removeprefix(self._prefix): value for name, value in entries.items() if name.startswith(self._prefix)}

    def select_bodies(self, states: FloatArray) -> FloatArray:
        """Return the bodies of the part, without the shaft of its spindle, of poses or velocities (n, all bodies, 3)."""
        return states[:, [self.run.scene.mechanism.body_index(self._prefix + body.name) for body in self.part.mechanism.bodies], :]

    @cached_property
    def poses(self) -> FloatArray:
        """Poses (n, bodies, 3) of the part."""
        return self.select_bodies(self.run.poses)

    def find_effect(self, kind: type[EffectT], *readings: str) -> EffectT | None:
        """Return the effect of a type, on one of the readings if there are any, or None."""
        effects = (effect for effect in self.part.effects if isinstance(effect, kind))
        return next((effect for effect in effects if not readings or getattr(effect, "reading", "") in readings), None)

    def reading_range(self, reading: str, default: Vec2 = (0.0, 0.0)) -> Vec2:
        """Return the smallest and the largest value of a reading over the run."""
        values = self.run.readings.get(self._prefix + reading)
        return default if values is None else (float(values.min()), float(values.max()))

    def is_held(self, reading: str, time: float) -> bool:
        """Return whether dry friction or a stop holds a reading at a time (s)."""
        changes = [(event.time, HOLD_EVENT_KINDS[event.kind]) for event in self._events_on(reading) if event.kind in HOLD_EVENT_KINDS]
        if not changes:
            low, high = self.reading_range(reading)
            return high - low <= 1e-9 * max(abs(low), abs(high))
        earlier = [is_hold for change_time, is_hold in changes if change_time <= time]
        return earlier[-1] if earlier else not changes[0][1]

    def struck_side(self, reading: str, time: float) -> int:
        """Return 1 for the high and -1 for the low stop of the last impact that is still shown at a time (s), or 0."""
        impacts = (event for event in self._events_on(reading) if event.kind == EventKind.IMPACT)
        recent = [event for event in impacts if 0.0 <= time - event.time < FLASH_DURATION / self.slow_down]
        if not recent:
            return 0
        # The nearer stop is the one that is hit.
        name = self._prefix + reading
        value = float(np.interp(recent[-1].time, self.run.times, self.run.readings[name]))
        contact = next(contact for contact in contacts_of(self.run.scene) if contact.output_name == name)
        return 1 if abs(value - contact.high) < abs(value - contact.low) else -1

    def _events_on(self, reading: str) -> list[Event]:
        return self._contact_events.get(self._prefix + reading, [])

    @cached_property
    def _contact_events(self) -> Mapping[str, list[Event]]:
        """Events of the run by subject; empty without contacts, whose events need no search."""
        events: defaultdict[str, list[Event]] = defaultdict(list)
        for event in self.run.events if contacts_of(self.run.scene) else ():
            events[event.subject].append(event)
        return events
