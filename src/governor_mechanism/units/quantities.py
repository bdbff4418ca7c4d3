"""Numbers and quantities to SI: bare numbers are SI already, text needs a unit.

pint is imported when the first text with a unit is met, and its registry is then kept.
"""

from __future__ import annotations

import difflib
import json
import math
import re
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from numbers import Real
from typing import Any

from governor_mechanism.errors import MechanismError, did_you_mean


@dataclass(frozen=True)
class Kind:
    """A kind of quantity: its name with an article, everyday units (the last is SI), exponents of its base units."""

    name: str
    units: tuple[str, ...]
    base: Mapping[str, int]
    example: str

    @property
    def si(self) -> str:
        """The unit of a bare number."""
        return self.units[-1] if self.units else ""

    @property
    def cure(self) -> str:
        """How to write a quantity of this kind."""
        if not self.units:
            return f"write a bare number such as {self.example}"
        return f'write "{self.example}", or the bare number in {self.si}'

    @property
    def written_in(self) -> str:
        """The everyday units as a phrase."""
        *others, last = self.units or ("bare numbers",)
        return f"write it in {', '.join(others)} or {last}" if others else f"write it in {last}"


_ANGULAR = {"radian": 1, "second": -1}
_PER_TIME = {"second": -1}
_ENERGY = {"kilogram": 1, "meter": 2, "second": -2}

KINDS: Mapping[str, Kind] = {
    "length": Kind("a length", ("mm", "cm", "m"), {"meter": 1}, "300 mm"),
    "mass": Kind("a mass", ("g", "t", "kg"), {"kilogram": 1}, "5 kg"),
    "force": Kind("a force", ("kgf", "kN", "N"), {"kilogram": 1, "meter": 1, "second": -2}, "40 N"),
    "angle": Kind("an angle", ("deg", "rad"), {"radian": 1}, "40 deg"),
    "angular_speed": Kind("an angular speed", ("rpm", "deg/s", "rad/s"), _ANGULAR, "120 rpm"),
    "angular_rate": Kind("an angular rate", ("deg/s", "rad/s"), _ANGULAR, "10 deg/s"),
    "time": Kind("a time", ("ms", "min", "s"), {"second": 1}, "10 s"),
    "speed": Kind("a speed", ("mm/s", "m/s"), {"meter": 1, "second": -1}, "50 mm/s"),
    "acceleration": Kind("an acceleration", ("m/s^2",), {"meter": 1, "second": -2}, "9.81 m/s^2"),
    "torque": Kind("a torque", ("kgf m", "N m"), _ENERGY, "5 N m"),
    "moment_of_inertia": Kind("a moment of inertia", ("kg m^2",), {"kilogram": 1, "meter": 2}, "0.5 kg m^2"),
    "stiffness": Kind("a stiffness", ("N/mm", "kgf/cm", "N/m"), {"kilogram": 1, "second": -2}, "2 N/mm"),
    "damping": Kind("a damping", ("N s/mm", "N s/m"), {"kilogram": 1, "second": -1}, "120 N s/m"),
    "torsion_stiffness": Kind("a stiffness in torsion", ("N m/deg", "N m/rad"), _ENERGY | {"radian": -1}, "3 N m/rad"),
    "torsion_damping": Kind(
        "a damping in torsion", ("N m s/rad",), {"kilogram": 1, "meter": 2, "second": -1, "radian": -1}, "0.1 N m s/rad"
    ),
    "quadratic_damping": Kind("a quadratic damping", ("N s^2/m^2",), {"kilogram": 1, "meter": -1}, "300 N s^2/m^2"),
    "quadratic_torsion_damping": Kind(
        "a quadratic damping in torsion",
        ("N m s^2/rad^2",),
        {"kilogram": 1, "meter": 2, "radian": -2},
        "0.3 N m s^2/rad^2",
    ),
    "area": Kind("an area", ("mm^2", "cm^2", "m^2"), {"meter": 2}, "20 cm^2"),
    "density": Kind("a density", ("g/cm^3", "kg/m^3"), {"kilogram": 1, "meter": -3}, "900 kg/m^3"),
    "pressure": Kind("a pressure", ("at", "bar", "Pa"), {"kilogram": 1, "meter": -1, "second": -2}, "5 at"),
    "modulus": Kind(
        "a modulus of shear", ("GPa", "N/mm^2", "Pa"), {"kilogram": 1, "meter": -1, "second": -2}, "80 GPa"
    ),
    "power": Kind("a power", ("PS", "kW", "W"), {"kilogram": 1, "meter": 2, "second": -3}, "20 PS"),
    "ratio": Kind("a ratio", (), {}, "0.3"),
    "number": Kind("a number", (), {}, "0.3"),
}
"""The kinds of quantity by the names that descriptions use."""

# What a wrong unit may stand for besides the kinds above; only messages need these.
_OTHER_KINDS = (
    ("a volume", {"meter": 3}),
    ("a temperature", {"kelvin": 1}),
    ("a frequency", _PER_TIME),
    ("an angular acceleration", {"radian": 1, "second": -2}),
)

_LONGEST = 100  # characters; a quantity is short, and long digit strings would cost time
_KILOGRAM_FORCE = Decimal("9.80665")
_NEWTON_PER_KILOGRAM = Decimal("9.81")  # what `gravity = true` means; weights given in newtons are reckoned with it
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*")
_NOT_A_NUMBER = re.compile(r"[+-]?(nan|inf|infinity)\b", re.IGNORECASE)
# Only small exponents and no other figures: pint would otherwise work out 9^9^9^9.
_UNIT = re.compile(r"(?:[()*/\s]|1(?![0-9])|(?:[^\W\d]|[°%])+(?:\^-?[1-9](?![0-9]))?)+")
# Turns as engineers write them; r and U only per time, since alone they may be slips for rad or something else.
_TURNS = re.compile(r"(?:revs?(?![^\W\d_])|[rU](?=\s*/|[\s*]+(?:s|min|h)\^-1))")
# For suggestions only: how misspelt turns and misspelt angles begin, in small letters, and what ends "per second".
_LIKE_TURNS = re.compile(r"re|ro|r(?![^\W\d_])|[tucgo]")
_LIKE_ANGLES = re.compile(r"ra|rd|ad|d|°")
_PER_SECOND = re.compile(r"(?:(?:/|per|p)\s*s(?:ec\w*)?|s\^?-1)$")
_SIGNS = str.maketrans({"−": "-", "⁻": "-", "¹": "1", "²": "2", "³": "3", "·": "*", "⋅": "*", "×": "*"})


def parse(value: object, kind: str, what: str) -> float:
    """The value in SI; `what` names it in messages, `kind` is one of KINDS.

    Numbers are SI already. Text holds a number and a unit; for angular speeds rev, r and U per time are turns, 1/min
    means turns per minute and 1/s means rad/s. Raises MechanismError with one sentence for anything else.
    """
    wanted = KINDS.get(kind)
    if wanted is None:
        raise MechanismError(
            f"{what}: no kind of quantity {kind!r}; kinds are {list(KINDS)}.{did_you_mean(kind, KINDS)}"
        )
    if isinstance(value, str):
        number = _text_to_si(value, wanted, what)
    elif isinstance(value, Real) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
    else:
        raise MechanismError(f"{what} is {wanted.name}; found {shown(value)}; {wanted.cure}")
    if not math.isfinite(number):
        raise MechanismError(f"{what} must be a finite number; found {shown(value)}; {wanted.cure}")
    return number


def shown(value: object) -> str:
    """How a message shows a value that was found: as a scene file would write it, shortened."""
    if isinstance(value, str):
        return json.dumps(value if len(value) <= 60 else value[:57] + "...", ensure_ascii=False)
    return str(value).lower() if isinstance(value, bool) else reprlib.repr(value)


def _text_to_si(text: str, wanted: Kind, what: str) -> float:
    cleaned = text.strip().translate(_SIGNS)
    start = f"{what} is {wanted.name}; {shown(text)}"
    if len(cleaned) > _LONGEST:
        raise MechanismError(f"{start} is too long for a quantity; {wanted.cure}")
    number = _NUMBER.match(cleaned)
    if number is None:
        if _NOT_A_NUMBER.match(cleaned):
            return math.nan
        raise MechanismError(f"{start} {'is empty' if not cleaned else 'has no number'}; {wanted.cure}")
    unit = cleaned[number.end() :]
    if unit.startswith(","):
        raise MechanismError(f"{start} has a comma; write a decimal point, and thousands without a mark")
    if not unit and not wanted.units:
        raise MechanismError(f"{start} is text; write the bare number {number[1]}")
    if not unit:
        raise MechanismError(
            f'{start} has no unit; write "{number[1]} {_first_unit(wanted)}", or the bare number in {wanted.si}'
        )
    try:
        return float(Decimal(number[1]) * _factor(unit, Decimal(number[1]), wanted, start))
    except ArithmeticError:  # an exponent beyond what Decimal works out
        return math.inf


def _first_unit(wanted: Kind) -> str:
    """The unit that the kind's example is written in."""
    return wanted.example.partition(" ")[2]


def _factor(unit: str, number: Decimal, wanted: Kind, start: str) -> Decimal:
    """What one `unit` is in SI, if it is of the kind wanted."""
    plain = re.sub(r"([^\W\d_])(-?[1-9])", r"\1^\2", unit)
    plain = f"1{plain}" if plain.startswith("/") else plain
    turns = _TURNS.match(plain)
    plain = f"turn{plain[turns.end() :]}" if turns else plain
    try:
        factor, base = _in_base_units(plain)
    except Exception as error:
        # pint raises many unrelated types (its own, tokenizer's, AssertionError); to the user all mean one thing.
        raise MechanismError(
            f'{start} has an unknown unit "{unit}"; {wanted.written_in}{_nearest(unit, wanted)}'
        ) from error
    if base == wanted.base and (wanted.units or plain == "%"):
        return factor
    if base == _PER_TIME and wanted.base == _ANGULAR:
        return _per_time(plain, number * factor, start)
    raise MechanismError(f"{start} is {_wrong_kind(plain, number, factor, base, wanted)}")


def _in_base_units(unit: str) -> tuple[Decimal, dict[str, int]]:
    if not _UNIT.fullmatch(unit):
        raise MechanismError(f"{unit!r} is not made of unit names")
    registry = _registry()
    factor, base = registry.get_base_units(registry.parse_units(unit))
    return Decimal(factor), {str(name): int(power) for name, power in dict(base._units).items()}


@cache
def _registry() -> Any:
    """pint's registry, reckoning in decimals so that "300 mm" and 0.3 are the same float."""
    import pint

    registry: Any = pint.UnitRegistry(non_int_type=Decimal)
    registry.define("@alias force_kilogram = kp")
    registry.define("Nm = newton * meter")
    registry.define("PS = metric_horsepower")  # pint alone would read petasiemens
    return registry


def _per_time(unit: str, per_second: Decimal, start: str) -> Decimal:
    """Units without an angle, as angular speeds: the two that engineers write, and no guess at the others."""
    squeezed = re.sub(r"\s", "", unit)
    if squeezed in ("1/s", "s^-1"):
        return Decimal(1)
    if squeezed in ("1/min", "min^-1"):
        return _in_base_units("rpm")[0]
    raise MechanismError(
        f'{start} may count turns or radians; write "{60 * per_second:.6g} rpm" or "{per_second:.6g} rad/s"'
    )


def _wrong_kind(unit: str, number: Decimal, factor: Decimal, base: Mapping[str, int], wanted: Kind) -> str:
    """What the unit stands for instead, and the cure; weight and mass are often taken for each other."""
    mass, force = KINDS["mass"], KINDS["force"]
    if wanted is mass and base == force.base:
        if unit in ("kgf", "kp"):
            return f"a force: that is a weight; write {float(number * factor / _KILOGRAM_FORCE):.12g} kg"
        kilograms = float(number * factor / _NEWTON_PER_KILOGRAM)
        return f"a force: that is a weight; write {kilograms:.3g} kg (rounded: it weighs so much at 9.81 m/s^2)"
    if wanted is force and base == mass.base:
        return f'no force: that is a mass; write "{float(number * factor):.12g} kgf" or in N'
    named = [(kind.name, kind.base) for kind in KINDS.values() if kind.units] + list(_OTHER_KINDS)
    found = next((name for name, known in named if known == base), "of another kind" if base else "a plain number")
    return f"{found}; {wanted.written_in}"


def _nearest(unit: str, wanted: Kind) -> str:
    """A known unit spelt nearly like this one; those of the kind wanted come first.

    Where turning is wanted, never radians for what may be turns, nor turns for what may be radians.
    """
    word = unit.lower()
    known = [*wanted.units, "1/min", "°", *(name for kind in KINDS.values() for name in kind.units)]
    if wanted.base == _ANGULAR:
        if _LIKE_TURNS.match(word):
            return f". Did you mean {'rev/s' if _PER_SECOND.search(word) else 'rpm'!r}?"
        angles = {"deg", "rad", "°", "deg/s", "rad/s"}
        known = ["deg/s", "rad/s"] if _LIKE_ANGLES.match(word) else [name for name in known if name not in angles]
    lowered = {name.lower(): name for name in reversed(known)}
    near = difflib.get_close_matches(word, list(lowered), n=1)
    return f". Did you mean {lowered[near[0]]!r}?" if near else ""


EVERYDAY = {"rad": (180 / math.pi, "deg"), "m": (1e3, "mm"), "rad/s": (30 / math.pi, "rpm")}
"""How many of an everyday unit make an SI unit; others are said as they are."""


def spoken(value: float, unit: str, digits: str = ".6g") -> str:
    """A value in SI with the unit an engineer says it in."""
    factor, name = EVERYDAY.get(unit, (1.0, unit))
    return f"{value * factor + 0.0:{digits}} {name}"  # adding zero: no minus before a zero
