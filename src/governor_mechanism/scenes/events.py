"""The table [events]: named crossings of readings and speeds. Slow to import: pydantic."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final

from pydantic import Field, ValidationInfo

from governor_mechanism.model.events import CROSSING_DIRECTIONS, NamedCrossing
from governor_mechanism.model.speeds import GIVEN_SPEED_CLAUSE
from governor_mechanism.scenes.effect_tables import ReadingQuantities, resolve_reading_name
from governor_mechanism.scenes.problems import KEY, ProblemCode, ProblemCollector, mistake, wrong_value
from governor_mechanism.scenes.quantities import choice, parse_first_fitting, parse_name, parse_si
from governor_mechanism.scenes.schema_validator import NUMBER_OR_TEXT, TEXT, SchemaValidator
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value

WATCHED_KINDS: Final = ("length", "angle", "angular_speed")
"""Kinds of quantities that a named crossing may watch."""


@dataclass(frozen=True)
class WatchedReadings:
    """What a named crossing may watch.

    Attributes
    ----------
    quantities
        Quantities of readings and speeds by name; None while they are not known.
    given_speeds
        Names of speeds that are given, which no crossing may watch.
    """

    quantities: ReadingQuantities
    given_speeds: frozenset[str] = frozenset()


def join_watched_readings(watched: Mapping[str, WatchedReadings | None]) -> WatchedReadings:
    """Return what a crossing may watch in all parts, by the start of the names of each part."""
    known = {prefix: one for prefix, one in watched.items() if one is not None}
    quantities = {f"{prefix}{name}": kind for prefix, one in known.items() for name, kind in (one.quantities or {}).items()}
    return WatchedReadings(quantities, frozenset(f"{prefix}{name}" for prefix, one in known.items() for name in one.given_speeds))


def _parse_reading(value: object, info: ValidationInfo) -> str:
    if not isinstance(value, str):
        raise wrong_value(value, "must be the name of a reading")
    watched: Any = info.context
    path = f"{KEY} {format_value(value)}"
    if value in watched.given_speeds:
        raise mistake(ProblemCode.CONFLICT, f"{path} is {GIVEN_SPEED_CLAUSE}")
    return resolve_reading_name(value, watched.quantities, path)


def _parse_value(value: object, info: ValidationInfo) -> float:
    """Return the value in the unit of the reading, or in any if the reading has a mistake."""
    watched: Any = info.context
    quantities = watched.quantities if "reading" in info.data else None
    kinds = WATCHED_KINDS if quantities is None else (quantities[info.data["reading"]],)
    return parse_first_fitting(kinds, lambda quantity: parse_si(value, quantity))[1]


class CrossingTable(SceneFileTable):
    """[events.name]."""

    example = '{ reading = "sleeve_lift", value = "20 mm", direction = "up" }'

    reading: Annotated[str, SchemaValidator(_parse_reading, json_schema=TEXT)] = Field(
        description='the reading or speed that is watched, as "arm_angle" or "engine.shaft_speed"'
    )
    value: Annotated[float, SchemaValidator(_parse_value, json_schema=NUMBER_OR_TEXT)] = Field(
        description='the value that the reading passes, as "20 mm"'
    )
    direction: Annotated[str, choice(CROSSING_DIRECTIONS)] = Field(
        NamedCrossing.direction, description="whether the reading rises or falls through the value, or either"
    )


def parse_crossings(table: object, watched: WatchedReadings, collector: ProblemCollector) -> tuple[NamedCrossing, ...]:
    """Return the named crossings without mistakes of [events]; anything but a table is reported with the top level."""

    def parse_crossing(name: str, values: object) -> NamedCrossing:
        return NamedCrossing(name=parse_name(name), **validate(CrossingTable, values, context=watched).given_values())

    return tuple(collector.parse_tables("events", table, parse_crossing))
