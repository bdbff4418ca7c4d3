"""[valve] of a custom machine."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, NamedTuple

from governor_mechanism.machines import custom
from governor_mechanism.machines.base import MassElement
from governor_mechanism.machines.custom import SketchedBody
from governor_mechanism.model import force_elements, joints
from governor_mechanism.model.curves import Outline
from governor_mechanism.model.joints import GROUND, Joint, Point, RotationalDriver
from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.valve import Reverser, Valve
from governor_mechanism.scenes import quantities
from governor_mechanism.scenes.custom.contacts import OUTLINE_TYPE
from governor_mechanism.scenes.custom.field_types import CUSTOM_TYPES, PointRegistry, make_unique_name
from governor_mechanism.scenes.effect_tables import ReadingQuantities, resolve_reading_name
from governor_mechanism.scenes.quantities import TABLE, FloatPair, Table, list_of, parse_table_list, without_context
from governor_mechanism.units.fields import Declaration, declare, entry, fields_of, optional_size, quantity
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, mistake, unknown_name, wrong_value
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
    outline: Outline | None = entry(
        "outline",
        default=None,
        meaning="the outline that rollers of other bodies touch, in the axes of the body: a list of corners [x, y], or "
        "[x, y, radius] where an arc begins (a negative radius for a hollow one), or a closed curve about the origin, as "
        '{ curve = { ... }, inset = "10 mm" }',
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
            name=self.name,
            shape=shape,
            can_rotate=self.can_rotate,
            points=self.points or {},
            origin=self.at,
            angle=self.angle,
            outline=self.outline,
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
    types={**CUSTOM_TYPES, "point masses": _POINT_MASSES, "outline": OUTLINE_TYPE},
    check=_check_body,
    find_conflicts=_find_mass_conflicts,
)
"""[[body]]; its context is the `PointRegistry`."""


_TYPED_JOINTS: Final = [joint for joint in joints.JOINTS if joint.type_name]

JOINT_TYPES: Final = tuple(joint.type_name for joint in _TYPED_JOINTS)
"""Types of [[joint]]."""

_FORCES: Final[Mapping[str, type[force_elements.ForceElement]]] = {
    "spring": force_elements.Spring,
    "damper": force_elements.Damper,
    "torsion_spring": force_elements.TorsionSpring,
    "torsion_damper": force_elements.TorsionDamper,
    "torque": force_elements.Torque,
    "force": force_elements.Force,
}
FORCE_TYPES: Final = tuple(_FORCES)
"""Types of [[force]]."""


@dataclass(frozen=True, kw_only=True)
class ElementTable(Table):
    """The table of a joint, link or force between two points or bodies, its `first` and `second` end."""

    # message about two ends on the same body
    one_body_message: str = "both ends are of {body}; they must be of two different bodies"

    def read_ends(self, values: object, registry: PointRegistry) -> tuple[dict[str, Any], tuple[str, str]]:
        """Return the values of the keys that are given, and the names of the two bodies; refuse two ends on the same one."""
        given = self.read(values, registry)
        ends = given.get("first", GROUND), given["second" if "second" in given else "point"]
        first, second = (end if isinstance(end, str) else end.body for end in ends)
        if first == second:
            raise mistake(ProblemCode.CONFLICT, self.one_body_message.format(body=format_value(first)))
        return given, (first, second)

    def build(self, values: object, context: Any = None, **arguments: Any) -> Any:
        """Return the joint or force element, by default named after its type and its bodies."""
        given, (first, second) = self.read_ends(values, context)
        kind = given.pop("type", "link").replace("_", " ")
        names = f"{first.partition('.')[0]} and {second.partition('.')[0]}"
        name = given.pop("name", "") or context.reserve_name(f"{kind} of {names}")
        owner: Any = self.make
        if issubclass(owner, joints.Joint):
            defaults = {key: one.default for key, one in self.fields.items() if not one.is_required and not one.follows}
            initial_values = owner.initial_values(defaults | given, context.initial_configuration)
            return owner.create(**{**initial_values, **given, "name": name})
        return owner(**given, name=name)


_NAME: Final = {"name": declare("label", default="", meaning="the name in messages and results; by default the type and the two bodies")}
_POINTS: Final = {name: fields_of(force_elements.Spring)[name] for name in ("first", "second")}
_BODIES: Final = {
    "first": declare("point or body", meaning='the first body or a point of it, as "ground" or "crank.A"'),
    "second": declare("point or body", meaning='the second body or a point of it, as "crank" or "crank.A"'),
}


def _type_key(types: tuple[str, ...]) -> dict[str, Declaration]:
    return {"type": declare("choice", words=types, meaning=f"one of {', '.join(types)}")}


def _joint_table(joint: type[joints.Joint]) -> ElementTable:
    """Return the table of a type of joint; one without a type is a link."""

    def find_conflicts(values: Mapping[str, Any], registry: object) -> Iterator[str]:
        return joint.find_conflicts(values)

    ends = _BODIES if joint.joins_bodies else _POINTS
    fields = {**_NAME, **ends, **(_type_key(JOINT_TYPES) if joint.type_name else {}), **fields_of(joint), **joint.keys}
    return ElementTable(make=joint, fields=fields, types=CUSTOM_TYPES, find_conflicts=find_conflicts)


def _find_missing_component(values: Mapping[str, Any], registry: object) -> Iterator[str]:
    """Yield a force without components."""
    if "x" not in values and "y" not in values:
        yield Problem('x or y is missing; write x = "40 N" for a force along x', ProblemCode.MISSING_KEY)


def _force_table(force: type[force_elements.ForceElement]) -> ElementTable:
    """Return the table of a type of force; the first end of one at a point is the ground."""
    own_fields = fields_of(force)
    ends = _POINTS if own_fields.get("first") == _POINTS["first"] else {}
    table = ElementTable(make=force, fields=_NAME | ends | _type_key(FORCE_TYPES) | own_fields, types=CUSTOM_TYPES)
    if force is not force_elements.Force:
        return table
    message = "point must be of a moving body; a force on the ground has no effect"
    return replace(table, one_body_message=message, find_conflicts=_find_missing_component)


LINK: Final = _joint_table(joints.Distance)
"""[[link]]: a massless bar, by default as long as the initial distance of its ends."""

JOINT_TABLES: Final[Mapping[str, ElementTable]] = {joint.type_name: _joint_table(joint) for joint in _TYPED_JOINTS}
FORCE_TABLES: Final[Mapping[str, ElementTable]] = {name: _force_table(force) for name, force in _FORCES.items()}
"""Tables of [[joint]] and [[force]] by type."""

UNTYPED_JOINT: Final = ElementTable(
    make=joints.Joint, fields=_NAME | _POINTS | _type_key(JOINT_TYPES), types=CUSTOM_TYPES, unknown_key=None
)
UNTYPED_FORCE: Final = ElementTable(make=dict, fields=_NAME | _type_key(FORCE_TYPES), types=CUSTOM_TYPES, unknown_key=None)
"""Joint and force of unknown type; only the common keys are checked."""


_X_COORDINATE = partial(PointCoordinate, quantity="length", direction_x=1.0, direction_y=0.0)
_Y_COORDINATE = partial(PointCoordinate, quantity="length", direction_x=0.0, direction_y=1.0)


def _read_angle(*, name: str, angle: str, against: str = GROUND) -> Reading:
    if angle in (against, GROUND):
        raise mistake(ProblemCode.CONFLICT, "angle must name a moving body, and against another body or the ground")
    return BodyAngle(name=name, quantity="angle", body=angle, reference_body=against)


def _read_line(*, name: str, line: list[Point]) -> Reading:
    start, end = _require_different("line", line)
    # LineAngle counts from the downward vertical.
    return LineAngle(name=name, quantity="angle", start=start, end=end, zero=math.pi / 2)


def _read_distance(*, name: str, distance: list[Point]) -> Reading:
    first, second = _require_different("distance", distance)
    return PointDistance(name=name, quantity="length", first=first, second=second)


def _require_different(key: str, points: list[Point]) -> list[Point]:
    if points[0] == points[1]:
        raise mistake(ProblemCode.CONFLICT, f"{key} needs two different points")
    return points


def _coordinate_table(axis: str, make: Callable[..., Any]) -> Table:
    """Return the table of a coordinate of a point, relative to another one."""
    origin = declare(
        "point", key="from", default=Point(body=GROUND), meaning="the point from which it is measured, along the axes of its body"
    )
    point = declare("point", key=axis, meaning=f"the point whose coordinate {axis} it is")
    summary = f"Coordinate {axis} of a point, relative to another one."
    return Table(make=make, fields={"origin": origin, "point": point}, types=CUSTOM_TYPES, summary=summary)


READING_TABLES: Final[Mapping[str, Table]] = {
    "angle": Table(
        make=_read_angle,
        fields={
            "angle": declare("body", meaning='the body whose angle it is, as "crank"'),
            "against": declare("body", default=GROUND, meaning="the body from which the angle is measured"),
        },
        types=CUSTOM_TYPES,
        summary="Angle of a body against another one.",
    ),
    "line": Table(
        make=_read_line,
        fields={"line": declare("two points", meaning="the two points of the line")},
        types=CUSTOM_TYPES,
        summary="Angle of a line from x, counterclockwise.",
    ),
    "x": _coordinate_table("x", _X_COORDINATE),
    "y": _coordinate_table("y", _Y_COORDINATE),
    "distance": Table(
        make=_read_distance,
        fields={"distance": declare("two points", meaning="the two points")},
        types=CUSTOM_TYPES,
        summary="Distance of two points.",
    ),
}
"""Tables of readings by the key that determines the kind of reading; each has one of them."""


def find_reading_kind(values: object) -> str:
    """Return the key that determines the kind, or the kind nearest to a key; "" if there is not exactly one."""
    keys = [key for key in values if isinstance(key, str)] if isinstance(values, Mapping) else []
    kinds = [key for key in keys if key in READING_TABLES]
    kinds = kinds or [kind for key in keys for kind in difflib.get_close_matches(key, list(READING_TABLES), n=1)]
    return kinds[0] if len(kinds) == 1 else ""


def make_default_readings(bodies: Iterable[SketchedBody]) -> list[Reading]:
    """Return the readings of a mechanism without [readings]: the angle of each rotating body, the position of each other one."""
    readings: list[Reading] = []
    for body in bodies:
        base_name = re.sub(r"\W+", "_", body.name).strip("_") or "body"
        base_name = base_name if base_name.isidentifier() else f"body_{base_name}"
        name = make_unique_name(base_name, {reading.name.rpartition("_")[0] for reading in readings}, "_")
        if body.can_rotate:
            readings.append(BodyAngle(name=f"{name}_angle", quantity="angle", body=body.name))
        else:
            coordinates = {"x": _X_COORDINATE, "y": _Y_COORDINATE}
            readings += [make(name=f"{name}_{axis}", point=Point(body=body.name)) for axis, make in coordinates.items()]
    return readings


_CRANK_HINT: Final = 'valve events need a crank that is driven; add a [[joint]] of type "driven_turn"'


class ValveContext(NamedTuple):
    """Readings of the mechanism, None if not all are known, and names of the drivers that turn a body."""

    readings: ReadingQuantities
    drivers: tuple[str, ...]


def _read_length_reading(declared: Declaration, value: object, context: ValveContext) -> str:
    """Return the name of a reading that is a length."""
    readings = context.readings
    name = resolve_reading_name(quantities.check_label(value), readings, f"{KEY} {format_value(value)}")
    if readings is not None and readings[name] != "length":
        lengths = [other for other, kind in readings.items() if kind == "length"]
        text = f"{KEY} {format_value(value)} is an angle; it must be a length, as {' or '.join(lengths) or 'x of a point'}"
        raise mistake(ProblemCode.WRONG_QUANTITY, text)
    return name


def _read_driver(declared: Declaration, value: object, context: ValveContext) -> str:
    """Return the name of a driver that turns a body."""
    if value not in context.drivers:
        raise unknown_name(f"{KEY} {format_value(value)} is no driver that turns a body; these are", value, context.drivers)
    return str(value)


def _parse_end(value: object) -> float | str:
    """Return the value of the reverser's key at one end; that key has its own units."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise wrong_value(value, 'must be a number in SI or a quantity, as "20 deg"')
    return value


REVERSER: Final = Table.of(
    Reverser,
    types={**quantities.VALUE_TYPES, "end": quantities.without_context(_parse_end, quantities.NUMBER_OR_TEXT)},
    example='{ key = "joint.lever.motion.start", forward = "20 deg", back = "-20 deg" }',
)
"""What reverses the gear."""

VALVE: Final = Table.of(
    Valve,
    types={
        **quantities.VALUE_TYPES,
        "length reading": quantities.ValueType(_read_length_reading, quantities.TEXT),
        "centre": quantities.ValueType(quantities.read_declared_quantity, quantities.NUMBER_OR_TEXT),
        "driver": quantities.ValueType(_read_driver, quantities.TEXT),
        "reverser": quantities.without_context(REVERSER.build, quantities.TABLE),
    },
)
"""[valve]; its context is a `ValveContext`."""


def parse_valve(
    table: object,
    readings: Sequence[Reading] | None,  # readings of the mechanism, or None if not all are known
    joints: Iterable[Joint],
) -> Valve:
    """Return the valve of [valve], which names the driver of its crank."""
    drivers = tuple(joint.name for joint in joints if isinstance(joint, RotationalDriver))
    kinds = None if readings is None else {reading.name: reading.quantity for reading in readings}
    given = VALVE.read(table, ValveContext(kinds, drivers))
    if not drivers:
        raise mistake(ProblemCode.MISSING_KEY, f"{KEY}: {_CRANK_HINT}")
    if len(drivers) > 1 and not given.get("crank"):
        names = ", ".join(map(repr, drivers))
        text = f"{KEY}.crank is missing: {names} turn bodies; name the driver of the crank, as crank = {format_value(drivers[0])}"
        raise mistake(ProblemCode.MISSING_KEY, text, key=f"{KEY}.crank")
    return Valve(**{**given, "crank": given.get("crank") or drivers[0]})
