"""Tables of a scene file, read by what the fields of a class declare, and their values: quantities in SI, words, functions of time."""

import dataclasses
import difflib
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from typing import Any, Final, TypeGuard, TypeVar

from governor_mechanism.errors import MechanismError, did_you_mean, escape_control_characters
from governor_mechanism.machines.base import MIN_DIMENSION
from governor_mechanism.model.part import EQUILIBRIUM
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.problems import KEY, ProblemCode, ProblemCollector, mistake, parse_each, unknown_name, wrong_value
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, read_quantity, require_plausible

UNITLESS_LIMITS: Final = {"length": 50.0, "mass": 1e6, "angular_speed": 1e3}
"""Magnitudes in SI by kind: a larger bare number may be a slip of units."""

_SQUARED_KINDS = ("moment_of_inertia", "torsion_stiffness", "torsion_damping", "quadratic_torsion_damping", "area")
MIN_VALUE_BY_KIND: Final = {"modulus": 1.0} | dict.fromkeys(_SQUARED_KINDS, MIN_DIMENSION**2)
"""Smallest values in SI by kind; watches need less than MIN_DIMENSION."""

SIGNS: Final[Mapping[str, tuple[Callable[[float], bool], str]]] = {
    "any": (lambda number: True, ""),
    "positive": (lambda number: number > 0, "must be positive"),
    "not negative": (lambda number: number >= 0, "must not be negative"),
    "not zero": (lambda number: number != 0, "must not be zero"),
}
"""Conditions on the sign of a quantity, with the requirement in messages."""

MAX_LABEL_LENGTH = 200
"""Largest number of characters of a title or a name; more do not fit into a figure."""

FloatPair = tuple[float, float]
Columns = tuple[tuple[float, ...], tuple[float, ...]]
_Parsed = TypeVar("_Parsed")


def parse_si(
    value: object,  # number in SI, or text with a unit
    kind: str,
    key: str = KEY,
    *,
    sign: str = "any",
    bounded: bool = False,  # whether the magnitude must be that of something that can be built
    hint: str = "",
) -> float:
    """Return a quantity in SI; MechanismError states the problem of the value."""
    # A bare number far above anything that is built is refused, because a unit would show what is
    # meant.
    try:
        number = read_quantity(value, kind, key)
    except MechanismError as error:
        raise mistake(ProblemCode.WRONG_QUANTITY, *error.problems) from error
    has_sign, requirement = SIGNS[sign]
    if not has_sign(number):
        raise wrong_value(value, requirement, hint, code=ProblemCode.OUT_OF_RANGE, path=key)
    min_value = MIN_VALUE_BY_KIND.get(kind, MIN_DIMENSION)
    max_value = QUANTITY_KINDS[kind].largest
    if bounded and number and not min_value <= abs(number) <= max_value:
        raise wrong_value(value, f"must lie between {min_value:g} and {max_value:g} in SI", code=ProblemCode.OUT_OF_RANGE, path=key)
    try:
        require_plausible(number, kind, key, value)
    except MechanismError as error:
        raise mistake(ProblemCode.OUT_OF_RANGE, *error.problems) from error
    if not isinstance(value, str) and abs(number) > UNITLESS_LIMITS.get(kind, math.inf):
        written, unit_kind = f"{number:.12g}", QUANTITY_KINDS[kind]
        hint = f'write "{written} {unit_kind.units[0]}" if that is meant, or "{written} {unit_kind.si_unit}"'
        raise mistake(ProblemCode.WRONG_QUANTITY, f"{key} = {written} is {written} {unit_kind.si_unit}; {hint}")
    return number


def parse_number(value: object, low: float, high: float, *, open_ends: str = "", reason: str = "") -> float:
    """Return a ratio from `low` to `high`; `open_ends` names the ends ("low", "high") that are excluded."""
    number = parse_si(value, "ratio")
    is_excluded = ("low" in open_ends and number == low) or ("high" in open_ends and number == high)
    if is_excluded or not low <= number <= high:
        bounds = f"{'above' if 'low' in open_ends else 'at least'} {low:g} and {'below' if 'high' in open_ends else 'at most'} {high:g}"
        raise wrong_value(value, f"must be {bounds}{reason}", code=ProblemCode.OUT_OF_RANGE)
    return number


def check_bool(value: object) -> bool:
    """Return True or False; refuse anything else."""
    if not isinstance(value, bool):
        raise wrong_value(value, "must be true or false")
    return value


def _is_label(value: object) -> TypeGuard[str]:
    """Return whether a value is one line of text, which any file, figure and terminal can show."""
    if not isinstance(value, str) or not 0 < len(value.strip()) <= MAX_LABEL_LENGTH:
        return False
    return "\0" not in value and escape_control_characters(value) == value


def check_label(value: object, hint: str = "") -> str:
    """Return a line of text that is not empty; refuse anything else."""
    if not _is_label(value):
        raise wrong_value(value, f"must be one line of text, at most {MAX_LABEL_LENGTH} characters", hint)
    return value


def read_names(value: object) -> tuple[str, ...]:
    """Return a list of names, each of which stands there once."""
    if not isinstance(value, list | tuple) or not all(map(_is_label, value)):
        raise wrong_value(value, 'must be a list of names, as ["crank pin", "slider"]')
    repeated = next((name for name, count in Counter(value).items() if count > 1), None)
    if repeated is not None:
        raise mistake(ProblemCode.DUPLICATE, f"{KEY} names {repeated!r} twice; name it once")
    return tuple(value)


def parse_name(value: object, key: str = KEY) -> str:
    """Return a name that other tables can refer to."""
    if not _is_label(value) or "." in value:
        raise wrong_value(value, f"must be one line of text without a dot, at most {MAX_LABEL_LENGTH} characters", path=key)
    return value


def parse_pair(value: object, kinds: tuple[str, str], names: tuple[str, str], key: str = KEY) -> FloatPair:
    """Return two quantities of a list."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise wrong_value(value, f"must be [{', '.join(names)}]", f"; write [0, {QUANTITY_KINDS[kinds[1]].written_example}]", path=key)
    first, second = parse_each(lambda item, kind, name: parse_si(item, kind, f"{key} {name}"), value, kinds, names)
    return first, second


def parse_position(value: object, key: str = KEY) -> FloatPair:
    """Return [x, y] in m."""
    return parse_pair(value, ("length", "length"), ("x", "y"), key)


def parse_points(value: object, kinds: tuple[str, str], names: tuple[str, str], key: str = KEY) -> Columns:
    """Return the first and the second quantities of a list of pairs."""
    if not isinstance(value, list | tuple):
        raise wrong_value(value, f"must be a list of [{', '.join(names)}]", path=key)
    points = parse_each(lambda item, number: parse_pair(item, kinds, names, f"{key}, point {number}:"), value, count(1))
    return tuple(first for first, _ in points), tuple(second for _, second in points)


def parse_time_points(value: object, kind: str, name: str) -> Columns:
    """Return times and values of a list of [time, value]; a single value is constant."""
    if not isinstance(value, list | tuple):
        return (0.0,), (parse_si(value, kind),)
    if not value:
        example = QUANTITY_KINDS[kind].written_example
        raise mistake(ProblemCode.WRONG_TYPE, f"{KEY} is an empty list of points; write [[0, {example}]], or one {name}")
    return parse_points(value, ("time", kind), ("time", name))


def parse_first_fitting(kinds: Iterable[str], parse: Callable[[str], _Parsed]) -> tuple[str, _Parsed]:
    """Return the first kind as which something can be parsed, and the result; else raise for the kind with the fewest mistakes."""
    refusals: list[MechanismError] = []
    for kind in kinds:
        try:
            return kind, parse(kind)
        except MechanismError as error:
            refusals.append(error)
    raise min(refusals, key=lambda refusal: len(refusal.problems))


JsonSchema = Mapping[str, Any]
"""A JSON Schema of draft 7, which editors of TOML understand."""

NUMBER_PATTERN: Final = r"^\s*(=|[-+\u2212]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*\D)"
"""Pattern of a number with a unit, or of an expression, for JSON Schema."""

TEXT: Final[JsonSchema] = {"type": "string", "minLength": 1}
TABLE: Final[JsonSchema] = {"type": "object"}
NUMBER_OR_TEXT: Final[JsonSchema] = {"type": ["number", "string"]}
"""Schemas of simple values."""


def quantity_schema(kind: str, sign: str = "any") -> dict[str, Any]:
    """Return the JSON Schema of a quantity: a number in SI, or text with a unit."""
    limit = {"positive": {"exclusiveMinimum": 0}, "not negative": {"minimum": 0}}.get(sign, {})
    return {**NUMBER_OR_TEXT, "pattern": NUMBER_PATTERN, **limit, "description": QUANTITY_KINDS[kind].hint}


def or_points(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a value, or of a list of [time, value]."""
    pair = {"type": "array", "items": [quantity_schema("time"), schema], "minItems": 2, "maxItems": 2}
    return {"anyOf": [schema, {"type": "array", "items": pair, "minItems": 1}]}


def pair_of(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a list of two values."""
    return {"type": "array", "items": schema, "minItems": 2, "maxItems": 2}


def list_of(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a list."""
    return {"type": "array", "items": schema}


@dataclass(frozen=True)
class ValueType:
    """How a scene file writes the values of a form."""

    # function of the declaration, the value, and what the table's reader knows besides, that returns the
    # value in SI
    read: Callable[[Declaration, Any, Any], Any]
    # JSON Schema of what is accepted, roughly: the reader may refuse more. A function of the declaration,
    # or the same for all.
    schema: Callable[[Declaration], JsonSchema] | JsonSchema = field(default_factory=dict)

    def schema_of(self, declared: Declaration) -> dict[str, Any]:
        """Return the JSON Schema of a declaration."""
        return dict(self.schema(declared) if callable(self.schema) else self.schema)


def without_context(read: Callable[[Any], Any], schema: JsonSchema) -> ValueType:
    """Return the type of values that a function of the value alone reads."""
    return ValueType(lambda declared, value, context: read(value), schema)


def read_declared_quantity(declared: Declaration, value: object, context: object = None) -> float | str:
    """Return the declared quantity in SI, or one of the words that may stand in its place."""
    if declared.words and value in declared.words:
        return str(value)
    try:
        if declared.limits:
            return parse_number(value, *declared.limits, open_ends=declared.open_ends, reason=declared.reason)
        return parse_si(value, declared.kind, sign=declared.sign, bounded=declared.built, hint=declared.hint)
    except MechanismError as error:
        if not declared.words or not error.problems:
            raise
        suggestion = f".{suggest_equilibrium(value)}" if EQUILIBRIUM in declared.words else ""
        words = " or ".join(f'"{word}"' for word in declared.words)
        raise mistake(ProblemCode.WRONG_QUANTITY, f"{error}; or write {words}{suggestion}") from error


def suggest_equilibrium(value: object) -> str:
    """Return a hint at "equilibrium", if a value is nearly that."""
    return did_you_mean(value.lower(), [EQUILIBRIUM]) if isinstance(value, str) else ""


def declared_quantity_schema(declared: Declaration) -> JsonSchema:
    """Return the JSON Schema of a declared quantity, and of the words that may stand in its place."""
    limits = zip(("minimum", "maximum"), ("low", "high"), declared.limits or (), strict=False)
    bounds = {f"exclusive{key.capitalize()}" if end in declared.open_ends else key: value for key, end, value in limits}
    schema = quantity_schema(declared.kind, "any" if declared.limits else declared.sign) | bounds
    return {"anyOf": [*({"const": word} for word in declared.words), schema]} if declared.words else schema


def _read_choice(declared: Declaration, value: object, context: object) -> str:
    """Return one of the words to choose from."""
    if isinstance(value, str) and value in declared.words:
        return value
    raise unknown_name(f"{KEY} {format_value(value)} is unknown; known are", value, declared.words)


def _read_program(declared: Declaration, value: object, context: object) -> float | PrescribedMotion:
    """Return a quantity in SI, or the motion with rests of a list of [time, quantity]."""
    if not isinstance(value, list | tuple):
        return parse_si(value, declared.kind, sign=declared.sign)
    times, values = parse_time_points(value, declared.kind, "value")
    return PrescribedMotion(times=times, values=values, has_rests=True)


def read_restitution(value: object) -> float:
    """Return a coefficient of restitution."""
    return parse_number(value, 0, 1, reason=" (speed after over speed before an impact)")


VALUE_TYPES: Final[Mapping[str, ValueType]] = {
    "quantity": ValueType(read_declared_quantity, declared_quantity_schema),
    "program": ValueType(_read_program, lambda declared: or_points(quantity_schema(declared.kind, declared.sign))),
    "choice": ValueType(_read_choice, lambda declared: {"enum": list(declared.words)}),
    "restitution": without_context(read_restitution, quantity_schema("ratio")),
    "flag": without_context(check_bool, {"type": "boolean"}),
    "label": without_context(check_label, TEXT),
    "names": without_context(read_names, {"type": "array", "items": TEXT, "uniqueItems": True}),
    "position": without_context(parse_position, pair_of(quantity_schema("length"))),
    "any": without_context(lambda value: value, {}),
}
"""How the values of each form are written."""


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
