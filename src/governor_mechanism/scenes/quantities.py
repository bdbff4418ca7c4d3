"""Values of a scene file: quantities in SI, words, positions and functions of time. Slow to import: pydantic."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from itertools import count
from types import UnionType
from typing import Annotated, Final, TypeGuard, TypeVar

from pydantic import PlainValidator

from governor_mechanism.errors import MechanismError, escape_control_characters
from governor_mechanism.machines.base import MIN_DIMENSION
from governor_mechanism.scenes.problems import KEY, ProblemCode, mistake, parse_each, unknown_name, wrong_value
from governor_mechanism.scenes.schema_validator import TEXT, SchemaValidator, pair_of, quantity_schema
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


def parse_si(value: object, kind: str, key: str = KEY, *, sign: str = "any", bounded: bool = False, hint: str = "") -> float:
    """Return a quantity in SI.

    A bare number far above anything that is built is refused, because a unit would show what is meant.

    Parameters
    ----------
    value
        Number in SI, or text with a unit.
    kind
        Key of QUANTITY_KINDS.
    key
        Key path in messages.
    sign
        Key of SIGNS.
    bounded
        Whether the magnitude must be that of something that can be built.
    hint
        End of the message about a wrong sign.

    Returns
    -------
    float
        The value in SI.

    Raises
    ------
    MechanismError
        With the problem of the value.
    """
    try:
        number = read_quantity(value, kind, key)
    except MechanismError as error:
        raise mistake(ProblemCode.WRONG_QUANTITY, *error.problems) from error
    has_sign, requirement = SIGNS[sign]
    if not has_sign(number):
        raise wrong_value(value, requirement, hint, code=ProblemCode.OUT_OF_RANGE, path=key)
    min_value, max_value = MIN_VALUE_BY_KIND.get(kind, MIN_DIMENSION), QUANTITY_KINDS[kind].largest
    if bounded and number and not min_value <= abs(number) <= max_value:
        raise wrong_value(value, f"must lie between {min_value:g} and {max_value:g} in SI", code=ProblemCode.OUT_OF_RANGE, path=key)
    try:
        require_plausible(number, kind, key, format_value(value))
    except MechanismError as error:
        raise mistake(ProblemCode.OUT_OF_RANGE, *error.problems) from error
    if not isinstance(value, str) and abs(number) > UNITLESS_LIMITS.get(kind, math.inf):
        written, unit_kind = f"{number:.12g}", QUANTITY_KINDS[kind]
        hint = f'write "{written} {unit_kind.units[0]}" if that is meant, or "{written} {unit_kind.si_unit}"'
        raise mistake(ProblemCode.WRONG_QUANTITY, f"{key} = {written} is {written} {unit_kind.si_unit}; {hint}")
    return number


def quantity(kind: str, sign: str = "any", *, bounded: bool = False, hint: str = "") -> PlainValidator:
    """Return the validator of a quantity; see `parse_si`."""
    schema = quantity_schema(kind, sign)
    return SchemaValidator(lambda value: parse_si(value, kind, sign=sign, bounded=bounded, hint=hint), json_schema=schema)


def built(kind: str, sign: str = "positive", *, hint: str = "") -> PlainValidator:
    """Return the validator of a quantity whose magnitude can be built."""
    return quantity(kind, sign, bounded=True, hint=hint)


def parse_number(value: object, low: float, high: float, *, open_ends: str = "", reason: str = "") -> float:
    """Return a ratio from `low` to `high`; `open_ends` names the ends ("low", "high") that are excluded."""
    number = parse_si(value, "ratio")
    is_excluded = ("low" in open_ends and number == low) or ("high" in open_ends and number == high)
    if is_excluded or not low <= number <= high:
        bounds = f"{'above' if 'low' in open_ends else 'at least'} {low:g} and {'below' if 'high' in open_ends else 'at most'} {high:g}"
        raise wrong_value(value, f"must be {bounds}{reason}", code=ProblemCode.OUT_OF_RANGE)
    return number


def number_between(low: float, high: float, *, open_ends: str = "", reason: str = "") -> PlainValidator:
    """Return the validator of a ratio; see `parse_number`."""
    bounds = {"exclusiveMinimum" if "low" in open_ends else "minimum": low, "exclusiveMaximum" if "high" in open_ends else "maximum": high}
    schema = quantity_schema("ratio") | bounds
    return SchemaValidator(lambda value: parse_number(value, low, high, open_ends=open_ends, reason=reason), json_schema=schema)


def choice(known_words: Collection[str]) -> PlainValidator:
    """Return the validator of a word from a list."""

    def check(value: object) -> str:
        if isinstance(value, str) and value in known_words:
            return value
        raise unknown_name(f"{KEY} {format_value(value)} is unknown; known are", value, known_words)

    return SchemaValidator(check, json_schema={"enum": list(known_words)})


def instance_of(kind: type | UnionType, requirement: str, hint: str = "") -> PlainValidator:
    """Return the validator of a value of a type."""

    def check(value: object) -> object:
        if not isinstance(value, kind):
            raise wrong_value(value, requirement, hint)
        return value

    return PlainValidator(check)


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


Position = Annotated[FloatPair, SchemaValidator(parse_position, json_schema=pair_of(quantity_schema("length")))]
Bool = Annotated[bool, SchemaValidator(check_bool, json_schema={"type": "boolean"})]
Label = Annotated[str, SchemaValidator(check_label, json_schema=TEXT)]
Angle = Annotated[float, quantity("angle")]
PositiveLength = Annotated[float, built("length")]
Length = Annotated[float, built("length", "not negative")]
Mass = Annotated[float, built("mass", "not negative")]
"""Types of fields; lengths and masses have magnitudes that can be built, and only PositiveLength excludes 0."""
