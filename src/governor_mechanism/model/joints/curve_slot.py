"""The curved slot."""

from dataclasses import dataclass

from governor_mechanism.model.curves import Curve, PolarCurve
from governor_mechanism.model.joints.base import ConstraintRow, Glyph, Guide, ImpulsePart, Joint, RowKind
from governor_mechanism.units.fields import entry, quantity


@dataclass(frozen=True, kw_only=True)
class CurveSlot(Joint):
    """The second point moves on a curve of the first body, y = curve(x) or a closed one. It removes one degree of freedom.

    Attributes
    ----------
    curve
        Curve in axes with their origin at the first point.
    angle
        Direction of the curve's x axis, or of angle 0 of a closed curve, rad, anticlockwise from the x axis of the first body.
    """

    type_name = "curve"
    glyphs = frozenset((Glyph.SLOT, Glyph.PIN_IN_SLOT, Glyph.FOOT))

    curve: Curve = entry(
        "curve",
        meaning="the curve y(x), as { coefficients = [0, 0, 5] } or { points = [[0, 0], [0.1, 0.05]] }, or a closed one about the first "
        'point: { closed = [[x, y], ...] }, { polar = [["0 deg", "50 mm"], ...] } or { radius = "50 mm", harmonics = [...] }',
    )
    angle: float = quantity(
        "angle", sign="any", default=0.0, meaning="the direction of the x axis of the curve in the axes of the first body"
    )

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        kind = RowKind.POLAR_CURVE if isinstance(self.curve, PolarCurve) else RowKind.BODY_NORMAL
        return [ConstraintRow(kind, {"angle": self.angle}, curve=self.curve)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (Guide(self.angle, self.curve),)
