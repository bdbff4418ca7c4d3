"""Consistency of the tables of a scene file with each other."""

import math
from collections.abc import Iterator

from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.part import TURNING_PLANE, FreeSpindle, Part, Spindle, Start
from governor_mechanism.units.problems import Problem, ProblemCode
from governor_mechanism.units.quantities import format_quantity


def check_tables_together(
    part: Part | None, effects: tuple[Effect, ...], spindle: Spindle | FreeSpindle, start: Start, centrifugal: object, *, has_spindle: bool
) -> Iterator[Problem]:
    """Yield the problems of tables that do not fit together; `part` is None if the mechanism is not known.

    `centrifugal` is what [effects] has under that key, or False.
    """
    if not has_spindle and any(isinstance(effect, Centrifugal) for effect in effects):
        yield _conflict("effects.centrifugal", 'needs a turning spindle; add [spindle] with speed = "120 rpm"')
    yield from _check_spindle_and_plane(part, spindle, centrifugal)
    has_clearance = any(isinstance(effect, Clearance) for effect in effects)
    for effect in effects:
        for stops in (one for one in effect.output_effects if {"low", "high"} <= one.contact.keys()):
            key = f"effects.{effect.key}" + (f".{stops.reading}" if stops is effect else "")
            if has_clearance and stops is effect and stops.reading == CLEARANCE_READING:
                yield _conflict(key, "cannot be combined with effects.clearance, whose two ends are such stops; leave it out")
            yield from _check_stops(stops, key, start, part)


def _conflict(key: str, text: str) -> Problem:
    return Problem(f"{key} {text}", ProblemCode.CONFLICT, key)


def _check_spindle_and_plane(part: Part | None, spindle: Spindle | FreeSpindle, centrifugal: object) -> Iterator[Problem]:
    """Yield the problems of a spindle and a mechanism that do not act on each other as the file demands."""
    is_fixed = part is not None and part.plane != TURNING_PLANE
    is_free = isinstance(spindle, FreeSpindle)
    hint = f'write plane = "{TURNING_PLANE}", or leave it out'
    if is_free and part is not None and not is_fixed and centrifugal is False:
        text = "= true is missing: a free spindle is slowed by the bodies that turn with it; add it, or give spindle.speed"
        yield _conflict("effects.centrifugal", text)
    if is_free and is_fixed:
        yield _conflict("spindle.inertia", f"has no effect, because nothing turns with the spindle in a fixed plane; {hint}")
    if is_fixed and centrifugal is True:
        yield _conflict("effects.centrifugal", f"= true needs a turning plane; {hint}")
    if isinstance(spindle, Spindle) and spindle.speed_fluctuation > 0 and (is_fixed or centrifugal is False):
        unloaded_text = "without effects.centrifugal = true; add it, or leave speed_fluctuation out"
        yield _conflict("spindle.speed_fluctuation", f"has no effect {f'in a fixed plane; {hint}' if is_fixed else unloaded_text}")


def _check_stops(stops: OutputEffect, key: str, start: Start, part: Part | None) -> Iterator[Problem]:
    """Yield stops that leave nothing of the travel, or else a start beyond the stops; it may be on a stop."""
    quantities = [reading.quantity for reading in part.mechanism.readings if reading.name == stops.reading] if part else []
    unit = {"angle": "rad", "length": "m"}[quantities[0]] if quantities else ""
    low, high = stops.contact["low"], stops.contact["high"]
    stop_range = _format_range(low, high, unit)
    limits = [limit for limit in part.mechanism.limits if limit.reading == stops.reading] if part else []
    excluding = [limit for limit in limits if high <= limit.low or low >= limit.high]
    for limit in excluding:
        text = f"{key}, {stop_range}, leaves nothing of the travel, {_format_range(limit.low, limit.high, unit)}"
        yield Problem(text, ProblemCode.OUT_OF_RANGE, key)
    value = start.values.get(stops.reading)
    if not excluding and not isinstance(value, str) and value is not None and not low <= value <= high:
        start_key = f"start.{stops.reading}"
        text = f"{start_key} ({format_quantity(value, unit)}) is beyond the stops of {key}, {stop_range}; start between them"
        yield Problem(text, ProblemCode.OUT_OF_RANGE, start_key)


def _format_range(low: float, high: float, unit: str) -> str:
    return " to ".join("none" if math.isinf(end) else format_quantity(end, unit) for end in (low, high))
