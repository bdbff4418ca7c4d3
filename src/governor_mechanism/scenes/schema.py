"""What each table of a scene file may hold: one pydantic model per table, and its refusals as sentences.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Final

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, ValidationError, ValidationInfo, create_model
from pydantic_core import ErrorDetails

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.base import CHOICE_KIND, Machine
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.scene import EQUILIBRIUM, Spindle
from governor_mechanism.scenes.quantities import (
    bounded_quantity_validator,
    choice_validator,
    join_names,
    key_path_of,
    parse_si,
    parse_time_points,
    prefix_errors,
    program_validator,
    quantity_validator,
    table_validator,
)
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, parse_quantity

ENGINE_CHOICES: Final = ("auto", "impulse", "multibody", "reduced")
"""The engines that a scene file may name."""

CUSTOM_KEYS: Final = ("size", "plane", "ground", "body", "joint", "link", "force", "readings")
"""What only a scene with a machine of the user's own has."""

RATE_KINDS: Final = {"angle": "angular_rate", "length": "speed"}
"""The kind of a coordinate's rate, by the quantity of the coordinate."""


class SceneFileTable(BaseModel):
    """A table of a scene file; keys it does not list are refused."""

    model_config = ConfigDict(extra="forbid", protected_namespaces=())
    alternative_keys: ClassVar[tuple[str, ...]] = ()
    """Keys that may stand in the same table of another scene, for messages."""

    def given_values(self) -> dict[str, Any]:
        """The keys that stand in the file, in the order of this class, as they were understood."""
        return {name: getattr(self, name) for name in type(self).model_fields if name in self.model_fields_set}


def _validate_title(value: object) -> str:
    if not isinstance(value, str):
        raise MechanismError(f'title must be text; found {format_value(value)}; write title = "..."')
    return value


def _validate_speed(value: object, info: ValidationInfo) -> Spindle:
    times, speeds = parse_time_points(value, "angular_speed", "speed", key_path_of(info))
    return prefix_errors(key_path_of(info), lambda: Spindle(times=times, speeds=speeds))


def _validate_speed_fluctuation(value: object, info: ValidationInfo) -> float:
    speed_fluctuation = parse_quantity(value, "ratio", key_path_of(info))
    if not 0 <= speed_fluctuation < 1:
        raise MechanismError(
            f"{key_path_of(info)} must be at least 0 and below 1: it is (highest - lowest) / mean speed; found {format_value(value)}"
        )
    return speed_fluctuation


def _validate_accuracy(value: object) -> float:
    accuracy = parse_quantity(value, "ratio", "run.accuracy")
    if not 0 < accuracy < 1:
        raise MechanismError(
            f"run.accuracy must lie above 0 and below 1 (it is relative to each reading's scale); found {format_value(value)}; write 1e-6"
        )
    return accuracy


class SceneTable(SceneFileTable):
    """The top of the file: what stands above the first table, and the tables."""

    machine: Annotated[str, choice_validator((*MACHINES, CUSTOM_MACHINE))] = Field(
        description=f"one of {join_names((*MACHINES, CUSTOM_MACHINE))}"
    )
    title: Annotated[str | None, PlainValidator(_validate_title)] = None
    dimensions: Annotated[dict[str, Any] | None, table_validator()] = None
    effects: Annotated[dict[str, Any] | None, table_validator()] = None
    spindle: Annotated[dict[str, Any] | None, table_validator()] = None
    start: Annotated[dict[str, Any] | None, table_validator()] = None
    run: Annotated[dict[str, Any] | None, table_validator()] = None


class SpindleTable(SceneFileTable):
    """[spindle] whose speed is given, as a Spindle."""

    alternative_keys = ("inertia", "start_speed", "torque")

    speed: Annotated[Any, PlainValidator(_validate_speed)] = Field(
        description='the speed, as "120 rpm", or a program, as [[0, "120 rpm"], [5, "126 rpm"]]; '
        "a spindle left to itself has inertia and start_speed instead"
    )
    speed_fluctuation: Annotated[float, PlainValidator(_validate_speed_fluctuation)] = 0.0
    cycles_per_turn: Annotated[float, quantity_validator("number", positive=True)] = 1.0


class FreeSpindleTable(SceneFileTable):
    """[spindle] that is left to itself: the arguments of FreeSpindle."""

    alternative_keys = ("speed", "speed_fluctuation", "cycles_per_turn")

    inertia: Annotated[float, bounded_quantity_validator("moment_of_inertia", sign="not negative")] = Field(
        description='the moment of inertia of the spindle alone, as "0.5 kg m^2"'
    )
    start_speed: Annotated[float, quantity_validator("angular_speed")] = Field(
        description='the speed with which a free spindle starts, as "120 rpm"'
    )
    torque: Annotated[Any, program_validator("torque", "torque")] = None


class RunTable(SceneFileTable):
    """[run]: the arguments of RunSettings."""

    duration: Annotated[float, quantity_validator("time", positive=True)] = 0.0
    output_interval: Annotated[float, quantity_validator("time", positive=True)] = 0.0
    accuracy: Annotated[float, PlainValidator(_validate_accuracy)] = 0.0
    engine: Annotated[str, choice_validator(ENGINE_CHOICES)] = ""


@cache
def dimensions_table_model(machine: type[Machine]) -> type[SceneFileTable]:
    """[dimensions] of a machine, from how its class declares them; values in SI."""
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(machine):
        kind, description = field.metadata["kind"], field.metadata["meaning"]
        if kind == CHOICE_KIND:
            fields[field.name] = (Annotated[str, choice_validator(field.metadata["words"])], Field(None, description=description))
            continue
        hint = f"; leave {field.name} out if there is none" if field.default is None else ""
        validator = quantity_validator(kind, positive=not field.metadata["signed"], hint=hint)
        if field.metadata["word"]:
            validator = _word_or_value_validator(validator, field.metadata["word"])
        kind_name = QUANTITY_KINDS[kind].name.split(" ", 1)[1] if kind in QUANTITY_KINDS else kind
        field_info = Field(default=... if field.default is dataclasses.MISSING else None, description=f"the {kind_name} {description}")
        fields[field.name] = (Annotated[Any, validator], field_info)
    return create_model("DimensionsTable", __base__=SceneFileTable, **fields)


def _word_or_value_validator(validator: PlainValidator, word: str) -> PlainValidator:
    """A check that a word passes as well, which stands for nothing given."""

    def validate(value: object, info: ValidationInfo) -> Any:
        if value == word:
            return None
        try:
            return validator.func(value, info)  # type: ignore[call-arg]
        except MechanismError as error:
            raise MechanismError(f'{error}; or write "{word}"') from error

    return PlainValidator(validate)


def rate_key(coordinate: str) -> str:
    """The key of a coordinate's rate: its last word replaced by 'rate'."""
    first, _, last = coordinate.rpartition("_")
    return f"{first or last}_rate"


@cache
def coordinate_start_table_model(coordinate: str, quantity: str) -> type[SceneFileTable]:
    """[start] for a coordinate that is an 'angle' or a 'length'; values in SI, or EQUILIBRIUM."""
    return start_table_model(((coordinate, quantity, rate_key(coordinate)),))


@cache
def start_table_model(readings: tuple[tuple[str, str, str], ...]) -> type[SceneFileTable]:
    """[start] for readings, each with its name, whether it is an 'angle' or a 'length', and the key of its rate."""
    fields: dict[str, Any] = {}
    for name, kind, rate in readings:
        fields[name] = (Annotated[Any, _start_value_validator(kind)], EQUILIBRIUM)
        fields[rate] = (Annotated[Any, quantity_validator(RATE_KINDS[kind])], 0.0)
    return create_model("StartTable", __base__=SceneFileTable, **fields)


def _start_value_validator(kind: str) -> PlainValidator:
    def validate(value: object, info: ValidationInfo) -> float | str:
        if value == EQUILIBRIUM:
            return EQUILIBRIUM
        try:
            return parse_si(value, kind, key_path_of(info))
        except MechanismError as error:
            raise MechanismError(f'{error}; or write "{EQUILIBRIUM}".{_equilibrium_hint(value)}') from error

    return PlainValidator(validate)


def find_misspelt_equilibrium(values: Mapping[str, Any]) -> list[str]:
    """What can be told of [start] where the machine is unknown: a misspelt EQUILIBRIUM."""
    return [
        f"start.{key} {format_value(value)} is unknown.{_equilibrium_hint(value)}"
        for key, value in values.items()
        if value != EQUILIBRIUM and _equilibrium_hint(value)
    ]


def _equilibrium_hint(value: object) -> str:
    return did_you_mean(value.lower(), [EQUILIBRIUM]) if isinstance(value, str) else ""


def validate_table(
    model: type[SceneFileTable], values: object, table_name: str, prefix: str | None = None
) -> tuple[dict[str, Any], list[str]]:
    """What the values given in a table mean, and a sentence for each mistake.

    `table` is '' for the top of the file, and "[body]" for one of the tables [[body]]; `prefix` is what messages put
    before a key, where it is not the table's name and a dot.
    """
    prefix = (f"{table_name}." if table_name else "") if prefix is None else prefix
    try:
        return model.model_validate(values, context=prefix).given_values(), []
    except ValidationError as error:
        errors = error.errors(include_url=False)
    unknown_keys = [str(detail["loc"][-1]) for detail in errors if detail["type"] == "extra_forbidden"]
    misspelt_keys = {near for key in unknown_keys for near in difflib.get_close_matches(key, list(model.model_fields), n=1)}
    messages: list[str] = []
    for detail in errors:
        key = str(detail["loc"][-1]) if detail["loc"] else ""
        # A required key that is only misspelt is one mistake, told where the wrong spelling stands.
        if not (detail["type"] == "missing" and key in misspelt_keys):
            messages += _error_messages(detail, key, model, table_name, prefix)
    return {}, messages


def _error_messages(detail: ErrorDetails, key: str, model: type[SceneFileTable], table_name: str, prefix: str) -> tuple[str, ...]:
    key_path = f"{prefix}{key}" if key else prefix.rstrip(".: ") or "the scene"
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, MechanismError):
        return cause.problems
    if detail["type"] == "missing":
        return (f"{key_path} is missing; it is {model.model_fields[key].description}",)
    if detail["type"] == "extra_forbidden":
        return (_unknown_key_message(key, detail["input"], model, table_name, key_path),)
    return (f"{key_path} cannot be read ({detail['msg'].lower()}); found {format_value(detail['input'])}",)


def _unknown_key_message(key: str, value: object, model: type[SceneFileTable], table_name: str, key_path: str) -> str:
    known_keys = [*model.model_fields, *model.alternative_keys]
    if table_name and not table_name.startswith("[") and key in SceneTable.model_fields:
        hint = f" {key!r} stands above the first [table], or is a table of its own."
    else:
        hint = did_you_mean(key, known_keys)
    if table_name:
        return f"{key_path} is unknown; known keys of [{table_name}] are {join_names(known_keys)}.{hint}"
    heading = f"[{key}]" if isinstance(value, Mapping) else f"[[{key}]]" if _is_table_list(value) else key
    return f"{heading} is unknown; a scene file has {join_names(known_keys)}.{hint}{_misplaced_key_hint(key, model)}"


def _is_table_list(value: object) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _misplaced_key_hint(key: str, model: type[SceneFileTable]) -> str:
    """Where a table of the other kind of scene belongs."""
    if "dimensions" in model.model_fields:
        return f' {key!r} belongs to machine = "{CUSTOM_MACHINE}".' if key in CUSTOM_KEYS else ""
    return " A machine of your own has none; its lengths stand with its bodies." if key == "dimensions" else ""
