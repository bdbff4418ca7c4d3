"""What an effect along one reading may hold: springs, dry friction, oil brakes and stops, in the reading's units.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import PlainValidator, ValidationInfo

from governor_mechanism.effects.dashpot import OilBrake, orifice_coefficient
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn, wire_spring_rate
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.time_functions import Program
from governor_mechanism.scenes.quantities import built, built_value, listed, located, points_in_time, si, truth, where
from governor_mechanism.scenes.schema import Table, understood
from governor_mechanism.units.quantities import parse, shown

NONE: Final = "none"
"""What stands for an end of stops that is left out."""

EXAMPLES: Final = {
    "spring": {"length": '{ rate = "2 N/mm" }', "angle": '{ rate = "3 N m/rad" }'},
    "dry_friction": {"length": '"40 N"', "angle": '"5 N m"'},
    "oil_brake": {"length": '"120 N s/m"', "angle": '"0.1 N m s/rad"'},
    "stops": {"length": '["10 mm", "60 mm"]', "angle": '["15 deg", "45 deg"]'},
}
"""What may stand for a reading, by the effect and the reading's quantity."""


class SpringTable(Table):
    """A spring on a length."""

    rate: Annotated[float, built("stiffness")] = 0.0
    wire: Annotated[float, built("length")] = 0.0
    coil: Annotated[float, built("length")] = 0.0
    turns: Annotated[float, built("number")] = 0.0
    modulus: Annotated[float, PlainValidator(lambda value, info: _modulus(value, where(info)))] = 0.0
    preload: Annotated[float, built("force", sign="any")] = 0.0
    zero: Annotated[float, built("length", sign="any")] = 0.0
    one_sided: Annotated[bool, PlainValidator(truth)] = False


class TorsionSpringTable(SpringTable):
    """A spring on an angle."""

    rate: Annotated[float, built("torsion_stiffness")] = 0.0
    preload: Annotated[float, built("torque", sign="any")] = 0.0
    zero: Annotated[float, built("angle", sign="any")] = 0.0


class OilTable(Table):
    """An oil brake on a length."""

    linear: Annotated[float, built("damping", sign="not negative")] = 0.0
    quadratic: Annotated[float, built("quadratic_damping", sign="not negative")] = 0.0
    piston: Annotated[float, built("area")] = 0.0
    hole: Annotated[float, built("area")] = 0.0
    screw: Annotated[float, built("ratio")] = 1.0
    oil: Annotated[float, built("density")] = 900.0


class TorsionOilTable(OilTable):
    """An oil brake on an angle."""

    linear: Annotated[float, built("torsion_damping", sign="not negative")] = 0.0
    quadratic: Annotated[float, built("quadratic_torsion_damping", sign="not negative")] = 0.0


WIRE: Final = ("wire", "coil", "turns", "modulus")
ORIFICE: Final = ("piston", "hole")
SPRINGS: Final[dict[str, type[Table]]] = {"length": SpringTable, "angle": TorsionSpringTable}
OILS: Final[dict[str, type[Table]]] = {"length": OilTable, "angle": TorsionOilTable}


def _modulus(value: object, place: str) -> float:
    modulus = si(value, "modulus", place)
    if not 1.0 <= modulus <= 1e13:
        raise MechanismError(f"{place} must lie between 1 Pa and 1e+13 Pa; found {shown(value)}; steel has 80 GPa")
    return modulus


def table_meaning(model: type[Table], value: object, place: str, example: str) -> dict[str, Any]:
    """What a table within [effects] means."""
    if not isinstance(value, Mapping):
        raise MechanismError(f"{place} must be a table; found {shown(value)}; write {example}")
    meaning, problems = understood(model, dict(value), place)
    if problems:
        raise MechanismError(*problems)
    return meaning


def restitution_value(value: object, info: ValidationInfo) -> float:
    """The part of the speed with which something bounces back."""
    part = parse(value, "ratio", where(info))
    if not 0 <= part <= 1:
        raise MechanismError(
            f"{where(info)} must lie between 0 and 1, it is the part of the speed that is left; found {shown(value)}"
        )
    return part


def spring_on(reading: str, quantity: str, value: Any, place: str) -> Effect:
    """A spring by its rate, or by the wire that it is wound of."""
    name = place.rpartition(".")[2]
    meaning = table_meaning(SPRINGS[quantity], value, place, f"{name} = {EXAMPLES['spring'][quantity]}")
    _refuse_wire(meaning, quantity, place)
    coil = {key: meaning.pop(key) for key in WIRE if key in meaning}
    if coil:
        meaning["rate"] = located(place, lambda: wire_spring_rate(**coil))
    return located(place, lambda: SpringOn(reading=reading, **meaning))


def _refuse_wire(meaning: Mapping[str, Any], quantity: str, place: str) -> None:
    """Rates that are missing, given twice, or of a coil that would have to turn."""
    given, missing = [key for key in WIRE if key in meaning], [key for key in WIRE if key not in meaning]
    if given and "rate" in meaning:
        raise MechanismError(
            f"{place}: rate cannot stand beside {listed(given)}, from which it follows; leave one of the two out"
        )
    if given and quantity == "angle":
        raise MechanismError(f'{place} is an angle, whose spring has no {listed(given)}; write rate = "3 N m/rad"')
    if given and missing:
        raise MechanismError(f"{place} lacks {listed(missing)}; a spring of wire needs {listed(WIRE)}")
    if not given and "rate" not in meaning:
        rate = EXAMPLES["spring"][quantity].strip("{ }")
        also = f", or {listed(WIRE)}" if quantity == "length" else ""
        raise MechanismError(f"{place}: rate is missing; write {rate}{also}")


def dry_friction_on(reading: str, quantity: str, value: Any, place: str) -> Effect:
    """Dry friction: a force or moment, or a program of them."""
    kind, called = ("force", "force") if quantity == "length" else ("torque", "moment")
    times, forces = points_in_time(value, kind, called, place)
    wrong = [number for number, force in enumerate(forces, start=1) if force < 0]
    if wrong:
        points = f", point {wrong[0]}:" if isinstance(value, list | tuple) else ""
        found = shown(value[wrong[0] - 1][1] if points else value)
        raise MechanismError(f"{place}{points} must not be negative, friction opposes either way; found {found}")
    return DryFriction(reading=reading, force=located(place, lambda: Program(times=times, values=forces)))


def oil_brake_on(reading: str, quantity: str, value: Any, place: str) -> Effect:
    """An oil brake: a damping alone, or a table of its parts."""
    if not isinstance(value, Mapping):
        kind = "damping" if quantity == "length" else "torsion_damping"
        return OilBrake(reading=reading, linear=built_value(value, kind, place, cure="; leave it out if there is none"))
    meaning = table_meaning(OILS[quantity], value, place, "")
    _refuse_oil(meaning, quantity, place)
    if "piston" in meaning:
        sizes = {key: meaning[key] for key in (*ORIFICE, "screw") if key in meaning}
        density = {"density": meaning["oil"]} if "oil" in meaning else {}
        meaning["quadratic"] = located(place, lambda: orifice_coefficient(**sizes, **density))
    parts = {key: meaning[key] for key in ("linear", "quadratic") if key in meaning}
    return located(place, lambda: OilBrake(reading=reading, **parts))


def _refuse_oil(meaning: Mapping[str, Any], quantity: str, place: str) -> None:
    """Quadratic parts given twice, in part, or of a piston that would have to turn."""
    given = [key for key in (*ORIFICE, "screw", "oil") if key in meaning]
    if given and "quadratic" in meaning:
        raise MechanismError(
            f"{place}: quadratic cannot stand beside {listed(given)}, from which it follows; leave one of the two out"
        )
    if given and quantity == "angle":
        raise MechanismError(
            f'{place} is an angle, whose oil brake has no {listed(given)}; write quadratic = "0.3 N m s^2/rad^2"'
        )
    missing = [key for key in ORIFICE if key not in meaning]
    if given and missing:
        raise MechanismError(f"{place} lacks {listed(missing)}; oil through a hole needs {listed(ORIFICE)}")


def ends_of(value: Any, quantity: str, place: str) -> tuple[float, float]:
    """The low and the high end of stops; infinite where there is none."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(
            f'{place} must be [low, high], an end that is not there "{NONE}"; found {shown(value)}; '
            f"write {EXAMPLES['stops'][quantity]}"
        )
    ends: list[float] = []
    problems: list[str] = []
    for given, called, missing in ((value[0], "low end", -math.inf), (value[1], "high end", math.inf)):
        try:
            ends.append(missing if given == NONE else si(given, quantity, f"{place}, {called}"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    low, high = ends
    if math.isinf(low) and math.isinf(high):
        raise MechanismError(f'{place} needs a low or a high end; found "{NONE}" for both; leave {place} out')
    if not low < high:
        raise MechanismError(
            f"{place} must have its low end first and below the high one; found {shown(value[0])} and {shown(value[1])}"
        )
    return low, high
