"""Harmonics of a scene file, of the time and of an angle, and lists of tables. Slow to import: pydantic."""

from functools import cache
from itertools import count
from typing import Annotated, ClassVar

from pydantic import Field, PlainValidator

from governor_mechanism.model.time_functions import AngleHarmonic, Harmonic
from governor_mechanism.scenes.problems import KEY, parse_each, wrong_value
from governor_mechanism.scenes.quantities import Angle, quantity
from governor_mechanism.scenes.schema_validator import TABLE, SchemaValidator, list_of
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import QUANTITY_KINDS

HarmonicClass = type[Harmonic]
AngleHarmonicClass = type[AngleHarmonic]
"""Classes of harmonics as types of fields."""


@cache
def harmonic_table(kind: str) -> type[SceneFileTable]:
    """Return the table of a harmonic amplitude * sin(2 pi * frequency * t + phase) of the time.

    Parameters
    ----------
    kind
        Kind of quantity of the amplitude.

    Returns
    -------
    type[SceneFileTable]
        The table.
    """
    written = QUANTITY_KINDS[kind].written_example

    class HarmonicTable(SceneFileTable):
        element: ClassVar[HarmonicClass] = Harmonic
        example = f'{{ amplitude = {written}, frequency = "2 Hz" }}'
        amplitude: Annotated[float, quantity(kind)] = Field(description=f"the amplitude, as {written}")
        frequency: Annotated[float, quantity("frequency", "positive")] = Field(
            description='the frequency in cycles, as "2 Hz" or "120 rpm", or the angular frequency, as "3 rad/s"'
        )
        phase: Angle = Field(0.0, description="the phase at 0 s")

    return HarmonicTable


@cache
def angle_harmonic_table(kind: str) -> type[SceneFileTable]:
    """Return the table of a harmonic amplitude * sin(order * angle + phase) of an angle.

    Parameters
    ----------
    kind
        Kind of quantity of the amplitude.

    Returns
    -------
    type[SceneFileTable]
        The table.
    """
    written = QUANTITY_KINDS[kind].written_example

    class AngleHarmonicTable(SceneFileTable):
        element: ClassVar[AngleHarmonicClass] = AngleHarmonic
        example = f"{{ amplitude = {written}, order = 2 }}"
        amplitude: Annotated[float, quantity(kind)] = Field(description=f"the amplitude, as {written}")
        order: Annotated[float, quantity("number", "not negative")] = Field(description="the cycles per turn of the angle, as 2")
        phase: Angle = Field(0.0, description="the phase where the angle is 0")

    return AngleHarmonicTable


def parse_table_list(model: type[SceneFileTable], value: object, noun: str, path: str = KEY) -> tuple[SceneFileTable, ...]:
    """Return the tables of a list; `noun` is what one of them is."""
    if not isinstance(value, list | tuple):
        raise wrong_value(value, f"must be a list, as [{model.example}]", path=path)
    return tuple(parse_each(lambda item, number: validate(model, item, f"{path}, {noun} {number}:"), value, count(1)))


def table_list(model: type[SceneFileTable], noun: str) -> PlainValidator:
    """Return the validator of a list of tables, see `parse_table_list`."""
    return SchemaValidator(lambda value: parse_table_list(model, value, noun), json_schema=list_of(TABLE))
