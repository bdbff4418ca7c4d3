"""[events] of a scene file: named crossings of readings. Slow to import: pydantic."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, PlainValidator, ValidationInfo

from governor_mechanism.model.events import CROSSING_DIRECTIONS, NamedCrossing
from governor_mechanism.scenes.effect_tables import ReadingQuantities, parse_by_quantity, resolve_reading_name
from governor_mechanism.scenes.problems import KEY, ProblemCollector, wrong_value
from governor_mechanism.scenes.quantities import choice, parse_name, parse_si
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value


def _parse_reading(value: object, info: ValidationInfo) -> str:
    if not isinstance(value, str):
        raise wrong_value(value, "must be the name of a reading")
    return resolve_reading_name(value, info.context, f"{KEY} {format_value(value)}")


def _parse_value(value: object, info: ValidationInfo) -> float:
    """Return the value in the unit of the reading, or in any if the reading has a mistake."""
    reading = info.data.get("reading", "")
    return parse_by_quantity(reading, info.context if reading else None, lambda quantity: parse_si(value, quantity))


class CrossingTable(SceneFileTable):
    """[events.name]."""

    example = '{ reading = "sleeve_lift", value = "20 mm", direction = "up" }'

    reading: Annotated[str, PlainValidator(_parse_reading)] = Field(description='the reading that is watched, as "arm_angle"')
    value: Annotated[float, PlainValidator(_parse_value)] = Field(description='the value that the reading passes, as "20 mm"')
    direction: Annotated[str, choice(CROSSING_DIRECTIONS)] = NamedCrossing.direction


def parse_crossings(table: object, quantities: ReadingQuantities, collector: ProblemCollector) -> tuple[NamedCrossing, ...]:
    """Return the named crossings without mistakes of [events]; anything but a table is reported with the top level."""

    def parse_crossing(name: str, values: object) -> NamedCrossing:
        return NamedCrossing(name=parse_name(name), **validate(CrossingTable, values, context=quantities).given_values())

    return tuple(collector.parse_tables("events", table, parse_crossing))
