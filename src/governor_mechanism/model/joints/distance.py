"""The massless link."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.model.joints.base import ConstraintRow, FirstConfiguration, FixedDistance, Glyph, ImpulsePart, Joint, RowKind
from governor_mechanism.units.fields import quantity
from governor_mechanism.units.problems import ProblemCode, mistake


@dataclass(frozen=True, kw_only=True)
class Distance(Joint):
    """A massless link: the two points keep their distance. It removes one degree of freedom.

    Attributes
    ----------
    length
        Distance of the points, m; positive.
    """

    noun = "link"
    glyphs = frozenset((Glyph.BAR, Glyph.PINS, Glyph.FEET))

    length: float = quantity("length", built=True, follows=True, meaning="the length; by default the initial distance of its ends")

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the distance of the ends."""
        distance = first_configuration.distance(given["first"], given["second"])
        if not given.get("length") and not distance:
            raise mistake(ProblemCode.MISSING_KEY, "length is missing, and the ends of the link coincide initially")
        return {"length": distance}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [ConstraintRow(RowKind.DISTANCE, {"constant": self.length})]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (FixedDistance(self.length),)
