"""The tables that all scenes have: top level, [spindle], [run], [dimensions] and [start]."""

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from functools import cache, partial
from typing import Any, Final

from governor_mechanism.errors import did_you_mean
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import EQUILIBRIUM, FreeSpindle, Spindle, Start
from governor_mechanism.model.scene import RunSettings
from governor_mechanism.scenes import quantities
from governor_mechanism.scenes.loads import LOAD_TYPES
from governor_mechanism.scenes.quantities import TOP_LEVEL_KEYS, Table, unknown_key_message
from governor_mechanism.units.fields import Declaration, declare, fields_of
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, ProblemCollector, wrong_value
from governor_mechanism.units.quantities import format_value

CUSTOM_KEYS: Final = ("size", "plane", "ground", "body", "joint", "link", "force", "contact", "readings", "valve", "assembly", "law")
"""Keys that only a scene with a custom machine has."""

RATE_KINDS: Final = {"angle": "angular_rate", "length": "speed"}
"""Kind of the rate of a coordinate, by the quantity of the coordinate."""


def _require_type(value: object, kind: Any, requirement: str, hint: str) -> object:
    if not isinstance(value, kind):
        raise wrong_value(value, requirement, hint)
    return value


_TABLE_HINT = f"; write [{KEY}] on a line of its own"
_LIST_HINT = f"; write [[{KEY}]] above each of them"
TOP_LEVEL_TYPES: Final[Mapping[str, quantities.ValueType]] = {
    **quantities.VALUE_TYPES,
    "title": quantities.without_context(partial(quantities.check_label, hint='; write title = "..."'), {}),
    "table": quantities.without_context(lambda value: _require_type(value, Mapping, "must be a table", _TABLE_HINT), {}),
    "tables": quantities.without_context(lambda value: _require_type(value, list | tuple, "must be a list of tables", _LIST_HINT), {}),
}
"""How the values of the top level are written; the keys of its tables are checked later."""


_table = partial(declare, "table", default=None)

_TITLE = declare("title", default=None, meaning="the title in reports and films")
_RUN = _table(meaning="duration, output interval, accuracy and engine")
_EVENTS = _table(meaning="crossings of readings, by name")
_NAMES = (*MACHINES, CUSTOM_MACHINE)
COMMON_FIELDS: Final[Mapping[str, Declaration]] = {
    "machine": declare("choice", words=_NAMES, meaning=f"one of {', '.join(_NAMES)}"),
    "title": _TITLE,
    "effects": _table(meaning="the effects that act; what is not listed is not simulated"),
    "spindle": _table(meaning="the spindle with which the plane turns"),
    "start": _table(meaning="values and rates of readings at the start"),
    "run": _RUN,
    "events": _EVENTS,
}
"""Keys of the top level of any scene file with one machine."""


def unknown_top_level_key(keys: Iterable[str], key: str, value: object) -> str:
    """Return the message about an unknown key or table of the top level."""
    known_keys = list(keys)
    is_list = isinstance(value, list | tuple) and bool(value) and all(isinstance(item, Mapping) for item in value)
    heading = f"[{key}]" if isinstance(value, Mapping) else f"[[{key}]]" if is_list else key
    custom_text = f' {key!r} belongs to machine = "{CUSTOM_MACHINE}".'
    elsewhere = custom_text if key in CUSTOM_KEYS else ""
    hint = f"{did_you_mean(key, known_keys)}{elsewhere}"
    return f"{heading} is unknown; a scene file has {', '.join(known_keys)}.{hint}"


def _unknown_coupled_key(keys: Iterable[str], key: str, value: object) -> str:
    """Return the message about an unknown key, or about a table that belongs to a part."""
    if key in TOP_LEVEL_KEYS:
        return f"{key} belongs to one of the parts in a scene of several; write it as part.NAME.{key}, under [part.NAME]"
    return unknown_key_message(keys, key, value)


TOP_LEVEL: Final = Table(
    make=dict,
    fields={**COMMON_FIELDS, "dimensions": _table(meaning="the dimensions of the machine")},
    types=TOP_LEVEL_TYPES,
    unknown_key=unknown_top_level_key,
)
"""The top level of a scene file with a machine that dimensions describe."""

COUPLED_TOP_LEVEL: Final = Table(
    make=dict,
    fields={
        "title": _TITLE,
        "run": _RUN,
        "events": _EVENTS,
        "load": _table(meaning="the load on the shaft of an engine"),
        "part": declare("table", meaning="the parts, one table [part.NAME] for each"),
        "coupling": _table(meaning="what couples the parts, one table [coupling.NAME] for each"),
    },
    types=TOP_LEVEL_TYPES,
    unknown_key=_unknown_coupled_key,
)
"""The top level of a scene file with several parts."""

RUN: Final = Table.of(RunSettings)
"""[run]."""


def _make_spindle(speed: Spindle, **given: Any) -> Spindle:
    return dataclasses.replace(speed, **given)


def _parse_speed(value: object) -> Spindle:
    times, speeds = quantities.parse_time_points(value, "angular_speed", "speed")
    return Spindle(times=times, speeds=speeds)


def _find_spindle_conflicts(values: Mapping[str, Any], context: object) -> Iterator[str]:
    """Yield cycles per turn without a fluctuation."""
    if "cycles_per_turn" in values and "speed_fluctuation" not in values:
        path = f"{KEY}.cycles_per_turn"
        hint = "write speed_fluctuation = 0.03, or leave cycles_per_turn out"
        yield Problem(f"{path} has no effect without a fluctuation; {hint}", ProblemCode.CONFLICT, path)


def _find_missing_keys(values: Mapping[str, Any], is_coupled: bool) -> Iterator[str]:
    """Yield what a spindle lacks that is not coupled and whose torque depends on no reading."""
    if is_coupled or (isinstance(values.get("torque"), Mapping | list) and "start_speed" not in values):
        return
    for key, text in (
        ("inertia", 'the moment of inertia of the spindle alone, as "0.5 kg m^2"'),
        ("start_speed", 'the speed at which a free spindle starts, as "120 rpm"'),
    ):
        if key not in values:
            yield Problem(f"{KEY}.{key} is missing; it is {text}", ProblemCode.MISSING_KEY, f"{KEY}.{key}")


_SPEED = declare(
    "speed",
    meaning='the speed, as "120 rpm", or over time, as [[0, "120 rpm"], [5, "126 rpm"]]; '
    "a free spindle has inertia and start_speed instead",
)
SPINDLE: Final = Table(
    make=_make_spindle,
    fields={"speed": _SPEED, **fields_of(Spindle)},
    types={
        **quantities.VALUE_TYPES,
        "speed": quantities.without_context(_parse_speed, quantities.or_points(quantities.quantity_schema("angular_speed"))),
    },
    find_conflicts=_find_spindle_conflicts,
    alternative_keys=tuple(fields_of(FreeSpindle)),
    alternative_hint="give either speed, or inertia, start_speed and torque of a free spindle",
)
"""[spindle] with a given speed."""

FREE_SPINDLE: Final = Table.of(
    FreeSpindle,
    types=LOAD_TYPES,
    find_conflicts=_find_missing_keys,
    alternative_keys=tuple(SPINDLE.fields),
    alternative_hint="the speed of a free spindle follows from its torque; leave it out, or give spindle.speed",
)
"""[spindle] of a free spindle."""


def parse_spindle(values: Mapping[str, Any], is_coupled: bool) -> Spindle | FreeSpindle:
    """Return the spindle of [spindle]; it is free if it has a key of a free one and no speed."""
    is_free = "speed" not in values and not FREE_SPINDLE.fields.keys().isdisjoint(values)
    spindle: Spindle | FreeSpindle = (FREE_SPINDLE if is_free else SPINDLE).build(values, is_coupled)
    return spindle


@cache
def dimensions_table(machine: type[Machine]) -> Table:
    """Return the table [dimensions] of a machine, with a key for each dimension that its class declares."""
    fields = {}
    for name, declared in fields_of(machine).items():
        meaning = f"the {declared.kind_and_meaning}" if declared.kinds else declared.meaning
        hint = f"; leave {name} out if there is none" if declared.default is None else ""
        fields[name] = dataclasses.replace(declared, meaning=meaning, hint=hint, noun=name)

    def make(**given: Any) -> Machine:
        """Return the machine; a word in place of a quantity leaves the dimension out."""
        left_out = {name for name, one in given.items() if one in fields[name].words and fields[name].form == "quantity"}
        return machine(**{name: None if name in left_out else one for name, one in given.items()})

    return Table(make=make, fields=fields, types=LOAD_TYPES)


def rate_key(coordinate: str) -> str:
    """Return the key of the rate of a coordinate: its last word is replaced by "rate"."""
    first, _, last = coordinate.rpartition("_")
    return f"{first or last}_rate"


@cache
def start_table(readings: tuple[tuple[str, str, str], ...]) -> Table:
    """Return the table [start]; each reading has a name, a quantity ("angle" or "length") and the key of its rate."""
    fields = {}
    for name, kind, rate in readings:
        fields[name] = declare("quantity", kind, sign="any", words=(EQUILIBRIUM,), default=EQUILIBRIUM)
        fields[rate] = declare("quantity", RATE_KINDS[kind], sign="any", default=0.0)
    return Table(make=dict, fields=fields)


def parse_start(table: object, readings: Mapping[str, tuple[str, str]], collector: ProblemCollector) -> Start:
    """Return the given start values and rates of readings, each with its quantity and the key of its rate."""
    own_table = start_table(tuple((name, quantity, rate) for name, (quantity, rate) in readings.items()))
    given = collector.attempt("start", own_table.read, table) or {}
    rates = {name: given[rate] for name, (_, rate) in readings.items() if rate in given}
    return Start(values={name: given[name] for name in readings if name in given}, rates=rates)


def find_misspelt_equilibrium(values: Mapping[str, Any]) -> list[str]:
    """Return messages about a misspelt "equilibrium" in [start] of an unknown machine."""
    hints = {key: quantities.suggest_equilibrium(value) for key, value in values.items() if value != EQUILIBRIUM}
    return [f"start.{key} {format_value(values[key])} is unknown.{hint}" for key, hint in hints.items() if hint]
