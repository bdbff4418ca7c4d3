"""Checks of what a method of the builder adds, when it is called, by the tables of scene files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.scenes.custom.assembly import parse_take
from governor_mechanism.scenes.custom.field_types import PointRegistry, is_moving, parse_moving_point
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
from governor_mechanism.units.quantities import format_value

_TABLES: Final[Mapping[str, Mapping[str, ElementTable]]] = {"joint": JOINT_TABLES, "force": FORCE_TABLES, "link": {"link": LINK}}
"""Tables by the key of their list and by type."""

_SHAPE_KEY = re.compile(r"\b(?:rod|disc|plate|curve)\.(?=[a-z])")
"""Beginning of a key of a table that is no argument of its own in Python."""


class CallChecks:
    """The bodies and points that a builder has so far, and the checks of what is added.

    Parameters
    ----------
    plane
        The plane of the mechanism.
    """

    def __init__(self, plane: str) -> None:
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
