"""Drivers, which turn a body or move a point: by a motion, or at a constant rate from a start."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from governor_mechanism.model.joints.base import (
    ConstraintRow,
    DrivenAngle,
    DrivenOffset,
    FirstConfiguration,
    Glyph,
    ImpulsePart,
    Joint,
    RowKind,
    relative_angle_row,
)
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.units.fields import Declaration, declare, quantity
from governor_mechanism.units.problems import Problem, ProblemCode


def motion_keys(rate: tuple[str, str], start: tuple[str, str], motion: tuple[str, str]) -> dict[str, Declaration]:
    """Return the keys of a driver in a scene file, each with its kind of quantity, or its form, and its meaning."""
    quantities = {
        name: declare("quantity", kind, sign="any", default=0.0, meaning=meaning)
        for name, (kind, meaning) in {"rate": rate, "start": start}.items()
    }
    return quantities | {"motion": Declaration(form=motion[0], default=None, meaning=motion[1])}


@dataclass(frozen=True, kw_only=True)
class Driver(Joint):
    """Base class of a joint that prescribes a motion.

    Attributes
    ----------
    motion
        What is prescribed over time, rad or m.
    """

    rate_example: ClassVar[str] = ""
    """How a scene file prescribes a motion, for messages."""

    motion: PrescribedMotion

    @classmethod
    def create(cls, **values: Any) -> Self:
        """Return a driver with a motion, by default at a constant rate from the start."""
        start = values.pop("start")
        rate = values.pop("rate", 0.0)
        motion = values.pop("motion", None)
        return cls(motion=motion(start) if motion else PrescribedMotion.constant_rate(start, rate), **values)

    @classmethod
    def find_conflicts(cls, given: Mapping[str, Any]) -> Iterator[str]:
        """Yield a motion given twice or not at all."""
        others = [key for key in ("rate", "start") if key in given]
        if "motion" in given and others:
            yield f"{' and '.join(others)} cannot be combined with motion, which is complete"
        if "motion" not in given and "rate" not in given:
            yield Problem(f"rate or motion is missing; write {cls.rate_example}", ProblemCode.MISSING_KEY)


@dataclass(frozen=True, kw_only=True)
class RotationalDriver(Driver):
    """A rotational driver: the angle of the second body minus that of the first follows a prescribed motion.

    Attributes
    ----------
    motion
        Relative angle over time, rad.
    """

    type_name = "driven_turn"
    joins_bodies = True
    rate_example = 'rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'
    keys = motion_keys(
        rate=("angular_speed", "the constant speed of the second body against the first; instead of motion"),
        start=("angle", "the relative angle at the start, with a rate; by default the initial one"),
        motion=("angle motion", "the relative angle over time: a list of [time, angle], or a start and a rate with harmonics"),
    )

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the start."""
        return {"start": first_configuration.relative_angle(given["first"], given["second"])}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [relative_angle_row(0.0, length_scale, self.motion)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (DrivenAngle(),)


@dataclass(frozen=True, kw_only=True)
class TranslationalDriver(Driver):
    """A translational driver: the displacement of the second point along a line of the first body follows a prescribed motion.

    The displacement is measured from the first point. Across the line the point is free.

    Attributes
    ----------
    motion
        Displacement over time, m.
    angle
        Direction of the line, rad, anticlockwise from the x axis of the first body.
    """

    noun = "driver"
    type_name = "driven_slide"
    rate_example = 'rate = "50 mm/s", or motion = [[0, "0 mm"], [1, "50 mm"]]'
    keys = motion_keys(
        rate=("speed", "the constant speed along the line; instead of motion"),
        start=("length", "the displacement at the start, with a rate; by default the initial one"),
        motion=("displacement motion", "the displacement over time: a list of [time, length], or a start and a rate with harmonics"),
    )
    glyphs = frozenset((Glyph.PATH,))

    angle: float = quantity("angle", sign="any", meaning='the direction of the line in the axes of the first body, as "0 deg"')

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the start."""
        first, second = given["first"], given["second"]
        return {"start": first_configuration.displacement_along(first, second, given["angle"], first.body)}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [ConstraintRow(RowKind.BODY_NORMAL, {"angle": self.angle - math.pi / 2}, self.motion)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (DrivenOffset(self.angle - math.pi / 2),)
