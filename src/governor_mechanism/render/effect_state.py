"""State of a scene's effects for a drawing: which exist, which contacts are held, and recent impacts."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.mechanics.dynamics.contacts import contacts_of
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.part import Part
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.geometry.body_points import value_range
from governor_mechanism.render.part_entries import select_part_entries
from governor_mechanism.render.reading_loads import LoadFunctions, reading_load_functions

EffectT = TypeVar("EffectT", bound=Effect)
OutputEffectT = TypeVar("OutputEffectT", bound=OutputEffect)

HOLD_EVENT_KINDS = {EventKind.STICK: True, EventKind.REST: True, EventKind.SLIP: False, EventKind.SEPARATION: False}
"""Events that begin (True) or end (False) the hold of a contact."""
FLASH_DURATION = 0.25
"""Duration (s of film) for which an impact is shown."""


@dataclass(frozen=True, kw_only=True)
class StopImpact:
    """Impact on the high or the low stop at a time (s)."""

    time: float
    is_high_stop: bool


@dataclass(frozen=True, kw_only=True)
class EffectState:
    """Effects of a part and the events of the outputs on which they act, by reading, and its loads that depend on readings, by name.

    `hold_changes` are times (s) with True if the contact is held from then on; `stop_impacts` are the impacts; `reading_ranges` are the
    smallest and largest value over the run. An impact is shown for `flash_duration` seconds of the run.
    """

    effects: tuple[Effect, ...] = ()
    hold_changes: Mapping[str, tuple[tuple[float, bool], ...]] = field(default_factory=dict)
    stop_impacts: Mapping[str, tuple[StopImpact, ...]] = field(default_factory=dict)
    reading_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    flash_duration: float = FLASH_DURATION
    load_functions: Mapping[str, LoadFunctions] = field(default_factory=dict)

    def find_effect(self, kind: type[EffectT]) -> EffectT | None:
        """Return the effect of a type, or None."""
        return next((effect for effect in self.effects if isinstance(effect, kind)), None)

    def find_effect_on(self, kind: type[OutputEffectT], *readings: str) -> OutputEffectT | None:
        """Return the effect of a type on one of the readings, or None."""
        return next((effect for effect in self.effects if isinstance(effect, kind) and effect.reading in readings), None)

    def is_held(self, reading: str, time: float) -> bool:
        """Return whether dry friction or a stop holds a reading at a time (s)."""
        changes = self.hold_changes.get(reading, ())
        if not changes:
            low, high = self.reading_ranges.get(reading, (0.0, 0.0))
            return high - low <= 1e-9 * max(abs(low), abs(high))
        earlier = [is_hold for change_time, is_hold in changes if change_time <= time]
        return earlier[-1] if earlier else not changes[0][1]

    def recent_impact(self, reading: str, time: float) -> StopImpact | None:
        """Return the last impact that is still shown at a time (s), or None."""
        recent = [impact for impact in self.stop_impacts.get(reading, ()) if 0.0 <= time - impact.time < self.flash_duration]
        return recent[-1] if recent else None


NO_EFFECTS = EffectState()


def effect_state_of(run: Trajectory, part: Part, slow_down: float = 1.0) -> EffectState:
    """Return the effect state of a part of a run whose seconds take `slow_down` seconds of film."""
    ranges = {name: value_range(values) for name, values in run.readings.items()}
    stop_values = {contact.output_name: (contact.low, contact.high) for contact in contacts_of(run.scene)}
    hold_changes: dict[str, list[tuple[float, bool]]] = {}
    stop_impacts: dict[str, list[StopImpact]] = {}
    for event in run.events if stop_values else ():
        if event.kind in HOLD_EVENT_KINDS:
            hold_changes.setdefault(event.subject, []).append((event.time, HOLD_EVENT_KINDS[event.kind]))
        elif event.kind == EventKind.IMPACT and event.subject in stop_values:
            stop_impacts.setdefault(event.subject, []).append(_stop_impact(run, event, stop_values[event.subject]))
    return EffectState(
        effects=part.effects,
        hold_changes={name: tuple(changes) for name, changes in select_part_entries(run, part, hold_changes).items()},
        stop_impacts={name: tuple(impacts) for name, impacts in select_part_entries(run, part, stop_impacts).items()},
        reading_ranges=select_part_entries(run, part, ranges),
        flash_duration=FLASH_DURATION / slow_down,
        load_functions=reading_load_functions(run, part),
    )


def _stop_impact(run: Trajectory, event: Event, stop_values: tuple[float, float]) -> StopImpact:
    """Return the stop impact of an event; the nearer stop at that time is the one that is hit."""
    value = float(np.interp(event.time, run.times, run.readings[event.subject]))
    return StopImpact(time=event.time, is_high_stop=abs(value - stop_values[1]) < abs(value - stop_values[0]))


def clearance_of(part: Part, effect_state: EffectState) -> Clearance | None:
    """Return the clearance of a part, or None."""
    has_clearance_reading = any(reading.name == CLEARANCE_READING for reading in part.mechanism.readings)
    return effect_state.find_effect(Clearance) if has_clearance_reading else None
