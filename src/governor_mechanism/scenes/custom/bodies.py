"""[[body]] of a custom machine, and the bodies and points to which its other tables refer. Slow to import: pydantic."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field, model_validator

from governor_mechanism.machines import custom
from governor_mechanism.machines.mass_elements import MassElement
from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.scenes.custom.field_types import NamedPoints, NewBodyName, PointRegistry
from governor_mechanism.scenes.harmonics import table_list
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, ProblemCollector, wrong_value
from governor_mechanism.scenes.quantities import Angle, Bool, Length, Mass, Position, PositiveLength, built
from governor_mechanism.scenes.table import SceneFileTable
from governor_mechanism.units.quantities import format_value


class MomentsTable(SceneFileTable):
    """Second moments of mass."""

    element = SecondMoments
    example = '{ xx = "0.5 kg m^2" }'
    xx: Annotated[float, built("moment_of_inertia", "not negative")] = Field(
        0.0, description="the integral of x^2 over the mass, about the mass centre"
    )
    yy: Annotated[float, built("moment_of_inertia", "not negative")] = Field(0.0, description="the integral of y^2 over the mass")
    xy: Annotated[float, built("moment_of_inertia", "any")] = Field(0.0, description="the integral of x y over the mass")
    zz: Annotated[float, built("moment_of_inertia", "not negative")] = Field(0.0, description="the integral of z^2 over the mass")

    @model_validator(mode="after")
    def _check_determinant(self) -> MomentsTable:
        if self.xy**2 > self.xx * self.yy * (1 + 1e-9):
            raise wrong_value(self.xy, "must not exceed the square root of xx * yy", code=ProblemCode.OUT_OF_RANGE, path=f"{KEY}.xy")
        return self


class RodTable(SceneFileTable):
    """A slender rod."""

    element = custom.rod_shape
    example = '{ length = "100 mm" }'
    length: PositiveLength = Field(description='the length of the rod, as "100 mm"')


class DiscTable(SceneFileTable):
    """A disc in the plane."""

    element = custom.disc_shape
    example = '{ radius = "100 mm" }'
    radius: PositiveLength = Field(description='the radius of the disc, as "100 mm"')
    thickness: Length = Field(0.0, description="the size normal to the plane")


class PlateTable(SceneFileTable):
    """A plate in the plane."""

    element = custom.plate_shape
    example = '{ width = "100 mm", height = "50 mm" }'
    width: PositiveLength = Field(description='the width along x, as "100 mm"')
    height: PositiveLength = Field(description='the height along y, as "100 mm"')
    thickness: Length = Field(0.0, description="the size normal to the plane")


class PointMassTable(SceneFileTable):
    """A mass on a body, in a point or as a solid ball."""

    example = '{ mass = "5 kg", at = ["300 mm", 0] }'
    mass: Annotated[float, built("mass")] = Field(description='the mass, as "5 kg"')
    position: Position = Field(alias="at", description='the position in the axes of the body, as ["300 mm", 0]')
    radius: Length = Field(0.0, description="the radius of the ball; 0 for a mass in a point")


class BodyTable(SceneFileTable):
    """[[body]]; the validation context is the `PointRegistry`."""

    name: NewBodyName = Field(description='the name of the body in other tables, as "crank"')
    mass: Mass = Field(0.0, description="the mass, without point masses")
    point_masses: Annotated[tuple[Any, ...], table_list(PointMassTable, "point mass")] = Field(
        (), description="further masses on the body, each a table"
    )
    inertia: Annotated[float, built("moment_of_inertia", hint="; a body that does not rotate has turns = false")] = Field(
        0.0, description="the moment of inertia about the mass centre, normal to the plane; instead of rod, disc or plate"
    )
    centre: Position = Field((0.0, 0.0), description="the mass centre in the axes of the body")
    moments: MomentsTable | None = Field(None, description="second moments of mass, for a body in a turning plane")
    rod: RodTable | None = Field(None, description="the body is a slender uniform rod along x, with the points start and end")
    disc: DiscTable | None = Field(None, description="the body is a uniform disc in the plane, about its origin")
    plate: PlateTable | None = Field(None, description="the body is a uniform plate in the plane, about its origin")
    point: Bool = Field(False, description="whether all mass is in the origin")
    turns: Bool = Field(True, description="whether the body can rotate")
    points: NamedPoints = Field(default_factory=dict, description='points by name, as { A = ["100 mm", 0] }, in the axes of the body')
    at: Position = Field((0.0, 0.0), description="the initial position of the origin; assembly starts from it")
    angle: Angle = Field(0.0, description="the initial angle of its axes, anticlockwise from x; assembly starts from it")

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterator[str]:
        """Yield mass properties that are missing, given twice or not sufficient."""
        shapes = [key for key in ("rod", "disc", "plate", "point") if key in values and values[key] is not False]
        properties = [key for key in ("inertia", "moments", "centre") if key in values]
        if len(shapes) > 1:
            yield f"{' and '.join(shapes)} are given; a body has one shape, or inertia and centre"
        elif shapes and properties:
            yield f"{' and '.join(properties)} cannot be combined with {shapes[0]}, which determines them"
        if "inertia" in values and "moments" in values:
            yield "inertia cannot be combined with moments, from which it follows as xx + yy"
        if values.get("point") is True and values.get("turns") is True:
            yield "a point mass does not rotate; leave out turns = true, or point = true"
        if "mass" not in values and "point_masses" not in values:
            hint = 'it is the mass, as "0.2 kg", and 0 for a lever without mass; a bar without mass is a [[link]]'
            yield Problem(f"{KEY}.mass is missing; {hint}", ProblemCode.MISSING_KEY, f"{KEY}.mass")
        has_inertia_alone = not shapes and "moments" not in values and "inertia" in values
        if has_inertia_alone and values.get("turns") is not False and context.plane == TURNING_PLANE:
            text = "inertia does not determine the centrifugal forces in a turning plane"
            hint = 'give moments = { xx = "0.5 kg m^2", ... } or a shape (rod, disc, plate) instead'
            yield Problem(f"{text}; {hint}", ProblemCode.MISSING_KEY)

    @model_validator(mode="after")
    def _check_values(self) -> BodyTable:
        collector = ProblemCollector()
        if self.mass and self.can_rotate and not (self._shape or self.moments or self.inertia):
            hint = "give inertia or moments, a shape (rod, disc, plate, point), point_masses instead of mass, or turns = false"
            text = f"inertia is missing; {hint} for a body that does not rotate"
            collector.add(ProblemCode.MISSING_KEY, text, key=f"{KEY}.inertia")
        if self.moments is not None and self.can_rotate and self.moments.xx + self.moments.yy <= 0:
            collector.add(ProblemCode.OUT_OF_RANGE, "moments must have xx or yy above 0; a body without extent has point = true")
        if self.angle and not self.can_rotate:
            text = f"angle must be left out for a body that does not rotate; found {format_value(self.angle)} rad"
            collector.add(ProblemCode.CONFLICT, text)
        for name in [name for name in ("origin", "centre", *(("start", "end") if self.rod else ())) if name in self.points]:
            collector.add(ProblemCode.DUPLICATE, f"points.{name} is the name of a point that the body already has; choose another")
        collector.raise_if_failed()
        return self

    @property
    def can_rotate(self) -> bool:
        """Whether the body rotates in the plane."""
        return self.turns and not self.point

    @property
    def _shape(self) -> RodTable | DiscTable | PlateTable | None:
        return self.rod or self.disc or self.plate

    def build(self, registry: PointRegistry) -> custom.SketchedBody:
        """Return the body."""
        shape = self._build_shape()
        if self.point_masses:
            shape = custom.add_point_masses(shape, [(ball.mass, ball.position, ball.radius) for ball in self.point_masses])
        return custom.SketchedBody(
            name=self.name, shape=shape, can_rotate=self.can_rotate, points=self.points, origin=self.at, angle=self.angle
        )

    def _build_shape(self) -> custom.BodyShape:
        if self._shape is not None:
            shape: custom.BodyShape = self._shape.make_element(mass=self.mass)
            return shape
        # In a fixed plane only the sum counts.
        moments = self.moments.make_element() if self.moments else SecondMoments(xx=self.inertia / 2, yy=self.inertia / 2)
        return custom.BodyShape(element=MassElement(mass=self.mass, centre=self.centre, moments=moments))
