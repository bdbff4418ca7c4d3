"""The prismatic joint: a slider that does not rotate."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.model.joints.base import ConstraintRow, FirstConfiguration, FixedAngle, Glyph, ImpulsePart, relative_angle_row
from governor_mechanism.model.joints.slider import Slider
from governor_mechanism.model.joints.weld import turn_field


@dataclass(frozen=True, kw_only=True)
class Prismatic(Slider):
    """A slider whose bodies keep their relative angle. It removes two degrees of freedom.

    Attributes
    ----------
    relative_angle
        Angle of the second body minus that of the first, rad.
    """

    noun = "prismatic joint"
    type_name = "prismatic"
    glyphs = frozenset((Glyph.GUIDE, Glyph.FOOT))

    relative_angle: float = turn_field()

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the relative angle."""
        return {"relative_angle": first_configuration.relative_angle(given["first"], given["second"])}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [*super().constraint_rows(length_scale), relative_angle_row(self.relative_angle, length_scale)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (*super().impulse_parts(), FixedAngle(self.relative_angle))
