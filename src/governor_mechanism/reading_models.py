"""What each table of a scene file may hold: one pydantic model per table, and its refusals as sentences.

Kept apart from `reading` because pydantic takes long to import.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, ValidationError, create_model
from pydantic_core import ErrorDetails

from governor_mechanism.effects import Centrifugal, Gravity
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines import MACHINES
from governor_mechanism.machines.dimensions import LARGEST, Machine
from governor_mechanism.scene import EQUILIBRIUM, FASTEST, Spindle
from governor_mechanism.units import KINDS, parse, shown

ENGINES: Final = ("auto", "impulse", "multibody")
"""The engines that a scene file may name."""

RATE_KINDS: Final = {"angle": "angular_rate", "length": "speed"}
"""The kind of a coordinate's rate, by the quantity of the coordinate."""

BARE_LIMITS: Final = {"length": (50.0, LARGEST), "mass": (1e6, LARGEST), "angular_speed": (1e3, FASTEST)}
"""In SI by kind: above what a bare number is taken for a slip of units, and where the refusals of any number begin."""


class Table(BaseModel):
    """A table of a scene file; keys it does not list are refused."""

    model_config = ConfigDict(extra="forbid", protected_namespaces=())

    def given(self) -> dict[str, Any]:
        """The keys that stand in the file, in the order of this class, as they were understood."""
        return {name: getattr(self, name) for name in type(self).model_fields if name in self.model_fields_set}


def _si(value: object, kind: str, where: str) -> float:
    """The value in SI; refuses a bare number far outside anything built, where a unit would settle what is meant."""
    number = parse(value, kind, where)
    slip, refused = BARE_LIMITS.get(kind, (LARGEST, LARGEST))
    if not isinstance(value, str) and slip < abs(number) <= refused:
        written, units = f"{number:.12g}", KINDS[kind]
        raise MechanismError(
            f"{where} = {written} is {written} {units.si}; "
            f'write "{written} {units.units[0]}" if that is meant, or "{written} {units.si}"'
        )
    return number


def _quantity(kind: str, where: str, *, positive: bool = False, cure: str = "") -> PlainValidator:
    """A quantity in SI; `cure` is said about one that ought to be positive and is not."""

    def convert(value: object) -> float:
        if positive and parse(value, kind, where) <= 0:
            raise MechanismError(f"{where} must be positive; found {shown(value)}{cure}")
        return _si(value, kind, where)

    return PlainValidator(convert)


def _table(name: str) -> PlainValidator:
    def convert(value: object) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise MechanismError(f"{name} must be a table; found {shown(value)}; write [{name}] on a line of its own")
        return dict(value)

    return PlainValidator(convert)


def _one_of(names: Mapping[str, object] | tuple[str, ...], what: str) -> PlainValidator:
    def convert(value: object) -> str:
        if isinstance(value, str) and value in names:
            return value
        near = did_you_mean(value, names) if isinstance(value, str) else ""
        raise MechanismError(f"{what} {shown(value)} is unknown; known are {listed(names)}.{near}")

    return PlainValidator(convert)


def _title(value: object) -> str:
    if not isinstance(value, str):
        raise MechanismError(f'title must be text; found {shown(value)}; write title = "..."')
    return value


def _gravity(value: object) -> Gravity | None:
    if isinstance(value, bool):
        return Gravity() if value else None
    try:
        acceleration = parse(value, "acceleration", "effects.gravity")
    except MechanismError as error:
        raise MechanismError(f"{error}; gravity may also be true (9.81 m/s^2) or false") from error
    if acceleration <= 0:
        raise MechanismError(
            f"effects.gravity must be positive; found {shown(value)}; write gravity = false for a scene without weights"
        )
    return Gravity(acceleration=acceleration)


def _centrifugal(value: object) -> Centrifugal | None:
    if not isinstance(value, bool):
        raise MechanismError(f"effects.centrifugal must be true or false; found {shown(value)}")
    return Centrifugal() if value else None


def _speed(value: object) -> Spindle:
    """A speed, or a program of [time, speed]; every wrong point is told."""
    if not isinstance(value, list | tuple):
        return Spindle(speeds=(_si(value, "angular_speed", "spindle.speed"),))
    points: list[tuple[float, float]] = []
    problems: list[str] = []
    for number, point in enumerate(value, start=1):
        try:
            points.append(_point(point, f"spindle.speed, point {number}:"))
        except MechanismError as error:
            problems += error.problems
    if not value:
        problems.append('spindle.speed is an empty program; write [[0, "120 rpm"]], or one speed')
    if problems:
        raise MechanismError(*problems)
    try:
        return Spindle(times=tuple(time for time, _ in points), speeds=tuple(speed for _, speed in points))
    except MechanismError as error:
        raise MechanismError(*(f"spindle.speed: {problem}" for problem in error.problems)) from error


def _point(point: object, where: str) -> tuple[float, float]:
    if not isinstance(point, list | tuple) or len(point) != 2:
        raise MechanismError(f'{where} must be [time, speed]; found {shown(point)}; write [0, "120 rpm"]')
    values: list[float] = []
    problems: list[str] = []
    for value, kind, name in zip(point, ("time", "angular_speed"), ("time", "speed"), strict=True):
        try:
            values.append(_si(value, kind, f"{where} {name}"))
        except MechanismError as error:
            problems += error.problems
    if problems:
        raise MechanismError(*problems)
    return values[0], values[1]


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

    machine: Annotated[str, _one_of(MACHINES, "machine")] = Field(description=f"one of {', '.join(MACHINES)}")
    title: Annotated[str | None, PlainValidator(_title)] = None
    dimensions: Annotated[dict[str, Any] | None, _table("dimensions")] = None
    effects: Annotated[dict[str, Any] | None, _table("effects")] = None
    spindle: Annotated[dict[str, Any] | None, _table("spindle")] = None
    start: Annotated[dict[str, Any] | None, _table("start")] = None
    run: Annotated[dict[str, Any] | None, _table("run")] = None


class EffectsTable(Table):
    """[effects]: an Effect for each that is switched on, None for one switched off."""

    gravity: Annotated[Any, PlainValidator(_gravity)] = None
    centrifugal: Annotated[Any, PlainValidator(_centrifugal)] = None


class SpindleTable(Table):
    """[spindle]: the given speed as a Spindle."""

    speed: Annotated[Any, PlainValidator(_speed)] = Field(
        description='the speed, as "120 rpm", or a program, as [[0, "120 rpm"], [5, "126 rpm"]]'
    )


class RunTable(Table):
    """[run]: the arguments of RunSettings."""

    duration: Annotated[float, _quantity("time", "run.duration", positive=True)] = 0.0
    every: Annotated[float, _quantity("time", "run.every", positive=True)] = 0.0
    accuracy: Annotated[float, PlainValidator(_accuracy)] = 0.0
    engine: Annotated[str, _one_of(ENGINES, "run.engine")] = ""


@cache
def dimensions_table(machine: type[Machine]) -> type[Table]:
    """[dimensions] of a machine, from how its class declares them; values in SI."""
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(machine):
        kind, meaning = field.metadata["kind"], field.metadata["meaning"]
        cure = f"; leave {field.name} out if there is none" if field.default is None else ""
        check = _quantity(kind, f"dimensions.{field.name}", positive=not field.metadata["signed"], cure=cure)
        name = KINDS[kind].name.split(" ", 1)[1] if kind in KINDS else kind
        described = Field(
            default=... if field.default is dataclasses.MISSING else None, description=f"the {name} {meaning}"
        )
        fields[field.name] = (Annotated[Any, check], described)
    return create_model("DimensionsTable", __base__=Table, **fields)


def rate_key(coordinate: str) -> str:
    """The key of a coordinate's rate: its last word replaced by 'rate'."""
    first, _, last = coordinate.rpartition("_")
    return f"{first or last}_rate"


@cache
def start_table(coordinate: str, quantity: str) -> type[Table]:
    """[start] for a coordinate that is an 'angle' or a 'length'; values in SI, or EQUILIBRIUM."""
    key, rate = f"start.{coordinate}", rate_key(coordinate)

    def convert(value: object) -> float | str:
        if value == EQUILIBRIUM:
            return EQUILIBRIUM
        try:
            return _si(value, quantity, key)
        except MechanismError as error:
            raise MechanismError(f'{error}; or write "{EQUILIBRIUM}".{_equilibrium_meant(value)}') from error

    fields: dict[str, Any] = {
        coordinate: (Annotated[Any, PlainValidator(convert)], EQUILIBRIUM),
        rate: (Annotated[Any, _quantity(RATE_KINDS[quantity], f"start.{rate}")], 0.0),
    }
    return create_model("StartTable", __base__=Table, **fields)


def start_word_problems(values: Mapping[str, Any]) -> list[str]:
    """What can be told of [start] where the machine is unknown: a misspelt EQUILIBRIUM."""
    return [
        f"start.{key} {shown(value)} is unknown.{_equilibrium_meant(value)}"
        for key, value in values.items()
        if value != EQUILIBRIUM and _equilibrium_meant(value)
    ]


def _equilibrium_meant(value: object) -> str:
    return did_you_mean(value.lower(), [EQUILIBRIUM]) if isinstance(value, str) else ""


def understood(model: type[Table], values: object, table: str) -> tuple[dict[str, Any], list[str]]:
    """What the values given in a table mean, and a sentence for each mistake; `table` is '' for the top of the file."""
    try:
        return model.model_validate(values).given(), []
    except ValidationError as error:
        mistakes = error.errors(include_url=False)
    unknown = [str(mistake["loc"][-1]) for mistake in mistakes if mistake["type"] == "extra_forbidden"]
    misspelt = {near for key in unknown for near in difflib.get_close_matches(key, list(model.model_fields), n=1)}
    sentences: list[str] = []
    for mistake in mistakes:
        key = str(mistake["loc"][-1]) if mistake["loc"] else ""
        # A required key that is only misspelt is one mistake, told where the wrong spelling stands.
        if not (mistake["type"] == "missing" and key in misspelt):
            sentences += _sentences(mistake, key, model, table)
    return {}, sentences


def _sentences(mistake: ErrorDetails, key: str, model: type[Table], table: str) -> tuple[str, ...]:
    where = f"{table}.{key}" if table and key else key or table or "the scene"
    cause = mistake.get("ctx", {}).get("error")
    if isinstance(cause, MechanismError):
        return cause.problems
    if mistake["type"] == "missing":
        return (f"{where} is missing; it is {model.model_fields[key].description}",)
    if mistake["type"] == "extra_forbidden":
        return (_unknown(key, mistake["input"], model, table),)
    return (f"{where} cannot be read ({mistake['msg'].lower()}); found {shown(mistake['input'])}",)


def _unknown(key: str, value: object, model: type[Table], table: str) -> str:
    known = list(model.model_fields)
    if table and key in SceneTable.model_fields:
        cure = f" {key!r} stands above the first [table], or is a table of its own."
    else:
        cure = did_you_mean(key, known)
    if table:
        return f"{table}.{key} is unknown; known keys of [{table}] are {listed(known)}.{cure}"
    what = f"[{key}]" if isinstance(value, Mapping) else key
    return f"{what} is unknown; a scene file has {listed(known)}.{cure}"


def listed(names: Iterable[str]) -> str:
    """Names as a phrase for a message."""
    return ", ".join(names)
