"""The curved slot."""

from dataclasses import dataclass

from governor_mechanism.model.curves import Curve
from governor_mechanism.model.joints.base import Glyph, Joint
from governor_mechanism.model.joints.constraint_row import ConstraintRow, RowKind
from governor_mechanism.model.joints.impulse_parts import Guide, ImpulsePart
from governor_mechanism.units.fields import entry, quantity


@dataclass(frozen=True, kw_only=True)
class CurveSlot(Joint):
    """The second point moves on a curve y = curve(x) of the first body. It removes one degree of freedom.

    Attributes
    ----------
    curve
        Curve in axes with their origin at the first point.
    angle
        Direction of the curve's x axis, rad, anticlockwise from the x axis of the first body.
    """

    type_name = "curve"
    glyphs = frozenset((Glyph.SLOT, Glyph.PIN_IN_SLOT, Glyph.FOOT))

    curve: Curve = entry("curve", meaning="the curve y(x), as { coefficients = [0, 0, 5] } or { points = [[0, 0], [0.1, 0.05]] }")
    angle: float = quantity(
        "angle", sign="any", default=0.0, meaning="the direction of the x axis of the curve in the axes of the first body"
    )

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [ConstraintRow(RowKind.BODY_NORMAL, {"angle": self.angle}, curve=self.curve)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (Guide(self.angle, self.curve),)
