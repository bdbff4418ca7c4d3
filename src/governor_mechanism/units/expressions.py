"""Arithmetic over quantities, as "2 * crank + 10 mm": units are carried along, names looked up; angles are plain numbers, in rad."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import QUANTITY_KINDS, USUAL_FACTORS, QuantityKind, TextWithValue, format_value, read_quantity

MAX_EXPRESSION_LENGTH = 200
"""Largest number of characters of an expression; a longer one is easier to read as several dimensions."""

Unit = tuple[Fraction, Fraction, Fraction]
"""Exponents of kg, m and s."""

PLAIN: Final[Unit] = (Fraction(0), Fraction(0), Fraction(0))
"""Unit of a plain number and of an angle."""

_BASE_UNITS: Final[Mapping[str, tuple[int, int, int]]] = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "rad": (0, 0, 0),
    "1": (0, 0, 0),
    "Hz": (0, 0, -1),
    "N": (1, 1, -2),
    "Pa": (1, -1, -2),
    "W": (1, 2, -3),
}
"""Exponents of the words in the SI units of `QUANTITY_KINDS`."""

_TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?:[ \t]*(?P<unit>[^\W\d_]+|[°%])(?![\w(]))?"
    r"|(?P<name>[^\W\d]\w*)|(?P<mark>\*\*|[-+*/^(),]))"
)
_SUPPORTED: Final = "an expression has numbers, names, + - * / ^, brackets and functions"


@dataclass(frozen=True)
class Measured:
    """A number, or an array of numbers, in SI with its unit."""

    value: float | FloatArray  # number or array, SI
    unit: Unit = PLAIN  # exponents of kg, m and s


@dataclass(frozen=True)
class Function:
    """A function of expressions."""

    apply: Callable[..., Measured]  # the function, from measured arguments to a measured result
    n_arguments: int = 1  # number of its arguments


@cache
def unit_of_kind(kind: str) -> Unit:
    """Return the unit of a kind of quantity."""
    exponents, sign = np.zeros(3, dtype=int), 1
    for word in re.findall(r"/|[A-Za-z1]+(?:\^\d)?", QUANTITY_KINDS[kind].si_unit):
        if word == "/":
            sign = -1
            continue
        name, _, power = word.partition("^")
        exponents = exponents + sign * int(power or 1) * np.array(_BASE_UNITS[name])
    mass, length, time = (Fraction(int(one)) for one in exponents)
    return mass, length, time


def format_unit(unit: Unit) -> str:
    """Return a unit in words, as "a length" or "in m^3"."""
    if unit == PLAIN:
        return "a plain number"
    named = next((one.name for name, one in QUANTITY_KINDS.items() if one.units and unit_of_kind(name) == unit), "")
    return named or f"in {si_unit_of(unit)}"


def si_unit_of(unit: Unit) -> str:
    """Return a unit as text, as "kg m^2"; empty for a plain number."""
    words = zip(("kg", "m", "s"), unit, strict=True)
    return " ".join(f"{name}^{power}" if power != 1 else name for name, power in words if power)


def read_any_quantity(value: object, what: str) -> tuple[float, str]:
    """Return a quantity of any kind in SI, and its kind; a bare number is a plain number; raise MechanismError if it is no quantity."""
    if not isinstance(value, str):
        return read_quantity(value, "number", what), "number"
    written_unit = value.strip().lstrip("+-−.0123456789eE").strip()
    usual = (kind for kind, one in QUANTITY_KINDS.items() if written_unit == one.si_unit or (written_unit, one.si_unit) in USUAL_FACTORS)
    for kind in (*usual, *QUANTITY_KINDS):
        try:
            return read_quantity(value, kind, what), kind
        except MechanismError:
            continue
    example = 'write a number with its unit, as "300 mm", a bare number, or an expression of other dimensions, as "= 2 * crank"'
    raise MechanismError(f"{what} is no quantity; found {format_value(value)}; {example}")


class Expression:
    """An arithmetic expression, read from text.

    Parameters
    ----------
    text
        The expression, without a sign of equality.

    Attributes
    ----------
    text
        The text.
    names
        Names in it that are not functions, each once.

    Raises
    ------
    MechanismError
        If the text is no expression.
    """

    def __init__(self, text: str) -> None:
        if len(text) > MAX_EXPRESSION_LENGTH:
            raise MechanismError(
                f"{format_value(text)} has more than {MAX_EXPRESSION_LENGTH} characters; name a part of it in [dimensions]"
            )
        reader, self.text = _Reader(text), text.strip()
        self._evaluate, self.names = reader.read(), tuple(dict.fromkeys(reader.names))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and other.text == self.text

    def __hash__(self) -> int:
        return hash(self.text)

    def evaluate(self, values: Callable[[str], Measured], functions: Mapping[str, Function]) -> Measured:
        """Return the value; `values` looks a name up, and `functions` are those that it may have."""
        with np.errstate(all="ignore"):  # whoever asks refuses what is not finite
            return self._evaluate(values, functions)


_Node = Callable[[Callable[[str], Measured], Mapping[str, Function]], Measured]


class _Reader:
    """Reader of one expression: sums of products of powers, from left to right."""

    def __init__(self, text: str) -> None:
        self.text, self.names = text, list[str]()
        self._tokens, position = list[re.Match[str]](), 0
        stripped = text.rstrip()
        while position < len(stripped):
            token = _TOKEN.match(stripped, position)
            if token is None:
                raise MechanismError(f"{format_value(text)} cannot be read at {stripped[position:].strip()!r}; {_SUPPORTED}")
            self._tokens.append(token)
            position = token.end()
        self._index = 0

    def read(self) -> _Node:
        """Return the whole expression."""
        node = self._sum()
        if self._index < len(self._tokens):
            raise self._unexpected()
        return node

    def _unexpected(self) -> MechanismError:
        at_end = self._index >= len(self._tokens)
        where = "ends too early" if at_end else f"cannot be read at {self._tokens[self._index].group().strip()!r}"
        return MechanismError(f"{format_value(self.text)} {where}; {_SUPPORTED}")

    def _take(self, *marks: str) -> str:
        """Return the next mark and pass it if it is one of these; "" otherwise."""
        mark = self._tokens[self._index]["mark"] if self._index < len(self._tokens) else None
        if mark not in marks:
            return ""
        self._index += 1
        return mark

    def _require(self, mark: str) -> None:
        if not self._take(mark):
            raise self._unexpected()

    def _sum(self) -> _Node:
        node = self._product()
        while mark := self._take("+", "-"):
            node = _joined(_add if mark == "+" else _subtract, node, self._product())
        return node

    def _product(self) -> _Node:
        node = self._signed()
        while mark := self._take("*", "/"):
            node = _joined(_multiply if mark == "*" else _divide, node, self._signed())
        return node

    def _signed(self) -> _Node:
        if mark := self._take("+", "-"):
            node = self._signed()
            return node if mark == "+" else _joined(_multiply, _constant(Measured(-1.0)), node)
        return self._power()

    def _power(self) -> _Node:
        base = self._single()
        return _joined(_raise, base, self._signed()) if self._take("^", "**") else base

    def _single(self) -> _Node:
        if self._take("("):
            node = self._sum()
            self._require(")")
            return node
        token = self._tokens[self._index] if self._index < len(self._tokens) else None
        if token is None or token["mark"]:
            raise self._unexpected()
        self._index += 1
        if token["number"]:
            return _constant(_read_literal(token["number"], token["unit"]))
        name = token["name"]
        if self._take("("):
            arguments = [self._sum()]
            while self._take(","):
                arguments.append(self._sum())
            self._require(")")
            return _call(name, arguments)
        if name == "pi":
            return _constant(Measured(np.pi))
        self.names.append(name)
        return lambda values, functions: values(name)


def _read_literal(number: str, unit: str | None) -> Measured:
    if not unit:
        return Measured(float(number))
    value, kind = read_any_quantity(f"{number} {unit}", f'"{number} {unit}"')
    return Measured(value, unit_of_kind(kind))


def _constant(value: Measured) -> _Node:
    return lambda values, functions: value


def _joined(function: Callable[..., Measured], *nodes: _Node) -> _Node:
    return lambda values, functions: function(*(node(values, functions) for node in nodes))


def _call(name: str, arguments: list[_Node]) -> _Node:
    def evaluate(values: Callable[[str], Measured], functions: Mapping[str, Function]) -> Measured:
        if name not in functions:
            raise MechanismError(f"there is no function {name!r}; functions are {', '.join(functions)}.{did_you_mean(name, functions)}")
        function, n_given = functions[name], len(arguments)
        if n_given != function.n_arguments:
            raise MechanismError(f"the function {name} takes {function.n_arguments} arguments; found {n_given}")
        return function.apply(*(one(values, functions) for one in arguments))

    return evaluate


def _require_same_unit(first: Measured, second: Measured, sentence: str) -> None:
    if first.unit != second.unit:
        raise MechanismError(f"{sentence} of different units: {format_unit(first.unit)} and {format_unit(second.unit)}")


def _add(first: Measured, second: Measured) -> Measured:
    _require_same_unit(first, second, "+ is between quantities")
    return Measured(first.value + second.value, first.unit)


def _subtract(first: Measured, second: Measured) -> Measured:
    _require_same_unit(first, second, "- is between quantities")
    return Measured(first.value - second.value, first.unit)


def _multiply(first: Measured, second: Measured) -> Measured:
    return Measured(first.value * second.value, _combine(first.unit, second.unit, 1))


def _divide(first: Measured, second: Measured) -> Measured:
    return Measured(np.divide(first.value, second.value), _combine(first.unit, second.unit, -1))


def _raise(base: Measured, exponent: Measured) -> Measured:
    if exponent.unit != PLAIN or (base.unit != PLAIN and np.ndim(exponent.value)):
        raise MechanismError("an exponent must be a plain number")
    power = Fraction(float(exponent.value)).limit_denominator(12) if base.unit != PLAIN else Fraction(0)
    unit = (base.unit[0] * power, base.unit[1] * power, base.unit[2] * power)
    return Measured(np.power(np.asarray(base.value, dtype=np.float64), exponent.value), unit)


def _combine(first: Unit, second: Unit, sign: int) -> Unit:
    return first[0] + sign * second[0], first[1] + sign * second[1], first[2] + sign * second[2]


def _of_number(function: Callable[[Any], Any], name: str) -> Function:
    """Return the function of a plain number or an angle."""

    def evaluate(argument: Measured) -> Measured:
        if argument.unit != PLAIN:
            raise MechanismError(f"{name} is of a plain number or an angle; it is of {format_unit(argument.unit)}")
        return Measured(function(argument.value))

    return Function(evaluate)


def _of_two_alike(function: Callable[[Any, Any], Any], name: str, *, keeps_unit: bool) -> Function:
    """Return the function of two quantities of the same unit."""

    def evaluate(first: Measured, second: Measured) -> Measured:
        _require_same_unit(first, second, f"{name} is of two quantities")
        return Measured(function(first.value, second.value), first.unit if keeps_unit else PLAIN)

    return Function(evaluate, 2)


ARITHMETIC: Final[Mapping[str, Function]] = {
    "sqrt": Function(lambda one: _raise(one, Measured(0.5))),
    "abs": Function(lambda one: Measured(np.abs(one.value), one.unit)),
    "hypot": _of_two_alike(np.hypot, "hypot", keeps_unit=True),
    "atan2": _of_two_alike(np.arctan2, "atan2", keeps_unit=False),
    **{name: _of_number(getattr(np, name), name) for name in ("sin", "cos", "tan")},
    **{f"a{name}": _of_number(getattr(np, f"arc{name}"), f"a{name}") for name in ("sin", "cos", "tan")},
}
"""Functions of every expression."""


class EvaluatedText(TextWithValue):
    """The text of an expression, as a file has it, with its value."""

    measured: Measured | None  # the value with its unit; None if it has none, which is reported where the expression is evaluated

    def __new__(cls, text: str, measured: Measured | None) -> EvaluatedText:
        """Return the text with a value."""
        evaluated = super().__new__(cls, text)
        evaluated.measured = measured
        return evaluated

    def convert(self, expected: QuantityKind, what: str) -> float:
        """Return the value in SI as a quantity of a kind; 1/s counts as rad/s, and a frequency counts cycles."""
        if self.measured is None:
            raise MechanismError
        kind = next(name for name, one in QUANTITY_KINDS.items() if one is expected)
        if self.measured.unit != unit_of_kind(kind):
            raise MechanismError(f"{what} is {expected.name}; {format_value(self)} is {format_unit(self.measured.unit)}")
        return float(self.measured.value) / (2 * np.pi if expected.si_unit == "Hz" else 1.0)
