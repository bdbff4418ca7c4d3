"""Numbers taken from each run of a sweep: final, least or greatest value of a reading, or a function of the run."""

import hashlib
import inspect
import math
import pickle
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from governor_mechanism.engines.reduced.batch import UncertifiedResult
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.observables.gas_torque import mean_gas_torque
from governor_mechanism.observables.valve_motion import has_valve_events, valve_motion_of
from governor_mechanism.observables.valve_timing import CYLINDER_ENDS, find_event_angles
from governor_mechanism.scenes.problems import ProblemCode, ProblemCollector
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import DISPLAY_UNITS, format_value

STATISTICS: Mapping[str, Callable[[FloatArray], float]] = {"final": itemgetter(-1), "min": np.min, "max": np.max, "span": np.ptp}
"""Statistics of a reading over its reported times."""

DURATION_RULE, ERROR_ESTIMATE_RULE = "duration", "error_estimate"
"""Rules that need no reading: the last reported time, s, and the relative error estimate."""

VALVE_RULES: Mapping[str, str] = {
    "valve travel": "m",
    **{f"{end} lead": "m" for end in CYLINDER_ENDS},
    **{f"{end} cut-off": "" for end in CYLINDER_ENDS},
}
"""Rules about the valve of a scene in its gear at the start, with their units: lengths, and strokes at cut-off as fractions."""

ENGINE_RULES: Mapping[str, str] = {"mean gas torque": "N m", "speed fluctuation": ""}
"""Rules about an engine that gas drives, with their units: its mean torque over a stroke, and the coefficient in the last turn of a run."""

SLIP_READING = "die_slip"
"""Reading whose range over a run is the slip of a die block."""

RATE_PREFIX = "rate of "
"""Prefix of a rule that takes the rate of a reading."""

DISPLAY_RATE_UNITS = {"rad/s": (180 / math.pi, "deg/s"), "m/s": (1e3, "mm/s")}
"""Display units of rates of readings; shaft speeds have their own in DISPLAY_UNITS."""

_RULE_PATTERN = re.compile(rf"(?:({'|'.join(STATISTICS)}) )?({RATE_PREFIX})?(.+)")


RunOutput = Trajectory | UncertifiedResult
"""What a number is taken from."""


@dataclass(frozen=True, kw_only=True)
class RunQuantity:
    """A number taken from a run by a rule or by a function of the caller.

    Attributes
    ----------
    name
        Name of the column.
    rule
        Rule such as "max arm_angle" or "duration"; empty for a function.
    function
        Function of the run; None for a rule.
    unit
        SI unit; empty if it is not known.
    scale
        Coordinate scale, SI; a change below scale times accuracy counts as none.
    """

    name: str
    rule: str = ""
    function: Callable[[Any], float] | None = None
    unit: str = ""
    scale: float = 0.0

    def evaluate(self, run: RunOutput) -> float:
        """Return the value in SI; raise MechanismError if the run has no such reading or the value is not finite."""
        value = float(self.function(run)) if self.function else _evaluate_rule(self.rule, run)
        if not math.isfinite(value):
            raise MechanismError(f"quantity {self.name!r} is not a finite number: {value}")
        return value

    @property
    def display_unit(self) -> tuple[float, str]:
        """Factor from SI to the unit shown to users, and that unit."""
        return find_display_unit(self.unit, is_rate=RATE_PREFIX in self.rule)

    @property
    def identity(self) -> str:
        """Text that identifies the quantity: its rule, or the name of its function and a digest of its code."""
        if self.function is None:
            return self.rule
        try:
            source = inspect.getsource(self.function)
        except (OSError, TypeError):  # defined interactively, or not a plain function
            source = ""
        digest = hashlib.sha256(pickle.dumps(self.function) + source.encode()).hexdigest()
        return f"{getattr(self.function, '__qualname__', type(self.function).__qualname__)} {digest[:16]}"


def find_display_unit(unit: str, *, is_rate: bool) -> tuple[float, str]:
    """Return the factor from an SI unit to the unit shown to users, and that unit."""
    return (DISPLAY_RATE_UNITS if is_rate else DISPLAY_UNITS).get(unit, DISPLAY_UNITS.get(unit, (1.0, unit)))


QuantityRequest = Mapping[str, "str | Callable[[Trajectory], float]"] | Sequence[str] | None
"""Names of quantities, or a mapping of the user's names to rules or functions."""


def parse_quantities(scene: Scene, requested: QuantityRequest, *, certify: bool) -> tuple[RunQuantity, ...]:
    """Return the requested quantities; None requests final, least and greatest value of the leading coordinate.

    Of a scene with a valve and a driven crank it requests travel, leads and cut-offs of the valve, and the slip of a die block; of an
    engine that gas drives its mean torque and the speed fluctuation.

    Raises MechanismError with a message for each quantity that is unknown, occurs twice, or cannot be sent to a process.
    """
    reading_units = find_reading_units(scene)
    has_valve = has_valve_events(scene)
    if requested is None and has_valve:
        requested = [*VALVE_RULES, *([f"span {SLIP_READING}"] if SLIP_READING in reading_units else [])]
    elif requested is None and scene.mechanism.stall_limits:
        requested = [*ENGINE_RULES]
    elif requested is None:
        leading = [name for name in (*_leading_coordinates(scene), *reading_units) if name in reading_units]
        requested = [f"{taken} {leading[0]}" for taken in ("final", "min", "max")] if leading else [DURATION_RULE]
    if isinstance(requested, str) or not isinstance(requested, Mapping | Sequence) or not requested:
        raise MechanismError(
            f"quantities must be a list of names, as ['max arm_angle'], or map names to functions; found {format_value(requested)}"
        )
    named_rules = list(requested.items()) if isinstance(requested, Mapping) else [(name, name) for name in requested]
    collector, quantities = ProblemCollector(), list[RunQuantity]()
    for name, rule in named_rules:
        with collector.at(""):
            if isinstance(rule, str) and rule in VALVE_RULES and has_valve:
                quantities.append(RunQuantity(name=name, rule=rule, unit=VALVE_RULES[rule], scale=scene.mechanism.length_scale))
            elif isinstance(rule, str) and rule in ENGINE_RULES and scene.mechanism.stall_limits:
                quantities.append(RunQuantity(name=name, rule=rule, unit=ENGINE_RULES[rule]))
            else:
                quantities.append(_parse_quantity(name, rule, scene, reading_units, certify=certify))
    repeated = (name for name, count in Counter(one.name for one in quantities).items() if count > 1)
    collector.add(ProblemCode.DUPLICATE, *(f"quantity {name!r} is listed twice; list it once" for name in repeated))
    collector.raise_if_failed()
    return tuple(quantities)


def find_quantity_reading(quantity: RunQuantity, scene: Scene) -> str | None:
    """Return the mechanism's reading of a quantity, "" for the duration, or None for any other quantity."""
    reading = "" if quantity.rule == DURATION_RULE else _split_rule(quantity.rule)[2]
    return reading if quantity.rule == DURATION_RULE or any(one.name == reading for one in scene.part.mechanism.readings) else None


def find_reading_units(scene: Scene) -> dict[str, str]:
    """Return the names of the readings of a run with their SI units."""
    units = {reading.name: READING_UNITS[reading.quantity] for reading in scene.mechanism.readings}
    units |= {output.name: output.unit for output in scene.mechanism.derived_readings}
    for plane in scene.system.planes:
        units[f"{plane.prefix}{SPINDLE_SPEED}"] = "rad/s"
        if not plane.given_speed:
            units[f"{plane.prefix}{SPINDLE_ANGLE}"] = "rad"
        elif plane.is_loaded:
            units[f"{plane.prefix}{SPINDLE_TORQUE}"] = "N m"
    return units


def _leading_coordinates(scene: Scene) -> list[str]:
    """Return the leading coordinates of the parts; those of governors, which turn with a spindle, come first."""
    if len(scene.parts) == 1:
        return [scene.part.mechanism.coordinate]
    return [f"{part.name}.{part.mechanism.coordinate}" for part in sorted(scene.parts, key=lambda part: not part.turns)]


def _parse_quantity(name: Any, rule: Any, scene: Scene, reading_units: Mapping[str, str], *, certify: bool) -> RunQuantity:
    if not isinstance(name, str) or not name.strip():
        raise MechanismError(f"a quantity needs a name; found {format_value(name)}; write 'max arm_angle'")
    if callable(rule):
        return _make_function_quantity(name, rule)
    if not isinstance(rule, str):
        raise MechanismError(f"quantity {name!r} must be text or a function of a run; found {format_value(rule)}")
    if rule == ERROR_ESTIMATE_RULE and not certify:
        raise MechanismError(f"quantity {ERROR_ESTIMATE_RULE!r} needs certified runs; set certify, or leave it out")
    if rule in (DURATION_RULE, ERROR_ESTIMATE_RULE):
        return RunQuantity(name=name, rule=rule, unit="s" if rule == DURATION_RULE else "")
    _, is_rate, reading = _split_rule(rule)
    readings_with_rate = {one.name for one in scene.mechanism.readings}
    if reading not in (readings_with_rate if is_rate else reading_units):
        raise MechanismError(_unknown_rule_message(rule, reading_units, readings_with_rate))
    scale = scene.mechanism.output_scale(reading) if reading in readings_with_rate else 0.0
    return RunQuantity(name=name, rule=rule, unit=f"{reading_units[reading]}{'/s' if is_rate else ''}", scale=scale)


def _split_rule(rule: str) -> tuple[str, bool, str]:
    """Return the statistic, whether it is one of the rate, and the reading of a rule; an empty reading for anything else."""
    parts = _RULE_PATTERN.fullmatch(rule)
    return (parts[1] or "final", bool(parts[2]), parts[3]) if parts else ("", False, "")


def _unknown_rule_message(rule: str, reading_units: Mapping[str, str], readings_with_rate: Iterable[str]) -> str:
    rates = [f"{RATE_PREFIX}{name}" for name in reading_units if name in readings_with_rate]
    known_rules = [f"{one} {name}".strip() for names in (reading_units, rates) for one in (*STATISTICS, "") for name in names]
    return (
        f"quantity {format_value(rule)} is unknown; known are final, min, max or span of a reading (final if none is given): "
        f"{', '.join(reading_units)}, or of 'rate of' a position; also {DURATION_RULE} and {ERROR_ESTIMATE_RULE}."
        f"{did_you_mean(rule, [*known_rules, DURATION_RULE, ERROR_ESTIMATE_RULE])}"
    )


def _make_function_quantity(name: str, function: Callable[[Trajectory], float]) -> RunQuantity:
    try:
        pickle.dumps(function)
    except Exception as error:  # pickle raises many types of error
        raise MechanismError(
            f"quantity {name!r}: the function cannot be sent to another process; define the function with def at module level"
        ) from error
    return RunQuantity(name=name, function=function)


def _evaluate_valve_rule(rule: str, scene: Scene) -> float:
    """Return the value of a rule about the valve of a scene, SI."""
    if rule == "valve travel":
        return valve_motion_of(scene).travel
    end, _, kind = rule.rpartition(" ")
    if kind == "lead":
        return valve_motion_of(scene).leads[CYLINDER_ENDS.index(end)]
    angle = find_event_angles(scene).get(rule)
    if angle is None:
        raise MechanismError(
            f"there is no {rule}: the steam port of the {end} does not open once in a turn; sweep another range, or reduce the lap"
        )
    stroke = float(valve_motion_of(scene).stroke_fractions(np.array([angle]))[0])
    return stroke if end == CYLINDER_ENDS[0] else 1.0 - stroke


def _speed_fluctuation(run: Trajectory) -> float:
    """Return the largest coefficient of speed fluctuation of the shafts in the last turn of a run."""
    if not run.speed_fluctuations:
        raise MechanismError("there is no speed fluctuation: the shaft makes no complete turn; make the run longer")
    return max(extremes.coefficient for extremes in run.speed_fluctuations.values())


def _evaluate_rule(rule: str, run: RunOutput) -> float:
    if rule == DURATION_RULE:
        return float(run.times[-1])
    if rule in VALVE_RULES and isinstance(run, Trajectory):  # a driven scene is not run in a batch
        return _evaluate_valve_rule(rule, run.scene)
    if rule in ENGINE_RULES and isinstance(run, Trajectory):
        return mean_gas_torque(run.scene) if rule == "mean gas torque" else _speed_fluctuation(run)
    if rule == ERROR_ESTIMATE_RULE:
        return math.nan if run.error_estimate is None else run.error_estimate
    statistic, is_rate, reading = _split_rule(rule)
    source = run.rates if is_rate else run.readings
    if reading not in source:
        raise MechanismError(f"this scene has no {rule!r}; its readings are {', '.join(run.readings)}")
    return float(STATISTICS[statistic](source[reading]))
