"""The rack and its pinion."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints.base import ConstraintRow, FirstConfiguration, Glyph, Joint, RowKind, direction
from governor_mechanism.units.fields import quantity


@dataclass(frozen=True, kw_only=True)
class RackAndPinion(Joint):
    """A pinion, the first body, drives a rack: the displacement of the second point is radius * angle + offset.

    The displacement is measured from the first point, the centre of the pinion. The joint removes one degree of freedom.

    Attributes
    ----------
    radius
        Pitch radius, m; negative for the opposite direction, not 0.
    angle
        Direction of the displacement, rad, anticlockwise from the x axis of the plane.
    offset
        Displacement at zero angle of the pinion, m.
    """

    noun = "rack"
    type_name = "rack"
    joins_bodies = True
    glyphs = frozenset((Glyph.RACK,))

    radius: float = quantity(
        "length", sign="not zero", built=True, meaning='the radius of the pinion, as "20 mm"; negative for the opposite direction'
    )
    angle: float = quantity("angle", sign="any", default=0.0, meaning="the direction in which the rack moves")
    offset: float = quantity(
        "length",
        sign="any",
        default=0.0,
        meaning="the displacement of the rack where the pinion has no angle; by default that of the initial configuration",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.radius == 0.0:
            raise MechanismError(f"radius of rack {self.name!r} must not be 0")

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the offset."""
        displacement = first_configuration.displacement_along(given["first"], given["second"], given["angle"])
        return {"offset": displacement - given["radius"] * first_configuration.poses[given["first"].body][2]}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        parameters = {"first_angle_factor": -self.radius, "constant": self.offset}
        return [ConstraintRow(RowKind.FIXED_DIRECTION, direction(self.angle) | parameters)]
