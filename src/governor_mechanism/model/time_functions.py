"""Functions of time: inputs given by points, and prescribed motions of drivers. Frozen values."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite


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
class PrescribedMotion:
    """A prescribed motion of a driver: a curve without kinks through given points.

    Before the first and after the last point it continues at the rate there. Two points are a motion at constant rate.

    Attributes
    ----------
    times
        Points of time, s, strictly rising; two or more.
    values
        Values at these times, rad or m.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        _require_equal_lengths("a motion", self.times, self.values)
        if len(self.times) < 2:
            raise MechanismError("a motion needs two points or more; PrescribedMotion.constant_rate gives one of constant rate")
        for before, after in zip(self.times, self.times[1:], strict=False):
            if after <= before:
                raise MechanismError(f"times of a motion must rise; {after:g} s follows {before:g} s; a driver cannot jump")

    @classmethod
    def constant_rate(cls, start_value: float, rate: float) -> PrescribedMotion:
        """Return the motion start_value + rate * time."""
        return cls(times=(0.0, 1.0), values=(start_value, start_value + rate))


def _require_equal_lengths(what: str, times: tuple[float, ...], values: tuple[float, ...]) -> None:
    if not times or len(times) != len(values):
        raise MechanismError(f"{what} needs as many times as values; got {len(times)} and {len(values)}")
    for time, value in zip(times, values, strict=True):
        require_finite(time, "s", f"time of {what}")
        require_finite(value, "", f"value of {what}")
