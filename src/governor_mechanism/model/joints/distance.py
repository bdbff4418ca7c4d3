"""The massless link."""

from dataclasses import dataclass

from governor_mechanism.model.joints.base import Glyph, Joint
from governor_mechanism.model.joints.constraint_row import ConstraintRow, RowKind
from governor_mechanism.model.joints.impulse_parts import FixedDistance, ImpulsePart
from governor_mechanism.model.measured_fields import measured


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

    length: float = measured("m", positive=True)

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [ConstraintRow(RowKind.DISTANCE, {"constant": self.length})]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (FixedDistance(self.length),)
