"""[effects] of a scene file. Slow to import: pydantic.

Effects along readings are tables keyed by reading, in the units of the quantity of the reading. The validation context
is the `ReadingQuantities` of the mechanism.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Final, TypeVar

from pydantic import Field, PlainValidator, ValidationInfo

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.dashpot import Dashpot, orifice_damping_coefficient
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring, helical_spring_rate
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.quantities import (
    Bool,
    Length,
    Mass,
    PositiveLength,
    Restitution,
    built,
    check_bool,
    parse_si,
    parse_time_points,
)
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value

ReadingQuantities = Mapping[str, str] | None
"""Quantities of the readings, "length" or "angle", by name; None if they are not known."""

SLEEVE_ALIAS, SLEEVE_LIFT_NAME = "sleeve", "sleeve_lift"
"""Short name of a reading of governors, and its name."""

NO_STOP: Final = "none"
"""Word for a stop that does not exist."""

_Parsed = TypeVar("_Parsed")

NO_CLEARANCE_HINT: Final = "; write clearance = false if there is none"

WIRE_KEYS: Final = ("wire", "coil", "turns", "modulus")
"""Keys of a helical spring; all are needed."""

ORIFICE_KEYS: Final = ("piston", "hole")
"""Keys of an orifice that are needed."""

OUTPUT_EFFECT_EXAMPLES: Final = {
    "spring": {"length": '{ rate = "2 N/mm" }', "angle": '{ rate = "3 N m/rad" }'},
    "dry_friction": {"length": '"40 N"', "angle": '"5 N m"'},
    "dashpot": {"length": '"120 N s/m"', "angle": '"0.1 N m s/rad"'},
    "stops": {"length": '["10 mm", "60 mm"]', "angle": '["15 deg", "45 deg"]'},
}
"""Valid values for a reading, by effect and quantity of the reading."""


def _derived_key_problems(
    values: Mapping[str, Any], derived: str, needed: tuple[str, ...], optional: tuple[str, ...] = (), reason_against: str = ""
) -> list[Problem]:
    """Return the problems of keys from which a value follows: given with the value, not allowed, or incomplete."""
    given = [key for key in (*needed, *optional) if key in values]
    missing = [key for key in needed if key not in values]
    if given and derived in values:
        text = f"{KEY}: {derived} cannot be combined with {', '.join(given)}, from which it follows; leave one of the two out"
    elif given and reason_against:
        text = f"{KEY} is an angle and cannot have {', '.join(given)}; {reason_against}"
    elif given and missing:
        text = f"{KEY} lacks {', '.join(missing)}; {', '.join(needed)} are all needed"
    else:
        return []
    return [Problem(text, ProblemCode.CONFLICT)]


class SpringTable(SceneFileTable):
    """A spring along a length."""

    example = OUTPUT_EFFECT_EXAMPLES["spring"]["length"]
    missing_hint: ClassVar[str] = f'write rate = "2 N/mm", or {", ".join(WIRE_KEYS)}'
    wire_hint: ClassVar[str] = ""

    rate: Annotated[float, built("stiffness")] = 0.0
    wire: PositiveLength = 0.0
    coil: PositiveLength = 0.0
    turns: Annotated[float, built("number")] = 0.0
    modulus: Annotated[float, PlainValidator(lambda value: _parse_modulus(value))] = 0.0
    preload: Annotated[float, built("force", "any")] = 0.0
    zero: Annotated[float, built("length", "any")] = 0.0
    one_sided: Bool = False

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[Problem]:
        """Yield a missing rate, or a rate given twice."""
        yield from _derived_key_problems(values, "rate", WIRE_KEYS, reason_against=cls.wire_hint)
        if not any(key in values for key in ("rate", *WIRE_KEYS)):
            yield Problem(f"{KEY}: rate is missing; {cls.missing_hint}", ProblemCode.MISSING_KEY)

    def build(self, reading: str) -> Effect:
        """Return the spring, its rate given or computed from its wire."""
        values = self.given_values()
        wire_values = {key: values.pop(key) for key in WIRE_KEYS if key in values}
        if wire_values:
            values["rate"] = helical_spring_rate(**wire_values)
        return OutputSpring(reading=reading, **values)


class TorsionSpringTable(SpringTable):
    """A spring along an angle."""

    example = OUTPUT_EFFECT_EXAMPLES["spring"]["angle"]
    missing_hint = wire_hint = 'write rate = "3 N m/rad"'

    rate: Annotated[float, built("torsion_stiffness")] = 0.0
    preload: Annotated[float, built("torque", "any")] = 0.0
    zero: Annotated[float, built("angle", "any")] = 0.0


def _parse_modulus(value: object) -> float:
    modulus = parse_si(value, "modulus")
    if not 1.0 <= modulus <= 1e13:
        text = f"{KEY} must lie between 1 Pa and 1e+13 Pa; found {format_value(value)}; steel has 80 GPa"
        raise mistake(ProblemCode.OUT_OF_RANGE, text)
    return modulus


class DashpotTable(SceneFileTable):
    """A dashpot along a length."""

    piston_hint: ClassVar[str] = ""

    linear: Annotated[float, built("damping", "not negative")] = 0.0
    quadratic: Annotated[float, built("quadratic_damping", "not negative")] = 0.0
    piston: Annotated[float, built("area")] = 0.0
    hole: Annotated[float, built("area")] = 0.0
    screw: Annotated[float, built("ratio")] = 1.0
    oil: Annotated[float, built("density")] = 900.0

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterable[Problem]:
        """Return the problem of a quadratic part given twice or incompletely."""
        return _derived_key_problems(values, "quadratic", ORIFICE_KEYS, ("screw", "oil"), reason_against=cls.piston_hint)

    def build(self, reading: str) -> Effect:
        """Return the dashpot, its quadratic part given or computed from its orifice."""
        values = self.given_values()
        coefficients = {key: values[key] for key in ("linear", "quadratic") if key in values}
        if "piston" in values:
            names = {"piston": "piston", "hole": "hole", "screw": "screw", "oil": "density"}
            coefficients["quadratic"] = orifice_damping_coefficient(**{names[key]: values[key] for key in names if key in values})
        return Dashpot(reading=reading, **coefficients)


class TorsionDashpotTable(DashpotTable):
    """A dashpot along an angle."""

    piston_hint = 'write quadratic = "0.3 N m s^2/rad^2"'

    linear: Annotated[float, built("torsion_damping", "not negative")] = 0.0
    quadratic: Annotated[float, built("quadratic_torsion_damping", "not negative")] = 0.0


class RodsTable(SceneFileTable):
    """Arguments of RodMasses."""

    example = '{ arm_mass = "0.6 kg", link_mass = "0.5 kg" }'
    arm_mass: Mass = 0.0
    link_mass: Mass = 0.0
    ball_radius: Length = 0.0


class MassesTable(SceneFileTable):
    """Arguments of CrankMasses."""

    example = '{ crank = "80 kg", rod = "70 kg", crosshead = "110 kg" }'
    crank: Annotated[float, built("mass")] = Field(description='the mass of the crank, as "80 kg"; rod and crosshead may have none')
    crank_centre: Annotated[float, built("length", "any")] = 0.0
    rod: Mass = 0.0
    rod_centre: Length | None = None
    rod_inertia: Annotated[float | None, built("moment_of_inertia")] = None
    crosshead: Mass = 0.0


class BellCranksTable(SceneFileTable):
    """Arguments of BellCrankMasses."""

    example = '{ mass = "6 kg", weight_width = "150 mm", weight_height = "200 mm" }'
    mass: Mass = 0.0
    weight_width: Length = 0.0
    weight_height: Length = 0.0
    weight_depth: Length = 0.0


class ClearanceTable(SceneFileTable):
    """Arguments of Clearance."""

    width: Annotated[float, built("length", hint=NO_CLEARANCE_HINT)] = Field(
        description='the distance that the sleeve may move between the links, as "0.5 mm"'
    )
    restitution: Restitution = 0.0


class RestitutionTable(SceneFileTable):
    """The key of [effects.stops] that is not a reading."""

    restitution: Restitution = 0.0


def _parse_gravity(value: object) -> tuple[Effect, ...]:
    if isinstance(value, bool):
        return (Gravity(),) if value else ()
    try:
        return (Gravity(acceleration=parse_si(value, "acceleration", sign="positive")),)
    except MechanismError as error:
        raise mistake(Problem(error.problems[0]).code, f"{error}; gravity may also be true (9.81 m/s^2) or false") from error


def _body_effect(model: type[SceneFileTable], effect: Callable[..., Effect]) -> PlainValidator:
    def check(value: object) -> tuple[Effect, ...]:
        return () if value is False else (effect(**validate(model, value).given_values()),)

    return PlainValidator(check)


def _parse_clearance(value: object) -> tuple[Effect, ...]:
    if value is False:
        return ()
    if value is True:
        raise mistake(ProblemCode.WRONG_TYPE, f'{KEY} is the distance that the sleeve may move; found true; write clearance = "0.5 mm"')
    if isinstance(value, Mapping):
        return (Clearance(**validate(ClearanceTable, value).given_values()),)
    return (Clearance(width=parse_si(value, "length", sign="positive", bounded=True, hint=NO_CLEARANCE_HINT)),)


OutputEffectFactory = Callable[[str, str, Any], Effect]
"""Function of a reading, its quantity and its value in the file that returns an effect."""


def _parse_spring(reading: str, quantity: str, value: Any) -> Effect:
    return validate(SpringTable if quantity == "length" else TorsionSpringTable, value).build(reading)


def _parse_dry_friction(reading: str, quantity: str, value: Any) -> Effect:
    kind, name = ("force", "force") if quantity == "length" else ("torque", "moment")
    times, forces = parse_time_points(value, kind, name)
    for number, force in enumerate(forces):
        if force < 0:
            is_list = isinstance(value, list | tuple)
            location, found = (f", point {number + 1}:", value[number][1]) if is_list else ("", value)
            text = f"{KEY}{location} must not be negative, because friction opposes the motion; found {format_value(found)}"
            raise mistake(ProblemCode.OUT_OF_RANGE, text)
    return DryFriction(reading=reading, force=InputFunction(times=times, values=forces))


def _parse_dashpot(reading: str, quantity: str, value: Any) -> Effect:
    if isinstance(value, Mapping):
        return validate(DashpotTable if quantity == "length" else TorsionDashpotTable, value).build(reading)
    kind = "damping" if quantity == "length" else "torsion_damping"
    return Dashpot(reading=reading, linear=parse_si(value, kind, sign="positive", bounded=True, hint="; leave it out if there is none"))


def _parse_stops(reading: str, quantity: str, value: Any, restitution: Mapping[str, float]) -> Effect:
    if not isinstance(value, list | tuple) or len(value) != 2:
        found, example = format_value(value), OUTPUT_EFFECT_EXAMPLES["stops"][quantity]
        text = f'{KEY} must be [low, high], with "{NO_STOP}" for a missing stop; found {found}; write {example}'
        raise mistake(ProblemCode.WRONG_TYPE, text)
    collector, ends = ProblemCollector(), list[float]()
    for end, name, default in zip(value, ("low", "high"), (-math.inf, math.inf), strict=True):
        with collector.at():
            ends.append(default if end == NO_STOP else parse_si(end, quantity, f"{KEY}, {name} end"))
    collector.raise_if_failed()
    low, high = ends
    if math.isinf(low) and math.isinf(high):
        text = f'{KEY} needs a low or a high end; found "{NO_STOP}" for both; leave {KEY} out'
        raise mistake(ProblemCode.MISSING_KEY, text)
    if not low < high:
        text = f"{KEY} must have its low end first; found {format_value(value[0])} and {format_value(value[1])}"
        raise mistake(ProblemCode.OUT_OF_RANGE, text)
    return Stops(reading=reading, low=low, high=high, **restitution)


def _output_effects(make: OutputEffectFactory) -> PlainValidator:
    """Return the validator of a table with one effect per reading."""

    def check(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
        return () if value is False else _parse_output_effects(_require_readings(value, info), info, make)

    return PlainValidator(check)


def _parse_all_stops(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    """Return the stops of a table with one entry per reading and one restitution for all."""
    if value is False:
        return ()
    table = _require_readings(value, info)
    collector, restitution, stops = ProblemCollector(), dict[str, float](), tuple[Effect, ...]()
    common = {key: table.pop(key) for key in RestitutionTable.model_fields if key in table}
    with collector.at():
        restitution = validate(RestitutionTable, common).given_values()
    with collector.at():
        stops = _parse_output_effects(_require_readings(table, info), info, partial(_parse_stops, restitution=restitution))
    collector.raise_if_failed()
    return stops


def _require_readings(value: object, info: ValidationInfo) -> dict[str, Any]:
    quantities: Mapping[str, str] = info.context or {SLEEVE_LIFT_NAME: "length"}
    name, quantity = (SLEEVE_ALIAS, "length") if SLEEVE_LIFT_NAME in quantities else next(iter(quantities.items()))
    example = f"write {info.field_name} = {{ {name} = {OUTPUT_EFFECT_EXAMPLES[str(info.field_name)][quantity]} }}"
    if not isinstance(value, Mapping):
        text = f"{KEY} must be a table with the readings on which it acts; found {format_value(value)}; {example}"
        raise mistake(ProblemCode.WRONG_TYPE, text)
    if not value:
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY} has no reading to act on; {example}")
    return {str(name): given for name, given in value.items()}


def _parse_output_effects(table: Mapping[str, Any], info: ValidationInfo, make: OutputEffectFactory) -> tuple[Effect, ...]:
    collector, effects = ProblemCollector(), dict[str, Effect]()
    for name, value in table.items():
        with collector.at(f"{KEY}.{name}"):
            reading = resolve_reading_name(name, info.context)
            if value is False:
                continue
            if reading in effects:
                raise mistake(ProblemCode.DUPLICATE, f"{KEY} is the same reading as another key; keep one of them")
            effects[reading] = parse_by_quantity(reading, info.context, value, make)
    collector.raise_if_failed()
    return tuple(effects.values())


def parse_by_quantity(reading: str, quantities: ReadingQuantities, value: Any, make: Callable[[str, str, Any], _Parsed]) -> _Parsed:
    """Return what `make` parses for the quantity of a reading; of an unknown quantity, the result with the fewest problems."""
    refusals: list[MechanismError] = []
    for quantity in ("length", "angle") if quantities is None else (quantities[reading],):
        try:
            return make(reading, quantity, value)
        except MechanismError as error:
            refusals.append(error)
    raise min(refusals, key=lambda refusal: len(refusal.problems))


def resolve_reading_name(name: str, quantities: ReadingQuantities, path: str = KEY) -> str:
    """Return the name of a reading, also for the short name of the sleeve's; `path` is where a message finds it."""
    if quantities is None or name in quantities:
        return name
    if name == SLEEVE_ALIAS and SLEEVE_LIFT_NAME in quantities:
        return SLEEVE_LIFT_NAME
    aliases = [SLEEVE_ALIAS] if SLEEVE_LIFT_NAME in quantities else []
    suggestion = did_you_mean(name, [*aliases, *quantities])
    raise mistake(ProblemCode.UNKNOWN_NAME, f"{path} is not a reading; readings are {', '.join(quantities)}.{suggestion}")


Effects = tuple[Effect, ...]


class EffectsTable(SceneFileTable):
    """[effects]; each key gives a tuple of effects, empty if it is switched off."""

    gravity: Annotated[Effects, PlainValidator(_parse_gravity)] = ()
    centrifugal: Annotated[Effects, PlainValidator(lambda value: (Centrifugal(),) if check_bool(value) else ())] = ()
    rods: Annotated[Effects, _body_effect(RodsTable, RodMasses)] = ()
    spring: Annotated[Effects, _output_effects(_parse_spring)] = ()
    dry_friction: Annotated[Effects, _output_effects(_parse_dry_friction)] = ()
    dashpot: Annotated[Effects, _output_effects(_parse_dashpot)] = ()
    stops: Annotated[Effects, PlainValidator(_parse_all_stops)] = ()
    clearance: Annotated[Effects, PlainValidator(_parse_clearance)] = ()
    masses: Annotated[Effects, _body_effect(MassesTable, CrankMasses)] = ()
    bell_cranks: Annotated[Effects, _body_effect(BellCranksTable, BellCrankMasses)] = ()


def parse_effects(table: Mapping[str, Any], quantities: ReadingQuantities, collector: ProblemCollector) -> tuple[Effect, ...]:
    """Return the effects that [effects] switches on; keys without a mistake count even if others have one."""
    effects: dict[str, tuple[Effect, ...]] = {}
    for key, value in table.items():
        with collector.at("effects"):
            effects |= validate(EffectsTable, {key: value}, context=quantities).given_values()
    return tuple(effect for key in EffectsTable.model_fields for effect in effects.get(key, ()))
