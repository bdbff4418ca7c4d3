"""The tables of a document that is being composed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from governor_mechanism.building.handles import BuiltPoint, Quantity, body_or_point_reference, point_reference
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.part import FIXED_PLANE

METHODS: Final = {"driven_turn": "motor", "driven_slide": "actuator"}
"""Methods of the builder by the type of the joint, where the names differ."""


class DocumentTables:
    """The keys, tables and lists of tables of a scene file, in the order in which they are added."""

    def __init__(self, title: str, *, plane: str = FIXED_PLANE, size: Quantity | None = None) -> None:
        self._keys: dict[str, Any] = {"title": title, "machine": CUSTOM_MACHINE, "plane": plane, **given_values(size=size)}
        self._tables: dict[str, dict[str, Any]] = {}
        self._lists: dict[str, list[dict[str, Any]]] = {}

    def __repr__(self) -> str:
        """Return the title and the names of what there is."""
        names = {key: ", ".join(str(one.get("name", one.get("type", key))) for one in tables) for key, tables in self._lists.items()}
        return f"{type(self).__name__}({self._keys['title']!r}{''.join(f'; {key}: {text}' for key, text in names.items())})"

    def _add(self, key: str, **table: Any) -> dict[str, Any]:
        self._lists.setdefault(key, []).append(table)
        return table

    def _add_body(self, name: str, mass: Quantity, angle: Quantity | None, at: Sequence[Quantity] | None, **shape: Any) -> dict[str, Any]:
        pose = given_values(at=plain_list(at), angle=angle)
        return self._add("body", name=name, mass=mass, **shape, **pose)

    def _join(self, kind: str, first: BuiltPoint, second: BuiltPoint, name: str, **values: Any) -> None:
        what = METHODS.get(kind, kind)
        ends = {"first": point_reference(what, first), "second": point_reference(what, second)}
        self._add("joint", type=kind, **name_of(name), **ends, **given_values(**values))

    def _couple(self, kind: str, first: object, second: object, name: str, **values: Any) -> None:
        what = METHODS.get(kind, kind)
        ends = {"first": body_or_point_reference(what, first), "second": body_or_point_reference(what, second)}
        self._add("joint", type=kind, **name_of(name), **ends, **given_values(**values))

    def _push(self, kind: str, first: BuiltPoint, second: BuiltPoint, name: str, **values: Any) -> None:
        ends = {"first": point_reference(kind, first), "second": point_reference(kind, second)}
        self._add("force", type=kind, **name_of(name), **ends, **given_values(**values))


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
    return {"name": name} if name else {}
