"""The table [events]: named crossings of readings and speeds."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.speeds import GIVEN_SPEED_CLAUSE
from governor_mechanism.scenes.effect_tables import ReadingQuantities, resolve_reading_name
from governor_mechanism.scenes.quantities import NUMBER_OR_TEXT, TEXT, VALUE_TYPES, ValueType, parse_first_fitting, parse_name, parse_si
from governor_mechanism.scenes.table import Table
from governor_mechanism.units.fields import Declaration
from governor_mechanism.units.problems import KEY, ProblemCode, ProblemCollector, mistake, wrong_value
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

    def resolve(self, name: object) -> str:
        """Return the name of a reading; refuse what is none, or none that a crossing may watch."""
        if not isinstance(name, str):
            raise wrong_value(name, "must be the name of a reading")
        path = f"{KEY} {format_value(name)}"
        if name in self.given_speeds:
            raise mistake(ProblemCode.CONFLICT, f"{path} is {GIVEN_SPEED_CLAUSE}")
        return resolve_reading_name(name, self.quantities, path)

    def kinds_of(self, name: object) -> tuple[str, ...]:
        """Return the kind of quantity of a reading; all that a crossing may watch if the reading is not known."""
        try:
            reading = self.resolve(name)
        except MechanismError:
            return WATCHED_KINDS
        return WATCHED_KINDS if self.quantities is None else (self.quantities[reading],)


def join_watched_readings(watched: Mapping[str, WatchedReadings | None]) -> WatchedReadings:
    """Return what a crossing may watch in all parts, by the start of the names of each part."""
    known = {prefix: one for prefix, one in watched.items() if one is not None}
    quantities = {f"{prefix}{name}": kind for prefix, one in known.items() for name, kind in (one.quantities or {}).items()}
    return WatchedReadings(quantities, frozenset(f"{prefix}{name}" for prefix, one in known.items() for name in one.given_speeds))


def _read_value(declared: Declaration, value: object, context: tuple[WatchedReadings, tuple[str, ...]]) -> float:
    """Return the value in the unit of the reading, or in any if the reading has a mistake."""
    return parse_first_fitting(context[1], lambda kind: parse_si(value, kind))[1]


CROSSING: Final = Table.of(
    NamedCrossing,
    types={
        **VALUE_TYPES,
        "watched reading": ValueType(lambda declared, value, context: context[0].resolve(value), TEXT),
        "watched value": ValueType(_read_value, NUMBER_OR_TEXT),
    },
    example='{ reading = "sleeve_lift", value = "20 mm", direction = "up" }',
)
"""[events.name]; its context is what a crossing may watch, and the kinds of its reading."""


def parse_crossings(table: object, watched: WatchedReadings, collector: ProblemCollector) -> tuple[NamedCrossing, ...]:
    """Return the named crossings without mistakes of [events]; anything but a table is reported with the top level."""

    def parse_crossing(name: str, values: object) -> NamedCrossing:
        own_name = parse_name(name)
        reading = values.get("reading") if isinstance(values, Mapping) else None
        crossing: NamedCrossing = CROSSING.build(values, (watched, watched.kinds_of(reading)), name=own_name)
        return crossing

    return tuple(collector.parse_tables("events", table, parse_crossing))
