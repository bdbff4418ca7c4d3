"""Conversion of quantities to SI: numbers are in SI, text needs a unit; pint, slow to import, serves the less usual ones."""

import difflib
import json
import math
import re
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, time
from decimal import Decimal
from functools import cache, lru_cache
from numbers import Number, Real
from pathlib import PurePath
from typing import Any

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.units.constants import KILOGRAM_FORCE_1901, RPM

LARGEST_MAGNITUDE = 1e9
LARGEST_RATE = 1e6
LARGEST_COEFFICIENT = 1e30
"""Largest magnitudes, SI: of most quantities; of what is measured per second; of coefficients, which may be over powers of a length."""


@dataclass(frozen=True)
class QuantityKind:
    """A kind of quantity."""

    name: str  # its name with an article
    units: tuple[str, ...]  # customary units; the last is SI
    example: str  # a value as text
    # largest magnitude, SI. Nothing that is built or moves has a larger one, which is a mistake of units;
    # and the engines multiply quantities and their squares, which beyond such magnitudes lose all digits or
    # overflow.
    largest: float = LARGEST_MAGNITUDE

    @property
    def si_unit(self) -> str:
        """Unit of a bare number."""
        return self.units[-1] if self.units else ""

    @property
    def hint(self) -> str:
        """Sentence on how to write a quantity of this kind."""
        bare = f"write a bare number such as {self.example}"
        return f'write "{self.example}", or the bare number in {self.si_unit}' if self.units else bare

    @property
    def written_example(self) -> str:
        """Example as a scene file has it: text in quotation marks, or a bare number."""
        return f'"{self.example}"' if self.units else self.example

    @property
    def units_hint(self) -> str:
        """Sentence with the customary units."""
        *others, last = self.units or ("bare numbers",)
        return f"write it in {', '.join(others)} or {last}" if others else f"write it in {last}"


QUANTITY_KINDS: Mapping[str, QuantityKind] = {
    "length": QuantityKind("a length", ("mm", "cm", "m"), "300 mm"),
    "mass": QuantityKind("a mass", ("g", "t", "kg"), "5 kg"),
    "force": QuantityKind("a force", ("kgf", "kN", "N"), "40 N"),
    "angle": QuantityKind("an angle", ("deg", "rad"), "40 deg"),
    "angular_speed": QuantityKind("an angular speed", ("rpm", "deg/s", "rad/s"), "120 rpm", LARGEST_RATE),
    "angular_rate": QuantityKind("an angular rate", ("deg/s", "rad/s"), "10 deg/s", LARGEST_RATE),
    "frequency": QuantityKind("a frequency", ("1/min", "rpm", "rad/s", "Hz"), "2 Hz", LARGEST_RATE),
    "time": QuantityKind("a time", ("ms", "min", "s"), "10 s"),
    "speed": QuantityKind("a speed", ("mm/s", "m/s"), "50 mm/s", LARGEST_RATE),
    "acceleration": QuantityKind("an acceleration", ("m/s^2",), "9.81 m/s^2", LARGEST_RATE),
    "angular_acceleration": QuantityKind("an angular acceleration", ("deg/s^2", "rad/s^2"), "10 rad/s^2", LARGEST_RATE),
    "torque": QuantityKind("a torque", ("kgf m", "N m"), "5 N m"),
    "moment_of_inertia": QuantityKind("a moment of inertia", ("kg m^2",), "0.5 kg m^2"),
    "stiffness": QuantityKind("a stiffness", ("N/mm", "kgf/cm", "N/m"), "2 N/mm"),
    "damping": QuantityKind("a damping", ("N s/mm", "N s/m"), "120 N s/m"),
    "torsion_stiffness": QuantityKind("a stiffness in torsion", ("N m/deg", "N m/rad"), "3 N m/rad"),
    "torsion_damping": QuantityKind("a damping in torsion", ("N m s/rad",), "0.1 N m s/rad"),
    "quadratic_damping": QuantityKind("a quadratic damping", ("N s^2/m^2",), "300 N s^2/m^2"),
    "quadratic_torsion_damping": QuantityKind("a quadratic damping in torsion", ("N m s^2/rad^2",), "0.3 N m s^2/rad^2"),
    "torque_per_length": QuantityKind("a torque per length", ("N m/mm", "N m/m"), "200 N m/m"),
    "force_per_angle": QuantityKind("a force per angle", ("N/deg", "N/rad"), "3 N/deg"),
    "force_per_angular_speed": QuantityKind("a force per angular speed", ("N/rpm", "N s/rad"), "3 N s/rad"),
    "ratio_per_length": QuantityKind("a fraction per length", ("1/mm", "1/m"), "20 1/m"),
    "ratio_per_angle": QuantityKind("a fraction per angle", ("1/deg", "1/rad"), "2 1/rad"),
    "ratio_per_angular_speed": QuantityKind("a fraction per angular speed", ("1/rpm", "s/rad"), "0.1 s/rad"),
    "area": QuantityKind("an area", ("mm^2", "cm^2", "m^2"), "20 cm^2"),
    "density": QuantityKind("a density", ("g/cm^3", "kg/m^3"), "900 kg/m^3"),
    "pressure": QuantityKind("a pressure", ("at", "bar", "Pa"), "5 at"),
    "modulus": QuantityKind("a modulus of shear", ("GPa", "N/mm^2", "Pa"), "80 GPa", 1e13),
    "power": QuantityKind("a power", ("PS", "kW", "W"), "20 PS"),
    "ratio": QuantityKind("a ratio", (), "0.3"),
    "number": QuantityKind("a number", (), "0.3"),
    "coefficient": QuantityKind("a coefficient", (), "0.3", LARGEST_COEFFICIENT),
}
"""Kinds of quantity by the names in descriptions."""

ACCEPTED_UNITS: Mapping[str, tuple[str, ...]] = {
    "length": ("nm", "um", "mm", "cm", "dm", "m", "km", "thou", "in", "ft", "yd", "mile"),
    "mass": ("mg", "g", "kg", "t", "oz", "lb", "slug"),
    "time": ("us", "ms", "s", "min", "h"),
    "angle": ("arcsec", "arcmin", "deg", "°", "mrad", "rad", "gon", "turn", "revolution"),
    "turning": ("rpm", "Hz", "kHz"),
    "force": ("mN", "N", "kN", "MN", "dyn", "gf", "kgf", "kp", "ozf", "lbf", "kip", "pdl"),
    "pressure": ("Pa", "hPa", "kPa", "MPa", "GPa", "mbar", "bar", "at", "atm", "mmHg", "inHg", "psi", "ksi"),
    "work and torque": ("mJ", "J", "kJ", "MJ", "Nm"),
    "power": ("mW", "W", "kW", "MW", "PS", "hp"),
    "ratio": ("%",),
}
"""Units that engineers use, by what they measure. A quantity takes them, their full names, and products, powers and quotients of them."""

# Other kinds of quantity with their SI units, for messages about a wrong unit.
_OTHER_KINDS = (("a volume", "m^3"), ("a temperature", "K"))

_THOUSANDTH = Decimal("0.001")
_DEGREE = Decimal("0.01745329251994329576923690768")
_RPM = Decimal("0.1047197551196597746154214461")
USUAL_FACTORS = {
    **dict.fromkeys((("mm", "m"), ("g", "kg"), ("ms", "s"), ("mm/s", "m/s")), _THOUSANDTH),
    **dict.fromkeys((("N/mm", "N/m"), ("kN", "N"), ("kN/m", "N/m"), ("kN s/m", "N s/m"), ("kW", "W")), Decimal(1000)),
    **{("cm", "m"): Decimal("0.01"), ("cm^2", "m^2"): Decimal("0.0001"), ("bar", "Pa"): Decimal(100_000)},
    **{("deg", "rad"): _DEGREE, ("rpm", "rad/s"): _RPM},
}
"""SI values of the usual units by unit and SI unit, as pint computes them: most scenes need no others."""

_MAX_TEXT_LENGTH = 100  # characters; a quantity is short, and long digit strings would cost time
_KILOGRAM_FORCE = Decimal(str(KILOGRAM_FORCE_1901))
_NEWTON_PER_KILOGRAM = Decimal("9.81")  # what `gravity = true` means; converts weights in newtons
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*")
_NOT_A_NUMBER = re.compile(r"[+-]?(nan|inf|infinity)\b", re.IGNORECASE)
# Only small exponents and no other digits: pint would evaluate 9^9^9^9.
_UNIT = re.compile(r"(?:[()*/\s]|1(?![0-9])|(?:[^\W\d]|[°%])+(?:\^-?[1-9](?![0-9]))?)+")
_UNIT_WORD = re.compile(r"(?:[^\W\d]|[°%])+")
# Turns; r and U only per time, since alone they may be misspelt rad or something else.
_TURN_UNIT = r"(?:revs?(?![^\W\d_])|[rU](?=\s*/|[\s*]+(?:s|min|h)\^-1))"
# For suggestions only: beginnings of misspelt turns and angles in lower case, and endings of "per second".
_TURN_SPELLING = re.compile(r"re|ro|r(?![^\W\d_])|[tucgo]")
_ANGLE_SPELLING = re.compile(r"ra|rd|ad|d|°")
_PER_SECOND = re.compile(r"(?:(?:/|per|p)\s*s(?:ec\w*)?|s\^?-1)$")
_CHARACTER_REPLACEMENTS = str.maketrans({"−": "-", "⁻": "-", "¹": "1", "²": "2", "³": "3", "·": "*", "⋅": "*", "×": "*"})


class TextWithValue(str):
    """A text that stands for a quantity and knows its value, as an expression of a scene file that is evaluated."""

    def convert(self, expected: QuantityKind, what: str) -> float:
        """Return the value in SI as a quantity of a kind; raise MechanismError if it is of another kind."""
        raise NotImplementedError


def parse_quantity(
    value: object,  # a number in SI, or text of a number and a unit
    kind: str,
    what: str,
) -> float:
    """Return a quantity in SI.

    In angular speeds, rev, r and U per time are turns, 1/min means turns per minute, and 1/s means rad/s. A frequency counts
    cycles: one of 2 pi rad/s, or of one turn per second, is 1 Hz.

    Raises MechanismError if the value is not a quantity of this kind within its largest magnitude.
    """
    number = read_quantity(value, kind, what)
    require_plausible(number, kind, what, value)
    return number


def require_plausible(number: float, kind: str, what: str, written: object = None) -> None:
    """Raise MechanismError if a quantity, SI, exceeds the largest magnitude of its kind; `written` is what a user gave, if it is known."""
    expected = QUANTITY_KINDS[kind]
    if not abs(number) <= expected.largest:
        limit = f"{expected.largest:g} {expected.si_unit}".rstrip()
        found = f"{number:g} {expected.si_unit}".rstrip() if written is None else format_value(written)
        raise MechanismError(f"{what} must lie within {limit}; found {found}")


def read_quantity(value: object, kind: str, what: str) -> float:
    """Return a quantity in SI of any magnitude; the rest is as in `parse_quantity`."""
    if kind not in QUANTITY_KINDS:
        raise MechanismError(f"{what}: no kind of quantity {kind!r}; kinds are {list(QUANTITY_KINDS)}.{did_you_mean(kind, QUANTITY_KINDS)}")
    expected = QUANTITY_KINDS[kind]
    if isinstance(value, TextWithValue):
        number = value.convert(expected, what)
    elif isinstance(value, str):
        number = _text_to_si(value, expected, what)
    elif isinstance(value, Real) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
    else:
        raise MechanismError(f"{what} is {expected.name}; found {format_value(value)}; {expected.hint}")
    if not math.isfinite(number):
        raise MechanismError(f"{what} must be a finite number; found {format_value(value)}; {expected.hint}")
    return number


def convert_texts(
    values: Any,  # numbers in SI and texts with a unit: one, or a list, tuple or array
    kind: str,
    what: str,
) -> Any:
    """Return a quantity, or a list of quantities, with the texts in SI; what is no text stays as it is, for others to check."""
    if isinstance(values, str):
        return parse_quantity(values, kind, what)
    items = values.tolist() if getattr(getattr(values, "dtype", None), "kind", "") in ("U", "O") else values
    if not isinstance(items, list | tuple) or not any(isinstance(item, str) for item in items):
        return values
    return [parse_quantity(item, kind, what) if isinstance(item, str) else item for item in items]


def number_or_text(text: str) -> float | str:
    """Return the number of a text without a unit, which is in SI as in a scene file, or any other text without blanks at its ends."""
    try:
        return float(text)
    except ValueError:
        return text.strip()


def format_value(value: object) -> str:
    """Return a value as a scene file would write it, shortened, for messages."""
    if isinstance(value, str):
        return json.dumps(value if len(value) <= 60 else value[:57] + "...", ensure_ascii=False)
    return _ValueFormat().repr(value)


class _ValueFormat(reprlib.Repr):
    """Shortened text of values, which names the type of a value that no scene file can hold."""

    def repr_int(self, number: int, level: int) -> str:
        return super().repr_int(number, level) if abs(number) < 10**100 else "an integer of more than 100 digits"

    def repr_instance(self, value: object, level: int) -> str:
        if isinstance(value, bool):
            return str(value).lower()
        return (
            str(value) if isinstance(value, Number | Decimal | date | time | PurePath | None) else f"a value of type {type(value).__name__}"
        )


@lru_cache(maxsize=1024)  # the rows of a sweep read the same texts
def _text_to_si(text: str, expected: QuantityKind, what: str) -> float:
    cleaned = text.strip().translate(_CHARACTER_REPLACEMENTS)
    message_start = f"{what} is {expected.name}; {format_value(text)}"
    if len(cleaned) > _MAX_TEXT_LENGTH:
        raise MechanismError(f"{message_start} is too long for a quantity; {expected.hint}")
    number = _NUMBER.match(cleaned)
    if _NOT_A_NUMBER.match(cleaned):
        return math.nan
    if number is None:
        raise MechanismError(f"{message_start} {'has no number' if cleaned else 'is empty'}; {expected.hint}")
    unit = cleaned[number.end() :]
    if unit.startswith(","):
        raise MechanismError(f"{message_start} has a comma; write a decimal point, and no thousands separator")
    if not unit and not expected.units:
        raise MechanismError(f"{message_start} is text; write the bare number {number[1]}")
    if not unit:
        hint = f'write "{number[1]} {expected.example.partition(" ")[2]}", or the bare number in {expected.si_unit}'
        raise MechanismError(f"{message_start} has no unit; {hint}")
    factor = Decimal(1) if unit == expected.si_unit else USUAL_FACTORS.get((unit, expected.si_unit))
    try:
        return float(Decimal(number[1]) * (factor or _unit_factor(unit, Decimal(number[1]), expected, message_start)))
    except ArithmeticError:  # an exponent beyond the range of Decimal
        return math.inf


def _unit_factor(unit: str, number: Decimal, expected: QuantityKind, message_start: str) -> Decimal:
    """Return the SI value of one `unit`, if it is of the expected kind."""
    with_powers = re.sub(r"([^\W\d_])(-?[1-9])", r"\1^\2", unit)
    normalised = re.sub(rf"^{_TURN_UNIT}", "turn", f"1{with_powers}" if with_powers.startswith("/") else with_powers)
    try:
        if not _UNIT.fullmatch(normalised):
            raise MechanismError(f"{normalised!r} contains no unit names")
        factor, base_unit = _in_base_units(normalised)
    except Exception as error:
        # pint raises many unrelated types (its own, tokenizer's, AssertionError) with one meaning for the user.
        hint = f"{expected.units_hint}{_suggest_unit(unit, expected)}"
        raise MechanismError(f'{message_start} has an unknown unit "{unit}"; {hint}') from error
    if _is_like(base_unit, expected.si_unit) and (expected.units or normalised == "%"):
        _require_accepted(normalised, number * factor, expected, message_start)
        return factor
    if _is_like(base_unit, "rad/s") and expected.si_unit == "Hz":
        factor /= _in_base_units("turn")[0]
        _require_accepted(normalised, number * factor, expected, message_start)
        return factor
    if _is_like(base_unit, "1/s") and expected.si_unit == "rad/s":
        return _per_time_factor(normalised, number * factor, message_start)
    raise MechanismError(f"{message_start} is {_wrong_kind_message(normalised, number, factor, base_unit, expected)}")


def _require_accepted(unit: str, si_value: Decimal, expected: QuantityKind, message_start: str) -> None:
    """Raise MechanismError, with the value in SI, if a unit of the right kind contains one that engineers do not use."""
    words = (word for word in _UNIT_WORD.findall(unit) if word != "per")
    refused = [word for word in words if _full_name(word) not in _accepted_names()]
    if not refused:
        return
    own = next((units for kind, units in ACCEPTED_UNITS.items() if QUANTITY_KINDS.get(kind) is expected), expected.units)
    in_si = f'write "{float(si_value):.12g} {expected.si_unit}"'
    raise MechanismError(f'{message_start} has the unit "{refused[0]}", which is not accepted; {in_si}; units are {", ".join(own)}')


@cache
def _accepted_names() -> frozenset[str]:
    """Return the full names of the accepted units."""
    return frozenset(_full_name(unit) for units in ACCEPTED_UNITS.values() for unit in units)


def _full_name(unit: str) -> str:
    """Return pint's name of a unit; it replaces the signs of degrees and percent before it looks a unit up."""
    return str(_unit_registry().get_name(unit.replace("°", "degree").replace("%", "percent")))


@cache
def _in_base_units(unit: str) -> tuple[Decimal, Any]:
    """Return the factor and the pint unit of a unit in base units; unlike pint's dimensions, they keep radians."""
    registry = _unit_registry()
    factor, base_unit = registry.get_base_units(registry.parse_units(unit))
    return Decimal(factor), base_unit


def _is_like(base_unit: Any, si_unit: str) -> bool:
    return bool(base_unit == _in_base_units(si_unit)[1])


@cache
def _unit_registry() -> Any:
    """Return pint's registry with decimal arithmetic, so that "300 mm" and 0.3 are the same float."""
    import pint  # slow to import

    registry: Any = pint.UnitRegistry(non_int_type=Decimal)
    registry.define("@alias force_kilogram = kp")
    registry.define("Nm = newton * meter")
    registry.define("PS = metric_horsepower")  # pint alone would read petasiemens
    return registry


def _per_time_factor(unit: str, per_second: Decimal, message_start: str) -> Decimal:
    """Return the factor of an angular speed without an angle; only 1/s and 1/min have a customary meaning."""
    squeezed = re.sub(r"\s", "", unit)
    if squeezed in ("1/s", "s^-1"):
        return Decimal(1)
    if squeezed in ("1/min", "min^-1"):
        return _in_base_units("rpm")[0]
    raise MechanismError(f'{message_start} may mean turns or radians; write "{60 * per_second:.6g} rpm" or "{per_second:.6g} rad/s"')


def _wrong_kind_message(unit: str, number: Decimal, factor: Decimal, base_unit: Any, expected: QuantityKind) -> str:
    """Return the kind that a unit belongs to instead, and the cure; weight and mass are often confused."""
    if expected.si_unit == "kg" and _is_like(base_unit, "N"):
        if unit in ("kgf", "kp"):
            return f"a force: that is a weight; write {float(number * factor / _KILOGRAM_FORCE):.12g} kg"
        return f"a force: that is a weight; write {float(number * factor / _NEWTON_PER_KILOGRAM):.3g} kg (rounded: its mass at 9.81 m/s^2)"
    if expected.si_unit == "N" and _is_like(base_unit, "kg"):
        return f'a mass, not a force; write "{float(number * factor):.12g} kgf" or in N'
    known = [*((kind.name, kind.si_unit) for kind in QUANTITY_KINDS.values() if kind.units), *_OTHER_KINDS, ("a plain number", "")]
    kind_name = next((name for name, si_unit in known if _is_like(base_unit, si_unit)), "of another kind")
    return f"{kind_name}; {expected.units_hint}"


def _suggest_unit(unit: str, expected: QuantityKind) -> str:
    """Return a hint at a known unit with a similar spelling, first of the expected kind; it never takes turns for radians."""
    word = unit.lower()
    candidates = [*expected.units, "1/min", "°", *(name for kind in QUANTITY_KINDS.values() for name in kind.units)]
    if expected.si_unit == "rad/s":
        if _TURN_SPELLING.match(word):
            return f". Did you mean {'rev/s' if _PER_SECOND.search(word) else 'rpm'!r}?"
        misleading = {"deg", "rad", "°", "deg/s", "rad/s", "deg/s^2", "rad/s^2", "Hz"}
        candidates = ["deg/s", "rad/s"] if _ANGLE_SPELLING.match(word) else [name for name in candidates if name not in misleading]
    lowered = {name.lower(): name for name in reversed(candidates)}
    matches = difflib.get_close_matches(word, list(lowered), n=1)
    return f". Did you mean {lowered[matches[0]]!r}?" if matches else ""


DISPLAY_UNITS = {"rad": (180 / math.pi, "deg"), "m": (1e3, "mm"), "rad/s": (1 / RPM, "rpm"), "Pa": (1e-5, "bar"), "1": (1.0, "")}
"""Customary units for display by SI unit, with their number per SI unit; other units are displayed as they are."""


def display_unit(unit: str) -> tuple[float, str]:
    """Return the number of customary units in an SI unit, and the name of that unit."""
    return DISPLAY_UNITS.get(unit, (1.0, unit))


def format_reading_name(name: str) -> str:
    """Return the name of a reading in running text."""
    return name if "." in name else name.replace("_", " ")


def in_mm(metres: float) -> str:
    """Return a length (m) as text in mm."""
    return f"{metres * 1e3:.6g} mm"


def format_quantity(
    value: float,
    unit: str,  # SI unit
    digits: str = ".6g",
) -> str:
    """Return a value as text with a customary unit."""
    factor, name = display_unit(unit)
    return f"{value * factor:z{digits}} {name}".rstrip()  # z leaves out the sign of a rounded zero
