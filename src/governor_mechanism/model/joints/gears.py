"""Joints that relate two motions: gear pair, rack and pinion, and the massless linkage between two displacements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints.base import (
    GROUND,
    AngleRatio,
    ConstraintRow,
    FirstConfiguration,
    Glyph,
    ImpulsePart,
    Joint,
    RowKind,
    direction,
)
from governor_mechanism.units.fields import entry, quantity


@dataclass(frozen=True, kw_only=True)
class Gear(Joint):
    """A gear pair: the angle of the second body is ratio * angle of the first + offset. It removes one degree of freedom.

    Both angles are measured from the carrier, which holds the axes of both wheels. The points only give the centres of the wheels.

    Attributes
    ----------
    ratio
        Ratio of the angles; negative for external teeth, not 0.
    offset
        Angle of the second body at zero angle of the first, rad.
    carrier
        Name of the body that carries the wheels, as the arm of an epicyclic gear; by default the ground.
    """

    type_name = "gear"
    joins_bodies = True
    glyphs = frozenset((Glyph.WHEELS,))

    ratio: float = quantity(
        "ratio",
        sign="not zero",
        built=True,
        meaning="the rotation of the second body per rotation of the first; negative for external gears",
    )
    offset: float = quantity(
        "angle",
        sign="any",
        default=0.0,
        meaning="the angle of the second body where the first has none; by default that of the initial configuration",
    )

    carrier: str = entry(
        "body", default=GROUND, meaning='the body that carries both wheels, as the arm of an epicyclic gear; by default "ground"'
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ratio == 0.0:
            raise MechanismError(f"ratio of gear {self.name!r} must not be 0; to fix a body use a weld")
        if self.is_carried and self.carrier in (self.first.body, self.second.body):
            raise MechanismError(
                f"gear {self.name!r} has {self.carrier!r} as a wheel and as its carrier; the carrier is a third body, or left out"
            )

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of both wheels, and of the carrier if it is not the ground."""
        return (*super().bodies, self.carrier) if self.is_carried else super().bodies

    @property
    def is_carried(self) -> bool:
        """Whether a body other than the ground carries the wheels."""
        return self.carrier != GROUND

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the offset."""
        relative_angle = first_configuration.relative_angle(given["first"], given["second"], given["ratio"])
        return {"offset": relative_angle + (given["ratio"] - 1.0) * first_configuration.poses[given["carrier"]][2]}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        factors = {"first_angle_factor": -length_scale * self.ratio, "second_angle_factor": length_scale}
        if self.is_carried:
            factors["third_angle_factor"] = length_scale * (self.ratio - 1.0)
        return [ConstraintRow(RowKind.FIXED_DIRECTION, {**factors, "constant": length_scale * self.offset}, third=self.carrier)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (AngleRatio(self.ratio, self.offset),)


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
