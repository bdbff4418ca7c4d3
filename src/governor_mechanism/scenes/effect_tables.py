"""[effects] of a scene file: an Effect for each that is switched on, its mistakes told in sentences.

Effects that act along readings are tables by the names of readings, in the units of the reading's quantity. Kept apart
from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any, Final

from pydantic import Field, PlainValidator, ValidationInfo, create_model

from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import Play
from governor_mechanism.effects.crank_masses import Masses
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.effect import Effect
from governor_mechanism.scenes.output_effect_tables import (
    EXAMPLES,
    dry_friction_on,
    ends_of,
    oil_brake_on,
    restitution_value,
    spring_on,
    table_meaning,
)
from governor_mechanism.scenes.quantities import built, built_value, listed, located, truth, where
from governor_mechanism.scenes.schema import Table, understood
from governor_mechanism.units.quantities import parse, shown

Readings = tuple[tuple[str, str], ...] | None
"""Names of readings with their quantities, 'length' or 'angle'; None where they are not known."""

SLEEVE, SLEEVE_LIFT = "sleeve", "sleeve_lift"
"""What users may call a reading of governors, and its name."""

RESTITUTION: Final = "restitution"


def effects_of(given: Mapping[str, Any], readings: Readings) -> tuple[tuple[Effect, ...], list[str]]:
    """The effects that a table [effects] switches on, and a sentence for each mistake; what has none is still read."""
    model, found, problems = effects_table(readings), dict[str, tuple[Effect, ...]](), list[str]()
    for key, value in given.items():
        meaning, told = understood(model, {key: value}, "effects")
        found |= meaning
        problems += told
    return tuple(effect for key in model.model_fields for effect in found.get(key, ())), problems


@cache
def effects_table(readings: Readings) -> type[Table]:
    """[effects] of a mechanism with these readings: under each key a tuple of effects."""
    checks: dict[str, Callable[[Any, ValidationInfo], tuple[Effect, ...]]] = {
        "gravity": _gravity,
        "centrifugal": _centrifugal,
        "rods": _rods,
        "spring": _along(readings, spring_on),
        "dry_friction": _along(readings, dry_friction_on),
        "oil_brake": _along(readings, oil_brake_on),
        "stops": _stops(readings),
        "play": _play,
        "masses": _masses,
        "bell_cranks": _bell_cranks,
    }
    fields: dict[str, Any] = {key: (Annotated[Any, PlainValidator(check)], ()) for key, check in checks.items()}
    return create_model("EffectsTable", __base__=Table, **fields)


def _gravity(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if isinstance(value, bool):
        return (Gravity(),) if value else ()
    try:
        acceleration = parse(value, "acceleration", where(info))
    except MechanismError as error:
        raise MechanismError(f"{error}; gravity may also be true (9.81 m/s^2) or false") from error
    if acceleration <= 0:
        raise MechanismError(
            f"{where(info)} must be positive; found {shown(value)}; write gravity = false for a scene without weights"
        )
    return (Gravity(acceleration=acceleration),)


def _centrifugal(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    return (Centrifugal(),) if truth(value, info) else ()


class RodsTable(Table):
    """The arguments of Rods."""

    arm_mass: Annotated[float, built("mass", sign="not negative")] = 0.0
    link_mass: Annotated[float, built("mass", sign="not negative")] = 0.0
    ball_radius: Annotated[float, built("length", sign="not negative")] = 0.0


class BellCranksTable(Table):
    """The arguments of BellCranks."""

    mass: Annotated[float, built("mass", sign="not negative")] = 0.0
    weight_width: Annotated[float, built("length", sign="not negative")] = 0.0
    weight_height: Annotated[float, built("length", sign="not negative")] = 0.0
    weight_depth: Annotated[float, built("length", sign="not negative")] = 0.0


NO_PLAY: Final = "; write play = false if there is none"


class PlayTable(Table):
    """The arguments of Play."""

    width: Annotated[float, built("length", cure=NO_PLAY)] = Field(
        description='how far the sleeve may move between the links, as "0.5 mm"'
    )
    restitution: Annotated[float, PlainValidator(restitution_value)] = 0.0


class RestitutionTable(Table):
    """What stands beside the readings in a table of stops."""

    restitution: Annotated[float, PlainValidator(restitution_value)] = 0.0


def _rods(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    meaning = table_meaning(RodsTable, value, where(info), 'rods = { arm_mass = "0.6 kg", link_mass = "0.5 kg" }')
    return (located(where(info), lambda: Rods(**meaning)),)


class MassesTable(Table):
    """The arguments of Masses."""

    crank: Annotated[float, built("mass")] = Field(
        description='the mass of the crank, as "80 kg"; rod and crosshead may go without'
    )
    crank_centre: Annotated[float, built("length", sign="any")] = 0.0
    rod: Annotated[float, built("mass", sign="not negative")] = 0.0
    rod_centre: Annotated[float | None, built("length", sign="not negative")] = None
    rod_inertia: Annotated[float | None, built("moment_of_inertia")] = None
    crosshead: Annotated[float, built("mass", sign="not negative")] = 0.0


def _masses(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    meaning = table_meaning(
        MassesTable, value, where(info), 'masses = { crank = "80 kg", rod = "70 kg", crosshead = "110 kg" }'
    )
    return (located(where(info), lambda: Masses(**meaning)),)


def _bell_cranks(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    example = 'bell_cranks = { mass = "6 kg", weight_width = "150 mm", weight_height = "200 mm" }'
    meaning = table_meaning(BellCranksTable, value, where(info), example)
    return (located(where(info), lambda: BellCranks(**meaning)),)


def _play(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
    if value is False:
        return ()
    if value is True:
        raise MechanismError(f'{where(info)} is how far the sleeve may move; found true; write play = "0.5 mm"')
    if isinstance(value, Mapping):
        meaning = table_meaning(PlayTable, value, where(info), "")
    else:
        meaning = {"width": built_value(value, "length", where(info), cure=NO_PLAY)}
    return (Play(**meaning),)


Make = Callable[[str, str, Any, str], Effect]
"""Makes an effect of a reading, its quantity, what is given for it, and where."""


def _along(readings: Readings, make: Make) -> Callable[[Any, ValidationInfo], tuple[Effect, ...]]:
    """A check of a table by the names of readings."""

    def convert(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
        if value is False:
            return ()
        return _on_readings(_by_reading(value, readings, info), readings, make, where(info))

    return convert


def _stops(readings: Readings) -> Callable[[Any, ValidationInfo], tuple[Effect, ...]]:
    """A check of stops: by the names of readings, with one restitution."""

    def convert(value: object, info: ValidationInfo) -> tuple[Effect, ...]:
        if value is False:
            return ()
        table = _by_reading(value, readings, info)
        beside = {RESTITUTION: table.pop(RESTITUTION)} if RESTITUTION in table else {}
        common, problems = understood(RestitutionTable, beside, where(info))

        def make(reading: str, quantity: str, given: Any, place: str) -> Effect:
            low, high = ends_of(given, quantity, place)
            return Stops(reading=reading, low=low, high=high, **common)

        try:
            if not table:
                raise MechanismError(f"{where(info)} has no reading to act on; {_example(readings, 'stops')}")
            found = _on_readings(table, readings, make, where(info))
        except MechanismError as error:
            raise MechanismError(*error.problems, *problems) from error
        if problems:
            raise MechanismError(*problems)
        return found

    return convert


def _by_reading(value: object, readings: Readings, info: ValidationInfo) -> dict[str, Any]:
    """The table of an effect that acts along readings."""
    example = _example(readings, str(info.field_name))
    if not isinstance(value, Mapping):
        raise MechanismError(f"{where(info)} must name the readings that it acts on; found {shown(value)}; {example}")
    if not value:
        raise MechanismError(f"{where(info)} has no reading to act on; {example}")
    return {str(name): given for name, given in value.items()}


def _on_readings(table: Mapping[str, Any], readings: Readings, make: Make, place: str) -> tuple[Effect, ...]:
    found: dict[str, Effect] = {}
    problems: list[str] = []
    for name, given in table.items():
        try:
            reading = _named(name, readings, f"{place}.{name}")
            if given is False:
                continue
            if reading in found:
                raise MechanismError(f"{place}.{name} is the same reading as another one there; keep one of them")
            found[reading] = _made(reading, readings, given, f"{place}.{name}", make)
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return tuple(found.values())


def _made(reading: str, readings: Readings, given: Any, place: str, make: Make) -> Effect:
    """The effect on a reading; on one of unknown quantity, what fits either."""
    quantities = ("length", "angle") if readings is None else (dict(readings)[reading],)
    refusals: list[MechanismError] = []
    for quantity in quantities:
        try:
            return make(reading, quantity, given, place)
        except MechanismError as error:
            refusals.append(error)
    raise min(refusals, key=lambda refusal: len(refusal.problems))


def _named(name: str, readings: Readings, place: str) -> str:
    """The reading of that name; `sleeve` is short for the sleeve's lift."""
    names = [name for name, _ in readings or ()]
    if readings is None or name in names:
        return name
    if name == SLEEVE and SLEEVE_LIFT in names:
        return SLEEVE_LIFT
    also = [SLEEVE] if SLEEVE_LIFT in names else []
    raise MechanismError(f"{place} is no reading; readings are {listed(names)}.{did_you_mean(name, [*also, *names])}")


def _example(readings: Readings, key: str) -> str:
    known = dict(readings) if readings else {SLEEVE_LIFT: "length"}
    name, quantity = (SLEEVE, "length") if SLEEVE_LIFT in known else next(iter(known.items()))
    return f"write {key} = {{ {name} = {EXAMPLES[key][quantity]} }}"
