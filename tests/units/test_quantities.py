"""Quantities become SI, and what cannot be one is refused in a sentence that says how to write it."""

import math
import re
import subprocess
import sys
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import ACCEPTED_UNITS, QUANTITY_KINDS, USUAL_FACTORS, format_quantity, format_value, parse_quantity
from refusing import refuses

ULP = 2.3e-16  # one rounding, where the test's own reference is rounded too


@pytest.mark.parametrize(
    ("text", "kind", "expected"),
    [
        ("300 mm", "length", 0.3),
        ("30cm", "length", 0.3),
        (" 0.3  m ", "length", 0.3),
        ("-58.8875797367 mm", "length", -0.0588875797367),
        ("−5 mm", "length", -0.005),
        ("1e3 mm", "length", 1.0),
        ("5 kg", "mass", 5.0),
        ("500 g", "mass", 0.5),
        ("1.5 t", "mass", 1500.0),
        ("40 kgf", "force", 392.266),
        ("40 kp", "force", 392.266),
        ("40 N", "force", 40.0),
        ("2 kN", "force", 2000.0),
        ("10 s", "time", 10.0),
        ("10 ms", "time", 0.01),
        ("2 min", "time", 120.0),
        ("9.80665 m/s^2", "acceleration", 9.80665),
        ("9.81 m/s2", "acceleration", 9.81),
        ("9.81 m/s²", "acceleration", 9.81),
        ("9.81 m s⁻²", "acceleration", 9.81),
        ("5 at", "pressure", 490332.5),
        ("2 PS", "power", 1470.9975),
        ("120 N s/m", "damping", 120.0),
        ("120 N/(m/s)", "damping", 120.0),
        ("0.5 kg m^2", "moment_of_inertia", 0.5),
        ("0.5 kg m2", "moment_of_inertia", 0.5),
        ("0.5 kg·m²", "moment_of_inertia", 0.5),
        ("5 N m", "torque", 5.0),
        ("5 Nm", "torque", 5.0),
        ("2 N/mm", "stiffness", 2000.0),
        ("50 mm/s", "speed", 0.05),
        ("30 %", "ratio", 0.3),
    ],
)
def test_everyday_units_become_exactly_the_si_number(text: str, kind: str, expected: float) -> None:
    assert parse_quantity(text, kind, "x") == expected


@pytest.mark.parametrize(
    ("text", "kind", "expected"),
    [
        ("10 in", "length", 0.254),
        ("3 inches", "length", 0.0762),
        ("2 feet", "length", 0.6096),
        ("1 yard", "length", 0.9144),
        ("7 millimetres", "length", 0.007),
        ("10 lb", "mass", 4.5359237),
        ("10 lbf", "force", 44.482216152605),
        ("30 psi", "pressure", 206842.71879505085),
        ("10 hp", "power", 7456.9987158227022),
        ("4 ft lbf", "torque", 4 * 0.3048 * 4.4482216152605),
        ("100 lbf/in", "stiffness", 17512.683524647637),
        ("20 lb ft^2", "moment_of_inertia", 20 * 0.45359237 * 0.3048**2),
        ("5 kgf/cm^2", "pressure", 490332.5),
        ("3 gon", "angle", 0.04712388980384690),
        ("2 h", "time", 7200.0),
        ("10 ft/s", "speed", 3.048),
    ],
)
def test_units_of_engineers_are_accepted(text: str, kind: str, expected: float) -> None:
    assert parse_quantity(text, kind, "x") == pytest.approx(expected, rel=ULP * 4, abs=0)  # the last digit of the literals


@pytest.mark.parametrize("unit", [unit for units in ACCEPTED_UNITS.values() for unit in units])
def test_every_accepted_unit_is_one_of_a_known_quantity(unit: str) -> None:
    kinds = [name for name in QUANTITY_KINDS if number_or_none(f"2 {unit}", name) is not None]
    assert kinds, unit
    assert number_or_none(f"6 {unit}", kinds[0]) == pytest.approx(3 * number_or_none(f"2 {unit}", kinds[0]), rel=4 * ULP)


@pytest.mark.parametrize("kind", list(QUANTITY_KINDS))
def test_every_kind_has_a_largest_magnitude(kind: str) -> None:
    largest = QUANTITY_KINDS[kind].largest
    assert parse_quantity(largest, kind, "x") == largest
    for number in (1.001 * largest, -1e160, 1e200):
        refuses(rf"^x must lie within {re.escape(f'{largest:g}')}.*; found", parse_quantity, number, kind, "x")


def number_or_none(text: str, kind: str) -> float | None:
    try:
        return parse_quantity(text, kind, "x")
    except MechanismError:
        return None


@pytest.mark.parametrize(
    ("text", "kind", "expected"),
    [
        ("40 deg", "angle", math.radians(40)),
        ("40°", "angle", math.radians(40)),
        ("0.5 rad", "angle", 0.5),
        ("120 rpm", "angular_speed", 4 * math.pi),
        ("120 1/min", "angular_speed", 4 * math.pi),
        ("120/min", "angular_speed", 4 * math.pi),
        ("120 min^-1", "angular_speed", 4 * math.pi),
        ("12.5 1/s", "angular_speed", 12.5),
        ("2 Hz", "frequency", 2.0),
        ("2 1/s", "frequency", 2.0),
        ("120 rpm", "frequency", 2.0),
        ("3 rad/s", "frequency", 3 / (2 * math.pi)),
        ("90 deg/s", "frequency", 0.25),
        ("12.5 s⁻¹", "angular_speed", 12.5),
        ("12.5 rad/s", "angular_speed", 12.5),
        ("90 deg/s", "angular_rate", math.pi / 2),
    ],
)
def test_angles_and_turning_become_radians(text: str, kind: str, expected: float) -> None:
    assert parse_quantity(text, kind, "x") == pytest.approx(expected, rel=ULP, abs=0)


@pytest.mark.parametrize(
    "text",
    [
        *("2 rev/s", "2 r/s", "2 U/s", "2 rev s^-1", "2rev/s", "2 turn/s", "7200 rev/h"),
        *("120 rev/min", "120 revs/min", "120 r/min", "120 rev per min"),
        *("120 U/min", "120 U / min", "120 U min⁻¹", "120 U min-1"),
    ],
)
@pytest.mark.parametrize("kind", ["angular_speed", "angular_rate"])
def test_turns_per_time_are_exactly_turns(text: str, kind: str) -> None:
    assert parse_quantity(text, kind, "x") == parse_quantity("120 rpm", kind, "x") == 4 * math.pi


@pytest.mark.parametrize(
    ("unit", "nearest"),
    [(unit, "rpm") for unit in ("tr/min", "RPM", "rmp", "r.p.m.", "Upm", "rot/min", "rev/mim", "Umdr/min", "U/mn")]
    + [(unit, "rev/s") for unit in ("rot/s", "tr/s", "Umdr/s", "Rev/s", "rev./sec", "Ups", "rot s^-1")]
    + [("rda/s", "rad/s"), ("Rad/s", "rad/s"), ("raad/s", "rad/s"), ("dge/s", "deg/s"), ("1/mn", "1/min")]
    + [("rsd/s", None), ("hz", None), ("xyz/s", None)],
)
def test_a_suggestion_never_takes_turns_for_radians(unit: str, nearest: str | None) -> None:
    with pytest.raises(MechanismError) as caught:
        parse_quantity(f"2 {unit}", "angular_speed", "x")
    told = f"write it in rpm, deg/s or rad/s{f'. Did you mean {nearest!r}?' if nearest else ''}"
    assert str(caught.value).endswith(told)


@pytest.mark.parametrize("value", [3, 3.0, np.float64(3.0), np.int64(3), Fraction(3)])
def test_bare_numbers_are_si(value: object) -> None:
    number = parse_quantity(value, "length", "x")
    assert number == 3.0
    assert type(number) is float


@pytest.mark.parametrize(
    ("value", "kind", "sentence"),
    [(1j, "mass", "found 1j"), (Decimal("1"), "mass", "found 1;"), (10**400, "length", "must be a finite number")],
)
def test_what_is_no_such_quantity_is_refused_in_one_sentence(value: object, kind: str, sentence: str) -> None:
    with pytest.raises(MechanismError) as caught:
        parse_quantity(value, kind, "x")
    (problem,) = caught.value.problems
    assert sentence in problem
    assert problem.startswith("x")


def test_the_sentence_about_a_wrong_kind_is_whole() -> None:
    with pytest.raises(MechanismError) as caught:
        parse_quantity("5 kg", "length", "dimensions.arm")
    assert str(caught.value) == 'dimensions.arm is a length; "5 kg" is a mass; write it in mm, cm or m'


@pytest.mark.parametrize("kind", list(QUANTITY_KINDS))
def test_the_units_a_message_recommends_are_accepted(kind: str) -> None:
    for unit in QUANTITY_KINDS[kind].units:
        assert parse_quantity(f"2 {unit}", kind, "x") > 0
    assert parse_quantity("1 " + QUANTITY_KINDS[kind].si_unit, kind, "x") == 1.0 if QUANTITY_KINDS[kind].si_unit else True
    example = QUANTITY_KINDS[kind].example
    assert parse_quantity(example if QUANTITY_KINDS[kind].units else float(example), kind, "x") > 0


def number_or_one_sentence(text: str, kind: str) -> bool:
    try:
        return math.isfinite(parse_quantity(text, kind, "x"))
    except MechanismError as error:
        return len(error.problems) == 1


@given(st.text(max_size=30), st.sampled_from(list(QUANTITY_KINDS)))
def test_any_text_is_a_number_or_a_sentence(text: str, kind: str) -> None:
    assert number_or_one_sentence(text, kind)


@given(st.text(alphabet="0123456789.eE-+*/^() mkgNsradpHztC°%²,_1\n", max_size=20), st.sampled_from(list(QUANTITY_KINDS)))
def test_any_text_made_of_units_is_a_number_or_a_sentence(text: str, kind: str) -> None:
    assert number_or_one_sentence("5 " + text, kind)


@given(st.decimals(min_value=-1000, max_value=1000, places=6))
def test_a_length_is_the_same_in_millimetres_and_metres(metres: Decimal) -> None:
    # The registry reckons in decimals, so not even the last bit differs.
    assert parse_quantity(f"{metres * 1000:f} mm", "length", "x") == parse_quantity(f"{metres:f} m", "length", "x") == float(metres)


def test_shown_is_as_a_scene_file_would_write_it() -> None:
    assert [format_value(value) for value in ("a\nb", True, 1.5, "x" * 80)] == ['"a\\nb"', "true", "1.5", f'"{"x" * 57}..."']


@pytest.fixture(scope="module")
def registry() -> pint.UnitRegistry:
    """Return pint's own units, in decimals."""
    return pint.UnitRegistry(non_int_type=Decimal)


@pytest.mark.parametrize(
    ("unit", "si_unit"), [*USUAL_FACTORS, *((kind.si_unit, kind.si_unit) for kind in QUANTITY_KINDS.values() if kind.units)]
)
def test_usual_units_are_those_of_pint(unit: str, si_unit: str, registry: pint.UnitRegistry) -> None:
    """To the last digit, also in quantities of all kinds with that unit."""
    factor = registry.Quantity(Decimal(1), unit).to(si_unit).magnitude
    assert USUAL_FACTORS.get((unit, si_unit), Decimal(1)) == factor
    for name, kind in QUANTITY_KINDS.items():
        if kind.si_unit == si_unit:
            assert parse_quantity(f"0.7 {unit}", name, "x") == float(Decimal("0.7") * factor)


def test_usual_units_never_import_pint() -> None:
    code = (
        "import sys; from governor_mechanism.units.quantities import parse_quantity as parse; parse(0.3, 'length', 'x'); "
        "parse('300 mm', 'length', 'x'); print('pint' in sys.modules); parse('0.3 km', 'length', 'x'); print('pint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]


@pytest.mark.parametrize(("value", "digits", "text"), [(-1e-17, ".4f", "0.0000 mm"), (-0.0, ".6g", "0 mm"), (-2e-3, ".4f", "-2.0000 mm")])
def test_a_rounded_zero_has_no_sign(value: float, digits: str, text: str) -> None:
    assert format_quantity(value, "m", digits) == text
