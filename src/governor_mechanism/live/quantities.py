"""Quantities, words and switches of a scene that a person may change, as the scene file writes them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.joints.drivers import Driver
from governor_mechanism.model.part import EQUILIBRIUM, Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import ENGINE_CHOICES, Scene
from governor_mechanism.scenes.changed_document import remove_document_key, replace_document_value
from governor_mechanism.scenes.custom.parts import FORCE_TABLES, JOINT_TABLES, VALVE
from governor_mechanism.scenes.effect_tables import CROSSING, SLEEVE_ALIAS, SLEEVE_LIFT_NAME
from governor_mechanism.scenes.quantities import Table
from governor_mechanism.scenes.schema import FREE_SPINDLE, SPINDLE, dimensions_table
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.quantities import QUANTITY_KINDS, display_unit, format_value

WRITTEN_QUANTITY: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*)?")
"""A number, and the unit behind it."""

FIXED_TABLES: Final = ("law", "readings")
"""Tables whose numbers state what a scene is, and not how large it is."""

WORDS: Final = (
    "title",
    "name",
    "machine",
    "type",
    "first",
    "second",
    "engine",
    "assembly",
    "plane",
    "accuracy",
    "output_interval",
    "reactions",
)
"""Keys that hold words, or how exactly a run is computed."""

COORDINATES: Final = {"1": "x", "2": "y"}
"""Names of the values of a position."""

POINT_WORDS: Final = {"1": "time", "2": "value"}
"""Names of both numbers of a point of a function of time, in front of its number."""

TABLE: Final = "table"
TABLE_WORDS: Final = {"1": "reading", "2": "value"}
"""Key of a function of a reading, and the names of both numbers of its points."""

PLACES: Final = ("ground", "at", "points")
"""Keys under which lists are positions."""

LAST_GROUPS: Final = ("run", "events")
"""Groups that come after the mechanism itself."""

RANGE_FACTOR: Final = 2.0
"""Factor between a value and the ends of its slider."""


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number of a scene file with its unit."""

    key: str  # dotted key; items of lists by name, or by number from 1
    group: str  # table that it belongs to
    words: str  # what it is
    value: float  # value in its unit
    unit: str  # unit as written; empty for a number in SI
    # low, high: ends of its slider
    low: float
    high: float

    def write(self, value: float) -> float | str:
        """Return a value as the scene file writes it."""
        return f"{value:.12g} {self.unit}" if self.unit else float(f"{value:.12g}")


def find_quantities(
    document: Mapping[str, Any],
    length_scale: float,  # half of the range of a coordinate that is zero, m
) -> dict[str, Quantity]:
    """Return the quantities of a document by key, in its order, those of the run last."""
    found = [_read(key, value, length_scale) for key, value in _leaves(document)]
    quantities = sorted((one for one in found if one is not None), key=lambda one: one.group in LAST_GROUPS)
    return {one.key: one for one in quantities}


def split_quantity(value: object) -> tuple[float, str] | None:
    """Return number and unit of a written quantity; None if it is none."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), ""
    match = WRITTEN_QUANTITY.fullmatch(value) if isinstance(value, str) else None
    return (float(match[1]), match[2].strip()) if match and match[2] else None


def _leaves(table: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield path and value of everything in a document that is no table and no list."""
    if isinstance(table, Mapping):
        items: Sequence[tuple[str, Any]] = [(key, value) for key, value in table.items() if key not in WORDS]
    elif isinstance(table, list | tuple):
        items = [(name_of_item(item, number), item) for number, item in enumerate(table, start=1)]
    else:
        yield path, table
        return
    for key, value in items:
        if path or key not in FIXED_TABLES:
            yield from _leaves(value, (*path, key))


def name_of_item(item: Any, number: int) -> str:
    """Return how a dotted key names an item of a list."""
    name = item.get("name") if isinstance(item, Mapping) else None
    return name if isinstance(name, str) and "." not in name else str(number)


def _read(path: tuple[str, ...], value: Any, length_scale: float) -> Quantity | None:
    """Return the quantity at a path; None if there is none."""
    written = split_quantity(value)
    if written is None or any("." in key for key in path):
        return None
    number, unit = written
    is_place = path[-1] in COORDINATES and bool(set(PLACES) & set(path[:-1]))
    n_group = 2 if path[0] == "part" else 1
    is_point = len(path) > n_group + 1 and path[-1] in POINT_WORDS and path[-2].isdecimal() and not is_place
    names = [*path[n_group:-1], COORDINATES[path[-1]]] if is_place else [*path[n_group:]]
    if is_point:
        words = TABLE_WORDS if path[-3] == TABLE else POINT_WORDS
        names = [*path[n_group:-2], words[path[-1]], path[-2]]
    half = RANGE_FACTOR * length_scale if is_place and not unit else 1.0
    low, high = (number / RANGE_FACTOR, number * RANGE_FACTOR) if number else (-half, half)
    return Quantity(
        key=".".join(path),
        group=path[n_group - 1],
        words=" ".join(names or path).replace("_", " "),
        value=number,
        unit=unit,
        low=min(low, high),
        high=max(low, high),
    )


ENGINE_KEY: Final = "run.engine"
"""Key of the engine."""

EFFECTS_KEY: Final = "effects"
"""Table of the effects."""

A_VALUE: Final = "a value"
"""What is chosen in place of a word where the file may have either a word or a quantity."""

FIXED_WORDS: Final = ("type", "machine", "engine")
"""Keys of words that say what a table is, or that are offered otherwise."""

GRAVITY: Final = 9.81
"""Acceleration, m/s2, of the weights that say how large a load is that is switched on."""

START_SHARES: Final = {DryFriction: 0.01, OutputSpring: 0.1, Dashpot: 0.1}
"""Load that is switched on, relative to the weight of the moving bodies: at a length scale, or at the rate of a swing over it."""

CONSTANT_SPEED = "constant speed"
SPEED_OVER_TIME = "speed over time"
FREE_SPEED = "free"
CONSTANT_RATE, MOTION_OVER_TIME = "constant rate", "over time"

Value = str | bool
"""What is chosen."""

Document = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A word or a switch of a scene file."""

    key: str  # dotted key
    words: str  # what it is
    value: Value  # the word, or whether it is on
    options: tuple[str, ...] = ()  # words to choose from; empty for a switch


class Offer(NamedTuple):
    """A choice, and what the document holds at a key when a word is chosen."""

    choice: Choice
    key: str
    write: Callable[[Value], Any]


def find_choices(run: Trajectory, document: Document) -> dict[str, Choice]:
    """Return the choices of the document of a run by key."""
    return {key: offer.choice for key, offer in _find_offers(run, document).items()}


def choose(run: Trajectory, document: Document, key: str, value: Value, kept: dict[str, Any]) -> Document:
    """Return the document with another choice, or MechanismError; `kept`, what stood at its keys earlier, gets what stands there now."""
    offers = _find_offers(run, document)
    if key not in offers:
        raise MechanismError(f"{key!r} is no choice of this scene; it has {', '.join(offers)}")
    choice, target, write = offers[key]
    allowed = choice.options or (True, False)
    if value not in allowed or isinstance(value, bool) == bool(choice.options):
        raise MechanismError(f"{choice.words} is one of {', '.join(map(str, allowed))}; found {format_value(value)}")
    kept[f"{key}: {choice.value}"] = _value_at(document, target)
    after = kept[f"{key}: {value}"] if f"{key}: {value}" in kept else write(value)
    changed: Document = remove_document_key(document, target) if after is None else replace_document_value(document, target, after)
    return changed


def _value_at(document: Any, key: str) -> Any:
    """Return what a document has at a dotted key; None if it has nothing there."""
    for name in key.split("."):
        if isinstance(document, list | tuple):
            document = next((one for number, one in enumerate(document, start=1) if name_of_item(one, number) == name), None)
        else:
            document = document.get(name) if isinstance(document, Mapping) else None
    return document


def _find_offers(run: Trajectory, document: Document) -> dict[str, Offer]:
    """Return what may be chosen in the document of a run, by key."""
    engine = document.get("run", {}).get("engine", ENGINE_CHOICES[0])
    offers = [Offer(Choice(key=ENGINE_KEY, words="engine", value=engine, options=ENGINE_CHOICES), ENGINE_KEY, str)]
    for prefix, one, part in _parts_of(document, run.scene):
        offers += _find_effects(prefix, one, part, run)
        offers += _find_spindle(prefix, one, part, run)
        offers += _find_start(prefix, one, part, run)
        offers += _find_drivers(prefix, one, part, run)
        offers += (offer for path, values, table in _tables_of(prefix, one) for offer in _find_words(path, values, table, part))
    for name, values in document.get("events", {}).items():
        offers += _find_words(f"events.{name}", values, CROSSING, run.scene.parts[0])
    return {offer.choice.key: offer for offer in offers}


def _parts_of(document: Document, scene: Scene) -> Iterator[tuple[str, Document, Part]]:
    """Yield the beginning of the keys, the table and the part of each part of a scene."""
    if len(scene.parts) == 1:
        yield "", document, scene.part
    else:
        yield from ((f"part.{part.name}.", document["part"][part.name], part) for part in scene.parts if part.name in document["part"])


def _tables_of(prefix: str, document: Document) -> Iterator[tuple[str, Document, Table]]:
    """Yield the tables of a part with words: their path, what they hold, and what they may hold."""
    if document.get("machine") in MACHINES:
        yield f"{prefix}dimensions", document.get("dimensions", {}), dimensions_table(MACHINES[document["machine"]])
    for key, tables in (("force", FORCE_TABLES), ("joint", JOINT_TABLES)):
        for number, item in enumerate(document.get(key, ()), start=1):
            if item.get("type") in tables:
                yield f"{prefix}{key}.{name_of_item(item, number)}", item, tables[item["type"]]
    if isinstance(document.get("valve"), Mapping):
        yield f"{prefix}valve", document["valve"], VALVE


def _find_words(path: str, values: Document, table: Table, part: Part) -> Iterator[Offer]:
    """Yield the words and flags of a table, and the words that may stand in place of a quantity."""
    for name, declared in table.fields_by_key.items():
        if name in FIXED_WORDS:
            continue
        key, value = f"{path}.{name}", values.get(name, declared.default)
        if declared.form == "flag" and isinstance(value, bool):
            yield _offer(key, value, (), bool)
        elif declared.form == "choice" and value in declared.words:
            yield _offer(key, str(value), declared.words, str)
        elif declared.form == "quantity" and declared.words and (value is None or isinstance(value, str | int | float)):
            shown = str(value) if value in declared.words else declared.words[0] if value is None else A_VALUE
            yield _offer(key, shown, (*declared.words, A_VALUE), partial(_word_or_value, declared, part))


def _offer(key: str, value: Value, options: tuple[str, ...], write: Callable[[Any], Any], words: str = "", target: str = "") -> Offer:
    """Return an offer at a key of the document, with words for it."""
    names = key.split(".")
    names = [names[1], *names[3:]] if names[0] == "part" else names[1:]
    found = words or " ".join(names).replace("_", " ")
    return Offer(Choice(key=key, words=found, value=value, options=options), target or key, write)


def _word_or_value(declared: Declaration, part: Part, word: str) -> str:
    """Return a word, or in place of A_VALUE a quantity to begin with."""
    if word != A_VALUE:
        return word
    if declared.kind == "length":
        return _write(2.0 * part.mechanism.length_scale, "m")
    return declared.examples[0] if declared.examples else QUANTITY_KINDS[declared.kind].example


def _write(value: float, unit: str, digits: int = 1) -> str:
    """Return a quantity in SI as a file has it, in its customary unit."""
    factor, shown = display_unit(unit)
    rounded = float(f"{value * factor + 0.0:.{digits}g}")
    return f"{rounded:.12g} {shown}".rstrip()


def _find_effects(prefix: str, document: Document, part: Part, run: Trajectory) -> Iterator[Offer]:
    """Yield the effects that a part has or may have, and the reading along which each of them acts."""
    given = document.get(EFFECTS_KEY, {})
    supported = MACHINES[part.machine].supported_effects if part.machine in MACHINES else ()
    for effect in EFFECTS:
        is_possible = effect in supported if effect.changes_bodies_of else part.turns or not effect.loads_turning_bodies
        if effect.key not in given and not is_possible:
            continue
        key = f"{prefix}{EFFECTS_KEY}.{effect.key}"
        value = given.get(effect.key, False)
        yield _offer(key, value is not False, (), partial(_switch, effect, part, run))
        along = [name for name in value if name not in effect.common_keys] if isinstance(value, Mapping) else []
        readings = [one.name for one in part.mechanism.readings]
        if issubclass(effect, OutputEffect) and len(along) == 1 and len(readings) > 1:
            reading = SLEEVE_LIFT_NAME if along[0] == SLEEVE_ALIAS else along[0]
            move = partial(_move_effect, effect, part, run, value, along[0])
            words = f"{effect.key.replace('_', ' ')} along"
            yield _offer(f"{key} along", reading, tuple(readings), move, f"{prefix[5:-1]} {words}".strip(), key)


def _switch(effect: type[Effect], part: Part, run: Trajectory, is_on: bool) -> Any:
    """Return what the file has at the key of an effect that is switched on with values to begin with, or off."""
    if not is_on:
        return False
    if issubclass(effect, OutputEffect):
        names = [reading.name for reading in part.mechanism.readings]
        reading = SLEEVE_LIFT_NAME if SLEEVE_LIFT_NAME in names else part.mechanism.coordinate
        return {reading: _first_load(effect, part, run, reading)}
    fields = fields_of(effect)
    if not any(one.is_required for one in fields.values()) and len(effect.value_fields) == min(len(fields), 1):
        return True
    shown = {name: one for name, one in fields.items() if one.examples} or {name: one for name, one in fields.items() if one.is_required}
    examples = {name: one.examples[0] if one.examples else QUANTITY_KINDS[one.kind].example for name, one in shown.items()}
    return examples[effect.value_fields[0]] if effect.value_fields else examples


def _move_effect(effect: type[Effect], part: Part, run: Trajectory, value: Document, before: str, reading: str) -> dict[str, Any]:
    """Return the table of an effect that acts along another reading, with the same load if it is of the same kind."""
    old, new = (part.mechanism.reading(name).quantity for name in (SLEEVE_LIFT_NAME if before == SLEEVE_ALIAS else before, reading))
    load = value[before] if old == new and effect is not Stops else _first_load(effect, part, run, reading)
    return {**{name: one for name, one in value.items() if name != before}, reading: load}


def _first_load(effect: type[Effect], part: Part, run: Trajectory, reading: str) -> Any:
    """Return a load along a reading to begin with: stops around the run, or a share of the weight of the moving bodies."""
    quantity = part.mechanism.reading(reading).quantity
    unit, length = READING_UNITS[quantity], part.mechanism.length_scale
    if effect is Stops:
        prefix = "" if len(run.scene.parts) == 1 else f"{part.name}."
        values = run.readings.get(f"{prefix}{reading}", np.zeros(1))
        margin = max(0.1 * float(np.ptp(values)), 0.01 * (length if quantity == "length" else 1.0))
        return [_write(float(values.min()) - margin, unit, 3), _write(float(values.max()) + margin, unit, 3)]
    weight = GRAVITY * (sum(body.mass for body in part.mechanism.bodies) or 1.0)
    arm = length if quantity == "angle" else 1.0
    per_unit = {DryFriction: 1.0, OutputSpring: 1.0 / length, Dashpot: 1.0 / math.sqrt(GRAVITY * length)}[effect]
    declared = fields_of(effect)["linear" if effect is Dashpot else "rate" if effect is OutputSpring else "force"].along(quantity)
    scale = arm * (arm if effect is not DryFriction else 1.0)
    load = _write(START_SHARES[effect] * weight * per_unit * scale, QUANTITY_KINDS[declared.kind].si_unit)
    return {"rate": load} if effect is OutputSpring else load


def _find_spindle(prefix: str, document: Document, part: Part, run: Trajectory) -> Iterator[Offer]:
    """Yield how a spindle turns that stands in the file."""
    table = document.get("spindle")
    if not isinstance(table, Mapping) or not table:
        return
    speed = table.get("speed")
    kind = FREE_SPEED if speed is None else CONSTANT_SPEED if split_quantity(speed) else SPEED_OVER_TIME
    first = table.get("start_speed") if speed is None else speed if kind == CONSTANT_SPEED else speed[0][1]
    name = "spindle_speed" if len(run.scene.parts) == 1 else f"{part.name}.spindle_speed"
    factor, rpm = display_unit("rad/s")
    number, unit = split_quantity(first) or (float(run.readings[name][0]) * factor, rpm)

    def write(word: Value) -> dict[str, Any]:
        """Return the table of a spindle that turns so."""
        own = {key: value for key, value in table.items() if key in SPINDLE.fields and key not in FREE_SPINDLE.fields}
        text, end = f"{number:.12g} {unit}".strip(), run.scene.run.duration
        faster = f"{1.05 * number:.12g} {unit}".strip()
        if word == FREE_SPEED:
            inertia = sum(body.mass for body in part.mechanism.bodies) * part.mechanism.length_scale**2
            return {"inertia": _write(inertia or 1.0, "kg m^2"), "start_speed": text}
        return own | {"speed": text if word == CONSTANT_SPEED else [[f"{0.25 * end:.3g} s", text], [f"{0.5 * end:.3g} s", faster]]}

    yield _offer(f"{prefix}spindle", kind, (CONSTANT_SPEED, SPEED_OVER_TIME, FREE_SPEED), write, f"{prefix[5:-1]} spindle".strip())


def _find_start(prefix: str, document: Document, part: Part, run: Trajectory) -> Iterator[Offer]:
    """Yield whether what turns with a spindle starts in equilibrium."""
    name = part.mechanism.coordinate
    value = document.get("start", {}).get(name, EQUILIBRIUM if part.machine in MACHINES else None)
    if not part.turns or value is None or part.mechanism.count_drivers():
        return
    reading = name if len(run.scene.parts) == 1 else f"{part.name}.{name}"
    unit = READING_UNITS[part.mechanism.reading(name).quantity]

    def write(word: Value) -> Any:
        """Return where it starts."""
        return word if word == EQUILIBRIUM else _write(float(run.readings[reading][0]), unit, 6)

    shown = EQUILIBRIUM if value == EQUILIBRIUM else A_VALUE
    yield _offer(f"{prefix}start.{name}", shown, (EQUILIBRIUM, A_VALUE), write, f"{prefix[5:-1]} start of {name.replace('_', ' ')}".strip())


def _find_drivers(prefix: str, document: Document, part: Part, run: Trajectory) -> Iterator[Offer]:
    """Yield how each driver of a custom machine moves: at a constant rate, or through points over time."""
    drivers = [joint for joint in part.mechanism.joints if isinstance(joint, Driver)]
    written = [(number, item) for number, item in enumerate(document.get("joint", ()), start=1) if "driven" in str(item.get("type"))]
    for (number, item), joint in zip(written, drivers, strict=False):
        if isinstance(item.get("motion"), Mapping):  # with harmonics
            continue
        key, end = f"{prefix}joint.{name_of_item(item, number)}", run.scene.run.duration
        first, last = CubicTimeFunction(joint.motion)(np.array([0.0, end])).tolist()
        write = partial(_write_driver, item, (0.0, first), (end, last))
        shown = MOTION_OVER_TIME if "motion" in item else CONSTANT_RATE
        words = f"motion of {name_of_item(item, number)}".replace("_", " ")
        yield _offer(f"{key} motion", shown, (CONSTANT_RATE, MOTION_OVER_TIME), write, words, key)


def _write_driver(item: Document, first: tuple[float, float], last: tuple[float, float], word: Value) -> dict[str, Any]:
    """Return the table of a driver that goes from its first to its last value (SI) in the time between them (s), in a way."""
    (start_time, start), (end_time, end) = first, last
    is_turn = item["type"] == "driven_turn"
    unit = "rad" if is_turn else "m"
    others = {name: value for name, value in item.items() if name not in ("rate", "start", "motion")}
    if word == MOTION_OVER_TIME:
        return others | {"motion": [[f"{time:.12g} s", _write(value, unit, 12)] for time, value in (first, last)]}
    rate = (end - start) / (end_time - start_time)
    return others | {"rate": _write(rate, "rad/s", 12) if is_turn else f"{1e3 * rate:.12g} mm/s", "start": _write(start, unit, 12)}
