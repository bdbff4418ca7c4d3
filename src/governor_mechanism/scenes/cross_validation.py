"""What the tables of a scene file say against each other, where each by itself is right: a sentence for each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import PLAY, Play
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import TURNING, FreeSpindle, Part, Spindle, Start
from governor_mechanism.units.quantities import spoken

UNITS = {"angle": "rad", "length": "m"}


def against_each_other(
    part: Part | None,
    effects: tuple[Effect, ...],
    spindle: Spindle | FreeSpindle,
    start: Start,
    tables: Mapping[str, Mapping[str, Any]],
) -> Iterable[str]:
    """All of it; `part` is None where the mechanism is not known."""
    if "spindle" not in tables and any(isinstance(effect, Centrifugal) for effect in effects):
        yield 'effects.centrifugal = true needs a spindle that turns; add [spindle] with a line speed = "120 rpm"'
    yield from _idle(part, spindle, tables)
    yield from _waves(spindle, tables)
    yield from _stops_beside_play(effects)
    for stops, key in _stops(effects):
        yield from tuple(_nothing_left(stops, key, part)) or _start_beyond(stops, key, start, part)


def _idle(part: Part | None, spindle: Spindle | FreeSpindle, tables: Mapping[str, Mapping[str, Any]]) -> Iterable[str]:
    """A spindle and a mechanism that do not act upon each other as the file says."""
    turning = part is not None and part.plane == TURNING
    fixed = part is not None and not turning
    centrifugal = tables.get("effects", {}).get("centrifugal", False)
    if isinstance(spindle, FreeSpindle) and turning and centrifugal is False:
        yield (
            "effects.centrifugal = true is missing: a free spindle is slowed by what turns with it; "
            "add it, or give spindle.speed"
        )
    if isinstance(spindle, FreeSpindle) and fixed:
        yield f'spindle.inertia: nothing turns with it in a fixed plane; write plane = "{TURNING}", or leave it out'
    if fixed and centrifugal is True:
        yield f'effects.centrifugal = true needs a plane that turns; write plane = "{TURNING}", or leave it out'
    uneven = isinstance(spindle, Spindle) and spindle.unevenness > 0
    if uneven and fixed:
        yield (
            "spindle.unevenness changes nothing: the mechanism lives in a fixed plane; "
            f'write plane = "{TURNING}", or leave it out'
        )
    elif uneven and centrifugal is False:
        yield (
            "spindle.unevenness changes nothing: without effects.centrifugal = true nothing feels the spindle turn; "
            "add it, or leave unevenness out"
        )


def _waves(spindle: Spindle | FreeSpindle, tables: Mapping[str, Mapping[str, Any]]) -> Iterable[str]:
    given = tables.get("spindle", {})
    if isinstance(spindle, Spindle) and "waves" in given and "unevenness" not in given:
        yield "spindle.waves says how often unevenness comes in a turn; write unevenness = 0.03, or leave waves out"


def _stops(effects: Iterable[Effect]) -> Iterable[tuple[Stops, str]]:
    """All stops, those of play too, each with the key that they come from."""
    for effect in effects:
        if isinstance(effect, Stops):
            yield effect, f"effects.stops.{effect.reading}"
        elif isinstance(effect, Play):
            yield effect.stops, "effects.play"


def _stops_beside_play(effects: Iterable[Effect]) -> Iterable[str]:
    kinds = {(type(effect), getattr(effect, "reading", "")) for effect in effects}
    if {(Play, ""), (Stops, PLAY)} <= kinds:
        yield f"effects.stops.{PLAY} cannot stand beside effects.play, whose two ends are such stops; leave it out"


def _start_beyond(stops: Stops, key: str, start: Start, part: Part | None) -> Iterable[str]:
    """A start that stops exclude; on a stop it may begin."""
    value = start.values.get(stops.reading)
    if not isinstance(value, str) and value is not None and not stops.low <= value <= stops.high:
        unit = UNITS.get(part.mechanism.reading(stops.reading).quantity, "") if part else ""
        yield (
            f"start.{stops.reading} ({spoken(value, unit)}) lies beyond the stops of {key}, "
            f"{_range(stops.low, stops.high, unit)}; start between them"
        )


def _nothing_left(stops: Stops, key: str, part: Part | None) -> Iterable[str]:
    """Stops that leave nothing of the travel in which the mechanism can be assembled."""
    mechanism: Mechanism | None = part.mechanism if part else None
    for limit in mechanism.limits if mechanism else ():
        if limit.reading == stops.reading and mechanism and (stops.high <= limit.low or stops.low >= limit.high):
            unit = UNITS.get(mechanism.reading(stops.reading).quantity, "")
            yield (
                f"{key}, {_range(stops.low, stops.high, unit)}, leaves nothing of the travel, "
                f"{_range(limit.low, limit.high, unit)}"
            )


def _range(low: float, high: float, unit: str) -> str:
    low_end, high_end = ("none" if math.isinf(end) else spoken(end, unit) for end in (low, high))
    return f"{low_end} to {high_end}"
