"""Single values of a scene file to SI: quantities, names, places and programs, each mistake told in a sentence.

A pydantic validator finds in its context what stands before the key in messages, as "run." or 'body "crank": '.
Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, TypeVar

from pydantic import PlainValidator, ValidationInfo

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.base import MAX_DIMENSION, MIN_DIMENSION
from governor_mechanism.model.scene import MAX_SPINDLE_SPEED
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, parse_quantity

UNITLESS_LIMITS: Final = {"length": (50.0, MAX_DIMENSION), "mass": (1e6, MAX_DIMENSION), "angular_speed": (1e3, MAX_SPINDLE_SPEED)}
"""In SI by kind: above what a bare number is taken for a slip of units, and where the refusals of any number begin."""

MIN_VALUE_BY_KIND: Final = {
    "moment_of_inertia": MIN_DIMENSION**2,
    "torsion_stiffness": MIN_DIMENSION**2,
    "torsion_damping": MIN_DIMENSION**2,
    "quadratic_torsion_damping": MIN_DIMENSION**2,
    "area": MIN_DIMENSION**2,
}
"""In SI by kind: where watches need less than SMALLEST."""

FloatPair = tuple[float, float]
_Result = TypeVar("_Result")


def key_path_of(info: ValidationInfo) -> str:
    """How messages call the key that is being read."""
    return f"{info.context or ''}{info.field_name}"


def join_names(names: Iterable[str]) -> str:
    """Names as a phrase for a message."""
    return ", ".join(names)


def parse_si(value: object, kind: str, key_path: str) -> float:
    """The value in SI; refuses a bare number far outside anything built, where a unit would settle what is meant."""
    number = parse_quantity(value, kind, key_path)
    suspicious_limit, refused_limit = UNITLESS_LIMITS.get(kind, (MAX_DIMENSION, MAX_DIMENSION))
    if not isinstance(value, str) and suspicious_limit < abs(number) <= refused_limit:
        number_text, unit_kind = f"{number:.12g}", QUANTITY_KINDS[kind]
        raise MechanismError(
            f"{key_path} = {number_text} is {number_text} {unit_kind.si_unit}; "
            f'write "{number_text} {unit_kind.units[0]}" if that is meant, or "{number_text} {unit_kind.si_unit}"'
        )
    return number


def quantity_validator(kind: str, *, positive: bool = False, hint: str = "") -> PlainValidator:
    """A quantity in SI; `cure` is said about one that ought to be positive and is not."""

    def validate(value: object, info: ValidationInfo) -> float:
        if positive and parse_quantity(value, kind, key_path_of(info)) <= 0:
            raise MechanismError(f"{key_path_of(info)} must be positive; found {format_value(value)}{hint}")
        return parse_si(value, kind, key_path_of(info))

    return PlainValidator(validate)


def bounded_quantity_validator(kind: str, *, sign: str = "positive", hint: str = "") -> PlainValidator:
    """A quantity of a size that can be built: 'positive', 'not negative', 'not zero', or of 'any' sign."""
    return PlainValidator(lambda value, info: parse_bounded_quantity(value, kind, key_path_of(info), sign=sign, hint=hint))


def parse_bounded_quantity(value: object, kind: str, key_path: str, *, sign: str = "positive", hint: str = "") -> float:
    """A value of `built`, at a place."""
    allowed: dict[str, Callable[[float], bool]] = {
        "positive": lambda number: number > 0,
        "not negative": lambda number: number >= 0,
        "not zero": lambda number: number != 0,
    }
    number = parse_quantity(value, kind, key_path)
    if sign in allowed and not allowed[sign](number):
        requirement = f"must {sign.replace('not ', 'not be ')}" if sign.startswith("not") else f"must be {sign}"
        raise MechanismError(f"{key_path} {requirement}; found {format_value(value)}{hint}")
    _require_bounded(number, value, kind, key_path)
    return parse_si(value, kind, key_path)


def _require_bounded(number: float, value: object, kind: str, key_path: str) -> None:
    min_value = MIN_VALUE_BY_KIND.get(kind, MIN_DIMENSION)
    if number and not min_value <= abs(number) <= MAX_DIMENSION:
        raise MechanismError(f"{key_path} must lie between {min_value:g} and {MAX_DIMENSION:g} in SI; found {format_value(value)}")


def require_table(value: object, name: str) -> dict[str, Any]:
    """A table that stands under a heading of its own."""
    if not isinstance(value, Mapping):
        raise MechanismError(f"{name} must be a table; found {format_value(value)}; write [{name}] on a line of its own")
    return dict(value)


def table_validator() -> PlainValidator:
    """A table by the name of its key."""
    return PlainValidator(lambda value, info: require_table(value, str(info.field_name)))


def choice_validator(names: Iterable[str]) -> PlainValidator:
    """A word out of a list."""
    known_words = tuple(names)

    def validate(value: object, info: ValidationInfo) -> str:
        if isinstance(value, str) and value in known_words:
            return value
        suggestion = did_you_mean(value, known_words) if isinstance(value, str) else ""
        raise MechanismError(f"{key_path_of(info)} {format_value(value)} is unknown; known are {join_names(known_words)}.{suggestion}")

    return PlainValidator(validate)


def validate_bool(value: object, info: ValidationInfo) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise MechanismError(f"{key_path_of(info)} must be true or false; found {format_value(value)}")
    return value


def parse_name(value: object, key_path: str) -> str:
    """A name that other tables refer to."""
    if not isinstance(value, str) or not value.strip() or "." in value:
        raise MechanismError(f"{key_path} must be text without a dot; found {format_value(value)}")
    return value


def validate_label(value: object, info: ValidationInfo) -> str:
    """A name that only messages and results use."""
    if not isinstance(value, str) or not value.strip():
        raise MechanismError(f"{key_path_of(info)} must be text; found {format_value(value)}")
    return value


def parse_pair(value: object, kinds: tuple[str, str], names: tuple[str, str], key_path: str) -> FloatPair:
    """Two quantities in a list."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(
            f'{key_path} must be [{join_names(names)}]; found {format_value(value)}; write [0, "{QUANTITY_KINDS[kinds[1]].example}"]'
        )
    values: list[float] = []
    problems: list[str] = []
    for item, kind, component_name in zip(value, kinds, names, strict=True):
        try:
            values.append(parse_si(item, kind, f"{key_path} {component_name}"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return values[0], values[1]


def parse_position(value: object, key_path: str) -> FloatPair:
    """[x, y] in m."""
    x, y = parse_pair(value, ("length", "length"), ("x", "y"), key_path)
    for number, axis_name in ((x, "x"), (y, "y")):
        if abs(number) > MAX_DIMENSION:
            raise MechanismError(f"{key_path} {axis_name} must lie within {MAX_DIMENSION:g} m; found {number:g} m")
    return x, y


def validate_position(value: object, info: ValidationInfo) -> FloatPair:
    """[x, y] in m, of a key."""
    return parse_position(value, key_path_of(info))


def parse_pairs(value: object, kinds: tuple[str, str], names: tuple[str, str], key_path: str) -> list[FloatPair]:
    """A list of pairs; every wrong one is told."""
    if not isinstance(value, list | tuple):
        raise MechanismError(f"{key_path} must be a list of [{join_names(names)}]; found {format_value(value)}")
    points: list[FloatPair] = []
    problems: list[str] = []
    for number, item in enumerate(value, start=1):
        try:
            points.append(parse_pair(item, kinds, names, f"{key_path}, point {number}:"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return points


def parse_time_points(value: object, kind: str, value_name: str, key_path: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Times and values of a program of [time, value]; one value alone is held for ever."""
    if not isinstance(value, list | tuple):
        return (0.0,), (parse_si(value, kind, key_path),)
    if not value:
        raise MechanismError(f'{key_path} is an empty program; write [[0, "{QUANTITY_KINDS[kind].example}"]], or one {value_name}')
    points = parse_pairs(value, ("time", kind), ("time", value_name), key_path)
    return tuple(time for time, _ in points), tuple(number for _, number in points)


def program_validator(kind: str, value_name: str) -> PlainValidator:
    """A quantity, or a program of [time, quantity]."""

    def validate(value: object, info: ValidationInfo) -> InputFunction:
        times, values = parse_time_points(value, kind, value_name, key_path_of(info))
        return prefix_errors(key_path_of(info), lambda: InputFunction(times=times, values=values))

    return PlainValidator(validate)


def prefix_errors(key_path: str, build: Callable[[], _Result]) -> _Result:
    """What `make` returns; its refusals say where."""
    try:
        return build()
    except MechanismError as error:
        raise MechanismError(*(f"{key_path}: {problem}" for problem in error.problems)) from error
