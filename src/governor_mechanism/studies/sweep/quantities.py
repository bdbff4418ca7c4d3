"""What a sweep takes from each run: the final, least or greatest value of a reading, or what a function says."""

from __future__ import annotations

import hashlib
import inspect
import math
import pickle
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.scene import TURNING, FreeSpindle, Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.units.quantities import EVERYDAY, shown

TAKEN: Mapping[str, Callable[[Any], float]] = {
    "final": lambda values: float(values[-1]),
    "min": lambda values: float(np.min(values)),
    "max": lambda values: float(np.max(values)),
    "span": lambda values: float(np.max(values) - np.min(values)),
}
"""What may be taken of a reading, over its reported times."""

DURATION, ESTIMATE = "duration", "error_estimate"

RATE = "rate of "

UNITS = {"angle": "rad", "length": "m"}

EVERYDAY_RATES = {"rad/s": (180 / math.pi, "deg/s"), "m/s": (1e3, "mm/s")}
"""As units.EVERYDAY, of what is no shaft's speed."""

_NAME = re.compile(rf"(?:({'|'.join(TAKEN)}) )?({RATE})?(.+)")


class Told(Protocol):
    """What quantities that have a name are taken from: a run, or as much of one."""

    @property
    def times(self) -> NDArray[np.float64]: ...

    @property
    def readings(self) -> Mapping[str, NDArray[np.float64]]: ...

    @property
    def rates(self) -> Mapping[str, NDArray[np.float64]]: ...

    @property
    def error_estimate(self) -> float | None: ...


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number taken from a run: by `rule`, as "max arm_angle" or "duration", or by a function of the caller's.

    unit is SI, empty where it is not known; what is less than `scale` times the accuracy is no change.
    """

    name: str
    rule: str = ""
    function: Callable[[Any], float] | None = None
    unit: str = ""
    scale: float = 0.0

    def of(self, run: Told) -> float:
        """Its value in SI. Raises MechanismError where the run has no such reading or the value is no finite number."""
        value = float(self.function(run)) if self.function else _ruled(self.rule, run)
        if not math.isfinite(value):
            raise MechanismError(f"quantity {self.name!r} is no finite number: {value}")
        return value

    @property
    def everyday(self) -> tuple[float, str]:
        """How many of which unit make the SI unit, for people."""
        return everyday(self.unit, rate=RATE in self.rule)

    @property
    def identity(self) -> str:
        """What tells it from another: its rule, or the function's name and a digest of what it is."""
        if self.function is None:
            return self.rule
        try:
            source = inspect.getsource(self.function)
        except (OSError, TypeError):  # typed in by hand, or no plain function
            source = ""
        digest = hashlib.sha256(pickle.dumps(self.function) + source.encode()).hexdigest()
        return f"{getattr(self.function, '__qualname__', type(self.function).__qualname__)} {digest[:16]}"


def everyday(unit: str, *, rate: bool) -> tuple[float, str]:
    """How many of an everyday unit make an SI unit, and its name; of rates of readings, not of speeds of shafts."""
    return (EVERYDAY_RATES if rate else EVERYDAY).get(unit, EVERYDAY.get(unit, (1.0, unit)))


Wanted = Mapping[str, "str | Callable[[Trajectory], float]"] | Sequence[str] | None
"""Names of quantities, or a mapping of names of one's own to those or to functions."""


def quantities_of(scene: Scene, wanted: Wanted, *, certify: bool) -> tuple[Quantity, ...]:
    """The quantities asked for; None means final, least and greatest value of the leading coordinate.

    Raises MechanismError with a sentence for each that is not known, stands twice, or cannot be sent to a process.
    """
    readings = readings_of(scene)
    if wanted is None:
        leading = [name for name in (scene.part.mechanism.coordinate, *readings) if name in readings]
        wanted = [f"{taken} {leading[0]}" for taken in ("final", "min", "max")] if leading else [DURATION]
    if isinstance(wanted, str) or not isinstance(wanted, Mapping | Sequence) or not wanted:
        raise MechanismError(
            f"quantities are a list of names, as in ['max arm_angle'], or names with functions; found {shown(wanted)}"
        )
    named = list(wanted.items()) if isinstance(wanted, Mapping) else [(name, name) for name in wanted]
    found, problems = list[Quantity](), list[str]()
    for name, rule in named:
        try:
            found.append(_quantity(name, rule, scene, readings, certify=certify))
        except MechanismError as error:
            problems += error.problems
    names = [one.name for one in found]
    problems += [
        f"quantity {name!r} stands twice; list it once" for name in dict.fromkeys(names) if names.count(name) > 1
    ]
    if problems:
        raise MechanismError(*problems)
    return tuple(found)


def reading_named(quantity: Quantity, scene: Scene) -> str | None:
    """The mechanism's reading that a quantity is taken from, empty for the time reached; None for any other."""
    if quantity.function is None and quantity.rule == DURATION:
        return ""
    parts = _NAME.fullmatch(quantity.rule) if quantity.function is None else None
    names = [reading.name for reading in scene.part.mechanism.readings]
    return parts[3] if parts and parts[3] in names else None


def readings_of(scene: Scene) -> dict[str, str]:
    """Names of the readings that a run of a scene has, with their SI units."""
    units = {reading.name: UNITS[reading.quantity] for reading in scene.part.mechanism.readings}
    if scene.part.plane == TURNING:
        units["spindle_speed"] = "rad/s"
        if isinstance(scene.spindle, FreeSpindle):
            units["spindle_angle"] = "rad"
        elif scene.centrifugal:
            units["spindle_torque"] = "N m"
    return units


def _quantity(name: Any, rule: Any, scene: Scene, readings: Mapping[str, str], *, certify: bool) -> Quantity:
    if not isinstance(name, str) or not name.strip():
        raise MechanismError(f"a quantity has a name; found {shown(name)}; write 'max arm_angle'")
    if callable(rule):
        return _from_function(name, rule)
    if rule == ESTIMATE and not certify:
        raise MechanismError(f"quantity {ESTIMATE!r} needs runs that are certified; ask for certify, or leave it out")
    if rule in (DURATION, ESTIMATE):
        return Quantity(name=name, rule=rule, unit="s" if rule == DURATION else "")
    parts = _NAME.fullmatch(rule) if isinstance(rule, str) else None
    rated = {reading.name for reading in scene.part.mechanism.readings}
    if parts is None or parts[3] not in readings or (parts[2] and parts[3] not in rated):
        raise MechanismError(_unknown(rule, readings, rated))
    unit = readings[parts[3]]
    scale = {"rad": 1.0, "m": scene.part.mechanism.size}.get(unit, 0.0)
    return Quantity(name=name, rule=rule, unit=f"{unit}/s" if parts[2] else unit, scale=scale)


def _unknown(rule: Any, readings: Mapping[str, str], rated: Iterable[str]) -> str:
    words = str(rule)
    taken = [*TAKEN, ""]
    known = [f"{one} {name}".strip() for one in taken for name in readings]
    known += [f"{one} {RATE}{name}".strip() for one in taken for name in readings if name in rated]
    return (
        f"quantity {shown(rule)} is unknown; known are final, min, max or span (or none of these: the final value) of "
        f"{', '.join(readings)}, or of 'rate of ...' those that are positions, and {DURATION} and {ESTIMATE}."
        f"{did_you_mean(words, [*known, DURATION, ESTIMATE])}"
    )


def _from_function(name: str, function: Callable[[Trajectory], float]) -> Quantity:
    try:
        pickle.dumps(function)
    except Exception as error:  # pickle raises many unrelated types
        raise MechanismError(
            f"quantity {name!r}: {function!r} cannot be sent to another process; "
            "write a function with def at the top of a module"
        ) from error
    return Quantity(name=name, function=function)


def _ruled(rule: str, run: Told) -> float:
    if rule == DURATION:
        return float(run.times[-1])
    if rule == ESTIMATE:
        return math.nan if run.error_estimate is None else run.error_estimate
    parts = _NAME.fullmatch(rule)
    source = run.rates if parts and parts[2] else run.readings
    if parts is None or parts[3] not in source:
        raise MechanismError(f"this scene has no {rule!r}; its readings are {', '.join(run.readings)}")
    return TAKEN[parts[1] or "final"](source[parts[3]])
