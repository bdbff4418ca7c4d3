"""The circular slot."""

from dataclasses import dataclass

from governor_mechanism.model.joints.base import ConstraintRow, FixedDistance, Glyph, ImpulsePart, Joint, RowKind
from governor_mechanism.units.fields import quantity


@dataclass(frozen=True, kw_only=True)
class ArcSlot(Joint):
    """The second point moves in a circular slot of the first body about the first point. It removes one degree of freedom.

    Attributes
    ----------
    radius
        Radius of the slot, m; positive.
    """

    type_name = "arc"
    glyphs = frozenset((Glyph.SLOT, Glyph.PIN_IN_SLOT, Glyph.FOOT))

    radius: float = quantity("length", meaning='the radius of the slot, as "100 mm"')

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [ConstraintRow(RowKind.DISTANCE, {"constant": self.radius})]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (FixedDistance(self.radius),)
