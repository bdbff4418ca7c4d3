"""The translational driver."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.model.joints.base import FirstConfiguration, Glyph
from governor_mechanism.model.joints.constraint_row import ConstraintRow, RowKind
from governor_mechanism.model.joints.driver import Driver, motion_keys
from governor_mechanism.model.joints.impulse_parts import DrivenOffset, ImpulsePart
from governor_mechanism.units.fields import quantity


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
