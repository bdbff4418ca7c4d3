"""[effects] of a scene file: an Effect for each that is switched on, its mistakes told in sentences.

Effects that act along readings are tables by the names of readings, in the units of the reading's quantity. Kept apart
from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any, Final

from pydantic import Field, PlainValidator, ValidationInfo, create_model

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.effect import Effect
from governor_mechanism.scenes.output_effect_tables import (
    OUTPUT_EFFECT_EXAMPLES,
    parse_dashpot,
    parse_dry_friction,
    parse_effect_table,
    parse_spring,
    parse_stops,
    validate_restitution,
)
from governor_mechanism.scenes.quantities import (
    bounded_quantity_validator,
    join_names,
    key_path_of,
    parse_bounded_quantity,
    prefix_errors,
    validate_bool,
)
from governor_mechanism.scenes.schema import SceneFileTable, validate_table
from governor_mechanism.units.quantities import format_value, parse_quantity

ReadingQuantities = tuple[tuple[str, str], ...] | None
"""Names of readings with their quantities, 'length' or 'angle'; None where they are not known."""

SLEEVE_ALIAS, SLEEVE_LIFT_NAME = "sleeve", "sleeve_lift"
"""What users may call a reading of governors, and its name."""

RESTITUTION_KEY: Final = "restitution"


def parse_effects(given: Mapping[str, Any], reading_quantities: ReadingQuantities) -> tuple[tuple[Effect, ...], list[str]]:
    """The effects that a table [effects] switches on, and a sentence for each mistake; what has none is still read."""
    model, effects, problems = effects_table_model(reading_quantities), dict[str, tuple[Effect, ...]](), list[str]()
    for key, value in given.items():
        parsed, new_problems = validate_table(model, {key: value}, "effects")
        effects |= parsed
        problems += new_problems
    return tuple(effect for key in model.model_fields for effect in effects.get(key, ())), problems


@cache
def effects_table_model(reading_quantities: ReadingQuantities) -> type[SceneFileTable]:
    """[effects] of a mechanism with these readings: under each key a tuple of effects."""
    validators: dict[str, Callable[[Any, ValidationInfo], tuple[Effect, ...]]] = {
        "gravity": _validate_gravity,
        "centrifugal": _validate_centrifugal,
        "rods": _validate_rods,
        "spring": _output_effect_validator(reading_quantities, parse_spring),
        "dry_friction": _output_effect_validator(reading_quantities, parse_dry_friction),
        "dashpot": _output_effect_validator(reading_quantities, parse_dashpot),
        "stops": _stops_validator(reading_quantities),
        "clearance": _validate_clearance,
        "masses": _validate_masses,
        "bell_cranks": _validate_bell_cranks,
    }
    fields: dict[str, Any] = {key: (Annotated[Any, PlainValidator(check)], ()) for key, check in validators.items()}
    return create_model("EffectsTable", __base__=SceneFileTable, **fields)


def _validate_gravity(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if isinstance(value, bool):
        return (Gravity(),) if value else ()
    try:
        acceleration = parse_quantity(value, "acceleration", key_path_of(info))
    except MechanismError as error:
        raise MechanismError(f"{error}; gravity may also be true (9.81 m/s^2) or false") from error
    if acceleration <= 0:
        raise MechanismError(
            f"{key_path_of(info)} must be positive; found {format_value(value)}; write gravity = false for a scene without weights"
        )
    return (Gravity(acceleration=acceleration),)


def _validate_centrifugal(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    return (Centrifugal(),) if validate_bool(value, info) else ()


class RodsTable(SceneFileTable):
    """The arguments of Rods."""

    arm_mass: Annotated[float, bounded_quantity_validator("mass", sign="not negative")] = 0.0
    link_mass: Annotated[float, bounded_quantity_validator("mass", sign="not negative")] = 0.0
    ball_radius: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0


class BellCranksTable(SceneFileTable):
    """The arguments of BellCranks."""

    mass: Annotated[float, bounded_quantity_validator("mass", sign="not negative")] = 0.0
    weight_width: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0
    weight_height: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0
    weight_depth: Annotated[float, bounded_quantity_validator("length", sign="not negative")] = 0.0


NO_CLEARANCE_HINT: Final = "; write clearance = false if there is none"


class ClearanceTable(SceneFileTable):
    """The arguments of Play."""

    width: Annotated[float, bounded_quantity_validator("length", hint=NO_CLEARANCE_HINT)] = Field(
        description='how far the sleeve may move between the links, as "0.5 mm"'
    )
    restitution: Annotated[float, PlainValidator(validate_restitution)] = 0.0


class RestitutionTable(SceneFileTable):
    """What stands beside the readings in a table of stops."""

    restitution: Annotated[float, PlainValidator(validate_restitution)] = 0.0


def _validate_rods(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    parsed = parse_effect_table(RodsTable, value, key_path_of(info), 'rods = { arm_mass = "0.6 kg", link_mass = "0.5 kg" }')
    return (prefix_errors(key_path_of(info), lambda: RodMasses(**parsed)),)


class MassesTable(SceneFileTable):
    """The arguments of Masses."""

    crank: Annotated[float, bounded_quantity_validator("mass")] = Field(
        description='the mass of the crank, as "80 kg"; rod and crosshead may go without'
    )
    crank_centre: Annotated[float, bounded_quantity_validator("length", sign="any")] = 0.0
    rod: Annotated[float, bounded_quantity_validator("mass", sign="not negative")] = 0.0
    rod_centre: Annotated[float | None, bounded_quantity_validator("length", sign="not negative")] = None
    rod_inertia: Annotated[float | None, bounded_quantity_validator("moment_of_inertia")] = None
    crosshead: Annotated[float, bounded_quantity_validator("mass", sign="not negative")] = 0.0


def _validate_masses(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    parsed = parse_effect_table(MassesTable, value, key_path_of(info), 'masses = { crank = "80 kg", rod = "70 kg", crosshead = "110 kg" }')
    return (prefix_errors(key_path_of(info), lambda: CrankMasses(**parsed)),)


def _validate_bell_cranks(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    example = 'bell_cranks = { mass = "6 kg", weight_width = "150 mm", weight_height = "200 mm" }'
    parsed = parse_effect_table(BellCranksTable, value, key_path_of(info), example)
    return (prefix_errors(key_path_of(info), lambda: BellCrankMasses(**parsed)),)


def _validate_clearance(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    if value is True:
        raise MechanismError(f'{key_path_of(info)} is how far the sleeve may move; found true; write clearance = "0.5 mm"')
    if isinstance(value, Mapping):
        parsed = parse_effect_table(ClearanceTable, value, key_path_of(info), "")
    else:
        parsed = {"width": parse_bounded_quantity(value, "length", key_path_of(info), hint=NO_CLEARANCE_HINT)}
    return (Clearance(**parsed),)


OutputEffectFactory = Callable[[str, str, Any, str], Effect]
"""Makes an effect of a reading, its quantity, what is given for it, and where."""


def _output_effect_validator(
    reading_quantities: ReadingQuantities, make: OutputEffectFactory
) -> Callable[[Any, ValidationInfo], tuple[Effect, ...]]:
    """A check of a table by the names of readings."""

    def validate(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
        if value is False:
            return ()
        return _parse_output_effects(_require_reading_table(value, reading_quantities, info), reading_quantities, make, key_path_of(info))

    return validate


def _stops_validator(reading_quantities: ReadingQuantities) -> Callable[[Any, ValidationInfo], tuple[Effect, ...]]:
    """A check of stops: by the names of readings, with one restitution."""

    def validate(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
        if value is False:
            return ()
        table = _require_reading_table(value, reading_quantities, info)
        restitution_values = {RESTITUTION_KEY: table.pop(RESTITUTION_KEY)} if RESTITUTION_KEY in table else {}
        common, problems = validate_table(RestitutionTable, restitution_values, key_path_of(info))

        def make(reading: str, quantity: str, given: Any, key_path: str) -> Effect:
            low, high = parse_stops(given, quantity, key_path)
            return Stops(reading=reading, low=low, high=high, **common)

        try:
            if not table:
                raise MechanismError(f"{key_path_of(info)} has no reading to act on; {_example_hint(reading_quantities, 'stops')}")
            effects = _parse_output_effects(table, reading_quantities, make, key_path_of(info))
        except MechanismError as error:
            raise MechanismError(*error.problems, *problems) from error
        if problems:
            raise MechanismError(*problems)
        return effects

    return validate


def _require_reading_table(value: object, reading_quantities: ReadingQuantities, info: ValidationInfo) -> dict[str, Any]:
    """The table of an effect that acts along readings."""
    example = _example_hint(reading_quantities, str(info.field_name))
    if not isinstance(value, Mapping):
        raise MechanismError(f"{key_path_of(info)} must name the readings that it acts on; found {format_value(value)}; {example}")
    if not value:
        raise MechanismError(f"{key_path_of(info)} has no reading to act on; {example}")
    return {str(name): given for name, given in value.items()}


def _parse_output_effects(
    table: Mapping[str, Any], reading_quantities: ReadingQuantities, make: OutputEffectFactory, key_path: str
) -> tuple[Effect, ...]:
    effects: dict[str, Effect] = {}
    problems: list[str] = []
    for name, given in table.items():
        try:
            reading = _resolve_reading_name(name, reading_quantities, f"{key_path}.{name}")
            if given is False:
                continue
            if reading in effects:
                raise MechanismError(f"{key_path}.{name} is the same reading as another one there; keep one of them")
            effects[reading] = _parse_output_effect(reading, reading_quantities, given, f"{key_path}.{name}", make)
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return tuple(effects.values())


def _parse_output_effect(
    reading: str, reading_quantities: ReadingQuantities, given: Any, key_path: str, make: OutputEffectFactory
) -> Effect:
    """The effect on a reading; on one of unknown quantity, what fits either."""
    quantities = ("length", "angle") if reading_quantities is None else (dict(reading_quantities)[reading],)
    refusals: list[MechanismError] = []
    for quantity in quantities:
        try:
            return make(reading, quantity, given, key_path)
        except MechanismError as error:
            refusals.append(error)
    raise min(refusals, key=lambda refusal: len(refusal.problems))


def _resolve_reading_name(name: str, reading_quantities: ReadingQuantities, key_path: str) -> str:
    """The reading of that name; `sleeve` is short for the sleeve's lift."""
    names = [name for name, _ in reading_quantities or ()]
    if reading_quantities is None or name in names:
        return name
    if name == SLEEVE_ALIAS and SLEEVE_LIFT_NAME in names:
        return SLEEVE_LIFT_NAME
    aliases = [SLEEVE_ALIAS] if SLEEVE_LIFT_NAME in names else []
    raise MechanismError(f"{key_path} is no reading; readings are {join_names(names)}.{did_you_mean(name, [*aliases, *names])}")


def _example_hint(reading_quantities: ReadingQuantities, key: str) -> str:
    quantities = dict(reading_quantities) if reading_quantities else {SLEEVE_LIFT_NAME: "length"}
    name, quantity = (SLEEVE_ALIAS, "length") if SLEEVE_LIFT_NAME in quantities else next(iter(quantities.items()))
    return f"write {key} = {{ {name} = {OUTPUT_EFFECT_EXAMPLES[key][quantity]} }}"
