"""Numbers taken from each run of a sweep: by rules about a reading, or by functions of the run."""

import hashlib
import inspect
import math
import pickle
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.observables.valve_motion import ValveMotion, has_valve_events, reverse_crank, valve_of
from governor_mechanism.scenes.changed_document import document_of, parse_scene_with
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.equilibrium_speed import WorkingRange
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.sweep.rows import ROW_NO_VALUE
from governor_mechanism.studies.sweep.rules import (
    DURATION_RULE,
    ENGINE_RULES,
    ERROR_ESTIMATE_RULE,
    STATISTICS,
    VALVE_RULES,
    MissingNumberError,
    RunNumbers,
    Taken,
    evaluate_engine_rule,
    evaluate_valve_rule,
)
from governor_mechanism.types import FloatArray
from governor_mechanism.units.expressions import read_any_quantity
from governor_mechanism.units.problems import ProblemCode, ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, display_unit, format_value
from governor_mechanism.verification.laws import relative_law_differences

N_GEARS = 7
"""Number of gears, from full forward to full back gear, in which leads are compared."""


@once_per_object
def leads_in_gears(scene: Scene) -> FloatArray:
    """Return the leads (gears, 2) of crank end and head end, m, from full forward to full back gear, where the crank turns back."""
    document, reverser = document_of(scene, "leads"), valve_of(scene).reverser
    if reverser is None:
        raise MechanismError(f"{scene.title}: the valve names nothing that reverses it")
    (forward, kind), (back, _) = (read_any_quantity(one, reverser.key) for one in (reverser.forward, reverser.back))
    unit, leads = QUANTITY_KINDS[kind].si_unit, []
    for place in np.linspace(0.0, 1.0, N_GEARS).tolist():
        value = forward + place * (back - forward)
        gear = parse_scene_with(document, [(reverser.key, f"{value!r} {unit}" if unit else value)])
        leads.append(ValveMotion(reverse_crank(gear) if place > 0.5 else gear).leads)
    return np.array(leads)


def _lead_differences(scene: Scene) -> FloatArray:
    leads = leads_in_gears(scene)
    differences: FloatArray = np.abs(leads[:, 0] - leads[:, 1])
    return differences


def _lead_change(scene: Scene) -> FloatArray:
    return np.array([np.ptp(leads_in_gears(scene).mean(axis=1))])


@once_per_object
def _working_range(scene: Scene) -> WorkingRange:
    """Return the working range of the governor of a scene, between its stops, or else the ends of its travel."""
    found = compute_controlling_force(rotating_part_alone(scene)).working_range
    if found is None:
        text = "the governor has no working range: at an end of its travel it has no equilibrium speed; give it stops"
        raise MissingNumberError(ROW_NO_VALUE, text)
    return found


def _insensitivity(scene: Scene) -> FloatArray:
    """Return the insensitivity, by the dry friction of the scene: the larger of those at both ends of the working range."""
    alone = rotating_part_alone(scene)
    frictions = [one for one in alone.output_effects if isinstance(one, DryFriction)]
    if not frictions:
        text = "the governor has no dry friction, which makes it insensitive; write effects.dry_friction"
        raise MissingNumberError(ROW_NO_VALUE, text)
    friction = frictions[0]
    band = compute_insensitivity_band(alone, _working_range(scene).coordinate, max(friction.force.values), friction.reading)
    return np.array([band.insensitivity.max()])


def _is_gear(scene: Scene) -> bool:
    return has_valve_events(scene) and valve_of(scene).reverser is not None


def _has_governor(scene: Scene) -> bool:
    return any(part.turns for part in scene.parts)


def _has_law(scene: Scene) -> bool:
    return len(scene.parts) == 1 and scene.part.law is not None


@dataclass(frozen=True, kw_only=True)
class SceneRule:
    """A rule about a scene."""

    take: Callable[[Scene], FloatArray]  # function that computes values, SI, of which the largest counts
    applies: Callable[[Scene], bool]  # whether a scene can have the number
    unit: str  # SI unit


SCENE_RULES: Mapping[str, SceneRule] = {
    "lead difference": SceneRule(take=_lead_differences, applies=_is_gear, unit="m"),
    "lead change": SceneRule(take=_lead_change, applies=_is_gear, unit="m"),
    "lowest equilibrium speed": SceneRule(
        take=lambda scene: _working_range(scene).speed.min(keepdims=True), applies=_has_governor, unit="rad/s"
    ),
    "highest equilibrium speed": SceneRule(
        take=lambda scene: _working_range(scene).speed.max(keepdims=True), applies=_has_governor, unit="rad/s"
    ),
    "sensitiveness": SceneRule(take=lambda scene: np.array([_working_range(scene).sensitiveness]), applies=_has_governor, unit=""),
    "work capacity": SceneRule(take=lambda scene: np.array([_working_range(scene).work_capacity]), applies=_has_governor, unit="N m"),
    "insensitivity": SceneRule(take=_insensitivity, applies=_has_governor, unit=""),
    "law difference": SceneRule(take=relative_law_differences, applies=_has_law, unit=""),
}
"""Rules about a scene: leads in seven gears, the working range of a governor, and the equations of a law."""


RATE_PREFIX = "rate of "
"""Prefix of a rule that takes the rate of a reading."""

DISPLAY_RATE_UNITS = {"rad/s": (180 / math.pi, "deg/s"), "m/s": (1e3, "mm/s")}
"""Display units of rates of readings; shaft speeds have their own in DISPLAY_UNITS."""

_RULE_PATTERN = re.compile(rf"(?:({'|'.join(sorted(STATISTICS, key=len, reverse=True))})(?: of)? )?({RATE_PREFIX})?(.+)")

MIN_SWING_RATIO = 10.0
"""Change between two turning points below which they count as noise, relative to the accuracy of the runs times the scale of a reading."""


@dataclass(frozen=True, kw_only=True)
class RunQuantity(Recorded):
    """A number taken from a run by a rule or by a function of the caller."""

    name: str  # name of the column
    rule: str = ""  # rule such as "max arm_angle" or "duration"; empty for a function
    function: Callable[[Any], float] | None = None  # function of the run; None for a rule
    unit: str = ""  # SI unit; empty if it is not known
    scale: float = 0.0  # coordinate scale, SI; a change below scale times accuracy counts as none
    min_swing: float = 0.0  # change between two turning points below which they count as noise, SI

    record = ("name", "unit")

    def evaluate(self, numbers: RunNumbers) -> float:
        """Return the value in SI; MissingNumberError without such a number, MechanismError without the reading or a finite value."""
        value = float(self.function(numbers.run)) if self.function else self._evaluate_rule(numbers)
        if not math.isfinite(value):
            raise MechanismError(f"quantity {self.name!r} is not a finite number: {value}")
        return value

    def _evaluate_rule(self, numbers: RunNumbers) -> float:
        run, rule = numbers.run, self.rule
        if rule == DURATION_RULE:
            return float(run.times[-1])
        if rule in VALVE_RULES:
            return evaluate_valve_rule(rule, run.scene)
        if rule in SCENE_RULES:
            return float(SCENE_RULES[rule].take(run.scene).max())
        if rule in ENGINE_RULES:
            return evaluate_engine_rule(rule, run)
        if rule == ERROR_ESTIMATE_RULE:
            return math.nan if run.error_estimate is None else run.error_estimate
        statistic, is_rate, reading = split_rule(rule)
        return STATISTICS[statistic].take(Taken(numbers, reading, is_rate, 0.0 if is_rate else self.scale, self.min_swing))

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
    return DISPLAY_RATE_UNITS.get(unit, display_unit(unit)) if is_rate else display_unit(unit)


QuantityRequest = Mapping[str, "str | Callable[[Trajectory], float]"] | Sequence[str] | None
"""Names of quantities, or a mapping of the user's names to rules or functions."""


def parse_quantities(
    scene: Scene, requested: Mapping[str, Any] | Sequence[str], accuracy: float | None, *, certify: bool
) -> tuple[RunQuantity, ...]:
    """Return the requested quantities."""
    if isinstance(requested, str) or not isinstance(requested, Mapping | Sequence) or not requested:
        raise MechanismError(
            f"quantities must be a list of names, as ['max arm_angle'], or map names to functions; found {format_value(requested)}"
        )
    parser = _QuantityParser(scene, accuracy, certify=certify)
    named_rules = list(requested.items()) if isinstance(requested, Mapping) else [(name, name) for name in requested]
    collector, quantities = ProblemCollector(), list[RunQuantity]()
    for name, rule in named_rules:
        with collector.at(""):
            quantities.append(parser.parse(name, rule))
    repeated = (name for name, count in Counter(one.name for one in quantities).items() if count > 1)
    collector.add(ProblemCode.DUPLICATE, *(f"quantity {name!r} is listed twice; list it once" for name in repeated))
    collector.raise_if_failed()
    return tuple(quantities)


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


class _QuantityParser:
    """Parser of the quantities of a scene, whose runs have an accuracy; None is that of the scene."""

    def __init__(self, scene: Scene, accuracy: float | None, *, certify: bool) -> None:
        self._scene, self._certify = scene, certify
        self._accuracy = accuracy if isinstance(accuracy, float) else scene.run.accuracy
        self._reading_units = find_reading_units(scene)
        self._positions = {one.name for one in scene.mechanism.readings}

    def parse(self, name: Any, rule: Any) -> RunQuantity:
        """Return the quantity of a name and a rule, or raise MechanismError."""
        if not isinstance(name, str) or not name.strip():
            raise MechanismError(f"a quantity needs a name; found {format_value(name)}; write 'max arm_angle'")
        if callable(rule):
            return _make_function_quantity(name, rule)
        if not isinstance(rule, str):
            raise MechanismError(f"quantity {name!r} must be text or a function of a run; found {format_value(rule)}")
        if rule == ERROR_ESTIMATE_RULE and not self._certify:
            raise MechanismError(f"quantity {ERROR_ESTIMATE_RULE!r} needs certified runs; set certify, or leave it out")
        if rule in (DURATION_RULE, ERROR_ESTIMATE_RULE):
            return RunQuantity(name=name, rule=rule, unit="s" if rule == DURATION_RULE else "")
        if rule in VALVE_RULES and has_valve_events(self._scene):
            return RunQuantity(name=name, rule=rule, unit=VALVE_RULES[rule], scale=self._scene.mechanism.length_scale)
        if rule in SCENE_RULES and SCENE_RULES[rule].applies(self._scene):
            return RunQuantity(name=name, rule=rule, unit=SCENE_RULES[rule].unit)
        if rule in ENGINE_RULES and self._scene.mechanism.stall_limits:
            return RunQuantity(name=name, rule=rule, unit=ENGINE_RULES[rule])
        return self._parse_statistic(name, rule)

    def _parse_statistic(self, name: str, rule: str) -> RunQuantity:
        statistic_name, is_rate, reading = split_rule(rule)
        if reading not in (self._positions if is_rate else self._reading_units):
            raise MechanismError(self._unknown_rule_message(rule))
        statistic = STATISTICS[statistic_name]
        reading_unit = self._reading_units[reading]
        is_position = reading in self._positions and not is_rate
        if (statistic.needs and not is_position) or (statistic.needs == "angle" and reading_unit != "rad"):
            names = [one for one in self._positions if statistic.needs == "position" or self._reading_units[one] == "rad"]
            raise MechanismError(
                f"quantity {rule!r}: {statistic_name} is that of {'an' if statistic.needs == 'angle' else 'a'} {statistic.needs}, "
                f"and this scene has the {statistic.needs}s {', '.join(sorted(names)) or 'none'}"
            )
        scale = self._scene.mechanism.output_scale(reading) if reading in self._positions else 0.0
        unit = statistic.unit if statistic.unit is not None else f"{reading_unit}{'/s' if is_rate else ''}"
        own_scale = scale if statistic.unit is None else 0.0  # a frequency is compared with itself, not with the scale of its reading
        return RunQuantity(name=name, rule=rule, unit=unit, scale=own_scale, min_swing=MIN_SWING_RATIO * self._accuracy * scale)

    def _unknown_rule_message(self, rule: str) -> str:
        rates = [f"{RATE_PREFIX}{name}" for name in self._reading_units if name in self._positions]
        known_rules = [f"{one} {name}".strip() for names in (self._reading_units, rates) for one in (*STATISTICS, "") for name in names]
        own_rules = [*(VALVE_RULES if has_valve_events(self._scene) else ()), *(ENGINE_RULES if self._scene.mechanism.stall_limits else ())]
        own_rules += [name for name, one in SCENE_RULES.items() if one.applies(self._scene)]
        own_rules += [DURATION_RULE, ERROR_ESTIMATE_RULE]
        return (
            f"quantity {format_value(rule)} is unknown; known are {', '.join(STATISTICS)} of a reading (final if none is given): "
            f"{', '.join(self._reading_units)}, or of 'rate of' a position; also {', '.join(own_rules)}."
            f"{did_you_mean(rule, [*known_rules, *own_rules])}"
        )


def split_rule(rule: str) -> tuple[str, bool, str]:
    """Return the statistic, whether it is one of the rate, and the reading of a rule; an empty reading for anything else."""
    parts = _RULE_PATTERN.fullmatch(rule)
    return (parts[1] or "final", bool(parts[2]), parts[3]) if parts else ("", False, "")


def _make_function_quantity(name: str, function: Callable[[Trajectory], float]) -> RunQuantity:
    try:
        pickle.dumps(function)
    except Exception as error:  # pickle raises many types of error
        raise MechanismError(
            f"quantity {name!r}: the function cannot be sent to another process; define the function with def at module level"
        ) from error
    return RunQuantity(name=name, function=function)
