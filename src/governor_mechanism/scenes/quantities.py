"""Single values of a scene file to SI: quantities, names, places and programs, each mistake told in a sentence.

A pydantic validator finds in its context what stands before the key in messages, as "run." or 'body "crank": '.
Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, TypeVar

from pydantic import PlainValidator, ValidationInfo

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.base import LARGEST, SMALLEST
from governor_mechanism.model.scene import FASTEST
from governor_mechanism.model.time_functions import Program
from governor_mechanism.units.quantities import KINDS, parse, shown

BARE_LIMITS: Final = {"length": (50.0, LARGEST), "mass": (1e6, LARGEST), "angular_speed": (1e3, FASTEST)}
"""In SI by kind: above what a bare number is taken for a slip of units, and where the refusals of any number begin."""

SMALLEST_OF: Final = {
    "moment_of_inertia": SMALLEST**2,
    "torsion_stiffness": SMALLEST**2,
    "torsion_damping": SMALLEST**2,
    "quadratic_torsion_damping": SMALLEST**2,
    "area": SMALLEST**2,
}
"""In SI by kind: where watches need less than SMALLEST."""

Pair = tuple[float, float]
Made = TypeVar("Made")


def where(info: ValidationInfo) -> str:
    """How messages call the key that is being read."""
    return f"{info.context or ''}{info.field_name}"


def listed(names: Iterable[str]) -> str:
    """Names as a phrase for a message."""
    return ", ".join(names)


def si(value: object, kind: str, place: str) -> float:
    """The value in SI; refuses a bare number far outside anything built, where a unit would settle what is meant."""
    number = parse(value, kind, place)
    slip, refused = BARE_LIMITS.get(kind, (LARGEST, LARGEST))
    if not isinstance(value, str) and slip < abs(number) <= refused:
        written, units = f"{number:.12g}", KINDS[kind]
        raise MechanismError(
            f"{place} = {written} is {written} {units.si}; "
            f'write "{written} {units.units[0]}" if that is meant, or "{written} {units.si}"'
        )
    return number


def quantity(kind: str, *, positive: bool = False, cure: str = "") -> PlainValidator:
    """A quantity in SI; `cure` is said about one that ought to be positive and is not."""

    def convert(value: object, info: ValidationInfo) -> float:
        if positive and parse(value, kind, where(info)) <= 0:
            raise MechanismError(f"{where(info)} must be positive; found {shown(value)}{cure}")
        return si(value, kind, where(info))

    return PlainValidator(convert)


def built(kind: str, *, sign: str = "positive", cure: str = "") -> PlainValidator:
    """A quantity of a size that can be built: 'positive', 'not negative', 'not zero', or of 'any' sign."""
    return PlainValidator(lambda value, info: built_value(value, kind, where(info), sign=sign, cure=cure))


def built_value(value: object, kind: str, place: str, *, sign: str = "positive", cure: str = "") -> float:
    """A value of `built`, at a place."""
    allowed: dict[str, Callable[[float], bool]] = {
        "positive": lambda number: number > 0,
        "not negative": lambda number: number >= 0,
        "not zero": lambda number: number != 0,
    }
    number = parse(value, kind, place)
    if sign in allowed and not allowed[sign](number):
        must = f"must {sign.replace('not ', 'not be ')}" if sign.startswith("not") else f"must be {sign}"
        raise MechanismError(f"{place} {must}; found {shown(value)}{cure}")
    _require_built(number, value, kind, place)
    return si(value, kind, place)


def _require_built(number: float, value: object, kind: str, place: str) -> None:
    least = SMALLEST_OF.get(kind, SMALLEST)
    if number and not least <= abs(number) <= LARGEST:
        raise MechanismError(f"{place} must lie between {least:g} and {LARGEST:g} in SI; found {shown(value)}")


def table(value: object, name: str) -> dict[str, Any]:
    """A table that stands under a heading of its own."""
    if not isinstance(value, Mapping):
        raise MechanismError(f"{name} must be a table; found {shown(value)}; write [{name}] on a line of its own")
    return dict(value)


def any_table() -> PlainValidator:
    """A table by the name of its key."""
    return PlainValidator(lambda value, info: table(value, str(info.field_name)))


def one_of(names: Iterable[str]) -> PlainValidator:
    """A word out of a list."""
    known = tuple(names)

    def convert(value: object, info: ValidationInfo) -> str:
        if isinstance(value, str) and value in known:
            return value
        near = did_you_mean(value, known) if isinstance(value, str) else ""
        raise MechanismError(f"{where(info)} {shown(value)} is unknown; known are {listed(known)}.{near}")

    return PlainValidator(convert)


def truth(value: object, info: ValidationInfo) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise MechanismError(f"{where(info)} must be true or false; found {shown(value)}")
    return value


def name(value: object, place: str) -> str:
    """A name that other tables refer to."""
    if not isinstance(value, str) or not value.strip() or "." in value:
        raise MechanismError(f"{place} must be text without a dot; found {shown(value)}")
    return value


def label(value: object, info: ValidationInfo) -> str:
    """A name that only messages and results use."""
    if not isinstance(value, str) or not value.strip():
        raise MechanismError(f"{where(info)} must be text; found {shown(value)}")
    return value


def pair(value: object, kinds: tuple[str, str], names: tuple[str, str], place: str) -> Pair:
    """Two quantities in a list."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(
            f'{place} must be [{listed(names)}]; found {shown(value)}; write [0, "{KINDS[kinds[1]].example}"]'
        )
    values: list[float] = []
    problems: list[str] = []
    for item, kind, called in zip(value, kinds, names, strict=True):
        try:
            values.append(si(item, kind, f"{place} {called}"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return values[0], values[1]


def place_of(value: object, place: str) -> Pair:
    """[x, y] in m."""
    x, y = pair(value, ("length", "length"), ("x", "y"), place)
    for number, called in ((x, "x"), (y, "y")):
        if abs(number) > LARGEST:
            raise MechanismError(f"{place} {called} must lie within {LARGEST:g} m; found {number:g} m")
    return x, y


def place_value(value: object, info: ValidationInfo) -> Pair:
    """[x, y] in m, of a key."""
    return place_of(value, where(info))


def pairs(value: object, kinds: tuple[str, str], names: tuple[str, str], place: str) -> list[Pair]:
    """A list of pairs; every wrong one is told."""
    if not isinstance(value, list | tuple):
        raise MechanismError(f"{place} must be a list of [{listed(names)}]; found {shown(value)}")
    found: list[Pair] = []
    problems: list[str] = []
    for number, item in enumerate(value, start=1):
        try:
            found.append(pair(item, kinds, names, f"{place}, point {number}:"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return found


def points_in_time(value: object, kind: str, called: str, place: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Times and values of a program of [time, value]; one value alone is held for ever."""
    if not isinstance(value, list | tuple):
        return (0.0,), (si(value, kind, place),)
    if not value:
        raise MechanismError(f'{place} is an empty program; write [[0, "{KINDS[kind].example}"]], or one {called}')
    points = pairs(value, ("time", kind), ("time", called), place)
    return tuple(time for time, _ in points), tuple(number for _, number in points)


def program(kind: str, called: str) -> PlainValidator:
    """A quantity, or a program of [time, quantity]."""

    def convert(value: object, info: ValidationInfo) -> Program:
        times, values = points_in_time(value, kind, called, where(info))
        return located(where(info), lambda: Program(times=times, values=values))

    return PlainValidator(convert)


def located(place: str, make: Callable[[], Made]) -> Made:
    """What `make` returns; its refusals say where."""
    try:
        return make()
    except MechanismError as error:
        raise MechanismError(*(f"{place}: {problem}" for problem in error.problems)) from error
