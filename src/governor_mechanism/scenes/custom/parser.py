"""Scene files with a mechanism of the user's own to its bodies, joints, forces and readings.

Every mistake is told: what cannot be understood in a table, and what cannot be found or built from it.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.custom import (
    CUSTOM_MACHINE,
    InitialConfiguration,
    SketchedBody,
    build_custom_mechanism,
    conflicting_drivers,
    length_scale_of,
    unconnected_bodies,
)
from governor_mechanism.model.force_elements import ForceElement
from governor_mechanism.model.joints import GROUND, Distance, Joint
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.model.scene import FIXED_PLANE, TURNING_PLANE, Part, Start
from governor_mechanism.scenes.custom.bodies import PointRegistry, parse_body
from governor_mechanism.scenes.custom.joints import (
    FORCE_FACTORIES,
    JOINT_FACTORIES,
    find_connected_bodies,
    make_custom_reading,
    make_default_readings,
)
from governor_mechanism.scenes.custom.schema import FORCE_TABLES, JOINT_TABLES, READING_TABLES, BodyTable, LinkTable
from governor_mechanism.scenes.custom.values import parse_named_points
from governor_mechanism.scenes.quantities import join_names
from governor_mechanism.scenes.schema import SceneFileTable, rate_key, start_table_model, validate_table
from governor_mechanism.units.quantities import format_value

CUSTOM_PART_NAME = "mechanism"
"""The name of the only part."""

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class CustomMachineContents:
    """What a file describes: None where mistakes stand in the way, each told in `problems`."""

    part: Part | None
    start: Start
    readings: tuple[Reading, ...] | None
    problems: list[str]


def parse_custom_machine(document: Mapping[str, Any], top_level: Mapping[str, Any]) -> CustomMachineContents:
    """The part and the start of a document; `top` is what could be understood of its keys above the tables."""
    parser = _CustomMachineParser(document, top_level)
    mechanism, start = parser.build_mechanism()
    if mechanism is None:
        return CustomMachineContents(None, start, parser.readings, parser.problems)
    part = Part(name=CUSTOM_PART_NAME, machine=CUSTOM_MACHINE, dimensions={}, mechanism=mechanism, plane=parser.plane)
    return CustomMachineContents(part, start, parser.readings, parser.problems)


class _CustomMachineParser:
    """Reads one document; notes the mistakes met."""

    def __init__(self, document: Mapping[str, Any], top_level: Mapping[str, Any]) -> None:
        self.problems: list[str] = []
        self.document = document
        self.is_complete = bool(top_level)  # else a table may be missing only because its heading is misspelt
        self.given_length_scale: float | None = top_level.get("size")
        plane = document.get("plane")
        self.plane = plane if plane in (FIXED_PLANE, TURNING_PLANE) else TURNING_PLANE if "spindle" in document else FIXED_PLANE
        self.registry = PointRegistry()
        self.readings: tuple[Reading, ...] | None = None
        """All readings; None where one could not be understood."""

    def build_mechanism(self) -> tuple[Mechanism | None, Start]:
        """The mechanism, or None where there are mistakes, and the start."""
        self._parse_ground()
        bodies = self._parse_bodies()
        initial_layout = InitialConfiguration(bodies)
        joints = [*self._parse_joints(initial_layout), *self._parse_links(initial_layout)]
        force_elements = self._parse_force_elements()
        self._check_unique_names(bodies, joints, force_elements)
        self._check_connections(bodies, joints, force_elements)
        readings = self._parse_readings(bodies)
        self._record_readings(readings, bodies)
        start = self._parse_start(readings)
        length_scale = self.given_length_scale or length_scale_of(bodies, joints, force_elements)
        if not length_scale and self.is_complete and not self.problems:
            self.problems.append('size is missing: the sketch has no length to refer accuracies to; write size = "1 m"')
        if self.problems or not self.is_complete:
            return None, start
        coordinate = next(iter(_start_reading_order(self.document.get("start", {}), readings)), readings[0].name)
        mechanism = self._try_build("", lambda: build_custom_mechanism(bodies, joints, force_elements, readings, coordinate, length_scale))
        return mechanism, start

    def _validate_table(
        self, model: type[SceneFileTable], values: object, heading: str, prefix: str | None = None
    ) -> dict[str, Any] | None:
        """What a table means; None, with its mistakes noted, where it is wrong."""
        if not isinstance(values, Mapping):
            location = (prefix or heading).rstrip(": ")
            self.problems.append(f"{location} must be a table; found {format_value(values)}")
            return None
        parsed, problems = validate_table(model, dict(values), heading, prefix)
        self.problems += problems
        return None if problems else parsed

    def _try_build(self, prefix: str, build: Callable[[], _Result]) -> _Result | None:
        try:
            return build()
        except MechanismError as error:
            self.problems += [f"{prefix}{problem}" for problem in error.problems]
        return None

    def _tables_under(self, key: str) -> list[Any]:
        """The tables under a heading; what is no list at all has been told with the top of the file."""
        given = self.document.get(key, [])
        return list(given) if isinstance(given, list | tuple) else []

    def _parse_ground(self) -> None:
        given = self.document.get("ground", {})
        points = self._try_build("", lambda: parse_named_points(given, GROUND)) if isinstance(given, Mapping) else None
        if points is None:
            self.registry.invalid_bodies.add(GROUND)
        else:
            self.registry.ground |= points

    def _parse_bodies(self) -> list[SketchedBody]:
        tables = self._tables_under("body")
        if "body" in self.document and not tables and isinstance(self.document["body"], list | tuple):
            self.problems.append("body is an empty list; a mechanism needs at least one [[body]]")
        bodies = []
        for number, values in enumerate(tables, start=1):
            prefix = _message_prefix("body", values, number)
            parsed = self._validate_table(BodyTable, values, "[body]", prefix)
            problems: list[str] = []
            body = parse_body(values, parsed, self.plane, problems) if isinstance(values, Mapping) else None
            self.problems += [f"{prefix}{problem}" for problem in problems]
            if body is not None:
                self.registry.bodies.setdefault(body.name, body)
                bodies.append(body)
            elif isinstance(values, Mapping) and isinstance(values.get("name"), str):
                self.registry.invalid_bodies.add(values["name"])
        return bodies

    def _parse_joints(self, initial_layout: InitialConfiguration) -> list[Joint]:
        def make(kind: str, parsed: dict[str, Any], name: str) -> Joint:
            return JOINT_FACTORIES[kind](parsed, name, self.registry, initial_layout)

        return self._parse_typed_tables("joint", JOINT_TABLES, make)

    def _parse_force_elements(self) -> list[ForceElement]:
        def make(kind: str, parsed: dict[str, Any], name: str) -> ForceElement:
            return FORCE_FACTORIES[kind](parsed, name, self.registry)

        return self._parse_typed_tables("force", FORCE_TABLES, make)

    def _parse_typed_tables(
        self, key: str, models: Mapping[str, type[SceneFileTable]], make: Callable[[str, dict[str, Any], str], _Result]
    ) -> list[_Result]:
        """What the tables under one heading describe, each of the type that it names."""
        elements = []
        for number, values in enumerate(self._tables_under(key), start=1):
            prefix = _message_prefix(key, values, number)
            kind = _nearest_word(values.get("type"), models) if isinstance(values, Mapping) else ""
            parsed = self._validate_table(models[kind], values, f"[{key}]", prefix)
            if parsed is not None:
                element = self._try_build(prefix, lambda: make(kind, parsed, self._name_element(kind, parsed)))  # noqa: B023 - called at once
                elements += [element] if element is not None else []
        return elements

    def _parse_links(self, initial_layout: InitialConfiguration) -> list[Joint]:
        links: list[Joint] = []
        for number, values in enumerate(self._tables_under("link"), start=1):
            prefix = _message_prefix("link", values, number)
            parsed = self._validate_table(LinkTable, values, "[link]", prefix)
            if parsed is not None:
                link = self._try_build(prefix, lambda: self._build_link(parsed, initial_layout))  # noqa: B023 - called at once
                links += [link] if link is not None else []
        return links

    def _build_link(self, parsed: dict[str, Any], initial_layout: InitialConfiguration) -> Distance:
        first, second = self.registry.find_two_points(parsed)
        length = parsed.get("length") or initial_layout.distance(first, second)
        if not length:
            raise MechanismError("length is missing, and the ends of the link stand in one place in the sketch")
        return Distance(name=self._name_element("link", parsed), first=first, second=second, length=length)

    def _name_element(self, kind: str, parsed: Mapping[str, Any]) -> str:
        """The name given, or one that says what it is and of what."""
        if parsed.get("name"):
            return str(parsed["name"])
        first, second = find_connected_bodies(parsed)
        default_name = f"{kind.replace('_', ' ')} of {first} and {second}"
        tables = [table for key in ("joint", "link", "force") for table in self._tables_under(key) if isinstance(table, Mapping)]
        used_names = {table["name"] for table in tables if isinstance(table.get("name"), str)}
        return self.registry.make_unique_name(default_name, used_names)

    def _check_unique_names(self, bodies: Iterable[SketchedBody], joints: Iterable[Joint], force_elements: Iterable[ForceElement]) -> None:
        for element_type, elements in (("body", bodies), ("joint or link", joints), ("force", force_elements)):
            self.problems += [
                f"{element_type} {name!r} stands {count} times; names must differ"
                for name, count in Counter(item.name for item in elements).items()
                if count > 1
            ]

    def _check_connections(self, bodies: list[SketchedBody], joints: list[Joint], force_elements: list[ForceElement]) -> None:
        for first, second in conflicting_drivers(joints):
            self.problems.append(
                f"joints {first.name!r} and {second.name!r} drive the same two bodies, "
                f"{first.first.body!r} and {first.second.body!r}; leave one of them out"
            )
        # A table that could not be understood may be what holds a body.
        is_fully_parsed = self.is_complete and not self.problems
        unconnected = unconnected_bodies([body.name for body in bodies], joints, force_elements) if is_fully_parsed else []
        if unconnected:
            names = join_names(repr(name) for name in unconnected)
            first_unconnected = next(body for body in bodies if body.name == unconnected[0])
            mobility_text = (
                f"it keeps a mobility of {3 if first_unconnected.can_rotate else 2}"
                if len(unconnected) == 1
                else "they keep one of 2 or more"
            )
            self.problems.append(
                f"nothing holds {'body' if len(unconnected) == 1 else 'bodies'} {names} to the ground, and {mobility_text}: "
                "no chain of joints, links, springs or dampers leads there; add a [[joint]] or a [[link]]"
            )

    def _parse_readings(self, bodies: Iterable[SketchedBody]) -> list[Reading]:
        given = self.document.get("readings")
        if not given or not isinstance(given, Mapping):
            return make_default_readings(bodies)
        readings = []
        for name, values in given.items():
            reading = self._parse_reading(str(name), values)
            readings += [reading] if reading is not None else []
        return readings

    def _parse_reading(self, name: str, values: object) -> Reading | None:
        prefix = f"readings.{name}"
        if not name.isidentifier():
            self.problems.append(f"{prefix}: the name of a reading is made of letters, digits and _, as crank_angle")
            return None
        keys = list(values) if isinstance(values, Mapping) else []
        kinds = [key for key in keys if key in READING_TABLES] or [
            nearest for key in keys if (nearest := _nearest_word(key, READING_TABLES))
        ]
        if len(kinds) != 1:
            known_kinds = ", ".join(READING_TABLES)
            self.problems.append(
                f'{prefix} must be a table with one of {known_kinds}; found {format_value(values)}; write {name} = {{ angle = "crank" }}'
            )
            return None
        parsed = self._validate_table(READING_TABLES[kinds[0]], values, prefix)
        if parsed is None:
            return None
        return self._try_build(f"{prefix}: ", lambda: make_custom_reading(kinds[0], parsed, name, self.registry))

    def _record_readings(self, readings: list[Reading], bodies: list[SketchedBody]) -> None:
        readings_table = self.document.get("readings")
        parsed_and_written = (
            (len(readings), len(readings_table))
            if readings_table and isinstance(readings_table, Mapping)
            else (len(bodies), len(self._tables_under("body")))
        )
        self.readings = tuple(readings) if readings and parsed_and_written[0] == parsed_and_written[1] else None

    def _parse_start(self, readings: list[Reading]) -> Start:
        given = self.document.get("start", {})
        if not isinstance(given, Mapping) or not readings:
            return Start()
        readings_table = self.document.get("readings")
        if isinstance(readings_table, Mapping) and len(readings) < len(readings_table):
            return Start()  # a reading that could not be understood may be meant
        rates = assign_rate_keys(readings)
        model = start_table_model(tuple((item.name, item.quantity, rates[item.name]) for item in readings))
        parsed = self._validate_table(model, given, "start") or {}
        return Start(
            values={item.name: parsed[item.name] for item in readings if item.name in parsed},
            rates={item.name: parsed[rates[item.name]] for item in readings if rates[item.name] in parsed},
        )


def assign_rate_keys(readings: Iterable[Reading]) -> dict[str, str]:
    """The key in [start] of each reading's rate, by its name; as short as can be told apart."""
    names = [reading.name for reading in readings]
    short_key_counts = Counter(rate_key(name) for name in names)
    return {
        name: rate_key(name) if short_key_counts[rate_key(name)] == 1 and rate_key(name) not in names else f"{name}_rate" for name in names
    }


def _start_reading_order(start: object, readings: list[Reading]) -> list[str]:
    """The readings that [start] names, by value or by rate, as they stand there."""
    by_key = {key: name for name, key in assign_rate_keys(readings).items()} | {item.name: item.name for item in readings}
    return [by_key[key] for key in start if key in by_key] if isinstance(start, Mapping) else []


def _message_prefix(key: str, values: object, number: int) -> str:
    """How messages call one of the tables under a heading: by its name, else by its number."""
    name = values.get("name") if isinstance(values, Mapping) else None
    return f"{key} {format_value(name)}: " if isinstance(name, str) and name else f"{key} {number}: "


def _nearest_word(word: object, known_words: Iterable[str]) -> str:
    """The known name that a word is, or is nearest to; '' where none is near."""
    names = [name for name in known_words if name]
    return next(iter(difflib.get_close_matches(word, names, n=1)), "") if isinstance(word, str) else ""
