"""The tables of a document that is being composed with their checks, and the bodies and points in it that the builder hands out."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Final, TypeAlias

from governor_mechanism.errors import MechanismError, did_you_mean, require_positive
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.part import FIXED_PLANE, TURNING_PLANE
from governor_mechanism.scenes.custom.contacts import CONTACT
from governor_mechanism.scenes.custom.field_types import PointRegistry, is_moving, parse_moving_point
from governor_mechanism.scenes.custom.parser import parse_take
from governor_mechanism.scenes.custom.parts import (
    BODY,
    FORCE_TABLES,
    JOINT_TABLES,
    JOINT_TYPES,
    LINK,
    POINT_MASS,
    READING_TABLES,
    ElementTable,
    find_reading_kind,
)
from governor_mechanism.scenes.quantities import parse_name, parse_position
from governor_mechanism.units.problems import Problem, unknown_name
from governor_mechanism.units.quantities import format_value, parse_quantity

_TABLES: Final[Mapping[str, Mapping[str, ElementTable]]] = {"joint": JOINT_TABLES, "force": FORCE_TABLES, "link": {"link": LINK}}
"""Tables by the key of their list and by type."""

_SHAPE_KEY = re.compile(r"\b(?:rod|disc|plate|curve)\.(?=[a-z])")
"""Beginning of a key of a table that is no argument of its own in Python."""


class CallChecks:
    """The bodies and points that a builder has so far, and the checks of what is added."""

    def __init__(
        self,
        plane: str,  # the plane of the mechanism
    ) -> None:
        self._registry = PointRegistry(plane)

    def check_body(self, what: str, table: Mapping[str, Any]) -> None:
        """Check a body with its points and masses, and make it known."""
        with _at(f"{what}:"):
            body = BODY.build(table, self._registry)
        self._registry.bodies[body.name] = body

    def check_new_name(self, what: str, name: str) -> None:
        """Refuse a second body of a name."""
        if name in self._registry.bodies:
            raise MechanismError(f"{what}: there already is a body {name!r}; choose another name")

    def check_ground(self, name: str, position: list[Any]) -> None:
        """Check a point of the ground, and make it known."""
        what = f"ground point {name!r}:"
        with _at(what):
            if is_moving(position):
                self._registry.moving_points[name], _ = parse_moving_point(f"ground.{name}", position)
            else:
                self._registry.ground[name] = parse_position(position, what)

    def check_joint_type(self, kind: object) -> None:
        """Refuse a type of joint that no scene file knows."""
        if kind not in JOINT_TYPES:
            raise unknown_name(f"joint: type {format_value(kind)} is unknown; types are", kind, JOINT_TYPES)

    def check_element(self, key: str, kind: str, what: str, table: Mapping[str, Any]) -> None:
        """Check a joint, link or force."""
        with _at(f"{what}:"):
            _TABLES[key][kind].read_ends(table, self._registry)

    def check_contact(self, what: str, table: Mapping[str, Any]) -> None:
        """Check a contact of a roller and an outline."""
        with _at(f"{what}:"):
            CONTACT.build(table, self._registry)

    def check_assembly(self, take: object) -> None:
        """Refuse what chooses no assembly."""
        with _at("assembly"):
            parse_take(take)

    def check_reading(self, name: str, table: Mapping[str, Any]) -> None:
        """Check what is read off the mechanism."""
        what = f"reading {name!r}:"
        kind = find_reading_kind(table)
        if not name.isidentifier():
            raise MechanismError(f"{what} the name consists of letters, digits and _, as crank_angle")
        if not kind:
            raise MechanismError(f"{what} one of angle, line, distance, x and y says what is read; none is given")
        with _at(what):
            READING_TABLES[kind].read(table, self._registry)


def check_point(what: str, x: object, y: object) -> None:
    """Check a position in the axes of a body."""
    parse_position([x, y], f"{what}:")


def check_mass(what: str, table: Mapping[str, Any]) -> None:
    """Check a mass that is fixed to a body."""
    with _at(f"{what}:"):
        POINT_MASS.read(table)


def check_name(what: str, name: object) -> str:
    """Return a name that others refer to; refuse one with a dot, of several lines, empty, or too long."""
    return parse_name(name, f"the name of {what}")


@contextmanager
def _at(what: str) -> Iterator[None]:
    """State the mistakes of tables with the arguments of Python."""
    try:
        yield
    except MechanismError as error:
        problems = (str(Problem(problem).at(what)) for problem in error.problems)
        raise MechanismError(*(_SHAPE_KEY.sub("", problem) for problem in problems)) from None


Quantity: TypeAlias = float | str
"""A number in SI, or text with a unit."""

Program: TypeAlias = float | str | Sequence[Any] | Mapping[str, Any]
"""A quantity, or what scene files write for one that changes: [[time, value], ...], a formula, harmonics, or a function of a reading."""

OWN_POINTS: Final = ("origin", "centre")
"""Points that every body has: the origin of its axes, and its mass centre."""


@dataclass(frozen=True)
class BuiltPoint:
    """A point of a body, or of the ground."""

    body: str  # name of the body
    reference: str | tuple[str, Quantity, Quantity]  # what scene files write for it: "body.point", or [body, x, y]

    def __repr__(self) -> str:
        """Return the point as scene files write it."""
        return self.reference if isinstance(self.reference, str) else f"{self.body}({self.reference[1]}, {self.reference[2]})"


@dataclass(frozen=True, eq=False)
class BuiltBody:
    """A body of a mechanism that is being built."""

    name: str  # name of the body
    table: dict[str, Any]  # its table in the document
    check: Callable[[Mapping[str, Any]], None]  # check of a table that shall take the place of its own
    shape_points: tuple[str, ...] = ()  # names of the points that its shape brings

    @property
    def origin(self) -> BuiltPoint:
        """The origin of its axes: the start of a rod, the centre of a disc or plate."""
        return BuiltPoint(self.name, f"{self.name}.origin")

    @property
    def centre(self) -> BuiltPoint:
        """Its mass centre."""
        return BuiltPoint(self.name, f"{self.name}.centre")

    @property
    def point_names(self) -> tuple[str, ...]:
        """Names of its points."""
        return (*self.shape_points, *self.table.get("points", ()), *OWN_POINTS)

    def point(self, x: Quantity, y: Quantity = 0.0, name: str = "") -> BuiltPoint:
        """Return a point at [x, y] in the axes of the body, m or texts with a unit; a rod lies along x from its start.

        With a name it stands in the document, and `body[name]` returns it again. Raises MechanismError if a coordinate
        is no length, the name is none, or the body has a point of this name.
        """
        if not isinstance(name, str) or name:
            check_name(f"a point of body {self.name!r}", name)
        check_point(f"point of body {self.name!r}", x, y)
        if not name:
            return BuiltPoint(self.name, (self.name, x, y))
        if name in self.point_names:
            raise MechanismError(f"body {self.name!r} already has a point {name!r}; choose another name")
        points = {**self.table.get("points", {}), name: [x, y]}
        self.check({**self.table, "points": points})
        self.table["points"] = points
        return BuiltPoint(self.name, f"{self.name}.{name}")

    def add_mass(self, mass: Quantity, at: BuiltPoint | Sequence[Quantity], radius: Quantity | None = None) -> None:
        """Fix a mass (kg or text with a unit) to the body, at [x, y] in its axes or one of its points.

        With a `radius`, m or text with a unit, it is a solid ball. Raises MechanismError if the position is none of
        this body, or a quantity is wrong.
        """
        position = self._position_of(at) if isinstance(at, BuiltPoint) else list(at) if isinstance(at, Iterable) else at
        ball = {"mass": mass, "at": position} | ({} if radius is None else {"radius": radius})
        check_mass(f"mass on body {self.name!r}", ball)
        balls = [*self.table.get("point_masses", ()), ball]
        self.check({**self.table, "point_masses": balls})
        self.table["point_masses"] = balls

    def set_outline(self, outline: Sequence[Any] | Mapping[str, Any]) -> None:
        """Give the body an outline for rollers of other bodies; raise MechanismError if it crosses itself, or a value is wrong.

        It is a list of corners [x, y], or [x, y, radius] where an arc begins, or {"curve": ..., "inset": ...} for a
        closed curve, as in scene files.
        """
        table = {**self.table, "outline": plain_list(outline)}
        self.check(table)
        self.table["outline"] = table["outline"]

    def _position_of(self, point: BuiltPoint) -> list[Any]:
        """Return the coordinates of a point of this body."""
        if point.body != self.name:
            raise MechanismError(f"a mass on body {self.name!r} needs a point of that body; found {point!r}")
        if not isinstance(point.reference, str):
            return list(point.reference[1:])
        name = point.reference.removeprefix(f"{self.name}.")
        known = {"origin": [0.0, 0.0], "start": [0.0, 0.0], **self.table.get("points", {})}
        known |= {"end": [self.table["rod"]["length"], 0.0]} if "rod" in self.table else {}
        if name not in known:
            raise MechanismError(f"the position of {point!r} follows from the masses; give [x, y] in the axes of the body")
        return list(known[name])

    def __getitem__(self, name: str) -> BuiltPoint:
        """Return a point of the body by its name."""
        if name not in self.point_names:
            names = ", ".join(self.point_names)
            raise MechanismError(
                f"body {self.name!r} has no point {format_value(name)}; known are {names}.{did_you_mean(name, self.point_names)}"
            )
        return BuiltPoint(self.name, f"{self.name}.{name}")

    def __repr__(self) -> str:
        """Return the name and the points of the body."""
        return f"{type(self).__name__}({self.name!r}; points {', '.join(self.point_names)})"


@dataclass(frozen=True, eq=False, repr=False)
class BuiltRod(BuiltBody):
    """A slender rod of a mechanism that is being built."""

    shape_points: tuple[str, ...] = ("start", "end")

    @property
    def start(self) -> BuiltPoint:
        """Its first end, the origin of its axes."""
        return BuiltPoint(self.name, f"{self.name}.start")

    @property
    def end(self) -> BuiltPoint:
        """Its second end."""
        return BuiltPoint(self.name, f"{self.name}.end")


def point_reference(what: str, point: object) -> Any:
    """Return a point as the document writes it; `what` needs it."""
    if isinstance(point, BuiltPoint):
        return point.reference if isinstance(point.reference, str) else list(point.reference)
    if isinstance(point, BuiltBody):
        names = ", ".join(f"{point.name}.{name}" for name in point.point_names)
        raise MechanismError(f"{what} takes points; found body {point.name!r}, whose points are {names}; others are made by point(x, y)")
    raise MechanismError(f"{what} takes points, as crank.end, or what ground(x, y) returns; found {format_value(point)}")


def body_reference(what: str, body: object) -> str:
    """Return a body as the document writes it; None is the ground."""
    if body is None:
        return GROUND
    if isinstance(body, BuiltBody):
        return body.name
    raise MechanismError(
        f"{what} takes a body, as what rod(...) returns; found {body if isinstance(body, BuiltPoint) else format_value(body)}"
    )


def body_or_point_reference(what: str, end: object) -> Any:
    """Return a body or a point as the document writes it; None is the ground."""
    return point_reference(what, end) if isinstance(end, BuiltPoint) else body_reference(what, end)


METHODS: Final = {"driven_turn": "motor", "driven_slide": "actuator"}
"""Methods of the builder by the type of the joint, where the names differ."""


class DocumentTables:
    """The keys, tables and lists of tables of a scene file, in the order in which they are added."""

    def __init__(self, title: str, *, plane: str = FIXED_PLANE, size: Quantity | None = None) -> None:
        _check_keys(title, plane, size)
        self._keys: dict[str, Any] = {"title": title, "machine": CUSTOM_MACHINE, "plane": plane, **given_values(size=size)}
        self._tables: dict[str, dict[str, Any]] = {}
        self._lists: dict[str, list[dict[str, Any]]] = {}

    def __repr__(self) -> str:
        """Return the title and the names of what there is."""
        names = {key: ", ".join(str(one.get("name", one.get("type", key))) for one in tables) for key, tables in self._lists.items()}
        return f"{type(self).__name__}({self._keys['title']!r}{''.join(f'; {key}: {text}' for key, text in names.items())})"

    @property
    def given_document(self) -> dict[str, Any]:
        """The document with what was given, without a first configuration."""
        return {**self._keys, **self._tables, **self._lists}

    @cached_property
    def _checks(self) -> CallChecks:
        return CallChecks(self._keys["plane"])

    def _add(self, key: str, what: str, name: str = "", **table: Any) -> None:
        """Add a joint, link or force; `what` is the method that does."""
        label = f"{what} {name!r}" if isinstance(name, str) and name else what
        table = {**({"type": table.pop("type")} if "type" in table else {}), **name_of(name), **table}
        self._checks.check_element(key, table.get("type", key), label, table)
        self._lists.setdefault(key, []).append(table)

    def _add_body(
        self, what: str, name: str, mass: Quantity, angle: Quantity | None, at: Sequence[Quantity] | None, **shape: Any
    ) -> tuple[dict[str, Any], Callable[[Mapping[str, Any]], None]]:
        """Add a body; return its table, and the check of a table that shall take its place."""
        label = f"{what} {format_value(name)}"
        table = {"name": name, "mass": mass, **shape, **given_values(at=plain_list(at), angle=angle)}
        checks = self._checks
        if isinstance(name, str):
            checks.check_new_name(label, name)
        checks.check_body(label, table)
        self._lists.setdefault("body", []).append(table)
        return table, partial(checks.check_body, label)

    def _join(self, kind: str, first: BuiltPoint, second: BuiltPoint, name: str, **values: Any) -> None:
        what = METHODS.get(kind, kind)
        ends = {"first": point_reference(what, first), "second": point_reference(what, second)}
        self._add("joint", what, name, type=kind, **ends, **given_values(**values))

    def _couple(self, kind: str, first: object, second: object, name: str, **values: Any) -> None:
        what = METHODS.get(kind, kind)
        ends = {"first": body_or_point_reference(what, first), "second": body_or_point_reference(what, second)}
        self._add("joint", what, name, type=kind, **ends, **given_values(**values))

    def _push(self, kind: str, first: BuiltPoint, second: BuiltPoint, name: str, **values: Any) -> None:
        ends = {"first": point_reference(kind, first), "second": point_reference(kind, second)}
        self._add("force", kind, name, type=kind, **ends, **given_values(**values))


def plain_list(value: Any) -> Any:
    """Return a list, tuple or array as a list, also inside; anything else as it is, for the parser to refuse."""
    if isinstance(value, str | Mapping) or not isinstance(value, Iterable):
        return value
    return [plain_list(item) for item in value]


def given_values(**values: Any) -> dict[str, Any]:
    """Return the values that are given."""
    return {key: value for key, value in values.items() if value is not None}


def name_of(name: str) -> dict[str, str]:
    """Return the name of an element if it is given; the parser makes others of the type and the bodies."""
    return {} if isinstance(name, str) and not name else {"name": name}


def _check_keys(title: object, plane: object, size: object) -> None:
    """Raise MechanismError for what no scene has as its title, plane and size."""
    if not isinstance(title, str) or not title.strip():
        raise MechanismError(f"title must be text; found {format_value(title)}")
    if plane not in (FIXED_PLANE, TURNING_PLANE):
        raise MechanismError(f"plane must be {FIXED_PLANE!r} or {TURNING_PLANE!r}; found {format_value(plane)}")
    if size is not None:
        require_positive(parse_quantity(size, "length", "size"), "m", "size")
