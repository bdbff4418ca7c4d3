"""Parser of a scene document: its tables in order, and their consistency."""

import dataclasses
import difflib
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from governor_mechanism.effects.body_forces import DEFAULT_GRAVITY, Centrifugal
from governor_mechanism.effects.holding import CLEARANCE_READING, Clearance
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.base import Machine, unsupported_effect_messages
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.coupling.coupled_system import LOAD_NAME, SPINDLE_ANGLE, SPINDLE_SPEED
from governor_mechanism.model.coupling.couplings import Coupling
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Reading, ShaftSpeed
from governor_mechanism.model.part import EQUILIBRIUM, TURNING_PLANE, FreeSpindle, Part, Spindle, Start
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.scenes import schema
from governor_mechanism.scenes.custom.dimensions import DimensionTable, evaluate_expressions
from governor_mechanism.scenes.effect_tables import WatchedReadings, join_watched_readings, parse_crossings, parse_effects
from governor_mechanism.scenes.loads import LOAD, parse_coupling
from governor_mechanism.scenes.quantities import Table, parse_name
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, ProblemCollector, wrong_value
from governor_mechanism.units.quantities import format_quantity, format_value


def check_tables_together(
    part: Part | None, effects: tuple[Effect, ...], spindle: Spindle | FreeSpindle, start: Start, centrifugal: object, *, has_spindle: bool
) -> Iterator[Problem]:
    """Yield the problems of tables that do not fit together; `part` is None if unknown, `centrifugal` its value in [effects], or False."""
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


GOVERNOR_PART_NAME = "governor"
"""Name of the only part of a scene."""


def parse_document(document: Mapping[str, Any], source: str) -> Scene:
    """Return the scene of a document of one part or of several; raise MechanismError with all mistakes."""
    collector = ProblemCollector()
    is_single = "part" not in document and "coupling" not in document
    title, parts, couplings, watched = (_parse_only_part if is_single else _parse_parts)(document, collector)
    crossings = parse_crossings(document.get("events"), watched, collector)
    table = given if isinstance(given := document.get("run"), Mapping) else {}
    run_table = collector.attempt("run", schema.RUN.read, table) or {}
    run = collector.attempt("[run]", lambda: RunSettings(**run_table))
    if collector.problems or not parts or run is None:
        raise MechanismError(*collector.problems)
    own_document = _copy_document(document)
    if not title and (name := Path(source).stem):  # changed copies, and their files, keep the title that the name of a file gives
        title = own_document["title"] = name
    title = title or parts[0].machine
    return Scene(title=title, parts=parts, couplings=couplings, crossings=crossings, run=run, source=source, document=own_document)


_Parts = tuple[str, tuple[Part, ...], tuple[Coupling, ...], WatchedReadings]
"""Title, parts, couplings and what a crossing may watch in a document."""


def _parse_only_part(document: Mapping[str, Any], collector: ProblemCollector) -> _Parts:
    parser = PartParser(document, collector)
    part = parser.parse()
    return parser.title, () if part is None else (part,), (), parser.watched_readings


def _parse_parts(document: Mapping[str, Any], collector: ProblemCollector) -> _Parts:
    top_level = collector.attempt("", schema.COUPLED_TOP_LEVEL.read, document) or {}
    tables = given if isinstance(given := document.get("part"), Mapping) else {}
    couplings = collector.parse_tables("coupling", document.get("coupling"), parse_coupling)
    collector.problems += _couplings_without_part(document, tables)
    coupled = set(_angles_of_couplings(document.get("coupling")))
    if isinstance(load := document.get("load"), Mapping):
        given_load = collector.attempt("load", LOAD.read, load)
        couplings += [LOAD.make(name=LOAD_NAME, **given_load)] if given_load else []
    parts, watched = [], dict[str, WatchedReadings | None]()
    for name, table in tables.items():
        part_collector = ProblemCollector()
        # Where a coupling has a mistake, the spindle that it means is not known, and none is reported to be missing.
        is_coupled = f"{name}.{SPINDLE_ANGLE}" in coupled or (bool(collector.problems) and _needs_spindle(table))
        parser = part_collector.attempt(KEY, PartParser, table, part_collector, name, is_coupled)
        part = parser and parser.parse()
        parts += [part] if part else []
        prefix = f"{name}." if len(tables) > 1 else ""
        watched[prefix] = None if parser is None else parser.watched_readings
        collector.problems += [problem.at(f"part.{name}:") for problem in part_collector.problems]
    title = top_level.get("title") or ""
    return title, tuple(parts), tuple(couplings), join_watched_readings(watched) if len(parts) == len(tables) else WatchedReadings(None)


def _angles_of_couplings(tables: object) -> Iterator[str]:
    """Yield the angles that couplings name, also those with another mistake: what they couple needs no speed of its own."""
    for table in tables.values() if isinstance(tables, Mapping) else ():
        angles = (table.get(key) for key in ("first", "second")) if isinstance(table, Mapping) else ()
        yield from (angle for angle in angles if isinstance(angle, str))


def _needs_spindle(table: object) -> bool:
    """Return whether a part turns and has no spindle of its own."""
    effects = table.get("effects") if isinstance(table, Mapping) and "spindle" not in table else None
    return isinstance(effects, Mapping) and effects.get("centrifugal") is True


def _couplings_without_part(document: Mapping[str, Any], parts: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield a problem for each name in a coupling or load of a scene of several parts that begins with the name of no part."""
    couplings = given if isinstance(given := document.get("coupling"), Mapping) else {}
    tables = {f"coupling.{name}": table for name, table in couplings.items()} | {"load": document.get("load")}
    for path, table in tables.items() if len(parts) > 1 else ():
        for key in ("first", "second", "reading", "sets", "scales", "angle") if isinstance(table, Mapping) else ():
            name = table.get(key)
            is_load = key in ("sets", "scales") and name == LOAD_NAME
            if isinstance(name, str) and name.partition(".")[0] not in parts and not is_load:
                part, dot, _ = name.partition(".")
                hint = did_you_mean(part, parts) if dot else f" Write it as PART.{part}, with the name of one of them."
                text = f"{path}.{key} {format_value(name)} names no part; parts are {', '.join(parts)}.{hint}"
                yield Problem(text, ProblemCode.UNKNOWN_NAME, f"{path}.{key}")


class PartParser:
    """Parser of the tables of one part, which has a name if it stands under [part]."""

    def __init__(self, document: Any, collector: ProblemCollector, name: str | None = None, is_coupled: bool = False) -> None:
        self.document = document
        self.collector = collector
        self.name = name
        self.is_coupled = is_coupled
        if name is not None:
            self._check_table_of(name)
        self.is_custom = _find_intended_machine(document) == CUSTOM_MACHINE
        self.dimensions = DimensionTable(document.get("dimensions"))
        if self.is_custom:
            self.document = document = evaluate_expressions(document, self.dimensions, collector)
        self.tables: dict[str, dict[str, Any]] = {name: dict(value) for name, value in document.items() if isinstance(value, Mapping)}
        self.title = ""
        self.quantities: dict[str, str] | None = None
        """Quantities of the readings by name; None while they are not known."""
        self.shaft_speeds: tuple[str, ...] = ()
        self.spindle: Spindle | FreeSpindle | None = None

    def _check_table_of(self, name: str) -> None:
        parse_name(name, "the name of a part")
        if not isinstance(self.document, Mapping):
            raise wrong_value(self.document, "must be a table", f"; write [part.{name}]")
        keys = [key for key in ("title", "run", "events") if key in self.document]
        self.collector.add(ProblemCode.CONFLICT, *(f"{KEY}.{key} stands once for the whole scene; move it above the parts" for key in keys))

    def parse(self) -> Part | None:
        """Return the part, or None if there are mistakes."""
        part, effects, start = self._parse_custom() if self.is_custom else self._parse_dimensioned()
        self.spindle = spindle = self._parse_spindle()
        if isinstance(spindle, FreeSpindle) and self.quantities is not None:
            self.quantities = self.quantities | {SPINDLE_ANGLE: "angle"}
        has_spindle = "spindle" in self.document or self.is_coupled  # even if it is not a table, which is reported
        centrifugal = self.tables.get("effects", {}).get("centrifugal", False)
        self.collector.problems += check_tables_together(part, effects, spindle, start, centrifugal, has_spindle=has_spindle)
        if self.collector.problems or part is None:
            return None
        with self.collector.at(""):
            return dataclasses.replace(part, name=self.name or part.name, effects=effects, spindle=spindle, start=start)
        return None

    @property
    def watched_readings(self) -> WatchedReadings:
        """What a named crossing may watch."""
        has_given_speed = isinstance(self.spindle, Spindle) and "spindle" in self.tables
        speeds = [*self.shaft_speeds, *([SPINDLE_SPEED] if isinstance(self.spindle, FreeSpindle) else [])]
        quantities = None if self.quantities is None else self.quantities | dict.fromkeys(speeds, "angular_speed")
        return WatchedReadings(quantities, frozenset([SPINDLE_SPEED] if has_given_speed else []))

    def _parse_spindle(self) -> Spindle | FreeSpindle:
        """Return the spindle; one at rest if the file has none, or a wrong one."""
        default: Spindle | FreeSpindle = FreeSpindle() if self.is_coupled else Spindle()
        if not self.tables.get("spindle") and ("spindle" not in self.tables or self.is_coupled):
            return default
        return self.collector.attempt("spindle", schema.parse_spindle, self.tables["spindle"], self.is_coupled) or default

    def _parse_effects(self, readings: Iterable[Reading] | None, extra_quantities: Mapping[str, str] | None = None) -> tuple[Effect, ...]:
        if readings is not None:
            self.quantities = {reading.name: reading.quantity for reading in readings} | dict(extra_quantities or {})
        # No force acts along a ratio.
        forced = None if self.quantities is None else {name: kind for name, kind in self.quantities.items() if kind != "ratio"}
        return parse_effects(self.tables.get("effects", {}), forced, self.collector)

    def _parse_top_level(self, table: Table) -> dict[str, Any] | None:
        """Return the keys outside the tables."""
        top_level = self.collector.attempt("", table.read, self.document)
        self.title = (top_level and top_level.get("title")) or ""
        return top_level

    def _parse_custom(self) -> tuple[Part | None, tuple[Effect, ...], Start]:
        """Return part, effects and start of a scene with a custom machine."""
        from governor_mechanism.scenes.custom.parser import CUSTOM_TOP_LEVEL, CustomMachineParser  # not for other machines

        top_level = self._parse_top_level(CUSTOM_TOP_LEVEL)
        part, start, readings = CustomMachineParser(self.document, top_level, self.collector, self.dimensions).parse()
        effects = self._parse_effects(readings)
        self._add_effect_problems(unsupported_effect_messages(CUSTOM_MACHINE, effects))
        return part, effects, start

    def _add_effect_problems(self, messages: Iterable[str]) -> None:
        self.collector.problems += [Problem(message, ProblemCode.CONFLICT).at("[effects]") for message in messages]

    def _parse_dimensioned(self) -> tuple[Part | None, tuple[Effect, ...], Start]:
        """Return part, effects and start of a scene with a machine that dimensions describe."""
        self._parse_top_level(schema.TOP_LEVEL)
        machine_class = MACHINES.get(_find_intended_machine(self.document))
        machine = self._build_machine(machine_class)
        mechanism = machine.mechanism() if machine else _build_placeholder_mechanism(machine_class) if machine_class else None
        # A clearance with a mistake still brings its reading, or naming that reading would be reported as a mistake too.
        has_clearance = machine_class is not None and Clearance in machine_class.supported_effects
        has_clearance = has_clearance and self.tables.get("effects", {}).get("clearance", False) is not False
        self.shaft_speeds = tuple(one.name for one in (mechanism.derived_readings if mechanism else ()) if isinstance(one, ShaftSpeed))
        effects = self._parse_effects(mechanism.readings if mechanism else None, {CLEARANCE_READING: "length"} if has_clearance else None)
        effect_problems = machine_class.effect_problems(effects) if machine_class else ()
        self._add_effect_problems(effect_problems)
        is_driven = machine.is_driven if machine else bool(machine_class and machine_class.driver_dimensions)
        driven_class = machine_class if is_driven else None
        start = self._parse_driven_start(driven_class) if driven_class else self._parse_start(machine, mechanism, has_clearance)
        can_build = machine and mechanism and not effect_problems
        return self.collector.attempt("[effects]", _build_part, machine, mechanism, effects) if can_build else None, effects, start

    def _build_machine(self, machine_class: type[Machine] | None) -> Machine | None:
        """Return the machine of [dimensions], or None if it cannot be built."""
        if "dimensions" not in self.document:
            needs = f"{machine_class.name} needs {', '.join(_required_keys(machine_class))}" if machine_class else "every machine needs it"
            self.collector.add(ProblemCode.MISSING_KEY, f"[dimensions] is missing; {needs}", key="dimensions")
        if machine_class is None or "dimensions" not in self.tables:
            return None
        table = schema.dimensions_table(machine_class)
        given = self.collector.attempt("dimensions", table.read, self.tables["dimensions"])
        if given is None:
            return None
        return self.collector.attempt("[dimensions]", lambda: table.make(**given).under_gravity(self._find_gravity))

    def _find_gravity(self) -> float:
        """Return the gravitational acceleration of the scene, m/s2; 9.81 if it is written wrongly, which is reported later."""
        collector = ProblemCollector()
        given = self.tables.get("effects", {}).get("gravity", False)
        effects = parse_effects({"gravity": given}, {}, collector)
        return DEFAULT_GRAVITY if collector.problems else sum(effect.gravity for effect in effects)

    def _parse_start(self, machine: Machine | None, mechanism: Mechanism | None, has_clearance: bool) -> Start:
        """Return values and rates of the coordinate, and of the clearance; it starts in its middle and at rest by default."""
        table = self.tables.get("start", {})
        if mechanism is None:
            self.collector.add(ProblemCode.UNKNOWN_NAME, *schema.find_misspelt_equilibrium(table), key="start")
            return Start(values={})
        coordinate = mechanism.coordinate
        readings = {coordinate: (mechanism.reading(coordinate).quantity, schema.rate_key(coordinate))}
        clearance = {CLEARANCE_READING: 0.0} if has_clearance else {}
        readings |= {name: ("length", f"{name}_rate") for name in clearance}
        given = schema.parse_start(table, readings, self.collector)
        rates = clearance | {**given.rates} if given.rates else given.rates
        default_start = machine.default_start if machine else EQUILIBRIUM
        start = Start(values={coordinate: default_start, **clearance, **given.values}, rates=rates)
        if machine:
            with self.collector.at("[start]"):
                self.collector.add(ProblemCode.OUT_OF_RANGE, *machine.start_problems(start.values), key="start")
        return start

    def _parse_driven_start(self, machine_class: type[Machine]) -> Start:
        """Return the start of a driven machine, which its drive determines."""
        for name in ("start", "spindle"):
            if self.document.get(name):
                text = f"[{name}] has no meaning for machine {machine_class.name!r}, whose crank is driven"
                hint = f"its speed and start are {' and '.join(machine_class.driver_dimensions)} in [dimensions]"
                self.collector.add(ProblemCode.CONFLICT, f"{text}: {hint}", key=name)
        return Start()


def _find_intended_machine(document: Mapping[str, Any]) -> str:
    """Return the machine of the document, or the one nearest to a misspelt name, so that the rest can be checked."""
    keys = [key for key in document if isinstance(key, str)]
    machine_key = "machine" if "machine" in document else next(iter(difflib.get_close_matches("machine", keys, n=1)), "")
    name = document.get(machine_key)
    if isinstance(name, str) and (name in MACHINES or name == CUSTOM_MACHINE):
        return name
    close_matches = difflib.get_close_matches(name, [*MACHINES, CUSTOM_MACHINE], n=1) if isinstance(name, str) else []
    return close_matches[0] if close_matches else CUSTOM_MACHINE if "body" in document else ""


def _build_part(machine: Machine, mechanism: Mechanism, effects: tuple[Effect, ...]) -> Part:
    """Return the part; `mechanism` is used unless the effects change its bodies."""
    if problems := machine.stop_problems(effects):
        raise MechanismError(*problems)
    if any(effect.changes_bodies_of for effect in effects):
        mechanism = machine.mechanism_with_effects(effects)
    return Part(name=GOVERNOR_PART_NAME, machine=machine.name, dimensions=machine.dimensions(), mechanism=mechanism, plane=machine.plane)


def _required_keys(machine_class: type[Machine]) -> list[str]:
    return [field.name for field in dataclasses.fields(machine_class) if field.default is dataclasses.MISSING]


def _build_placeholder_mechanism(machine_class: type[Machine]) -> Mechanism | None:
    """Return some mechanism of this kind, so that [start] can be checked although [dimensions] is wrong."""
    try:
        return machine_class(**dict.fromkeys(_required_keys(machine_class), 1.0)).mechanism()
    except ValueError:
        return None


def _copy_document(value: Any) -> Any:
    """Return a copy that does not change with the caller's document."""
    if isinstance(value, str | float | int):  # most values; other checks take longer
        return value
    if isinstance(value, Mapping):
        return {key: _copy_document(item) for key, item in value.items()}
    return [_copy_document(item) for item in value] if isinstance(value, list | tuple) else value
