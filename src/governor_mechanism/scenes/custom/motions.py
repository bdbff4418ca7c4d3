"""Prescribed motions of a custom machine: tables of [time, value] and formulas. Slow to import: pydantic."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import Field, PlainValidator

from governor_mechanism.model.time_functions import Harmonic, PrescribedMotion
from governor_mechanism.scenes.custom.values import table_list
from governor_mechanism.scenes.problems import KEY, ProblemCode, mistake
from governor_mechanism.scenes.quantities import Angle, parse_pairs, quantity
from governor_mechanism.scenes.table import SceneFileTable, validate
from governor_mechanism.units.quantities import format_value

MotionBuilder = Callable[[float], PrescribedMotion]
"""Return the motion, for its value at 0 s (rad or m) where the file leaves the start out."""


class DisplacementHarmonicTable(SceneFileTable):
    """A harmonic of a displacement."""

    example = '{ amplitude = "10 mm", frequency = "2 Hz" }'
    amplitude: Annotated[float, quantity("length")] = Field(description='the amplitude, as "10 mm"')
    frequency: Annotated[float, quantity("frequency", "positive")] = Field(
        description='the frequency in cycles, as "2 Hz" or "120 rpm", or the angular frequency, as "3 rad/s"'
    )
    phase: Angle = 0.0


class AngleHarmonicTable(DisplacementHarmonicTable):
    """A harmonic of an angle."""

    example = '{ amplitude = "10 deg", frequency = "2 Hz" }'
    amplitude: Annotated[float, quantity("angle")] = Field(description='the amplitude, as "10 deg"')


class DisplacementFormulaTable(SceneFileTable):
    """A displacement start + rate * t + the sum of amplitude * sin(2 pi * frequency * t + phase)."""

    start: Annotated[float | None, quantity("length")] = None
    rate: Annotated[float, quantity("speed")] = 0.0
    harmonics: Annotated[tuple[Any, ...], table_list(DisplacementHarmonicTable, "harmonic")] = ()

    def build(self, value_at_zero: float) -> PrescribedMotion:
        """Return the motion; without a start it has the given value at 0 s."""
        harmonics = tuple(Harmonic(**table.given_values()) for table in self.harmonics)
        harmonics_at_zero = sum(item.amplitude * math.sin(item.phase) for item in harmonics)
        return PrescribedMotion.constant_rate(value_at_zero - harmonics_at_zero if self.start is None else self.start, self.rate, harmonics)


class AngleFormulaTable(DisplacementFormulaTable):
    """An angle by the same formula."""

    start: Annotated[float | None, quantity("angle")] = None
    rate: Annotated[float, quantity("angular_speed")] = 0.0
    harmonics: Annotated[tuple[Any, ...], table_list(AngleHarmonicTable, "harmonic")] = ()


def _motion_validator(kind: str, name: str, formula: type[DisplacementFormulaTable]) -> PlainValidator:
    """Return the validator of a motion given by points of [time, value] or by a formula."""

    def check(value: object) -> MotionBuilder:
        if isinstance(value, Mapping):
            return validate(formula, value).build
        if not isinstance(value, list | tuple):
            text = f"{KEY} must be a list of [time, {name}], or a formula {{ start, rate, harmonics = [...] }}; found {format_value(value)}"
            raise mistake(ProblemCode.WRONG_TYPE, text)
        points = parse_pairs(value, ("time", kind), ("time", name))
        motion = PrescribedMotion(times=tuple(time for time, _ in points), values=tuple(number for _, number in points))
        return lambda _: motion

    return PlainValidator(check)


AngleMotion = Annotated[Any, _motion_validator("angle", "angle", AngleFormulaTable)]
DisplacementMotion = Annotated[Any, _motion_validator("length", "displacement", DisplacementFormulaTable)]
"""Types of fields; the values are `MotionBuilder`."""
