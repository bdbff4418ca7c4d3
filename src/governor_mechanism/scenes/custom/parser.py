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
    CUSTOM,
    Sketch,
    Sketched,
    contradictory_drives,
    custom_mechanism,
    size_of,
    unheld,
)
from governor_mechanism.model.force_elements import Load
from governor_mechanism.model.joints import GROUND, Distance, Joint
from governor_mechanism.model.mechanism import Mechanism, Reading
from governor_mechanism.model.scene import FIXED, TURNING, Part, Start
from governor_mechanism.scenes.custom.bodies import Places, sketched
from governor_mechanism.scenes.custom.joints import (
    FORCE_MAKERS,
    JOINT_MAKERS,
    bodies_named,
    default_readings,
    reading_of,
)
from governor_mechanism.scenes.custom.schema import FORCES, JOINTS, READINGS, BodyTable, LinkTable
from governor_mechanism.scenes.custom.values import points_of
from governor_mechanism.scenes.quantities import listed
from governor_mechanism.scenes.schema import Table, rate_key, start_table_of, understood
from governor_mechanism.units.quantities import shown

PART = "mechanism"
"""The name of the only part."""

_Made = TypeVar("_Made")


@dataclass(frozen=True)
class Described:
    """What a file describes: None where mistakes stand in the way, each told in `problems`."""

    part: Part | None
    start: Start
    readings: tuple[Reading, ...] | None
    problems: list[str]


def described(document: Mapping[str, Any], top: Mapping[str, Any]) -> Described:
    """The part and the start of a document; `top` is what could be understood of its keys above the tables."""
    reader = _Reader(document, top)
    mechanism, start = reader.mechanism()
    if mechanism is None:
        return Described(None, start, reader.readings, reader.problems)
    part = Part(name=PART, machine=CUSTOM, dimensions={}, mechanism=mechanism, plane=reader.plane)
    return Described(part, start, reader.readings, reader.problems)


class _Reader:
    """Reads one document; notes the mistakes met."""

    def __init__(self, document: Mapping[str, Any], top: Mapping[str, Any]) -> None:
        self.problems: list[str] = []
        self.document = document
        self.complete = bool(top)  # else a table may be missing only because its heading is misspelt
        self.given_size: float | None = top.get("size")
        plane = document.get("plane")
        self.plane = plane if plane in (FIXED, TURNING) else TURNING if "spindle" in document else FIXED
        self.places = Places()
        self.readings: tuple[Reading, ...] | None = None
        """All readings; None where one could not be understood."""

    def mechanism(self) -> tuple[Mechanism | None, Start]:
        """The mechanism, or None where there are mistakes, and the start."""
        self._ground()
        bodies = self._bodies()
        sketch = Sketch(bodies)
        joints = [*self._joints(sketch), *self._links(sketch)]
        loads = self._loads()
        self._refuse_repeated(bodies, joints, loads)
        self._refuse_contradictions(bodies, joints, loads)
        readings = self._readings(bodies)
        self._note(readings, bodies)
        start = self._start(readings)
        size = self.given_size or size_of(bodies, joints, loads)
        if not size and self.complete and not self.problems:
            self.problems.append('size is missing: the sketch has no length to refer accuracies to; write size = "1 m"')
        if self.problems or not self.complete:
            return None, start
        coordinate = next(iter(_in_order(self.document.get("start", {}), readings)), readings[0].name)
        made = self._made("", lambda: custom_mechanism(bodies, joints, loads, readings, coordinate, size))
        return made, start

    def _table(
        self, model: type[Table], values: object, heading: str, prefix: str | None = None
    ) -> dict[str, Any] | None:
        """What a table means; None, with its mistakes noted, where it is wrong."""
        if not isinstance(values, Mapping):
            where = (prefix or heading).rstrip(": ")
            self.problems.append(f"{where} must be a table; found {shown(values)}")
            return None
        meaning, problems = understood(model, dict(values), heading, prefix)
        self.problems += problems
        return None if problems else meaning

    def _made(self, prefix: str, make: Callable[[], _Made]) -> _Made | None:
        try:
            return make()
        except MechanismError as error:
            self.problems += [f"{prefix}{problem}" for problem in error.problems]
        return None

    def _list(self, key: str) -> list[Any]:
        """The tables under a heading; what is no list at all has been told with the top of the file."""
        given = self.document.get(key, [])
        return list(given) if isinstance(given, list | tuple) else []

    def _ground(self) -> None:
        given = self.document.get("ground", {})
        points = self._made("", lambda: points_of(given, GROUND)) if isinstance(given, Mapping) else None
        if points is None:
            self.places.faulty.add(GROUND)
        else:
            self.places.ground |= points

    def _bodies(self) -> list[Sketched]:
        tables = self._list("body")
        if "body" in self.document and not tables and isinstance(self.document["body"], list | tuple):
            self.problems.append("body is an empty list; a mechanism needs at least one [[body]]")
        found = []
        for number, values in enumerate(tables, start=1):
            prefix = _prefix("body", values, number)
            meaning = self._table(BodyTable, values, "[body]", prefix)
            problems: list[str] = []
            body = sketched(values, meaning, self.plane, problems) if isinstance(values, Mapping) else None
            self.problems += [f"{prefix}{problem}" for problem in problems]
            if body is not None:
                self.places.bodies.setdefault(body.name, body)
                found.append(body)
            elif isinstance(values, Mapping) and isinstance(values.get("name"), str):
                self.places.faulty.add(values["name"])
        return found

    def _joints(self, sketch: Sketch) -> list[Joint]:
        def make(kind: str, meaning: dict[str, Any], name: str) -> Joint:
            return JOINT_MAKERS[kind](meaning, name, self.places, sketch)

        return self._typed("joint", JOINTS, make)

    def _loads(self) -> list[Load]:
        def make(kind: str, meaning: dict[str, Any], name: str) -> Load:
            return FORCE_MAKERS[kind](meaning, name, self.places)

        return self._typed("force", FORCES, make)

    def _typed(
        self, key: str, models: Mapping[str, type[Table]], make: Callable[[str, dict[str, Any], str], _Made]
    ) -> list[_Made]:
        """What the tables under one heading describe, each of the type that it names."""
        found = []
        for number, values in enumerate(self._list(key), start=1):
            prefix = _prefix(key, values, number)
            kind = _nearest(values.get("type"), models) if isinstance(values, Mapping) else ""
            meaning = self._table(models[kind], values, f"[{key}]", prefix)
            if meaning is not None:
                made = self._made(prefix, lambda: make(kind, meaning, self._name(kind, meaning)))  # noqa: B023 - called at once
                found += [made] if made is not None else []
        return found

    def _links(self, sketch: Sketch) -> list[Joint]:
        found: list[Joint] = []
        for number, values in enumerate(self._list("link"), start=1):
            prefix = _prefix("link", values, number)
            meaning = self._table(LinkTable, values, "[link]", prefix)
            if meaning is not None:
                link = self._made(prefix, lambda: self._link(meaning, sketch))  # noqa: B023 - called at once
                found += [link] if link is not None else []
        return found

    def _link(self, meaning: dict[str, Any], sketch: Sketch) -> Distance:
        first, second = self.places.two(meaning)
        length = meaning.get("length") or sketch.distance(first, second)
        if not length:
            raise MechanismError("length is missing, and the ends of the link stand in one place in the sketch")
        return Distance(name=self._name("link", meaning), first=first, second=second, length=length)

    def _name(self, kind: str, meaning: Mapping[str, Any]) -> str:
        """The name given, or one that says what it is and of what."""
        if meaning.get("name"):
            return str(meaning["name"])
        first, second = bodies_named(meaning)
        plain = f"{kind.replace('_', ' ')} of {first} and {second}"
        tables = [
            table for key in ("joint", "link", "force") for table in self._list(key) if isinstance(table, Mapping)
        ]
        taken = {table["name"] for table in tables if isinstance(table.get("name"), str)}
        return self.places.unused(plain, taken)

    def _refuse_repeated(self, bodies: Iterable[Sketched], joints: Iterable[Joint], loads: Iterable[Load]) -> None:
        for what, group in (("body", bodies), ("joint or link", joints), ("force", loads)):
            self.problems += [
                f"{what} {name!r} stands {count} times; names must differ"
                for name, count in Counter(item.name for item in group).items()
                if count > 1
            ]

    def _refuse_contradictions(self, bodies: list[Sketched], joints: list[Joint], loads: list[Load]) -> None:
        for one, other in contradictory_drives(joints):
            self.problems.append(
                f"joints {one.name!r} and {other.name!r} drive the same two bodies, "
                f"{one.first.body!r} and {one.second.body!r}; leave one of them out"
            )
        # A table that could not be understood may be what holds a body.
        known = self.complete and not self.problems
        loose = unheld([body.name for body in bodies], joints, loads) if known else []
        if loose:
            names = listed(repr(name) for name in loose)
            lonely = next(body for body in bodies if body.name == loose[0])
            keeps = (
                f"it keeps a mobility of {3 if lonely.turns else 2}"
                if len(loose) == 1
                else "they keep one of 2 or more"
            )
            self.problems.append(
                f"nothing holds {'body' if len(loose) == 1 else 'bodies'} {names} to the ground, and {keeps}: "
                "no chain of joints, links, springs or dampers leads there; add a [[joint]] or a [[link]]"
            )

    def _readings(self, bodies: Iterable[Sketched]) -> list[Reading]:
        given = self.document.get("readings")
        if not given or not isinstance(given, Mapping):
            return default_readings(bodies)
        found = []
        for name, values in given.items():
            reading = self._reading(str(name), values)
            found += [reading] if reading is not None else []
        return found

    def _reading(self, name: str, values: object) -> Reading | None:
        prefix = f"readings.{name}"
        if not name.isidentifier():
            self.problems.append(f"{prefix}: the name of a reading is made of letters, digits and _, as crank_angle")
            return None
        keys = list(values) if isinstance(values, Mapping) else []
        kinds = [key for key in keys if key in READINGS] or [near for key in keys if (near := _nearest(key, READINGS))]
        if len(kinds) != 1:
            one = ", ".join(READINGS)
            self.problems.append(
                f"{prefix} must be a table with one of {one}; found {shown(values)}; "
                f'write {name} = {{ angle = "crank" }}'
            )
            return None
        meaning = self._table(READINGS[kinds[0]], values, prefix)
        if meaning is None:
            return None
        return self._made(f"{prefix}: ", lambda: reading_of(kinds[0], meaning, name, self.places))

    def _note(self, readings: list[Reading], bodies: list[Sketched]) -> None:
        written = self.document.get("readings")
        counts = (
            (len(readings), len(written))
            if written and isinstance(written, Mapping)
            else (len(bodies), len(self._list("body")))
        )
        self.readings = tuple(readings) if readings and counts[0] == counts[1] else None

    def _start(self, readings: list[Reading]) -> Start:
        given = self.document.get("start", {})
        if not isinstance(given, Mapping) or not readings:
            return Start()
        written = self.document.get("readings")
        if isinstance(written, Mapping) and len(readings) < len(written):
            return Start()  # a reading that could not be understood may be meant
        rates = rate_keys(readings)
        model = start_table_of(tuple((item.name, item.quantity, rates[item.name]) for item in readings))
        meaning = self._table(model, given, "start") or {}
        return Start(
            values={item.name: meaning[item.name] for item in readings if item.name in meaning},
            rates={item.name: meaning[rates[item.name]] for item in readings if rates[item.name] in meaning},
        )


def rate_keys(readings: Iterable[Reading]) -> dict[str, str]:
    """The key in [start] of each reading's rate, by its name; as short as can be told apart."""
    names = [reading.name for reading in readings]
    short = Counter(rate_key(name) for name in names)
    return {
        name: rate_key(name) if short[rate_key(name)] == 1 and rate_key(name) not in names else f"{name}_rate"
        for name in names
    }


def _in_order(start: object, readings: list[Reading]) -> list[str]:
    """The readings that [start] names, by value or by rate, as they stand there."""
    by_key = {key: name for name, key in rate_keys(readings).items()} | {item.name: item.name for item in readings}
    return [by_key[key] for key in start if key in by_key] if isinstance(start, Mapping) else []


def _prefix(key: str, values: object, number: int) -> str:
    """How messages call one of the tables under a heading: by its name, else by its number."""
    name = values.get("name") if isinstance(values, Mapping) else None
    return f"{key} {shown(name)}: " if isinstance(name, str) and name else f"{key} {number}: "


def _nearest(word: object, known: Iterable[str]) -> str:
    """The known name that a word is, or is nearest to; '' where none is near."""
    names = [name for name in known if name]
    return next(iter(difflib.get_close_matches(word, names, n=1)), "") if isinstance(word, str) else ""
