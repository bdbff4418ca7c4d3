"""[valve] of a custom machine."""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from governor_mechanism.model.joints import Joint, RotationalDriver
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.model.valve import Reverser, Valve
from governor_mechanism.scenes import quantities
from governor_mechanism.scenes.effect_tables import ReadingQuantities, resolve_reading_name
from governor_mechanism.scenes.table import Table
from governor_mechanism.units.fields import Declaration
from governor_mechanism.units.problems import KEY, ProblemCode, mistake, unknown_name, wrong_value
from governor_mechanism.units.quantities import format_value

_CRANK_HINT: Final = 'valve events need a crank that is driven; add a [[joint]] of type "driven_turn"'


class ValveContext(NamedTuple):
    """Readings of the mechanism, None if not all are known, and names of the drivers that turn a body."""

    readings: ReadingQuantities
    drivers: tuple[str, ...]


def _read_length_reading(declared: Declaration, value: object, context: ValveContext) -> str:
    """Return the name of a reading that is a length."""
    readings = context.readings
    name = resolve_reading_name(quantities.check_label(value), readings, f"{KEY} {format_value(value)}")
    if readings is not None and readings[name] != "length":
        lengths = [other for other, kind in readings.items() if kind == "length"]
        text = f"{KEY} {format_value(value)} is an angle; it must be a length, as {' or '.join(lengths) or 'x of a point'}"
        raise mistake(ProblemCode.WRONG_QUANTITY, text)
    return name


def _read_driver(declared: Declaration, value: object, context: ValveContext) -> str:
    """Return the name of a driver that turns a body."""
    if value not in context.drivers:
        raise unknown_name(f"{KEY} {format_value(value)} is no driver that turns a body; these are", value, context.drivers)
    return str(value)


def _parse_end(value: object) -> float | str:
    """Return the value of the reverser's key at one end; that key has its own units."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise wrong_value(value, 'must be a number in SI or a quantity, as "20 deg"')
    return value


REVERSER: Final = Table.of(
    Reverser,
    types={**quantities.VALUE_TYPES, "end": quantities.without_context(_parse_end, quantities.NUMBER_OR_TEXT)},
    example='{ key = "joint.lever.motion.start", forward = "20 deg", back = "-20 deg" }',
)
"""What reverses the gear."""

VALVE: Final = Table.of(
    Valve,
    types={
        **quantities.VALUE_TYPES,
        "length reading": quantities.ValueType(_read_length_reading, quantities.TEXT),
        "centre": quantities.ValueType(quantities.read_declared_quantity, quantities.NUMBER_OR_TEXT),
        "driver": quantities.ValueType(_read_driver, quantities.TEXT),
        "reverser": quantities.without_context(REVERSER.build, quantities.TABLE),
    },
)
"""[valve]; its context is a `ValveContext`."""


def parse_valve(
    table: object,
    readings: Sequence[Reading] | None,  # readings of the mechanism, or None if not all are known
    joints: Iterable[Joint],
) -> Valve:
    """Return the valve of [valve].

    Result: the valve, which names the driver of its crank. Raises MechanismError with a `Problem` for each
    mistake.
    """
    drivers = tuple(joint.name for joint in joints if isinstance(joint, RotationalDriver))
    kinds = None if readings is None else {reading.name: reading.quantity for reading in readings}
    given = VALVE.read(table, ValveContext(kinds, drivers))
    if not drivers:
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY}: {_CRANK_HINT}")
    if len(drivers) > 1 and not given.get("crank"):
        names = ", ".join(map(repr, drivers))
        text = f"{KEY}.crank is missing: {names} turn bodies; name the driver of the crank, as crank = {format_value(drivers[0])}"
        raise mistake(ProblemCode.MISSING_KEY, text, key=f"{KEY}.crank")
    return Valve(**{**given, "crank": given.get("crank") or drivers[0]})
