"""What an effect along one reading may hold: springs, dry friction, dashpots and stops, in the reading's units.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import PlainValidator, ValidationInfo

from governor_mechanism.effects.dashpot import Dashpot, orifice_damping_coefficient
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring, helical_spring_rate
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.scenes.quantities import (
    bounded_quantity_validator,
    join_names,
    key_path_of,
    parse_bounded_quantity,
    parse_si,
    parse_time_points,
    prefix_errors,
    validate_bool,
)
from governor_mechanism.scenes.schema import SceneFileTable, validate_table
from governor_mechanism.units.quantities import format_value, parse_quantity

NO_STOP: Final = "none"
"""What stands for an end of stops that is left out."""

OUTPUT_EFFECT_EXAMPLES: Final = {
    "spring": {"length": '{ rate = "2 N/mm" }', "angle": '{ rate = "3 N m/rad" }'},
    "dry_friction": {"length": '"40 N"', "angle": '"5 N m"'},
    "dashpot": {"length": '"120 N s/m"', "angle": '"0.1 N m s/rad"'},
    "stops": {"length": '["10 mm", "60 mm"]', "angle": '["15 deg", "45 deg"]'},
}
"""What may stand for a reading, by the effect and the reading's quantity."""


class SpringTable(SceneFileTable):
    """A spring on a length."""

    rate: Annotated[float, bounded_quantity_validator("stiffness")] = 0.0
    wire: Annotated[float, bounded_quantity_validator("length")] = 0.0
    coil: Annotated[float, bounded_quantity_validator("length")] = 0.0
    turns: Annotated[float, bounded_quantity_validator("number")] = 0.0
    modulus: Annotated[float, PlainValidator(lambda value, info: _parse_modulus(value, key_path_of(info)))] = 0.0
    preload: Annotated[float, bounded_quantity_validator("force", sign="any")] = 0.0
    zero: Annotated[float, bounded_quantity_validator("length", sign="any")] = 0.0
    one_sided: Annotated[bool, PlainValidator(validate_bool)] = False


class TorsionSpringTable(SpringTable):
    """A spring on an angle."""

    rate: Annotated[float, bounded_quantity_validator("torsion_stiffness")] = 0.0
    preload: Annotated[float, bounded_quantity_validator("torque", sign="any")] = 0.0
    zero: Annotated[float, bounded_quantity_validator("angle", sign="any")] = 0.0


class DashpotTable(SceneFileTable):
    """An dashpot on a length."""

    linear: Annotated[float, bounded_quantity_validator("damping", sign="not negative")] = 0.0
    quadratic: Annotated[float, bounded_quantity_validator("quadratic_damping", sign="not negative")] = 0.0
    piston: Annotated[float, bounded_quantity_validator("area")] = 0.0
    hole: Annotated[float, bounded_quantity_validator("area")] = 0.0
    screw: Annotated[float, bounded_quantity_validator("ratio")] = 1.0
    oil: Annotated[float, bounded_quantity_validator("density")] = 900.0


class TorsionDashpotTable(DashpotTable):
    """An dashpot on an angle."""

    linear: Annotated[float, bounded_quantity_validator("torsion_damping", sign="not negative")] = 0.0
    quadratic: Annotated[float, bounded_quantity_validator("quadratic_torsion_damping", sign="not negative")] = 0.0


WIRE_KEYS: Final = ("wire", "coil", "turns", "modulus")
ORIFICE_KEYS: Final = ("piston", "hole")
SPRING_TABLES: Final[dict[str, type[SceneFileTable]]] = {"length": SpringTable, "angle": TorsionSpringTable}
DASHPOT_TABLES: Final[dict[str, type[SceneFileTable]]] = {"length": DashpotTable, "angle": TorsionDashpotTable}


def _parse_modulus(value: object, key_path: str) -> float:
    modulus = parse_si(value, "modulus", key_path)
    if not 1.0 <= modulus <= 1e13:
        raise MechanismError(f"{key_path} must lie between 1 Pa and 1e+13 Pa; found {format_value(value)}; steel has 80 GPa")
    return modulus


def parse_effect_table(model: type[SceneFileTable], value: object, key_path: str, example: str) -> dict[str, Any]:
    """What a table within [effects] means."""
    if not isinstance(value, Mapping):
        raise MechanismError(f"{key_path} must be a table; found {format_value(value)}; write {example}")
    parsed, problems = validate_table(model, dict(value), key_path)
    if problems:
        raise MechanismError(*problems)
    return parsed


def validate_restitution(value: object, info: ValidationInfo) -> float:
    """The part of the speed with which something bounces back."""
    restitution = parse_quantity(value, "ratio", key_path_of(info))
    if not 0 <= restitution <= 1:
        raise MechanismError(
            f"{key_path_of(info)} must lie between 0 and 1, it is the part of the speed that is left; found {format_value(value)}"
        )
    return restitution


def parse_spring(reading: str, quantity: str, value: Any, key_path: str) -> Effect:
    """A spring by its rate, or by the wire that it is wound of."""
    reading_name = key_path.rpartition(".")[2]
    parsed = parse_effect_table(SPRING_TABLES[quantity], value, key_path, f"{reading_name} = {OUTPUT_EFFECT_EXAMPLES['spring'][quantity]}")
    _check_spring_keys(parsed, quantity, key_path)
    wire_values = {key: parsed.pop(key) for key in WIRE_KEYS if key in parsed}
    if wire_values:
        parsed["rate"] = prefix_errors(key_path, lambda: helical_spring_rate(**wire_values))
    return prefix_errors(key_path, lambda: OutputSpring(reading=reading, **parsed))


def _check_spring_keys(parsed: Mapping[str, Any], quantity: str, key_path: str) -> None:
    """Rates that are missing, given twice, or of a coil that would have to turn."""
    given_keys, missing_keys = ([key for key in WIRE_KEYS if key in parsed], [key for key in WIRE_KEYS if key not in parsed])
    if given_keys and "rate" in parsed:
        raise MechanismError(
            f"{key_path}: rate cannot stand beside {join_names(given_keys)}, from which it follows; leave one of the two out"
        )
    if given_keys and quantity == "angle":
        raise MechanismError(f'{key_path} is an angle, whose spring has no {join_names(given_keys)}; write rate = "3 N m/rad"')
    if given_keys and missing_keys:
        raise MechanismError(f"{key_path} lacks {join_names(missing_keys)}; a spring of wire needs {join_names(WIRE_KEYS)}")
    if not given_keys and "rate" not in parsed:
        rate_example = OUTPUT_EFFECT_EXAMPLES["spring"][quantity].strip("{ }")
        alternative = f", or {join_names(WIRE_KEYS)}" if quantity == "length" else ""
        raise MechanismError(f"{key_path}: rate is missing; write {rate_example}{alternative}")


def parse_dry_friction(reading: str, quantity: str, value: Any, key_path: str) -> Effect:
    """Dry friction: a force or moment, or a program of them."""
    kind, kind_name = ("force", "force") if quantity == "length" else ("torque", "moment")
    times, forces = parse_time_points(value, kind, kind_name, key_path)
    negative_points = [number for number, force in enumerate(forces, start=1) if force < 0]
    if negative_points:
        point_label = f", point {negative_points[0]}:" if isinstance(value, list | tuple) else ""
        found_text = format_value(value[negative_points[0] - 1][1] if point_label else value)
        raise MechanismError(f"{key_path}{point_label} must not be negative, friction opposes either way; found {found_text}")
    return DryFriction(reading=reading, force=prefix_errors(key_path, lambda: InputFunction(times=times, values=forces)))


def parse_dashpot(reading: str, quantity: str, value: Any, key_path: str) -> Effect:
    """An dashpot: a damping alone, or a table of its parts."""
    if not isinstance(value, Mapping):
        kind = "damping" if quantity == "length" else "torsion_damping"
        return Dashpot(reading=reading, linear=parse_bounded_quantity(value, kind, key_path, hint="; leave it out if there is none"))
    parsed = parse_effect_table(DASHPOT_TABLES[quantity], value, key_path, "")
    _check_dashpot_keys(parsed, quantity, key_path)
    if "piston" in parsed:
        orifice = {key: parsed[key] for key in (*ORIFICE_KEYS, "screw") if key in parsed}
        density = {"density": parsed["oil"]} if "oil" in parsed else {}
        parsed["quadratic"] = prefix_errors(key_path, lambda: orifice_damping_coefficient(**orifice, **density))
    coefficients = {key: parsed[key] for key in ("linear", "quadratic") if key in parsed}
    return prefix_errors(key_path, lambda: Dashpot(reading=reading, **coefficients))


def _check_dashpot_keys(parsed: Mapping[str, Any], quantity: str, key_path: str) -> None:
    """Quadratic parts given twice, in part, or of a piston that would have to turn."""
    given_keys = [key for key in (*ORIFICE_KEYS, "screw", "oil") if key in parsed]
    if given_keys and "quadratic" in parsed:
        raise MechanismError(
            f"{key_path}: quadratic cannot stand beside {join_names(given_keys)}, from which it follows; leave one of the two out"
        )
    if given_keys and quantity == "angle":
        raise MechanismError(
            f'{key_path} is an angle, whose dashpot has no {join_names(given_keys)}; write quadratic = "0.3 N m s^2/rad^2"'
        )
    missing_keys = [key for key in ORIFICE_KEYS if key not in parsed]
    if given_keys and missing_keys:
        raise MechanismError(f"{key_path} lacks {join_names(missing_keys)}; oil through a hole needs {join_names(ORIFICE_KEYS)}")


def parse_stops(value: Any, quantity: str, key_path: str) -> tuple[float, float]:
    """The low and the high end of stops; infinite where there is none."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise MechanismError(
            f'{key_path} must be [low, high], an end that is not there "{NO_STOP}"; found {format_value(value)}; '
            f"write {OUTPUT_EFFECT_EXAMPLES['stops'][quantity]}"
        )
    ends: list[float] = []
    problems: list[str] = []
    for end, end_name, default in ((value[0], "low end", -math.inf), (value[1], "high end", math.inf)):
        try:
            ends.append(default if end == NO_STOP else parse_si(end, quantity, f"{key_path}, {end_name}"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    low, high = ends
    if math.isinf(low) and math.isinf(high):
        raise MechanismError(f'{key_path} needs a low or a high end; found "{NO_STOP}" for both; leave {key_path} out')
    if not low < high:
        raise MechanismError(
            f"{key_path} must have its low end first and below the high one; found {format_value(value[0])} and {format_value(value[1])}"
        )
    return low, high
