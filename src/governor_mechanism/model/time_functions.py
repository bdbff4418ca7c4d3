"""Inputs as functions of time and of readings, and prescribed motions of drivers. Frozen values."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

from governor_mechanism.errors import MechanismError, require_finite, require_not_negative, require_rising
from governor_mechanism.units.fields import quantity, require_valid_fields
from governor_mechanism.units.quantities import require_plausible


@dataclass(frozen=True, kw_only=True)
class ReadingFunction:
    """Base class of a function of a reading."""

    # name of the reading, of this part or, as "part.reading", of another one. "spindle_speed" is that of a
    # free or coupled spindle, "shaft_speed" that of the shaft of an engine.
    reading: str
    lag: float = 0.0  # time constant of a first-order lag between the function and what it acts on, s; 0 for none
    # quantity of the reading that the units of the function imply: "length", "angle" or "angular_speed";
    # empty without units
    quantity: str = ""
    # reading of the coupled mechanism whose value or rate the function takes; empty before the parts of a
    # scene are coupled
    source: str = ""
    is_rate: bool = False  # whether the function takes the rate of its source

    def __post_init__(self) -> None:
        require_not_negative(self.lag, "s", f"lag of the function of {self.reading!r}")
        require_valid_fields(self, f"the function of {self.reading!r}")

    def scaled(self, factor: float) -> ReadingFunction:
        """Return the function times a factor."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class LinearFunction(ReadingFunction):
    """The function gain * (reading - about)."""

    gain: float = quantity(sign="any")  # value per unit of the reading, SI
    about: float = quantity(sign="any", default=0.0)  # reading at which the function is 0, SI

    def scaled(self, factor: float) -> LinearFunction:
        """Return the function times a factor."""
        return replace(self, gain=self.gain * factor)


@dataclass(frozen=True, kw_only=True)
class TableFunction(ReadingFunction):
    """A function that is linear between points and constant beyond the first and the last one."""

    positions: tuple[float, ...]  # values of the reading, SI, strictly rising; two or more
    values: tuple[float, ...]  # values of the function there, SI

    def __post_init__(self) -> None:
        super().__post_init__()
        what = f"a table of {self.reading!r}"
        if len(self.positions) < 2 or len(self.positions) != len(self.values):
            raise MechanismError(f"{what} needs two points or more, each with a reading and a value; got {len(self.positions)}")
        for number in (*self.positions, *self.values):
            require_finite(number, "", f"number in {what}")
        require_rising(self.positions, f"the readings in {what}")

    def scaled(self, factor: float) -> TableFunction:
        """Return the function times a factor."""
        return replace(self, values=tuple(value * factor for value in self.values))


@dataclass(frozen=True, kw_only=True)
class AngleHarmonic:
    """A harmonic amplitude * sin(order * angle + phase) of an angle."""

    amplitude: float = quantity(sign="any", meaning="the amplitude")  # amplitude, SI
    # cycles per turn of the angle; at least 0
    order: float = quantity("number", sign="not negative", meaning="the cycles per turn of the angle, as 2")
    # phase where the angle is 0, rad
    phase: float = quantity("angle", sign="any", default=0.0, meaning="the phase where the angle is 0")

    def __post_init__(self) -> None:
        require_valid_fields(self, "a harmonic")


@dataclass(frozen=True, kw_only=True)
class HarmonicFunction(ReadingFunction):
    """A sum of harmonics of an angle."""

    harmonics: tuple[AngleHarmonic, ...]  # the harmonics; at least one

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.harmonics:
            raise MechanismError(f"the harmonics of {self.reading!r} are missing; give at least one")

    def scaled(self, factor: float) -> HarmonicFunction:
        """Return the function times a factor."""
        return replace(self, harmonics=tuple(replace(one, amplitude=one.amplitude * factor) for one in self.harmonics))


class StrokeHold(Enum):
    """What ends the motion of an input for the rest of a stroke: the dead centre at which the stroke begins, or its own event in it."""

    FROM_DEAD_CENTRE = "dead centre"
    FROM_CUT_OFF = "cut-off"


@dataclass(frozen=True, kw_only=True)
class InputFunction:
    """A value over time, smooth between points and constant before the first and after the last point, with harmonics and functions.

    One point is a constant, two points are a ramp, and two points at one time are a step. Harmonics of the time and functions of
    readings are added to the value; the sum is multiplied by the factors.
    """

    times: tuple[float, ...] = (0.0,)  # points of time, s, not falling; at most two at one time
    values: tuple[float, ...] = (0.0,)  # values at these times, SI
    harmonics: tuple[Harmonic, ...] = ()  # harmonics of the time to add
    functions: tuple[ReadingFunction, ...] = ()  # functions of readings to add
    factors: tuple[ReadingFunction, ...] = ()  # functions of readings to multiply by
    # event in each stroke of an engine from which the value is held to the next dead centre; None if it is
    # never held
    hold: StrokeHold | None = None
    integral_before: float = 0.0  # integral over the time before 0 s, SI; not 0 for the speed of a run that goes on from a state

    def __post_init__(self) -> None:
        _require_equal_lengths("an input function", self.times, self.values)
        require_rising(self.times, "times of an input function", " s", strictly=False)
        for first, _, third in zip(self.times, self.times[1:], self.times[2:], strict=False):
            if first == third:
                raise MechanismError(f"three points of an input function are at {first:g} s; a step takes two")

    @property
    def is_constant(self) -> bool:
        """Whether all values over time are equal and no reading matters."""
        return all(value == self.values[0] for value in self.values) and not self.harmonics and not self.depends_on_readings

    @property
    def range_in_time(self) -> tuple[float, float]:
        """Bounds of the value over time without functions of readings, SI."""
        amplitude = sum(abs(one.amplitude) for one in self.harmonics)
        return min(self.values) - amplitude, max(self.values) + amplitude

    @property
    def depends_on_readings(self) -> bool:
        """Whether the value depends on a reading."""
        return bool(self.functions or self.factors)

    def scaled(self, factor: float) -> InputFunction:
        """Return the input times a factor."""
        functions = tuple(function.scaled(factor) for function in self.functions)
        harmonics = tuple(replace(one, amplitude=one.amplitude * factor) for one in self.harmonics)
        return replace(self, values=tuple(value * factor for value in self.values), harmonics=harmonics, functions=functions)


@dataclass(frozen=True, kw_only=True)
class Harmonic:
    """A harmonic amplitude * sin(2 pi * frequency * time + phase) of a prescribed motion or of an input."""

    amplitude: float = quantity(sign="any", meaning="the amplitude")  # amplitude, SI
    # frequency, Hz; positive
    frequency: float = quantity(
        "frequency", meaning='the frequency in cycles, as "2 Hz" or "120 rpm", or the angular frequency, as "3 rad/s"'
    )
    phase: float = quantity("angle", sign="any", default=0.0, meaning="the phase at 0 s")  # phase at 0 s, rad

    def __post_init__(self) -> None:
        require_valid_fields(self, "a harmonic")


@dataclass(frozen=True, kw_only=True)
class PrescribedMotion:
    """A prescribed motion of a driver: a curve without kinks through given points, plus harmonics.

    Two points are a motion at constant rate, three a parabola, more a cubic spline that reproduces polynomials up to the third
    degree. Before the first and after the last point the curve continues at the rate there. A motion with rests is
    monotone between its points instead, and constant before the first and after the last one; its rate does not jump.
    """

    times: tuple[float, ...]  # points of time, s, strictly rising; two or more
    values: tuple[float, ...]  # values at these times, rad or m
    harmonics: tuple[Harmonic, ...] = ()  # harmonics that are added to the curve
    # whether the curve is monotone between its points, so that it rests between two equal values and outside
    # the points
    has_rests: bool = False

    def __post_init__(self) -> None:
        _require_equal_lengths("a motion", self.times, self.values)
        if len(self.times) < 2:
            raise MechanismError("a motion needs two points or more; PrescribedMotion.constant_rate gives one of constant rate")
        require_rising(self.times, "times of a motion", " s", hint="; a driver cannot jump")
        points = list(zip(self.times, self.values, strict=True))
        rates = [abs((after[1] - before[1]) / (after[0] - before[0])) for before, after in pairwise(points)]
        rates += [abs(item.amplitude) * math.tau * item.frequency for item in self.harmonics]
        require_plausible(max(rates), "angular_rate", "rate of a motion, per second,")  # that of a length has the same bound

    @classmethod
    def constant_rate(cls, start_value: float, rate: float, harmonics: tuple[Harmonic, ...] = ()) -> PrescribedMotion:
        """Return the motion start_value + rate * time plus harmonics."""
        return cls(times=(0.0, 1.0), values=(start_value, start_value + rate), harmonics=harmonics)


def _require_equal_lengths(what: str, times: tuple[float, ...], values: tuple[float, ...]) -> None:
    if not times or len(times) != len(values):
        raise MechanismError(f"{what} needs as many times as values; got {len(times)} and {len(values)}")
    for time, value in zip(times, values, strict=True):
        require_finite(time, "s", f"time of {what}")
        require_finite(value, "", f"value of {what}")
