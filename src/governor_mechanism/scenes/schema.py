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
from governor_mechanism.machines.base import CHOICE, Machine
from governor_mechanism.machines.custom import CUSTOM
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.scene import EQUILIBRIUM, Spindle
from governor_mechanism.scenes.quantities import (
    any_table,
    built,
    listed,
    located,
    one_of,
    points_in_time,
    program,
    quantity,
    si,
    where,
)
from governor_mechanism.units.quantities import KINDS, parse, shown

ENGINES: Final = ("auto", "impulse", "multibody", "reduced")
"""The engines that a scene file may name."""

CUSTOM_KEYS: Final = ("size", "plane", "ground", "body", "joint", "link", "force", "readings")
"""What only a scene with a machine of the user's own has."""

RATE_KINDS: Final = {"angle": "angular_rate", "length": "speed"}
"""The kind of a coordinate's rate, by the quantity of the coordinate."""


class Table(BaseModel):
    """A table of a scene file; keys it does not list are refused."""

    model_config = ConfigDict(extra="forbid", protected_namespaces=())
    also_known: ClassVar[tuple[str, ...]] = ()
    """Keys that may stand in the same table of another scene, for messages."""

    def given(self) -> dict[str, Any]:
        """The keys that stand in the file, in the order of this class, as they were understood."""
        return {name: getattr(self, name) for name in type(self).model_fields if name in self.model_fields_set}


def _title(value: object) -> str:
    if not isinstance(value, str):
        raise MechanismError(f'title must be text; found {shown(value)}; write title = "..."')
    return value


def _speed(value: object, info: ValidationInfo) -> Spindle:
    times, speeds = points_in_time(value, "angular_speed", "speed", where(info))
    return located(where(info), lambda: Spindle(times=times, speeds=speeds))


def _unevenness(value: object, info: ValidationInfo) -> float:
    unevenness = parse(value, "ratio", where(info))
    if not 0 <= unevenness < 1:
        raise MechanismError(
            f"{where(info)} must be at least 0 and below 1: it is (highest - lowest) / mean speed; found {shown(value)}"
        )
    return unevenness


def _accuracy(value: object) -> float:
    accuracy = parse(value, "ratio", "run.accuracy")
    if not 0 < accuracy < 1:
        raise MechanismError(
            f"run.accuracy must lie above 0 and below 1 (it is relative to each reading's scale); "
            f"found {shown(value)}; write 1e-6"
        )
    return accuracy


class SceneTable(Table):
    """The top of the file: what stands above the first table, and the tables."""

    machine: Annotated[str, one_of((*MACHINES, CUSTOM))] = Field(description=f"one of {listed((*MACHINES, CUSTOM))}")
    title: Annotated[str | None, PlainValidator(_title)] = None
    dimensions: Annotated[dict[str, Any] | None, any_table()] = None
    effects: Annotated[dict[str, Any] | None, any_table()] = None
    spindle: Annotated[dict[str, Any] | None, any_table()] = None
    start: Annotated[dict[str, Any] | None, any_table()] = None
    run: Annotated[dict[str, Any] | None, any_table()] = None


class SpindleTable(Table):
    """[spindle] whose speed is given, as a Spindle."""

    also_known = ("inertia", "start_speed", "torque")

    speed: Annotated[Any, PlainValidator(_speed)] = Field(
        description='the speed, as "120 rpm", or a program, as [[0, "120 rpm"], [5, "126 rpm"]]; '
        "a spindle left to itself has inertia and start_speed instead"
    )
    unevenness: Annotated[float, PlainValidator(_unevenness)] = 0.0
    waves: Annotated[float, quantity("number", positive=True)] = 1.0


class FreeSpindleTable(Table):
    """[spindle] that is left to itself: the arguments of FreeSpindle."""

    also_known = ("speed", "unevenness", "waves")

    inertia: Annotated[float, built("moment_of_inertia", sign="not negative")] = Field(
        description='the moment of inertia of the spindle alone, as "0.5 kg m^2"'
    )
    start_speed: Annotated[float, quantity("angular_speed")] = Field(
        description='the speed with which a free spindle starts, as "120 rpm"'
    )
    torque: Annotated[Any, program("torque", "torque")] = None


class RunTable(Table):
    """[run]: the arguments of RunSettings."""

    duration: Annotated[float, quantity("time", positive=True)] = 0.0
    every: Annotated[float, quantity("time", positive=True)] = 0.0
    accuracy: Annotated[float, PlainValidator(_accuracy)] = 0.0
    engine: Annotated[str, one_of(ENGINES)] = ""


@cache
def dimensions_table(machine: type[Machine]) -> type[Table]:
    """[dimensions] of a machine, from how its class declares them; values in SI."""
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(machine):
        kind, meaning = field.metadata["kind"], field.metadata["meaning"]
        if kind == CHOICE:
            fields[field.name] = (Annotated[str, one_of(field.metadata["words"])], Field(None, description=meaning))
            continue
        cure = f"; leave {field.name} out if there is none" if field.default is None else ""
        check = quantity(kind, positive=not field.metadata["signed"], cure=cure)
        if field.metadata["word"]:
            check = _or_word(check, field.metadata["word"])
        name = KINDS[kind].name.split(" ", 1)[1] if kind in KINDS else kind
        described = Field(
            default=... if field.default is dataclasses.MISSING else None, description=f"the {name} {meaning}"
        )
        fields[field.name] = (Annotated[Any, check], described)
    return create_model("DimensionsTable", __base__=Table, **fields)


def _or_word(check: PlainValidator, word: str) -> PlainValidator:
    """A check that a word passes as well, which stands for nothing given."""

    def convert(value: object, info: ValidationInfo) -> Any:
        if value == word:
            return None
        try:
            return check.func(value, info)  # type: ignore[call-arg]
        except MechanismError as error:
            raise MechanismError(f'{error}; or write "{word}"') from error

    return PlainValidator(convert)


def rate_key(coordinate: str) -> str:
    """The key of a coordinate's rate: its last word replaced by 'rate'."""
    first, _, last = coordinate.rpartition("_")
    return f"{first or last}_rate"


@cache
def start_table(coordinate: str, quantity: str) -> type[Table]:
    """[start] for a coordinate that is an 'angle' or a 'length'; values in SI, or EQUILIBRIUM."""
    return start_table_of(((coordinate, quantity, rate_key(coordinate)),))


@cache
def start_table_of(readings: tuple[tuple[str, str, str], ...]) -> type[Table]:
    """[start] for readings, each with its name, whether it is an 'angle' or a 'length', and the key of its rate."""
    fields: dict[str, Any] = {}
    for name, kind, rate in readings:
        fields[name] = (Annotated[Any, _start_value(kind)], EQUILIBRIUM)
        fields[rate] = (Annotated[Any, quantity(RATE_KINDS[kind])], 0.0)
    return create_model("StartTable", __base__=Table, **fields)


def _start_value(kind: str) -> PlainValidator:
    def convert(value: object, info: ValidationInfo) -> float | str:
        if value == EQUILIBRIUM:
            return EQUILIBRIUM
        try:
            return si(value, kind, where(info))
        except MechanismError as error:
            raise MechanismError(f'{error}; or write "{EQUILIBRIUM}".{_equilibrium_meant(value)}') from error

    return PlainValidator(convert)


def start_word_problems(values: Mapping[str, Any]) -> list[str]:
    """What can be told of [start] where the machine is unknown: a misspelt EQUILIBRIUM."""
    return [
        f"start.{key} {shown(value)} is unknown.{_equilibrium_meant(value)}"
        for key, value in values.items()
        if value != EQUILIBRIUM and _equilibrium_meant(value)
    ]


def _equilibrium_meant(value: object) -> str:
    return did_you_mean(value.lower(), [EQUILIBRIUM]) if isinstance(value, str) else ""


def understood(
    model: type[Table], values: object, table: str, prefix: str | None = None
) -> tuple[dict[str, Any], list[str]]:
    """What the values given in a table mean, and a sentence for each mistake.

    `table` is '' for the top of the file, and "[body]" for one of the tables [[body]]; `prefix` is what messages put
    before a key, where it is not the table's name and a dot.
    """
    prefix = (f"{table}." if table else "") if prefix is None else prefix
    try:
        return model.model_validate(values, context=prefix).given(), []
    except ValidationError as error:
        mistakes = error.errors(include_url=False)
    unknown = [str(mistake["loc"][-1]) for mistake in mistakes if mistake["type"] == "extra_forbidden"]
    misspelt = {near for key in unknown for near in difflib.get_close_matches(key, list(model.model_fields), n=1)}
    sentences: list[str] = []
    for mistake in mistakes:
        key = str(mistake["loc"][-1]) if mistake["loc"] else ""
        # A required key that is only misspelt is one mistake, told where the wrong spelling stands.
        if not (mistake["type"] == "missing" and key in misspelt):
            sentences += _sentences(mistake, key, model, table, prefix)
    return {}, sentences


def _sentences(mistake: ErrorDetails, key: str, model: type[Table], table: str, prefix: str) -> tuple[str, ...]:
    where = f"{prefix}{key}" if key else prefix.rstrip(".: ") or "the scene"
    cause = mistake.get("ctx", {}).get("error")
    if isinstance(cause, MechanismError):
        return cause.problems
    if mistake["type"] == "missing":
        return (f"{where} is missing; it is {model.model_fields[key].description}",)
    if mistake["type"] == "extra_forbidden":
        return (_unknown(key, mistake["input"], model, table, where),)
    return (f"{where} cannot be read ({mistake['msg'].lower()}); found {shown(mistake['input'])}",)


def _unknown(key: str, value: object, model: type[Table], table: str, where: str) -> str:
    known = [*model.model_fields, *model.also_known]
    if table and not table.startswith("[") and key in SceneTable.model_fields:
        cure = f" {key!r} stands above the first [table], or is a table of its own."
    else:
        cure = did_you_mean(key, known)
    if table:
        return f"{where} is unknown; known keys of [{table}] are {listed(known)}.{cure}"
    what = f"[{key}]" if isinstance(value, Mapping) else f"[[{key}]]" if _tables(value) else key
    return f"{what} is unknown; a scene file has {listed(known)}.{cure}{_elsewhere(key, model)}"


def _tables(value: object) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _elsewhere(key: str, model: type[Table]) -> str:
    """Where a table of the other kind of scene belongs."""
    if "dimensions" in model.model_fields:
        return f' {key!r} belongs to machine = "{CUSTOM}".' if key in CUSTOM_KEYS else ""
    return " A machine of your own has none; its lengths stand with its bodies." if key == "dimensions" else ""
