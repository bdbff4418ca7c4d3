"""The tables that all scenes have: top level, [spindle], [run], [dimensions] and [start]. Slow to import: pydantic."""

import dataclasses
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, Final

from pydantic import Field, PlainValidator, create_model

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.base import CHOICE_KIND, Machine
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import EQUILIBRIUM, FreeSpindle, Spindle, Start
from governor_mechanism.model.scene import RunSettings
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.scenes.loads import input_function, parse_load
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.quantities import choice, instance_of, number_between, parse_si, parse_time_points, quantity
from governor_mechanism.scenes.schema_validator import SchemaValidator, or_load, or_points, quantity_schema
from governor_mechanism.scenes.table import TOP_LEVEL_KEYS, SceneFileTable, Title, validate
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value

ENGINE_CHOICES: Final = ("auto", "impulse", "multibody", "reduced")
"""Engines that a scene file may name."""

CUSTOM_KEYS: Final = ("size", "plane", "ground", "body", "joint", "link", "force", "readings", "valve")
"""Keys that only a scene with a custom machine has."""

RATE_KINDS: Final = {"angle": "angular_rate", "length": "speed"}
"""Kind of the rate of a coordinate, by the quantity of the coordinate."""


AnyTable = Annotated[dict[str, Any] | None, instance_of(Mapping, "must be a table", f"; write [{KEY}] on a line of its own")]
"""Type of a field; the keys of the table are checked later."""


class CommonSceneTable(SceneFileTable):
    """The top level of any scene file."""

    machine: Annotated[str, choice((*MACHINES, CUSTOM_MACHINE))] = Field(description=f"one of {', '.join((*MACHINES, CUSTOM_MACHINE))}")
    title: Title = Field(None, description="the title in reports and films")
    effects: AnyTable = Field(None, description="the effects that act; what is not listed is not simulated")
    spindle: AnyTable = Field(None, description="the spindle with which the plane turns")
    start: AnyTable = Field(None, description="values and rates of readings at the start")
    run: AnyTable = Field(None, description="duration, output interval, accuracy and engine")
    events: AnyTable = Field(None, description="crossings of readings, by name")

    @classmethod
    def unknown_key(cls, key: str, value: object) -> str:
        """Return the message about an unknown key or table."""
        known_keys = list(cls.fields_by_key())
        is_list = isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)
        heading = f"[{key}]" if isinstance(value, Mapping) else f"[[{key}]]" if is_list else key
        custom_text = f' {key!r} belongs to machine = "{CUSTOM_MACHINE}".'
        table_text = " A custom machine has no dimensions; its lengths are given with its bodies."
        elsewhere = custom_text if key in CUSTOM_KEYS else table_text if key in TOP_LEVEL_KEYS else ""
        return f"{heading} is unknown; a scene file has {', '.join(known_keys)}.{did_you_mean(key, known_keys)}{elsewhere}"


class CoupledSceneTable(SceneFileTable):
    """The top level of a scene file with several parts."""

    title: Title = Field(None, description="the title in reports and films")
    run: AnyTable = Field(None, description="duration, output interval, accuracy and engine")
    events: AnyTable = Field(None, description="crossings of readings, by name")
    load: AnyTable = Field(None, description="the load on the shaft of an engine")
    part: AnyTable = Field(description="the parts, one table [part.NAME] for each")
    coupling: AnyTable = Field(None, description="what couples the parts, one table [coupling.NAME] for each")

    @classmethod
    def unknown_key(cls, key: str, value: object) -> str:
        """Return the message about an unknown key, or about a table that belongs to a part."""
        if key in TOP_LEVEL_KEYS:
            return f"{key} belongs to one of the parts in a scene of several; write it as part.NAME.{key}, under [part.NAME]"
        return super().unknown_key(key, value)


class SceneTable(CommonSceneTable):
    """The top level of a scene file with a machine that dimensions describe."""

    dimensions: AnyTable = Field(None, description="the dimensions of the machine")


def _parse_speed(value: object) -> Spindle:
    times, speeds = parse_time_points(value, "angular_speed", "speed")
    return Spindle(times=times, speeds=speeds)


class SpindleTable(SceneFileTable):
    """[spindle] with a given speed."""

    alternative_keys = ("inertia", "start_speed", "torque")
    alternative_hint = "give either speed, or inertia, start_speed and torque of a free spindle"

    speed: Annotated[Any, SchemaValidator(_parse_speed, json_schema=or_points(quantity_schema("angular_speed")))] = Field(
        description='the speed, as "120 rpm", or over time, as [[0, "120 rpm"], [5, "126 rpm"]]; '
        "a free spindle has inertia and start_speed instead"
    )
    speed_fluctuation: Annotated[float, number_between(0, 1, open_ends="high", reason=": it is (highest - lowest) / mean speed")] = Field(
        0.0, description="the coefficient of fluctuation of the speed, (highest - lowest) / mean, for a cyclic variation"
    )
    cycles_per_turn: Annotated[float, quantity("number", "positive")] = Field(1.0, description="the number of fluctuations in a turn")

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield cycles per turn without a fluctuation."""
        if "cycles_per_turn" in values and "speed_fluctuation" not in values:
            path, hint = f"{KEY}.cycles_per_turn", "write speed_fluctuation = 0.03, or leave cycles_per_turn out"
            yield Problem(f"{path} has no effect without a fluctuation; {hint}", ProblemCode.CONFLICT, path)

    def make_element(self, **arguments: Any) -> Spindle:
        """Return the spindle."""
        given: Spindle = self.speed
        return dataclasses.replace(given, speed_fluctuation=self.speed_fluctuation, cycles_per_turn=self.cycles_per_turn)


class FreeSpindleTable(SceneFileTable):
    """[spindle] of a free spindle."""

    element = FreeSpindle
    alternative_keys = ("speed", "speed_fluctuation", "cycles_per_turn")
    alternative_hint = "the speed of a free spindle follows from its torque; leave it out, or give spindle.speed"

    inertia: Annotated[float, quantity("moment_of_inertia", "not negative", bounded=True)] = Field(
        0.0, description="the moment of inertia of the spindle alone, without the governor"
    )
    start_speed: Annotated[float, quantity("angular_speed")] = Field(0.0, description="the speed at which a free spindle starts")
    torque: Annotated[Any, input_function("torque", "torque")] = Field(None, description="the torque on the spindle; none by default")

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield what a spindle lacks that is not coupled (the context) and whose torque depends on no reading."""
        if context or (isinstance(values.get("torque"), Mapping | list) and "start_speed" not in values):
            return
        for key, text in (
            ("inertia", 'the moment of inertia of the spindle alone, as "0.5 kg m^2"'),
            ("start_speed", 'the speed at which a free spindle starts, as "120 rpm"'),
        ):
            if key not in values:
                yield Problem(f"{KEY}.{key} is missing; it is {text}", ProblemCode.MISSING_KEY, f"{KEY}.{key}")


def parse_spindle(values: Mapping[str, Any], is_coupled: bool) -> Spindle | FreeSpindle:
    """Return the spindle of [spindle]; it is free if it has a key of a free one and no speed."""
    is_free = "speed" not in values and not FreeSpindleTable.model_fields.keys().isdisjoint(values)
    spindle: Spindle | FreeSpindle = validate(FreeSpindleTable if is_free else SpindleTable, values, context=is_coupled).make_element()
    return spindle


class RunTable(SceneFileTable):
    """[run]."""

    element = RunSettings
    duration: Annotated[float, quantity("time", "positive")] = Field(default=RunSettings.duration, description="the simulated time")
    output_interval: Annotated[float, quantity("time", "positive")] = Field(
        default=RunSettings.output_interval, description="the interval of the reported times"
    )
    accuracy: Annotated[float, number_between(0, 1, open_ends="low high", reason=", relative to the scale of each reading, as 1e-6")] = (
        Field(default=RunSettings.accuracy, description="the largest error, relative to the scale of each reading")
    )
    engine: Annotated[str, choice(ENGINE_CHOICES)] = Field(
        default=RunSettings.engine, description="the engine; auto takes the cheapest that can model the scene"
    )


@cache
def dimensions_table_model(machine: type[Machine]) -> type[SceneFileTable]:
    """Return the model of [dimensions] of a machine, from the declared fields of its class.

    Parameters
    ----------
    machine
        Class of the machine.

    Returns
    -------
    type[SceneFileTable]
        Model with one field per dimension, SI.
    """
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(machine):
        kind, description = field.metadata["kind"], field.metadata["meaning"]
        if kind == CHOICE_KIND:
            fields[field.name] = (Annotated[str, choice(field.metadata["words"])], Field(None, description=description))
            continue
        hint = f"; leave {field.name} out if there is none" if field.default is None else ""
        sign = "any" if field.metadata["signed"] else "positive"
        validator = _dimension_validator(field, kind, sign, hint)
        kind_name = QUANTITY_KINDS[kind].name.split(" ", 1)[1] if kind in QUANTITY_KINDS else kind
        default = ... if field.default is dataclasses.MISSING else None
        fields[field.name] = (Annotated[Any, validator], Field(default, description=f"the {kind_name} {description}"))
    return create_model("DimensionsTable", __base__=SceneFileTable, **fields)


def _dimension_validator(field: dataclasses.Field[Any], kind: str, sign: str, hint: str) -> PlainValidator:
    """Return the validator of a dimension: a quantity, one that changes with time, or a load."""
    if field.metadata["is_load"]:
        return _or_load(kind, sign, field.name)
    return _or_program(kind, sign) if field.metadata["is_program"] else _or_word(field.metadata["omission_word"], kind, sign, hint)


def _or_word(word: str, kind: str, sign: str = "any", hint: str = "", *, value_of_word: str | None = None) -> PlainValidator:
    """Return the validator of a quantity, or of a word (if there is one) that stands for `value_of_word`."""

    def check(value: object) -> float | str | None:
        """Return the quantity in SI, or what its word stands for."""
        if word and value == word:
            return value_of_word
        try:
            return parse_si(value, kind, sign=sign, hint=hint)
        except MechanismError as error:
            if not word:
                raise
            suggestion = f".{_suggest_equilibrium(value)}" if word == EQUILIBRIUM else ""
            raise mistake(ProblemCode.WRONG_QUANTITY, f'{error}; or write "{word}"{suggestion}') from error

    accepted = quantity_schema(kind, sign)
    return SchemaValidator(check, json_schema={"anyOf": [{"const": word}, accepted]} if word else accepted)


def _or_load(kind: str, sign: str, name: str) -> PlainValidator:
    """Return the validator of a quantity, or of what changes with time and readings."""

    def check(value: object) -> float | InputFunction:
        """Return the quantity in SI, or the function."""
        return parse_load(value, kind, name) if isinstance(value, list | tuple | Mapping) else parse_si(value, kind, sign=sign)

    return SchemaValidator(check, json_schema=or_load(quantity_schema(kind, sign)))


def _or_program(kind: str, sign: str) -> PlainValidator:
    """Return the validator of a quantity, or of a list of [time, quantity], which is a motion with rests."""

    def check(value: object) -> float | PrescribedMotion:
        """Return the quantity in SI, or the motion."""
        if not isinstance(value, list | tuple):
            return parse_si(value, kind, sign=sign)
        times, values = parse_time_points(value, kind, "value")
        return PrescribedMotion(times=times, values=values, has_rests=True)

    return SchemaValidator(check, json_schema=or_points(quantity_schema(kind, sign)))


def rate_key(coordinate: str) -> str:
    """Return the key of the rate of a coordinate: its last word is replaced by "rate"."""
    first, _, last = coordinate.rpartition("_")
    return f"{first or last}_rate"


@cache
def start_table_model(readings: tuple[tuple[str, str, str], ...]) -> type[SceneFileTable]:
    """Return the model of [start]; each reading has a name, a quantity ("angle" or "length") and the key of its rate."""
    fields: dict[str, Any] = {}
    for name, kind, rate in readings:
        fields[name] = (Annotated[Any, _or_word(EQUILIBRIUM, kind, value_of_word=EQUILIBRIUM)], EQUILIBRIUM)
        fields[rate] = (Annotated[Any, quantity(RATE_KINDS[kind])], 0.0)
    return create_model("StartTable", __base__=SceneFileTable, **fields)


def parse_start(table: object, readings: Mapping[str, tuple[str, str]], collector: ProblemCollector) -> Start:
    """Return the given start values and rates of readings, each with its quantity and the key of its rate."""
    model = start_table_model(tuple((name, quantity, rate) for name, (quantity, rate) in readings.items()))
    parsed = collector.attempt("start", validate, model, table)
    given = {} if parsed is None else parsed.given_values()
    rates = {name: given[rate] for name, (_, rate) in readings.items() if rate in given}
    return Start(values={name: given[name] for name in readings if name in given}, rates=rates)


def find_misspelt_equilibrium(values: Mapping[str, Any]) -> list[str]:
    """Return messages about a misspelt "equilibrium" in [start] of an unknown machine."""
    hints = {key: _suggest_equilibrium(value) for key, value in values.items() if value != EQUILIBRIUM}
    return [f"start.{key} {format_value(values[key])} is unknown.{hint}" for key, hint in hints.items() if hint]


def _suggest_equilibrium(value: object) -> str:
    return did_you_mean(value.lower(), [EQUILIBRIUM]) if isinstance(value, str) else ""
