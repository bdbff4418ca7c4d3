"""The massless linkage between two displacements."""

from dataclasses import dataclass

from governor_mechanism.model.joints.base import ConstraintRow, Joint, RowKind, direction
from governor_mechanism.units.fields import quantity


@dataclass(frozen=True, kw_only=True)
class ProportionalDisplacement(Joint):
    """A massless linkage: the displacement of the second point is ratio * displacement of the first + offset.

    Both displacements are measured in the plane along one direction. The joint removes one degree of freedom.

    Attributes
    ----------
    ratio
        Ratio of the displacements.
    angle
        Direction, rad, anticlockwise from the x axis of the plane.
    offset
        Displacement of the second point at zero displacement of the first, m.
    """

    noun = "proportion"

    ratio: float = quantity(sign="any")
    angle: float = quantity("angle", sign="any")
    offset: float = quantity("length", sign="any", default=0.0)

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        parameters = {"first_point_weight": self.ratio, "constant": self.offset}
        return [ConstraintRow(RowKind.FIXED_DIRECTION, direction(self.angle) | parameters)]
