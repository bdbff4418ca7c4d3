"""Joints that guide a point or a body: pin, slider, prismatic joint, weld, massless link, and slots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from governor_mechanism.model.curves import Curve, PolarCurve
from governor_mechanism.model.joints.base import (
    ConstraintRow,
    FirstConfiguration,
    FixedAngle,
    FixedDistance,
    Glyph,
    Guide,
    ImpulsePart,
    Joint,
    Pivot,
    RowKind,
    coincidence_rows,
    relative_angle_row,
)
from governor_mechanism.units.fields import entry, quantity
from governor_mechanism.units.problems import ProblemCode, mistake


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


turn_field = partial(
    quantity,
    "angle",
    sign="any",
    key="turn",
    default=0.0,
    meaning="the angle of the second body against the first; by default the initial one",
)
"""Declare the relative angle of two bodies that do not rotate against each other."""


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """A rigid connection: the points coincide and the relative angle is constant. It removes three degrees of freedom.

    Attributes
    ----------
    relative_angle
        Angle of the second body minus that of the first, rad.
    """

    type_name = "weld"
    glyphs = frozenset((Glyph.FEET,))

    relative_angle: float = turn_field()

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the relative angle."""
        return {"relative_angle": first_configuration.relative_angle(given["first"], given["second"])}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [*coincidence_rows(), relative_angle_row(self.relative_angle, length_scale)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (Pivot(), FixedAngle(self.relative_angle))


@dataclass(frozen=True, kw_only=True)
class Prismatic(Slider):
    """A slider whose bodies keep their relative angle. It removes two degrees of freedom.

    Attributes
    ----------
    relative_angle
        Angle of the second body minus that of the first, rad.
    """

    noun = "prismatic joint"
    type_name = "prismatic"
    glyphs = frozenset((Glyph.GUIDE, Glyph.FOOT))

    relative_angle: float = turn_field()

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the relative angle."""
        return {"relative_angle": first_configuration.relative_angle(given["first"], given["second"])}

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint; `length_scale` (m) converts angles to lengths."""
        return [*super().constraint_rows(length_scale), relative_angle_row(self.relative_angle, length_scale)]

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint."""
        return (*super().impulse_parts(), FixedAngle(self.relative_angle))


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
