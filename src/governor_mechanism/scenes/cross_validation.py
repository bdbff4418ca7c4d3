"""What the tables of a scene file say against each other, where each by itself is right: a sentence for each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import TURNING_PLANE, FreeSpindle, Part, Spindle, Start
from governor_mechanism.units.quantities import format_quantity

_SI_UNITS = {"angle": "rad", "length": "m"}


def check_tables_together(
    part: Part | None, effects: tuple[Effect, ...], spindle: Spindle | FreeSpindle, start: Start, tables: Mapping[str, Mapping[str, Any]]
) -> Iterable[str]:
    """All of it; `part` is None where the mechanism is not known."""
    if "spindle" not in tables and any(isinstance(effect, Centrifugal) for effect in effects):
        yield 'effects.centrifugal = true needs a spindle that turns; add [spindle] with a line speed = "120 rpm"'
    yield from _check_spindle_and_plane(part, spindle, tables)
    yield from _check_cycles_per_turn(spindle, tables)
    yield from _check_stops_and_clearance(effects)
    for stops, key in _iterate_stops(effects):
        yield from tuple(_check_remaining_travel(stops, key, part)) or _check_start_within_stops(stops, key, start, part)


def _check_spindle_and_plane(part: Part | None, spindle: Spindle | FreeSpindle, tables: Mapping[str, Mapping[str, Any]]) -> Iterable[str]:
    """A spindle and a mechanism that do not act upon each other as the file says."""
    is_turning = part is not None and part.plane == TURNING_PLANE
    is_fixed = part is not None and not is_turning
    centrifugal = tables.get("effects", {}).get("centrifugal", False)
    if isinstance(spindle, FreeSpindle) and is_turning and centrifugal is False:
        yield ("effects.centrifugal = true is missing: a free spindle is slowed by what turns with it; add it, or give spindle.speed")
    if isinstance(spindle, FreeSpindle) and is_fixed:
        yield f'spindle.inertia: nothing turns with it in a fixed plane; write plane = "{TURNING_PLANE}", or leave it out'
    if is_fixed and centrifugal is True:
        yield f'effects.centrifugal = true needs a plane that turns; write plane = "{TURNING_PLANE}", or leave it out'
    fluctuates = isinstance(spindle, Spindle) and spindle.speed_fluctuation > 0
    if fluctuates and is_fixed:
        yield (
            "spindle.speed_fluctuation changes nothing: the mechanism lives in a fixed plane; "
            f'write plane = "{TURNING_PLANE}", or leave it out'
        )
    elif fluctuates and centrifugal is False:
        yield (
            "spindle.speed_fluctuation changes nothing: without effects.centrifugal = true nothing feels the spindle turn; "
            "add it, or leave speed_fluctuation out"
        )


def _check_cycles_per_turn(spindle: Spindle | FreeSpindle, tables: Mapping[str, Mapping[str, Any]]) -> Iterable[str]:
    spindle_table = tables.get("spindle", {})
    if isinstance(spindle, Spindle) and "cycles_per_turn" in spindle_table and "speed_fluctuation" not in spindle_table:
        yield "spindle.cycles_per_turn says how often the speed fluctuation comes in a turn; write speed_fluctuation = 0.03, or leave cycles_per_turn out"


def _iterate_stops(effects: Iterable[Effect]) -> Iterable[tuple[Stops, str]]:
    """All stops, those of play too, each with the key that they come from."""
    for effect in effects:
        if isinstance(effect, Stops):
            yield effect, f"effects.stops.{effect.reading}"
        elif isinstance(effect, Clearance):
            yield effect.stops, "effects.clearance"


def _check_stops_and_clearance(effects: Iterable[Effect]) -> Iterable[str]:
    effect_keys = {(type(effect), getattr(effect, "reading", "")) for effect in effects}
    if {(Clearance, ""), (Stops, CLEARANCE_READING)} <= effect_keys:
        yield f"effects.stops.{CLEARANCE_READING} cannot stand beside effects.clearance, whose two ends are such stops; leave it out"


def _check_start_within_stops(stops: Stops, key: str, start: Start, part: Part | None) -> Iterable[str]:
    """A start that stops exclude; on a stop it may begin."""
    value = start.values.get(stops.reading)
    if not isinstance(value, str) and value is not None and not stops.low <= value <= stops.high:
        unit = _SI_UNITS.get(part.mechanism.reading(stops.reading).quantity, "") if part else ""
        yield (
            f"start.{stops.reading} ({format_quantity(value, unit)}) lies beyond the stops of {key}, "
            f"{_format_range(stops.low, stops.high, unit)}; start between them"
        )


def _check_remaining_travel(stops: Stops, key: str, part: Part | None) -> Iterable[str]:
    """Stops that leave nothing of the travel in which the mechanism can be assembled."""
    mechanism: Mechanism | None = part.mechanism if part else None
    for limit in mechanism.limits if mechanism else ():
        if limit.reading == stops.reading and mechanism and (stops.high <= limit.low or stops.low >= limit.high):
            unit = _SI_UNITS.get(mechanism.reading(stops.reading).quantity, "")
            yield (
                f"{key}, {_format_range(stops.low, stops.high, unit)}, leaves nothing of the travel, "
                f"{_format_range(limit.low, limit.high, unit)}"
            )


def _format_range(low: float, high: float, unit: str) -> str:
    low_text, high_text = ("none" if math.isinf(end) else format_quantity(end, unit) for end in (low, high))
    return f"{low_text} to {high_text}"
