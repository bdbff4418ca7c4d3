"""Values of a custom machine: references to points, named points, curves and motions. Slow to import: pydantic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, count, repeat
from typing import Annotated, Any

from pydantic import PlainValidator

from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import GROUND
from governor_mechanism.scenes.problems import KEY, ProblemCode, mistake, parse_each, wrong_value
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
    raise wrong_value(value, 'must be "body.point" or ["body", x, y]')


def _parse_two_points(value: object) -> tuple[PointReference, PointReference]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise wrong_value(value, 'must be two points, as ["ground.O", "crank.A"]')
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
        raise wrong_value(value, 'must be a table, as { A = ["10 mm", 0] }')

    def parse_point(name: object, position: object) -> tuple[str, FloatPair]:
        return parse_name(name, f"the name of a point in {KEY}"), parse_position(position, f"{KEY}.{name}")

    return dict(parse_each(parse_point, value, value.values()))


def _parse_curve(value: object) -> Curve:
    keys = list(value) if isinstance(value, Mapping) else []
    if not isinstance(value, Mapping) or keys not in (["coefficients"], ["points"]):
        raise wrong_value(value, "must be { coefficients = [c0, c1, ...] } or { points = [[x, y], ...] }")
    (curve,) = parse_each(_parse_spline if keys == ["points"] else _parse_polynomial, value.values(), paths=[f"{KEY}.{keys[0]}"])
    return curve


def _parse_spline(value: object) -> Curve:
    points = parse_pairs(value, ("length", "length"), ("x", "y"))
    return SplineCurve(x=tuple(x for x, _ in points), y=tuple(y for _, y in points))


def _parse_polynomial(value: object) -> Curve:
    if not isinstance(value, list | tuple):
        raise wrong_value(value, "must be a list of numbers")
    kinds = chain(["length"], repeat("number"))
    numbers = (parse_si(item, kind, f"{KEY}, c{power}") for power, (item, kind) in enumerate(zip(value, kinds, strict=False)))
    return PolynomialCurve(coefficients=tuple(numbers))


def table_list(model: type[SceneFileTable], noun: str) -> PlainValidator:
    """Return the validator of a list of tables; `noun` is what one of them is."""

    def check(value: object) -> tuple[SceneFileTable, ...]:
        if not isinstance(value, list | tuple):
            raise wrong_value(value, f"must be a list, as [{model.example}]")
        return tuple(parse_each(lambda item, number: validate(model, item, f"{KEY}, {noun} {number}:"), value, count(1)))

    return PlainValidator(check)


PointRef = Annotated[PointReference, PlainValidator(_parse_point)]
PointOrBodyRef = Annotated[PointReference, PlainValidator(lambda value: _parse_point(value, allow_body=True))]
TwoPointRefs = Annotated[tuple[PointReference, PointReference], PlainValidator(_parse_two_points)]
NamedPoints = Annotated[dict[str, FloatPair] | None, PlainValidator(parse_named_points)]
BodyName = Annotated[str, PlainValidator(check_label)]
NewBodyName = Annotated[str, PlainValidator(_parse_body_name)]
CurveValue = Annotated[Any, PlainValidator(_parse_curve)]
"""Types of fields."""
