"""Expressions of scene files: arithmetic of textbooks, with units; what cannot be read or added is refused with a sentence."""

import math

import pytest

from governor_mechanism.units.expressions import ARITHMETIC, Expression, Measured, read_any_quantity, unit_of_kind
from governor_mechanism.units.quantities import QUANTITY_KINDS

NAMES = {"crank": Measured(0.5, unit_of_kind("length")), "lambda": Measured(3.0), "mass": Measured(2.0, unit_of_kind("mass"))}


def evaluate(text: str) -> Measured:
    return Expression(text).evaluate(NAMES.__getitem__, ARITHMETIC)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2 + 3 * 4", 14.0),
        ("(2 + 3) * 4", 20.0),
        ("8 / 4 / 2", 1.0),
        ("2 - 3 - 4", -5.0),
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("1.5e1 - .5", 14.5),
        ("lambda * 2", 6.0),
        ("4 * atan(1)", math.pi),
        ("sin(30 deg) + cos(60deg)", 1.0),
        ("atan2(crank, -crank)", 0.75 * math.pi),
        ("acos(crank / (2 * crank))", math.pi / 3),
    ],
)
def test_plain_numbers_follow_the_rules_of_arithmetic(text: str, value: float):
    assert evaluate(text) == Measured(pytest.approx(value, rel=1e-15, abs=1e-15))


@pytest.mark.parametrize(
    ("text", "value", "kind"),
    [
        ("2 * crank + 10 mm", 1.01, "length"),
        ("sqrt(crank^2)", 0.5, "length"),
        ("hypot(3 * crank, 4 * crank)", 2.5, "length"),
        ("mass * crank^2", 0.5, "moment_of_inertia"),
        ("mass * crank / (1 s)^2", 1.0, "force"),
        ("abs(-crank) / 2 s", 0.25, "speed"),
    ],
)
def test_units_are_carried_along(text: str, value: float, kind: str):
    result = evaluate(text)
    assert result.unit == unit_of_kind(kind)
    assert result.value == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "value", "kind"), [("20 mm", 0.02, "length"), ("20 deg", math.pi / 9, "angle"), ("2 lb", 0.90718474, "mass")]
)
def test_a_quantity_of_any_kind_is_recognised(text: str, value: float, kind: str):
    assert read_any_quantity(text, "it") == (pytest.approx(value, rel=1e-15), kind)


def test_every_kind_of_quantity_has_a_unit():
    assert {name: unit_of_kind(name) for name in QUANTITY_KINDS}["power"] == (*unit_of_kind("torque")[:2], -3)
