"""Values of a custom machine: references to points, named points, curves and motions. Slow to import: pydantic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import PlainValidator

from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import GROUND
from governor_mechanism.scenes.problems import KEY, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.quantities import FloatPair, check_label, parse_name, parse_pairs, parse_position, parse_si
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value


@dataclass(frozen=True)
class PointReference:
    """A point as written: a body with the name of a point ("" for the body alone), or with a position in its axes."""

    body: str
    point: str = ""
    position: FloatPair | None = None


def _parse_point(value: object, *, allow_body: bool = False) -> PointReference:
    if isinstance(value, str):
        body, dot, point = value.strip().partition(".")
        if body and (point if dot else allow_body):
            return PointReference(body, point)
        if body and not dot:
            text = f'{KEY} {format_value(value)} names no point; write "{value}.origin", or ["{value}", "10 mm", 0]'
            raise mistake(ProblemCode.WRONG_TYPE, text)
    elif isinstance(value, list | tuple) and len(value) == 3 and isinstance(value[0], str):
        return PointReference(value[0], position=parse_position(value[1:]))
    raise mistake(ProblemCode.WRONG_TYPE, f'{KEY} must be "body.point" or ["body", x, y]; found {format_value(value)}')


def _parse_two_points(value: object) -> tuple[PointReference, PointReference]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise mistake(ProblemCode.WRONG_TYPE, f'{KEY} must be two points, as ["ground.O", "crank.A"]; found {format_value(value)}')
    return _parse_point(value[0]), _parse_point(value[1])


def _parse_body_name(value: object) -> str:
    body = parse_name(value)
    if body == GROUND:
        text = f"{KEY} must not be {GROUND!r}, which is the fixed plane; its points are in [ground]"
        raise mistake(ProblemCode.DUPLICATE, text)
    return body


def parse_named_points(value: object) -> dict[str, FloatPair]:
    """Return named points of a body or of the ground, m; report every wrong one."""
    if not isinstance(value, Mapping):
        raise mistake(ProblemCode.WRONG_TYPE, f'{KEY} must be a table, as {{ A = ["10 mm", 0] }}; found {format_value(value)}')
    collector, points = ProblemCollector(), dict[str, FloatPair]()
    for name, position in value.items():
        with collector.at():
            points[parse_name(name, f"the name of a point in {KEY}")] = parse_position(position, f"{KEY}.{name}")
    collector.raise_if_failed()
    return points


def _parse_curve(value: object) -> Curve:
    keys = list(value) if isinstance(value, Mapping) else []
    if not isinstance(value, Mapping) or len(keys) != 1 or keys[0] not in ("coefficients", "points"):
        text = f"{KEY} must be {{ coefficients = [c0, c1, ...] }} or {{ points = [[x, y], ...] }}; found {format_value(value)}"
        raise mistake(ProblemCode.WRONG_TYPE, text)
    collector, key = ProblemCollector(), f"{KEY}.{keys[0]}"
    curve: Curve = PolynomialCurve(coefficients=(0.0,))
    with collector.at(key):
        if keys[0] == "points":
            points = parse_pairs(value["points"], ("length", "length"), ("x", "y"))
            curve = SplineCurve(x=tuple(x for x, _ in points), y=tuple(y for _, y in points))
        else:
            given = value["coefficients"]
            if not isinstance(given, list | tuple):
                raise mistake(ProblemCode.WRONG_TYPE, f"{KEY} must be a list of numbers; found {format_value(given)}")
            kinds = ("length" if power == 0 else "number" for power in range(len(given)))
            numbers = (parse_si(item, kind, f"{KEY}, c{power}") for power, (item, kind) in enumerate(zip(given, kinds, strict=True)))
            curve = PolynomialCurve(coefficients=tuple(numbers))
    collector.raise_if_failed()
    return curve


def table_list(model: type[SceneFileTable], noun: str) -> PlainValidator:
    """Return the validator of a list of tables; `noun` is what one of them is."""

    def check(value: object) -> tuple[SceneFileTable, ...]:
        if not isinstance(value, list | tuple):
            raise mistake(ProblemCode.WRONG_TYPE, f"{KEY} must be a list, as [{model.example}]; found {format_value(value)}")
        collector, tables = ProblemCollector(), list[SceneFileTable]()
        for number, item in enumerate(value, start=1):
            with collector.at(f"{KEY}, {noun} {number}:"):
                tables.append(validate(model, item))
        collector.raise_if_failed()
        return tuple(tables)

    return PlainValidator(check)


PointRef = Annotated[PointReference, PlainValidator(_parse_point)]
PointOrBodyRef = Annotated[PointReference, PlainValidator(lambda value: _parse_point(value, allow_body=True))]
TwoPointRefs = Annotated[tuple[PointReference, PointReference], PlainValidator(_parse_two_points)]
NamedPoints = Annotated[dict[str, FloatPair] | None, PlainValidator(parse_named_points)]
BodyName = Annotated[str, PlainValidator(check_label)]
NewBodyName = Annotated[str, PlainValidator(_parse_body_name)]
CurveValue = Annotated[Any, PlainValidator(_parse_curve)]
"""Types of fields."""
