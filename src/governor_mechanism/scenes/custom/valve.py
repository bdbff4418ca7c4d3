"""[valve] of a custom machine. Slow to import: pydantic."""

from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Final, NamedTuple

from pydantic import Field, ValidationInfo

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints import Joint, RotationalDriver
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.model.valve import ADMISSIONS, CENTRE_RULES, EQUAL_LEADS, Reverser, Valve
from governor_mechanism.scenes.effect_tables import ReadingQuantities, resolve_reading_name
from governor_mechanism.scenes.problems import KEY, ProblemCode, mistake, unknown_name, wrong_value
from governor_mechanism.scenes.quantities import check_label, choice, parse_si, quantity
from governor_mechanism.scenes.schema_validator import NUMBER_OR_TEXT, TABLE, TEXT, SchemaValidator
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value

_CRANK_HINT: Final = 'valve events need a crank that is driven; add a [[joint]] of type "driven_turn"'


class ValveContext(NamedTuple):
    """Readings of the mechanism, None if not all are known, and names of the drivers that turn a body."""

    readings: ReadingQuantities
    drivers: tuple[str, ...]


def _parse_length_reading(value: object, info: ValidationInfo[ValveContext]) -> str:
    """Return the name of a reading that is a length."""
    readings: ReadingQuantities = info.context.readings
    name = resolve_reading_name(check_label(value), readings, f"{KEY} {format_value(value)}")
    if readings is not None and readings[name] != "length":
        lengths = [other for other, kind in readings.items() if kind == "length"]
        text = f"{KEY} {format_value(value)} is an angle; it must be a length, as {' or '.join(lengths) or 'x of a point'}"
        raise mistake(ProblemCode.WRONG_QUANTITY, text)
    return name


def _parse_centre(value: object) -> float | str:
    """Return the reading in the centre of the valve's motion, or a rule for it."""
    if value in CENTRE_RULES:
        return str(value)
    try:
        return parse_si(value, "length")
    except MechanismError as error:
        rules = " or ".join(f'"{rule}"' for rule in CENTRE_RULES)
        raise mistake(ProblemCode.WRONG_QUANTITY, f"{error}; or write {rules}") from error


def _parse_driver(value: object, info: ValidationInfo[ValveContext]) -> str:
    """Return the name of a driver that turns a body."""
    if value not in info.context.drivers:
        raise unknown_name(f"{KEY} {format_value(value)} is no driver that turns a body; these are", value, info.context.drivers)
    return str(value)


def _parse_end(value: object) -> float | str:
    """Return the value of the reverser's key at one end; that key has its own units."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise wrong_value(value, 'must be a number in SI or a quantity, as "20 deg"')
    return value


class ReverserTable(SceneFileTable):
    """What reverses the gear."""

    element = Reverser
    example = '{ key = "joint.lever.motion.start", forward = "20 deg", back = "-20 deg" }'
    key: Annotated[str, SchemaValidator(check_label, json_schema=TEXT)] = Field(
        description='the key of this file that reverses the gear, as "joint.lever.motion.start"'
    )
    forward: Annotated[float | str, SchemaValidator(_parse_end, json_schema=NUMBER_OR_TEXT)] = Field(
        description='its value in full forward gear, as "20 deg"'
    )
    back: Annotated[float | str, SchemaValidator(_parse_end, json_schema=NUMBER_OR_TEXT)] = Field(
        description='its value in full back gear, as "-20 deg"'
    )


class ValveTable(SceneFileTable):
    """[valve]; the validation context is a `ValveContext`."""

    reading: Annotated[str, SchemaValidator(_parse_length_reading, json_schema=TEXT)] = Field(
        description="the reading of the valve's position, which grows away from the shaft"
    )
    steam_lap: Annotated[float, quantity("length", bounded=True)] = Field(
        description='the length by which the valve in its centre covers the edges that admit steam, as "24 mm"'
    )
    exhaust_lap: Annotated[float, quantity("length", bounded=True)] = Field(
        0.0, description="the length by which the valve in its centre covers the edges of the exhaust; negative leaves them open"
    )
    centre: Annotated[float | str, SchemaValidator(_parse_centre, json_schema=NUMBER_OR_TEXT)] = Field(
        EQUAL_LEADS, description=f"the reading in the centre of the valve's motion, or a rule: {', '.join(CENTRE_RULES)}"
    )
    piston: Annotated[str, SchemaValidator(_parse_length_reading, json_schema=TEXT)] = Field(
        "", description="the reading of the piston's position, which grows away from the shaft"
    )
    admission: Annotated[str, choice(ADMISSIONS)] = Field(Valve.admission, description="the edges of the valve over which steam enters")
    crank: Annotated[str, SchemaValidator(_parse_driver, json_schema=TEXT)] = Field(
        "", description="the name of the driver that turns the crank; by default the only one"
    )
    reverser: Annotated[Any, SchemaValidator(lambda value: validate(ReverserTable, value).make_element(), json_schema=TABLE)] = Field(
        None, description="what reverses the gear: { key, forward, back }, a key of the scene file and its values at the ends"
    )

    def make_element(self, **arguments: Any) -> Valve:
        """Return the valve."""
        own_keys = {"reading": "displacement", "piston": "piston_travel"}
        values = {"centre": self.centre, **self.given_values(), **arguments}
        return Valve(**{own_keys.get(name, name): value for name, value in values.items()})


def parse_valve(table: object, readings: Sequence[Reading] | None, joints: Iterable[Joint]) -> Valve:
    """Return the valve of [valve].

    Parameters
    ----------
    table
        The table as read from TOML.
    readings
        Readings of the mechanism, or None if not all are known.
    joints
        Joints of the mechanism.

    Returns
    -------
    Valve
        The valve, which names the driver of its crank.

    Raises
    ------
    MechanismError
        With a `Problem` for each mistake.
    """
    drivers = tuple(joint.name for joint in joints if isinstance(joint, RotationalDriver))
    quantities = None if readings is None else {reading.name: reading.quantity for reading in readings}
    parsed = validate(ValveTable, table, context=ValveContext(quantities, drivers))
    if not drivers:
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY}: {_CRANK_HINT}")
    if len(drivers) > 1 and not parsed.crank:
        names = ", ".join(map(repr, drivers))
        text = f"{KEY}.crank is missing: {names} turn bodies; name the driver of the crank, as crank = {format_value(drivers[0])}"
        raise mistake(ProblemCode.MISSING_KEY, text, key=f"{KEY}.crank")
    return parsed.make_element(crank=parsed.crank or drivers[0])
