"""The tables of a document that is being composed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any, Final

from governor_mechanism.building.call_checks import CallChecks
from governor_mechanism.building.handles import BuiltPoint, Quantity, body_or_point_reference, point_reference
from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.part import FIXED_PLANE, TURNING_PLANE
from governor_mechanism.units.quantities import format_value, parse_quantity

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
