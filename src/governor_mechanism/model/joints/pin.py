"""The pin: a revolute joint."""

from dataclasses import dataclass

from governor_mechanism.model.joints.base import ConstraintRow, Glyph, ImpulsePart, Joint, Pivot, coincidence_rows


@dataclass(frozen=True, kw_only=True)
class Pin(Joint):
    """A revolute joint: the two points coincide. It removes two degrees of freedom."""

    type_name = "pin"
    glyphs = frozenset((Glyph.PIN, Glyph.FEET))

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return coincidence_rows()

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (Pivot(),)
