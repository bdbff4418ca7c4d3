"""What a user lets happen in time: a load or a speed by points, and a motion that a drive enforces. Frozen values."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite


@dataclass(frozen=True, kw_only=True)
class InputFunction:
    """A value against time: `times` (s) and `values` (SI), smooth between points and held before and after them.

    One point is a constant. Two points alone are a straight ramp. Two points at one time are a step.
    """

    times: tuple[float, ...] = (0.0,)
    values: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        _require_equal_lengths("a program", self.times, self.values)
        for before, after in zip(self.times, self.times[1:], strict=False):
            if after < before:
                raise MechanismError(f"times of a program must not fall; {after:g} s follows {before:g} s")
        for first, _, third in zip(self.times, self.times[1:], self.times[2:], strict=False):
            if first == third:
                raise MechanismError(f"three points of a program stand at {first:g} s; a step takes two")

    @property
    def is_constant(self) -> bool:
        """True when the value never changes."""
        return len(set(self.values)) == 1


@dataclass(frozen=True, kw_only=True)
class PrescribedMotion:
    """A motion that a drive enforces: `times` (s) and `values` (rad or m), a curve without kinks through the points.

    Before the first and after the last point it goes on at its speed there; two points are a steady motion.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        _require_equal_lengths("a motion", self.times, self.values)
        if len(self.times) < 2:
            raise MechanismError("a motion needs two points or more; Motion.steady gives one of constant speed")
        for before, after in zip(self.times, self.times[1:], strict=False):
            if after <= before:
                raise MechanismError(f"times of a motion must rise; {after:g} s follows {before:g} s, and nothing is driven in a jump")

    @classmethod
    def constant_rate(cls, start_value: float, rate: float) -> PrescribedMotion:
        """The motion start + rate * time."""
        return cls(times=(0.0, 1.0), values=(start_value, start_value + rate))


def _require_equal_lengths(what: str, times: tuple[float, ...], values: tuple[float, ...]) -> None:
    if not times or len(times) != len(values):
        raise MechanismError(f"{what} needs as many times as values; got {len(times)} and {len(values)}")
    for time, value in zip(times, values, strict=True):
        require_finite(time, "s", f"time of {what}")
        require_finite(value, "", f"value of {what}")
