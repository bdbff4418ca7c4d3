"""Functions of time: inputs given by points, and prescribed motions of drivers. Frozen values."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.model.measured_fields import measured, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class InputFunction:
    """A value over time, smooth between points and constant before the first and after the last point.

    One point is a constant, two points are a ramp, and two points at one time are a step.

    Attributes
    ----------
    times
        Points of time, s, not falling; at most two at one time.
    values
        Values at these times, SI.
    """

    times: tuple[float, ...] = (0.0,)
    values: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        _require_equal_lengths("an input function", self.times, self.values)
        for before, after in zip(self.times, self.times[1:], strict=False):
            if after < before:
                raise MechanismError(f"times of an input function must not fall; {after:g} s follows {before:g} s")
        for first, _, third in zip(self.times, self.times[1:], self.times[2:], strict=False):
            if first == third:
                raise MechanismError(f"three points of an input function are at {first:g} s; a step takes two")

    @property
    def is_constant(self) -> bool:
        """Whether all values are equal."""
        return len(set(self.values)) == 1


@dataclass(frozen=True, kw_only=True)
class Harmonic:
    """A harmonic amplitude * sin(2 pi * frequency * time + phase) of a prescribed motion.

    Attributes
    ----------
    amplitude
        Amplitude, rad or m.
    frequency
        Frequency, Hz; positive.
    phase
        Phase at 0 s, rad.
    """

    amplitude: float = measured("")
    frequency: float = measured("Hz", positive=True)
    phase: float = measured("rad", default=0.0)

    def __post_init__(self) -> None:
        require_valid_fields(self, "a harmonic")


@dataclass(frozen=True, kw_only=True)
class PrescribedMotion:
    """A prescribed motion of a driver: a curve without kinks through given points, plus harmonics.

    Two points are a motion at constant rate, three a parabola, more a cubic spline that reproduces polynomials up to the third
    degree. Before the first and after the last point the curve continues at the rate there.

    Attributes
    ----------
    times
        Points of time, s, strictly rising; two or more.
    values
        Values at these times, rad or m.
    harmonics
        Harmonics that are added to the curve.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]
    harmonics: tuple[Harmonic, ...] = ()

    def __post_init__(self) -> None:
        _require_equal_lengths("a motion", self.times, self.values)
        if len(self.times) < 2:
            raise MechanismError("a motion needs two points or more; PrescribedMotion.constant_rate gives one of constant rate")
        for before, after in zip(self.times, self.times[1:], strict=False):
            if after <= before:
                raise MechanismError(f"times of a motion must rise; {after:g} s follows {before:g} s; a driver cannot jump")

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
