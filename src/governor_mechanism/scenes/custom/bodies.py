"""[[body]] of a custom machine, and the bodies and points to which its other tables refer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from governor_mechanism.machines import custom
from governor_mechanism.machines.mass_elements import MassElement
from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.scenes.custom.field_types import CUSTOM_TYPES, PointRegistry
from governor_mechanism.scenes.quantities import TABLE, FloatPair, list_of, without_context
from governor_mechanism.scenes.table import Table, parse_table_list
from governor_mechanism.units.fields import Declaration, declare, entry, optional_size, quantity
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, wrong_value
from governor_mechanism.units.quantities import format_value


def _check_moments(given: Mapping[str, float]) -> Iterator[str]:
    """Yield a product of inertia that no mass has."""
    xy = given.get("xy", 0.0)
    if xy**2 > given.get("xx", 0.0) * given.get("yy", 0.0) * (1 + 1e-9):
        error = wrong_value(xy, "must not exceed the square root of xx * yy", code=ProblemCode.OUT_OF_RANGE, path=f"{KEY}.xy")
        yield from error.problems


def _size(meaning: str) -> Declaration:
    return declare("quantity", "length", built=True, meaning=f'{meaning}, as "100 mm"')


_THICKNESS = declare("quantity", "length", sign="not negative", built=True, default=0.0, meaning="the size normal to the plane")
MOMENTS: Final = Table.of(SecondMoments, example='{ xx = "0.5 kg m^2" }', check=_check_moments)
"""Second moments of mass."""

ROD: Final = Table(
    make=partial(partial, custom.rod_shape), fields={"length": _size("the length of the rod")}, example='{ length = "100 mm" }'
)
"""A slender rod. The mass makes a shape of it, also of the following two."""

DISC: Final = Table(
    make=partial(partial, custom.disc_shape),
    fields={"radius": _size("the radius of the disc"), "thickness": _THICKNESS},
    example='{ radius = "100 mm" }',
)
"""A disc in the plane."""

PLATE: Final = Table(
    make=partial(partial, custom.plate_shape),
    fields={"width": _size("the width along x"), "height": _size("the height along y"), "thickness": _THICKNESS},
    example='{ width = "100 mm", height = "50 mm" }',
)
"""A plate in the plane."""


@dataclass(frozen=True, kw_only=True)
class PointMass:
    """A mass on a body, in a point or as a solid ball."""

    mass: float = quantity("mass", built=True, meaning='the mass, as "5 kg"')
    position: FloatPair = entry("position", key="at", meaning='the position in the axes of the body, as ["300 mm", 0]')
    radius: float = optional_size("length", meaning="the radius of the ball; 0 for a mass in a point")


POINT_MASS: Final = Table.of(PointMass, example='{ mass = "5 kg", at = ["300 mm", 0] }')
"""A mass on a body."""


@dataclass(frozen=True, kw_only=True)
class WrittenBody:
    """A body as [[body]] describes it."""

    name: str = entry("new body", meaning='the name of the body in other tables, as "crank"')
    mass: float = optional_size("mass", meaning="the mass, without point masses")
    point_masses: tuple[PointMass, ...] = entry("point masses", default=(), meaning="further masses on the body, each a table")
    inertia: float = quantity(
        "moment_of_inertia",
        built=True,
        hint="; a body that does not rotate has turns = false",
        default=0.0,
        meaning="the moment of inertia about the mass centre, normal to the plane; instead of rod, disc or plate",
    )
    centre: FloatPair = entry("position", default=(0.0, 0.0), meaning="the mass centre in the axes of the body")
    moments: SecondMoments | None = entry(
        "table", content=MOMENTS, default=None, meaning="second moments of mass, for a body in a turning plane"
    )
    rod: Any = entry("table", content=ROD, default=None, meaning="the body is a slender uniform rod along x, with the points start and end")
    disc: Any = entry("table", content=DISC, default=None, meaning="the body is a uniform disc in the plane, about its origin")
    plate: Any = entry("table", content=PLATE, default=None, meaning="the body is a uniform plate in the plane, about its origin")
    point: bool = entry("flag", default=False, meaning="whether all mass is in the origin")
    turns: bool = entry("flag", default=True, meaning="whether the body can rotate")
    points: Mapping[str, FloatPair] | None = entry(
        "points", default=None, meaning='points by name, as { A = ["100 mm", 0] }, in the axes of the body'
    )
    at: FloatPair = entry("position", default=(0.0, 0.0), meaning="the initial position of the origin; assembly starts from it")
    angle: float = quantity(
        "angle", sign="any", default=0.0, meaning="the initial angle of its axes, anticlockwise from x; assembly starts from it"
    )

    def find_problems(self) -> Iterator[Problem]:
        """Yield values that do not fit together."""
        if self.mass and self.can_rotate and not (self._shape or self.moments or self.inertia):
            hint = "give inertia or moments, a shape (rod, disc, plate, point), point_masses instead of mass, or turns = false"
            text = f"inertia is missing; {hint} for a body that does not rotate"
            yield Problem(text, ProblemCode.MISSING_KEY, f"{KEY}.inertia")
        if self.moments is not None and self.can_rotate and self.moments.xx + self.moments.yy <= 0:
            text = "moments must have xx or yy above 0; a body without extent has point = true"
            yield Problem(text, ProblemCode.OUT_OF_RANGE)
        if self.angle and not self.can_rotate:
            text = f"angle must be left out for a body that does not rotate; found {format_value(self.angle)} rad"
            yield Problem(text, ProblemCode.CONFLICT)
        for name in [name for name in ("origin", "centre", *(("start", "end") if self.rod else ())) if name in (self.points or {})]:
            text = f"points.{name} is the name of a point that the body already has; choose another"
            yield Problem(text, ProblemCode.DUPLICATE)

    @property
    def can_rotate(self) -> bool:
        """Whether the body rotates in the plane."""
        return self.turns and not self.point

    @property
    def _shape(self) -> Any:
        """The function that makes the shape from the mass; None without a shape."""
        return self.rod or self.disc or self.plate

    def sketch(self) -> custom.SketchedBody:
        """Return the body."""
        shape = self._build_shape()
        if self.point_masses:
            shape = custom.add_point_masses(shape, [(ball.mass, ball.position, ball.radius) for ball in self.point_masses])
        return custom.SketchedBody(
            name=self.name, shape=shape, can_rotate=self.can_rotate, points=self.points or {}, origin=self.at, angle=self.angle
        )

    def _build_shape(self) -> custom.BodyShape:
        if self._shape is not None:
            shape: custom.BodyShape = self._shape(mass=self.mass)
            return shape
        # In a fixed plane only the sum counts.
        moments = self.moments or SecondMoments(xx=self.inertia / 2, yy=self.inertia / 2)
        return custom.BodyShape(element=MassElement(mass=self.mass, centre=self.centre, moments=moments))


def _find_mass_conflicts(values: Mapping[str, Any], registry: PointRegistry) -> Iterator[str]:
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
    if has_inertia_alone and values.get("turns") is not False and registry.plane == TURNING_PLANE:
        text = "inertia does not determine the centrifugal forces in a turning plane"
        hint = 'give moments = { xx = "0.5 kg m^2", ... } or a shape (rod, disc, plate) instead'
        yield Problem(f"{text}; {hint}", ProblemCode.MISSING_KEY)


def _sketch_body(**given: Any) -> custom.SketchedBody:
    return WrittenBody(**given).sketch()


def _check_body(given: Mapping[str, Any]) -> Iterator[Problem]:
    return WrittenBody(**given).find_problems()


_POINT_MASSES = without_context(lambda value: parse_table_list(POINT_MASS, value, "point mass"), list_of(TABLE))
BODY: Final = Table.of(
    WrittenBody,
    make=_sketch_body,
    types={**CUSTOM_TYPES, "point masses": _POINT_MASSES},
    check=_check_body,
    find_conflicts=_find_mass_conflicts,
)
"""[[body]]; its context is the `PointRegistry`."""
