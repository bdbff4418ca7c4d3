"""Prescribed motions of a custom machine by tables or formulas, and moving points of the ground. Slow to import: pydantic."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainValidator

from governor_mechanism.machines.custom import BodyShape, SketchedBody
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import GROUND, Joint, Point, TranslationalDriver
from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.model.time_functions import Harmonic, PrescribedMotion
from governor_mechanism.scenes.custom.values import table_list
from governor_mechanism.scenes.problems import KEY, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.quantities import Angle, parse_pairs, parse_si, quantity
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


def _parse_motion_table(value: object, kind: str, name: str) -> PrescribedMotion:
    points = parse_pairs(value, ("time", kind), ("time", name))
    return PrescribedMotion(times=tuple(time for time, _ in points), values=tuple(number for _, number in points))


def _motion_validator(kind: str, name: str, formula: type[DisplacementFormulaTable]) -> PlainValidator:
    """Return the validator of a motion given by points of [time, value] or by a formula."""

    def check(value: object) -> MotionBuilder:
        if isinstance(value, Mapping):
            return validate(formula, value).build
        if not isinstance(value, list | tuple):
            text = f"{KEY} must be a list of [time, {name}], or a formula {{ start, rate, harmonics = [...] }}; found {format_value(value)}"
            raise mistake(ProblemCode.WRONG_TYPE, text)
        motion = _parse_motion_table(value, kind, name)
        return lambda _: motion

    return PlainValidator(check)


def is_moving(position: object) -> bool:
    """Return whether a point of the ground is written with a coordinate that is a motion."""
    return isinstance(position, list | tuple) and any(isinstance(coordinate, Mapping | list | tuple) for coordinate in position)


def parse_moving_point(name: str, position: object) -> tuple[SketchedBody, list[Joint]]:
    """Return a moving point of the ground: a massless body, and the drivers of its coordinates.

    Parameters
    ----------
    name
        Name of the body.
    position
        Both coordinates as written: a length, a table or a formula.

    Returns
    -------
    SketchedBody
        The body where it is at 0 s.
    list of Joint
        Its drivers along x and y.
    """
    if not isinstance(position, list | tuple) or len(position) != 2:
        raise mistake(ProblemCode.WRONG_TYPE, f"{KEY} must be [x, y], each a length or a motion; found {format_value(position)}")
    collector, motions = ProblemCollector(), list[PrescribedMotion]()
    for coordinate, axis in zip(position, "xy", strict=True):
        with collector.at(f"{KEY} {axis}:"):
            motions.append(_parse_coordinate(coordinate))
    collector.raise_if_failed()
    x, y = (float(CubicTimeFunction(motion)(np.zeros(1))[0]) for motion in motions)
    starts, angles = (Point(body=GROUND, y=y), Point(body=GROUND, x=x)), (0.0, math.pi / 2)
    drivers: list[Joint] = [
        TranslationalDriver(name=f"{axis} of {name}", first=start, second=Point(body=name), motion=motion, angle=angle)
        for axis, start, motion, angle in zip("xy", starts, motions, angles, strict=True)
    ]
    return SketchedBody(name=name, mass=0.0, shape=BodyShape(second_moments=SecondMoments()), can_rotate=False, origin=(x, y)), drivers


def _parse_coordinate(value: object) -> PrescribedMotion:
    """Return the motion of a coordinate; a length is at rest."""
    if isinstance(value, Mapping):
        return validate(DisplacementFormulaTable, {"start": 0.0, **value}).build(0.0)
    if isinstance(value, list | tuple):
        return _parse_motion_table(value, "length", "displacement")
    return PrescribedMotion.constant_rate(parse_si(value, "length"), 0.0)


AngleMotion = Annotated[Any, _motion_validator("angle", "angle", AngleFormulaTable)]
DisplacementMotion = Annotated[Any, _motion_validator("length", "displacement", DisplacementFormulaTable)]
"""Types of fields; the values are `MotionBuilder`."""
