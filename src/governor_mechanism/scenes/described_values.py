"""Values of a scene in words: dimensions, coefficients, functions of time and of readings."""

import dataclasses
import math
from typing import Any

from governor_mechanism.model.time_functions import (
    AngleHarmonic,
    Harmonic,
    HarmonicFunction,
    InputFunction,
    LinearFunction,
    PrescribedMotion,
    ReadingFunction,
    TableFunction,
)
from governor_mechanism.units.quantities import format_quantity

MAX_WRITTEN_POINTS = 6
"""Largest number of points of a program or table that are written out; of a longer one, the ends."""

NEAT_UNITS = {"m2": "m^2", "m^2": "m^2", "1": ""}
"""Units that are written differently in scene files."""

QUANTITY_UNITS = {"angle": "rad", "length": "m", "angular_speed": "rad/s", "ratio": ""}
"""Unit of a reading by its quantity."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class DescribedValue:
    """A named value with its unit.

    Attributes
    ----------
    name
        Name, as in a scene file.
    value
        Number in SI, word, text of a function, or None for a value that is left out.
    unit
        SI unit; empty for a number without one.
    meaning
        What it is; may be empty.
    """

    name: str
    value: float | str | None
    unit: str = ""
    meaning: str = ""

    @property
    def text(self) -> str:
        """The value with a customary unit."""
        if self.value is None:
            return "left out"
        return self.value if isinstance(self.value, str) else format_number(self.value, self.unit)

    def as_json(self) -> dict[str, Any]:
        """Return the fields by name, without an empty meaning."""
        values = {"name": self.name, "value": self.value, "unit": self.unit}
        return values | ({"meaning": self.meaning} if self.meaning else {})


def format_number(
    value: float,
    unit: str,  # SI unit
) -> str:
    """Return a number with a customary unit, as scene files write it.

    Result: text such as "300 mm"; "none" for an infinite one.
    """
    return "none" if math.isinf(value) else format_quantity(value, NEAT_UNITS.get(unit, unit))


def describe_value(
    name: str,
    value: Any,  # a number in SI, None, a flag, a word, a function or a motion
    unit: str,  # SI unit of the number or of the values of the function
    meaning: str = "",
) -> DescribedValue:
    """Return a value of a description with its name.

    Result: the value; that of a function is a text.
    """
    if isinstance(value, InputFunction):
        is_plain = value.is_constant
        return DescribedValue(name=name, value=value.values[0] if is_plain else describe_input(value, unit), unit=unit, meaning=meaning)
    if isinstance(value, PrescribedMotion):
        return DescribedValue(name=name, value=_describe_points(value.times, value.values, unit), unit=unit, meaning=meaning)
    if isinstance(value, bool):
        return DescribedValue(name=name, value=str(value).lower(), meaning=meaning)
    is_left_out = value is None or (isinstance(value, float) and math.isinf(value))
    return DescribedValue(name=name, value=None if is_left_out else value, unit="" if isinstance(value, str) else unit, meaning=meaning)


def describe_input(
    function: InputFunction,  # value over time, with the functions of readings that are added and multiplied
    unit: str,  # SI unit of the value
) -> str:
    """Return an input in words.

    Result: text such as "300 N m at 0 s, 150 N m at 6 s, times a table of governor.sleeve_lift".
    """
    has_zero = len(function.times) == 1 and not function.values[0] and bool(function.functions or function.harmonics)
    terms = [] if has_zero else [_describe_points(function.times, function.values, unit)]
    for one in function.harmonics:
        terms.append(f"{'plus ' if terms else ''}{_describe_harmonic(one, format_number(one.frequency, 'Hz'), unit)}")
    terms += [f"{'plus ' if terms else ''}{describe_reading_function(one, unit)}" for one in function.functions]
    terms += [f"times {describe_reading_function(one, '')}" for one in function.factors]
    return ", ".join(terms)


def describe_reading_function(function: ReadingFunction, unit: str) -> str:
    """Return a function of a reading in words; `unit` is the SI unit of its value."""
    reading, own_unit = function.reading, QUANTITY_UNITS.get(function.quantity, "")
    lag = f", with a lag of {format_number(function.lag, 's')}" if function.lag else ""
    if isinstance(function, LinearFunction):
        about = f" about {format_number(function.about, own_unit)}" if function.about else ""
        gain_unit = f" {unit} per {own_unit}" if own_unit else " in SI"
        return f"{function.gain:.6g}{gain_unit} of {reading}{about}{lag}"
    if isinstance(function, TableFunction):
        return f"a table of {reading}: {_describe_points(function.positions, function.values, unit, own_unit)}{lag}"
    if isinstance(function, HarmonicFunction):
        return ", plus ".join(_describe_harmonic(one, f"order {one.order:g}", unit) for one in function.harmonics) + f" in {reading}{lag}"
    return f"a function of {reading}{lag}"


def _describe_harmonic(harmonic: Harmonic | AngleHarmonic, frequency: str, unit: str) -> str:
    """Return a sine in words; `frequency` is its frequency or order."""
    phase = f" at a phase of {format_number(harmonic.phase, 'rad')}" if harmonic.phase else ""
    return f"a sine of {format_number(harmonic.amplitude, unit)} and {frequency}{phase}"


def _describe_points(positions: tuple[float, ...], values: tuple[float, ...], unit: str, position_unit: str = "s") -> str:
    """Return values at positions, which are times by default; of many, the first and the last."""
    if len(positions) == 1:
        return format_number(values[0], unit)
    points = [f"{format_number(y, unit)} at {format_number(x, position_unit)}" for x, y in zip(positions, values, strict=True)]
    return ", ".join(points) if len(points) <= MAX_WRITTEN_POINTS else f"{len(points)} points from {points[0]} to {points[-1]}"
