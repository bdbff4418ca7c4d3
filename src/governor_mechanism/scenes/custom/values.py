"""Single values of a user's own mechanism: points, curves and motions, each mistake told in a sentence.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import PlainValidator, ValidationInfo

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.curves import Curve, PolynomialCurve
from governor_mechanism.model.curves import SplineCurve as CurveTable
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.scenes.quantities import FloatPair, key_path_of, parse_name, parse_pairs, parse_position, parse_si, prefix_errors
from governor_mechanism.scenes.schema import SceneFileTable, validate_table
from governor_mechanism.units.quantities import format_value


@dataclass(frozen=True)
class PointReference:
    """A point as written: a body and the name of a point ('' for the body alone), or a place in the body's axes."""

    body: str
    point: str = ""
    position: FloatPair | None = None


def validate_point(value: object, info: ValidationInfo) -> PointReference:
    """A point of a body."""
    return _parse_point(value, key_path_of(info))


def _parse_point(value: object, key_path: str, *, allow_body: bool = False) -> PointReference:
    if isinstance(value, str):
        body, dot, point = value.strip().partition(".")
        if body and (point if dot else allow_body):
            return PointReference(body, point)
        if body and not dot:
            raise MechanismError(f'{key_path} {format_value(value)} names no point; write "{value}.origin", or ["{value}", "10 mm", 0]')
    elif isinstance(value, list | tuple) and len(value) == 3 and isinstance(value[0], str):
        return PointReference(value[0], position=parse_position(value[1:], key_path))
    raise MechanismError(f'{key_path} must be "body.point" or ["body", x, y]; found {format_value(value)}')


def validate_point_or_body(value: object, info: ValidationInfo) -> PointReference:
    """A point of a body, or the body alone."""
    return _parse_point(value, key_path_of(info), allow_body=True)


def validate_two_points(value: object, info: ValidationInfo) -> tuple[PointReference, PointReference]:
    """Two points."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(f'{key_path_of(info)} must be two points, as ["ground.O", "crank.A"]; found {format_value(value)}')
    return _parse_point(value[0], key_path_of(info)), _parse_point(value[1], key_path_of(info))


def validate_body_name(value: object, info: ValidationInfo) -> str:
    """The name of a body."""
    body = parse_name(value, key_path_of(info))
    if body == GROUND:
        raise MechanismError(f"{key_path_of(info)} must not be {GROUND!r}; that is the plane, whose points stand in [ground]")
    return body


def validate_named_points(value: object, info: ValidationInfo) -> dict[str, FloatPair]:
    """Named points."""
    if not isinstance(value, Mapping):
        raise MechanismError(f'{key_path_of(info)} must be a table, as {{ A = ["10 mm", 0] }}; found {format_value(value)}')
    return parse_named_points(value, key_path_of(info))


def parse_named_points(values: Mapping[str, Any], key_path: str) -> dict[str, FloatPair]:
    """Named points; every wrong one is told."""
    points: dict[str, FloatPair] = {}
    problems: list[str] = []
    for key, value in values.items():
        try:
            points[parse_name(key, f"the name of a point in {key_path}")] = parse_position(value, f"{key_path}.{key}")
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return points


def nested_table_validator(model: type[SceneFileTable], example: str) -> PlainValidator:
    """A table within a table, with an example of what stands in it."""

    def validate(value: object, info: ValidationInfo) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise MechanismError(
                f"{key_path_of(info)} must be a table; found {format_value(value)}; write {info.field_name} = {{ {example} }}"
            )
        parsed, problems = validate_table(model, dict(value), str(info.field_name), f"{key_path_of(info)}.")
        if problems:
            raise MechanismError(*problems)
        return parsed

    return PlainValidator(validate)


def validate_curve(value: object, info: ValidationInfo) -> Curve:
    """A curve by its coefficients or by points."""
    keys = list(value) if isinstance(value, Mapping) else []
    if not isinstance(value, Mapping) or len(keys) != 1 or keys[0] not in ("coefficients", "points"):
        raise MechanismError(
            f"{key_path_of(info)} must be {{ coefficients = [c0, c1, ...] }} or {{ points = [[x, y], ...] }}; found {format_value(value)}"
        )
    key_path = f"{key_path_of(info)}.{keys[0]}"
    if keys[0] == "points":
        points = parse_pairs(value["points"], ("length", "length"), ("x", "y"), key_path)
        x, y = tuple(x for x, _ in points), tuple(y for _, y in points)
        return prefix_errors(key_path, lambda: CurveTable(x=x, y=y))
    given = value["coefficients"]
    if not isinstance(given, list | tuple):
        raise MechanismError(f"{key_path} must be a list of numbers; found {format_value(given)}")
    coefficients = tuple(parse_si(item, "number" if power else "length", f"{key_path}, c{power}") for power, item in enumerate(given))
    return prefix_errors(key_path, lambda: PolynomialCurve(coefficients=coefficients))


def motion_validator(kind: str, value_name: str) -> PlainValidator:
    """A motion by points of [time, value]."""

    def validate(value: object, info: ValidationInfo) -> PrescribedMotion:
        points = parse_pairs(value, ("time", kind), ("time", value_name), key_path_of(info))
        times, values = tuple(time for time, _ in points), tuple(number for _, number in points)
        return prefix_errors(key_path_of(info), lambda: PrescribedMotion(times=times, values=values))

    return PlainValidator(validate)


def validate_table_list(value: object, info: ValidationInfo) -> list[Any]:
    """Tables under headings in double brackets."""
    if not isinstance(value, list | tuple):
        raise MechanismError(
            f"{info.field_name} must be a list of tables; found {format_value(value)}; write [[{info.field_name}]] above each of them"
        )
    return list(value)
