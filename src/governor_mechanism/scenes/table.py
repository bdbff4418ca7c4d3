"""Tables of a scene file, read by what the fields of a class declare."""

import dataclasses
import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import Any, Final

from governor_mechanism.errors import did_you_mean
from governor_mechanism.scenes.quantities import VALUE_TYPES, ValueType
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.problems import KEY, ProblemCode, ProblemCollector, parse_each, wrong_value

TOP_LEVEL_KEYS: Final = ("machine", "title", "dimensions", "effects", "spindle", "start", "run", "events")
"""Keys of a scene file outside its tables, and its tables."""


def _find_nothing(*_: Any) -> Iterable[str]:
    return ()


def unknown_key_message(known_keys: Iterable[str], key: str, value: object) -> str:
    """Return the message about an unknown key of a table."""
    known = list(known_keys)
    elsewhere = f" {key!r} belongs above the first [table], or is a table of its own." if key in TOP_LEVEL_KEYS else ""
    return f"{KEY}.{key} is unknown; known keys are {', '.join(known)}.{elsewhere or did_you_mean(key, known)}"


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of a scene file. Every mistake is reported as a sentence, with `KEY` for the path of the table."""

    make: Callable[..., Any]  # what the table describes: its keys, except `type`, are the arguments
    fields: Mapping[str, Declaration]  # what its keys hold, by argument
    # how values are written, by form
    types: Mapping[str, ValueType] = dataclasses.field(default_factory=lambda: VALUE_TYPES)
    summary: str = ""  # what the table describes, in a sentence
    example: str = ""  # a valid table, for messages
    # function of the values read, which yields their mistakes if no key has one
    check: Callable[[Mapping[str, Any]], Iterable[str]] = _find_nothing
    # function of the table as it is written and of what its reader knows besides, which yields the problems
    # of keys that are missing, or exclude each other. A mere sentence is a conflict.
    find_conflicts: Callable[[Mapping[str, Any], Any], Iterable[str]] = _find_nothing
    alternative_keys: tuple[str, ...] = ()  # keys that the same table may have instead, in another scene
    alternative_hint: str = ""  # what to do if keys of both kinds are given
    # function of the known keys, an unknown one and its value, which returns the message; None if unknown
    # keys are passed over
    unknown_key: Callable[[Iterable[str], str, object], str] | None = unknown_key_message

    @classmethod
    def of(cls, owner: type, **properties: Any) -> "Table":
        """Return the table that describes an instance of a dataclass; the arguments are other attributes of the table."""
        return cls(**{"make": owner, "fields": fields_of(owner), **properties})

    @cached_property
    def fields_by_key(self) -> dict[str, Declaration]:
        """What the keys of the file hold."""
        return {one.key or name: one for name, one in self.fields.items()}

    def read(self, values: object, context: Any = None) -> dict[str, Any]:
        """Return the values of the keys that are given, by argument and in the order of the declarations."""
        if not isinstance(values, Mapping):
            raise wrong_value(values, "must be a table", f"; write {self.example}" if self.example else "")
        keys = self.fields_by_key
        own_keys = [key for key in values if key in keys]
        misplaced = [key for key in values if key in self.alternative_keys] if own_keys else []
        unknown = [key for key in values if key not in keys and key not in misplaced] if self.unknown_key else []
        collector = ProblemCollector()
        for path in (f"{KEY}.{key}" for key in misplaced[:1]):
            text = f"{path} cannot be combined with {', '.join(own_keys)}; {self.alternative_hint}"
            collector.add(ProblemCode.CONFLICT, text, key=path)
        given = self._read_fields(values, unknown, context, collector)
        for key in unknown:
            text = self.unknown_key([*keys, *self.alternative_keys], str(key), values[key]) if self.unknown_key else ""
            collector.add(ProblemCode.UNKNOWN_KEY, text, key=f"{KEY}.{key}")
        conflicts = [] if collector.has_failed else [*self.check(given)]
        conflicts += [] if unknown else [*self.find_conflicts(values, context)]
        collector.add(ProblemCode.CONFLICT, *conflicts)
        collector.raise_if_failed()
        return given

    def _read_fields(self, values: Mapping[str, Any], unknown: list[str], context: Any, collector: ProblemCollector) -> dict[str, Any]:
        """Return the values of the keys that are given; a required key that is misspelt is one mistake, where the wrong spelling is."""
        keys = self.fields_by_key
        misspelt = {near for key in unknown for near in difflib.get_close_matches(str(key), list(keys), n=1)}
        given: dict[str, Any] = {}
        for name, (key, declared) in zip(self.fields, keys.items(), strict=True):
            path = f"{KEY}.{key}"
            if key in values:
                with collector.at(path):
                    given[name] = self.types[declared.form].read(declared, values[key], context)
            elif declared.is_required and key not in misspelt:
                collector.add(ProblemCode.MISSING_KEY, f"{path} is missing; it is {declared.meaning}", key=path)
        return given

    def build(self, values: object, context: Any = None, **arguments: Any) -> Any:
        """Return what the table describes; `arguments` are those that are no keys of the table."""
        given = self.read(values, context)
        given.pop("type", None)
        return self.make(**given, **arguments)

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the table, with a property for each key."""
        keys = self.fields_by_key
        required = [key for key, declared in keys.items() if declared.is_required]
        schema: dict[str, Any] = {"type": "object", "properties": {key: self.schema_of(one) for key, one in keys.items()}}
        return schema | ({"required": required} if required else {}) | {"additionalProperties": False}

    def schema_of(self, declared: Declaration) -> dict[str, Any]:
        """Return the JSON Schema of a key; anything is accepted where its form does not say more."""
        return self.types[declared.form].schema_of(declared) | ({"description": declared.meaning} if declared.meaning else {})


def parse_table_list(table: Table, value: object, noun: str, path: str = KEY) -> tuple[Any, ...]:
    """Return what the tables of a list describe; `noun` is what one of them is."""
    if not isinstance(value, list | tuple):
        raise wrong_value(value, f"must be a list, as [{table.example}]", path=path)
    paths = (f"{path}, {noun} {number}:" for number in count(1))
    return tuple(parse_each(table.build, value, paths=paths))


def _read_table(declared: Declaration, value: object, context: object) -> Any:
    return declared.content.build(value, context)


TABLE_TYPE: Final = ValueType(_read_table, lambda declared: declared.content.schema())
"""A table within a table."""


def nearest_type(values: object, known_types: Iterable[str]) -> str:
    """Return the known type nearest to the `type` of a table; "" if none is near."""
    word = values.get("type") if isinstance(values, Mapping) else None
    return next(iter(difflib.get_close_matches(word, list(known_types), n=1)), "") if isinstance(word, str) else ""
