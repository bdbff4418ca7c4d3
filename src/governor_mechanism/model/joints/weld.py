"""The weld: a rigid connection."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from governor_mechanism.model.joints.base import (
    ConstraintRow,
    FirstConfiguration,
    FixedAngle,
    Glyph,
    ImpulsePart,
    Joint,
    Pivot,
    coincidence_rows,
    relative_angle_row,
)
from governor_mechanism.units.fields import quantity

turn_field = partial(
    quantity,
    "angle",
    sign="any",
    key="turn",
    default=0.0,
    meaning="the angle of the second body against the first; by default the initial one",
)
"""Declare the relative angle of two bodies that do not rotate against each other."""


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """A rigid connection: the points coincide and the relative angle is constant. It removes three degrees of freedom.

    Attributes
    ----------
    relative_angle
        Angle of the second body minus that of the first, rad.
    """

    type_name = "weld"
    glyphs = frozenset((Glyph.FEET,))

    relative_angle: float = turn_field()

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the relative angle."""
        return {"relative_angle": first_configuration.relative_angle(given["first"], given["second"])}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [*coincidence_rows(), relative_angle_row(self.relative_angle, length_scale)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (Pivot(), FixedAngle(self.relative_angle))
