"""Limit of stability: the value of a parameter at which an eigenvalue of the linearised equations crosses the imaginary axis."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Generic, TypeVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Result
from governor_mechanism.statics.first_order_system import FirstOrderSystem, Onset
from governor_mechanism.units.short_repr import short_repr

RELATIVE_TOLERANCE = 1e-12
"""Tolerance of the value at the limit, relative to the ends of its range."""


Linearised = TypeVar("Linearised", bound=FirstOrderSystem)


@dataclass(frozen=True, kw_only=True, eq=False)
class StabilityLimit(Result, Generic[Linearised]):
    """Limit of stability along one key of a scene.

    Attributes
    ----------
    key
        Key of the scene.
    unit
        Its SI unit.
    value
        Value at the limit, SI.
    frequency
        Frequency of the oscillation that begins there, rad/s; 0 if the motion diverges without oscillation.
    stable_below
        Whether the steady state is stable for smaller values.
    onset
        Whether the oscillations begin softly or hard.
    linearisation
        Linearised equations at the limit.
    """

    key: str
    unit: str
    value: float
    frequency: float
    stable_below: bool
    onset: Onset
    linearisation: Linearised

    __repr__ = short_repr


def find_stability_limit(
    linearise_at: Callable[[float], Linearised],
    low: float,  # one end of the range, SI
    high: float,  # the other end, SI
    *,
    key: str,
    unit: str,  # its SI unit
) -> StabilityLimit[Linearised]:
    """Return the limit of stability between two values of a parameter.

    Raises MechanismError if the scene is not stable at one end and unstable at the other, or has no steady
    state at a value.
    """
    from scipy.optimize import brentq  # slow to import

    linearise_at = cache(linearise_at)

    def growth_rate(value: float) -> float:
        """Return the largest real part, also if it is within its error."""
        try:
            linearisation = linearise_at(value)
        except MechanismError as error:
            raise MechanismError(*(f"{key} = {value:.6g} {unit}".strip() + f": {problem}" for problem in error.problems)) from error
        return linearisation.critical_real_part

    ends = {value: linearise_at(value) for value in (low, high)}
    rates = [end.growth_rate for end in ends.values()]
    if not rates[0] * rates[1] < 0.0:
        states = " and ".join(
            f"{end.stability} at {value:.6g} {unit}".strip() + f" (largest real part {end.growth_rate:.6g} 1/s)"
            for value, end in ends.items()
        )
        raise MechanismError(
            f"no limit of stability lies between the ends of {key}: it is {states}; give ends that are stable and unstable"
        )
    value = float(brentq(growth_rate, low, high, xtol=RELATIVE_TOLERANCE * max(abs(low), abs(high)), rtol=RELATIVE_TOLERANCE))
    linearisation = linearise_at(value)
    return StabilityLimit(
        key=key,
        unit=unit,
        value=value,
        frequency=linearisation.critical_frequency,
        stable_below=(rates[0] < 0.0) == (low < high),
        onset=linearisation.onset,
        linearisation=linearisation,
    )
