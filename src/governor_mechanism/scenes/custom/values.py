"""Single values of a user's own mechanism: points, curves and motions, each mistake told in a sentence.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import PlainValidator, ValidationInfo

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.curves import Curve, Polynomial
from governor_mechanism.model.curves import Table as CurveTable
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.time_functions import Motion
from governor_mechanism.scenes.quantities import Pair, located, name, pairs, place_of, si, where
from governor_mechanism.scenes.schema import Table, understood
from governor_mechanism.units.quantities import shown


@dataclass(frozen=True)
class End:
    """A point as written: a body and the name of a point ('' for the body alone), or a place in the body's axes."""

    body: str
    point: str = ""
    place: Pair | None = None


def end_value(value: object, info: ValidationInfo) -> End:
    """A point of a body."""
    return _end_of(value, where(info))


def _end_of(value: object, place: str, *, bare: bool = False) -> End:
    if isinstance(value, str):
        body, dot, point = value.strip().partition(".")
        if body and (point if dot else bare):
            return End(body, point)
        if body and not dot:
            raise MechanismError(
                f'{place} {shown(value)} names no point; write "{value}.origin", or ["{value}", "10 mm", 0]'
            )
    elif isinstance(value, list | tuple) and len(value) == 3 and isinstance(value[0], str):
        return End(value[0], place=place_of(value[1:], place))
    raise MechanismError(f'{place} must be "body.point" or ["body", x, y]; found {shown(value)}')


def end_or_body_value(value: object, info: ValidationInfo) -> End:
    """A point of a body, or the body alone."""
    return _end_of(value, where(info), bare=True)


def two_ends_value(value: object, info: ValidationInfo) -> tuple[End, End]:
    """Two points."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(f'{where(info)} must be two points, as ["ground.O", "crank.A"]; found {shown(value)}')
    return _end_of(value[0], where(info)), _end_of(value[1], where(info))


def body_name(value: object, info: ValidationInfo) -> str:
    """The name of a body."""
    found = name(value, where(info))
    if found == GROUND:
        raise MechanismError(f"{where(info)} must not be {GROUND!r}; that is the plane, whose points stand in [ground]")
    return found


def points_value(value: object, info: ValidationInfo) -> dict[str, Pair]:
    """Named points."""
    if not isinstance(value, Mapping):
        raise MechanismError(f'{where(info)} must be a table, as {{ A = ["10 mm", 0] }}; found {shown(value)}')
    return points_of(value, where(info))


def points_of(values: Mapping[str, Any], place: str) -> dict[str, Pair]:
    """Named points; every wrong one is told."""
    found: dict[str, Pair] = {}
    problems: list[str] = []
    for key, value in values.items():
        try:
            found[name(key, f"the name of a point in {place}")] = place_of(value, f"{place}.{key}")
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return found


def nested(model: type[Table], example: str) -> PlainValidator:
    """A table within a table, with an example of what stands in it."""

    def convert(value: object, info: ValidationInfo) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise MechanismError(
                f"{where(info)} must be a table; found {shown(value)}; write {info.field_name} = {{ {example} }}"
            )
        meaning, problems = understood(model, dict(value), str(info.field_name), f"{where(info)}.")
        if problems:
            raise MechanismError(*problems)
        return meaning

    return PlainValidator(convert)


def curve_value(value: object, info: ValidationInfo) -> Curve:
    """A curve by its coefficients or by points."""
    keys = list(value) if isinstance(value, Mapping) else []
    if not isinstance(value, Mapping) or len(keys) != 1 or keys[0] not in ("coefficients", "points"):
        raise MechanismError(
            f"{where(info)} must be {{ coefficients = [c0, c1, ...] }} or {{ points = [[x, y], ...] }}; "
            f"found {shown(value)}"
        )
    place = f"{where(info)}.{keys[0]}"
    if keys[0] == "points":
        places = pairs(value["points"], ("length", "length"), ("x", "y"), place)
        x, y = tuple(x for x, _ in places), tuple(y for _, y in places)
        return located(place, lambda: CurveTable(x=x, y=y))
    given = value["coefficients"]
    if not isinstance(given, list | tuple):
        raise MechanismError(f"{place} must be a list of numbers; found {shown(given)}")
    numbers = tuple(si(item, "number" if power else "length", f"{place}, c{power}") for power, item in enumerate(given))
    return located(place, lambda: Polynomial(coefficients=numbers))


def motion_value(kind: str, called: str) -> PlainValidator:
    """A motion by points of [time, value]."""

    def convert(value: object, info: ValidationInfo) -> Motion:
        found = pairs(value, ("time", kind), ("time", called), where(info))
        times, values = tuple(time for time, _ in found), tuple(number for _, number in found)
        return located(where(info), lambda: Motion(times=times, values=values))

    return PlainValidator(convert)


def list_of_tables(value: object, info: ValidationInfo) -> list[Any]:
    """Tables under headings in double brackets."""
    if not isinstance(value, list | tuple):
        raise MechanismError(
            f"{info.field_name} must be a list of tables; found {shown(value)}; "
            f"write [[{info.field_name}]] above each of them"
        )
    return list(value)
