"""The slider: a point on a line of a body."""

from dataclasses import dataclass

from governor_mechanism.model.joints.base import ConstraintRow, Glyph, Guide, ImpulsePart, Joint, RowKind
from governor_mechanism.units.fields import quantity


@dataclass(frozen=True, kw_only=True)
class Slider(Joint):
    """The second point moves on a straight line of the first body. The joint removes one degree of freedom.

    Attributes
    ----------
    angle
        Direction of the line through the first point, rad, anticlockwise from the x axis of the first body.
    """

    type_name = "slider"
    glyphs = frozenset((Glyph.GUIDE, Glyph.PIN_ON_BLOCK, Glyph.FOOT))

    angle: float = quantity("angle", sign="any", meaning='the direction of the line in the axes of the first body, as "0 deg"')

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [ConstraintRow(RowKind.BODY_NORMAL, {"angle": self.angle})]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (Guide(self.angle),)
