"""Values of a custom machine: points, curves, motions, and moving points of the ground."""

import math
from collections.abc import Callable, Collection, Mapping
from functools import cached_property
from itertools import chain, count
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import MassElement
from governor_mechanism.machines.custom import BodyShape, InitialConfiguration, SketchedBody
from governor_mechanism.mechanics.curves.segments import make_curve_segments
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.curves import FLAT, ROLLER, Curve, Lift, LiftCurve, PolarHarmonics, PolarSpline, PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import GROUND, Joint, Point, TranslationalDriver
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.scenes import quantities
from governor_mechanism.scenes.loads import LOAD_TYPES, angle_harmonic_table, harmonic_table, parse_harmonics
from governor_mechanism.scenes.quantities import TABLE_TYPE, Table, parse_table_list
from governor_mechanism.units.fields import declare
from governor_mechanism.units.problems import KEY, ProblemCode, mistake, parse_each, unknown_name, wrong_value
from governor_mechanism.units.quantities import format_value


class PointRegistry:
    """Bodies, their points and their initial positions, for the tables that refer to them by name."""

    def __init__(
        self,
        plane: str,  # TURNING_PLANE or FIXED_PLANE
    ) -> None:
        self.plane = plane
        # named points of the ground that are at rest, m
        self.ground: dict[str, quantities.FloatPair] = {"origin": (0.0, 0.0)}
        self.moving_points: dict[str, SketchedBody] = {}  # moving points of the ground by name, as massless bodies
        self.bodies: dict[str, SketchedBody] = {}  # bodies by name
        # names of bodies whose own tables are wrong; a reference to one of them fails without a message
        self.invalid_bodies: set[str] = set()
        self.used_names: set[str] = set()

    @cached_property
    def initial_configuration(self) -> InitialConfiguration:
        """Initial poses of the bodies; use it when all bodies are known."""
        return InitialConfiguration([*self.bodies.values(), *self.moving_points.values()])

    def require_body(self, name: str) -> str:
        """Return the name of a body; refuse an unknown one."""
        if name in self.invalid_bodies:
            raise MechanismError
        known_names = [GROUND, *self.bodies, *sorted(self.invalid_bodies - {GROUND})]
        if name not in known_names:
            raise unknown_name(f"{KEY} names the unknown body {format_value(name)}; bodies are", name, known_names)
        return name

    def find_point(self, name: str, point: str = "", position: quantities.FloatPair | None = None) -> Point:
        """Return a point of a body, by its name or position; a body alone means its mass centre."""
        if self.require_body(name) == GROUND and point in self.moving_points:
            return Point(body=self.moving_points[point].name)
        body = self.bodies.get(name)
        named_points = self.ground if body is None else body.named_points
        position = position or named_points.get(point or ("origin" if body is None else "centre"))
        if position is None:
            known_names = [*named_points, *(self.moving_points if body is None else ())]
            location = "[ground]" if body is None else f"the points of body {format_value(name)}"
            text = f"{KEY} names the unknown point {format_value(point)} of {format_value(name)}; known are"
            raise unknown_name(text, point, known_names, f"; add others to {location}")
        return Point(body=GROUND, x=position[0], y=position[1]) if body is None else body.point(position)

    def reserve_name(self, base_name: str) -> str:
        """Return a name that is not used, with a number at its end if necessary, and reserve it."""
        name = make_unique_name(base_name, self.used_names, " ")
        self.used_names.add(name)
        return name


def make_unique_name(base_name: str, used_names: Collection[str], separator: str) -> str:
    """Return a name that is not used, with the lowest possible number from 2 on at its end if necessary."""
    numbered_names = (f"{base_name}{separator}{number}" for number in count(2))
    return next(name for name in chain([base_name], numbered_names) if name not in used_names)


def _parse_point(value: object, registry: PointRegistry, *, allow_body: bool = False) -> Point:
    """Return a point of the registry."""
    if isinstance(value, str):
        body, dot, point = value.strip().partition(".")
        if body and (point if dot else allow_body):
            return registry.find_point(body, point)
        if body and not dot:
            text = f'{KEY} {format_value(value)} names no point; write "{value}.origin", or ["{value}", "10 mm", 0]'
            raise mistake(ProblemCode.WRONG_TYPE, text)
    elif isinstance(value, list | tuple) and len(value) == 3 and isinstance(value[0], str):
        return registry.find_point(value[0], position=quantities.parse_position(value[1:]))
    raise wrong_value(value, 'must be "body.point" or ["body", x, y]')


def _parse_point_or_outline(value: object, registry: PointRegistry) -> Point | str:
    """Return a point of the registry, or the name of a body, whose outline is meant."""
    if isinstance(value, str) and value.strip() and "." not in value:
        return registry.require_body(quantities.check_label(value))
    return _parse_point(value, registry)


def _parse_two_points(value: object, registry: PointRegistry) -> list[Point]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise wrong_value(value, 'must be two points, as ["ground.O", "crank.A"]')
    return parse_each(lambda point: _parse_point(point, registry), value)


def _parse_body_name(value: object) -> str:
    body = quantities.parse_name(value)
    if body == GROUND:
        raise mistake(ProblemCode.DUPLICATE, f"{KEY} must not be {GROUND!r}, which is the fixed plane; its points are in [ground]")
    return body


def parse_named_points(value: object) -> dict[str, quantities.FloatPair]:
    """Return named points of a body or of the ground, m; report every wrong one."""
    if not isinstance(value, Mapping):
        raise wrong_value(value, 'must be a table, as { A = ["10 mm", 0] }')

    def parse_point(name: object, position: object) -> tuple[str, quantities.FloatPair]:
        return quantities.parse_name(name, f"the name of a point in {KEY}"), quantities.parse_position(position, f"{KEY}.{name}")

    return dict(parse_each(parse_point, value, value.values()))


def _parse_curve(value: object) -> Curve:
    keys = set(value) if isinstance(value, Mapping) else set()
    for own_keys, table in ((_HARMONIC_CURVE.fields, _HARMONIC_CURVE), (_LIFT_CURVE.fields, _LIFT_CURVE)):
        if isinstance(value, Mapping) and "radius" in keys and keys <= own_keys.keys():
            curve: Curve = table.build(value)
            return curve
    if not isinstance(value, Mapping) or len(keys) != 1 or not keys <= _CURVES.keys():
        raise wrong_value(
            value,
            "must be { coefficients = [c0, c1, ...] } or { points = [[x, y], ...] }, or for a closed curve { closed = [[x, y], ...] }, "
            "{ polar = [[angle, radius], ...] }, { radius = r, harmonics = [...] } or { radius = r, lifts = [...] }",
        )
    (key,) = keys
    (curve,) = parse_each(_CURVES[key], value.values(), paths=[f"{KEY}.{key}"])
    return curve


def _parse_spline(value: object) -> Curve:
    x, y = quantities.parse_points(value, ("length", "length"), ("x", "y"))
    return SplineCurve(x=x, y=y)


def _parse_polynomial(value: object) -> Curve:
    if not isinstance(value, list | tuple):
        raise wrong_value(value, "must be a list of numbers")
    numbers = (quantities.parse_si(item, "coefficient" if power else "length", f"{KEY}, c{power}") for power, item in enumerate(value))
    return PolynomialCurve(coefficients=tuple(numbers))


def _parse_polar_spline(value: object) -> Curve:
    angles, radii = quantities.parse_points(value, ("angle", "length"), ("angle", "radius"))
    return PolarSpline(angles=angles, radii=radii)


def _parse_closed_spline(value: object) -> Curve:
    """Return a closed curve through points [x, y] as its radius over the angle."""
    if not isinstance(value, list | tuple):
        raise wrong_value(value, "must be a list of points [x, y]")
    points = parse_each(quantities.parse_position, value, paths=[f"{KEY}, point {number}" for number in range(1, len(value) + 1)])
    angles = np.unwrap([math.atan2(y, x) for x, y in points])
    if len(points) > 1 and angles[-1] < angles[0]:
        angles, points = angles[::-1], points[::-1]
    steps = np.diff(angles, append=angles[:1] + math.tau)
    if len(points) < 3 or np.any(steps <= 0.0) or np.any(steps >= math.pi):
        raise mistake(
            ProblemCode.OUT_OF_RANGE,
            f"{KEY} must be three or more points that go once round the first point of the joint, with one point in each direction from "
            "there and less than half a turn from one to the next; the curve closes by itself",
        )
    return PolarSpline(angles=tuple(angles.tolist()), radii=tuple(math.hypot(x, y) for x, y in points))


_CURVES: Final[Mapping[str, Callable[[object], Curve]]] = {
    "coefficients": _parse_polynomial,
    "points": _parse_spline,
    "closed": _parse_closed_spline,
    "polar": _parse_polar_spline,
}
"""Readers of the values of curves by the only key of their table."""

_RADIUS_HARMONICS = quantities.without_context(
    lambda value: parse_harmonics(angle_harmonic_table("length"), value), quantities.list_of(quantities.TABLE)
)
_HARMONIC_CURVE: Final = Table(
    make=PolarHarmonics,
    fields={
        "radius": declare("quantity", "length", meaning="the mean radius"),
        "harmonics": declare("harmonics", default=(), meaning="a list of { amplitude, order, phase }: sines of the angle"),
    },
    types={**quantities.VALUE_TYPES, "harmonics": _RADIUS_HARMONICS},
    example='{ radius = "50 mm", harmonics = [{ amplitude = "10 mm", order = 2 }] }',
)
"""A closed curve of harmonics."""

LIFT: Final = Table.of(Lift, example='{ over = "120 deg", lift = "20 mm" }')


def _make_lift_curve(**values: Any) -> LiftCurve:
    """Return the curve of a cam; refuse one that its follower cannot touch everywhere."""
    curve = LiftCurve(**values)
    make_curve_segments(curve)
    return curve


_LIFT_CURVE: Final = Table(
    make=_make_lift_curve,
    fields={
        "radius": declare("quantity", "length", meaning="the radius at angle 0"),
        "lifts": declare("lifts", meaning="a list of { over, lift, law }: rises, falls and dwells round the turn"),
        "follower": declare(
            "choice",
            words=(ROLLER, FLAT),
            default=ROLLER,
            meaning="what is lifted: roller, whose centre follows the curve, or flat, which touches it and has the radius as its distance",
        ),
    },
    types={
        **quantities.VALUE_TYPES,
        "lifts": quantities.without_context(lambda value: parse_table_list(LIFT, value, "lift"), quantities.list_of(quantities.TABLE)),
    },
    example='{ radius = "40 mm", lifts = [{ over = "180 deg", lift = "20 mm" }, { over = "180 deg", lift = "-20 mm" }] }',
)
"""The curve of a cam."""


MotionBuilder = Callable[[float], PrescribedMotion]
"""Return the motion, for its value at 0 s (rad or m) where the file leaves the start out."""


def _parse_motion(value: object, kind: str, rate_kind: str, name: str) -> MotionBuilder:
    """Return a motion of a kind of quantity, given by points of [time, value] or by a formula."""
    if isinstance(value, Mapping):
        return _read_formula(value, kind, rate_kind)
    if not isinstance(value, list | tuple):
        raise wrong_value(value, f"must be a list of [time, {name}], or a formula {{ start, rate, harmonics = [...] }}")
    times, values = quantities.parse_points(value, ("time", kind), ("time", name))
    motion = PrescribedMotion(times=times, values=values)
    return lambda _: motion


def _read_formula(value: object, kind: str, rate_kind: str) -> MotionBuilder:
    """Return a motion start + rate * t + the sum of amplitude * sin(2 pi * frequency * t + phase)."""
    fields = {
        "start": declare("quantity", kind, sign="any", default=None),
        "rate": declare("quantity", rate_kind, sign="any", default=0.0),
        "harmonics": declare("harmonics", default=()),
    }
    read_harmonics = quantities.without_context(lambda one: parse_harmonics(harmonic_table(kind), one), {})
    table = Table(make=dict, fields=fields, types={**quantities.VALUE_TYPES, "harmonics": read_harmonics})
    given = table.read(value)
    harmonics, rate = given.get("harmonics", ()), given.get("rate", 0.0)

    def build(value_at_zero: float) -> PrescribedMotion:
        """Return the motion; without a start it has the given value at 0 s."""
        offset = sum(item.amplitude * math.sin(item.phase) for item in harmonics)
        return PrescribedMotion.constant_rate(given.get("start", value_at_zero - offset), rate, harmonics)

    return build


def _parse_angle_motion(value: object) -> MotionBuilder:
    return _parse_motion(value, "angle", "angular_speed", "angle")


def _parse_displacement_motion(value: object) -> MotionBuilder:
    return _parse_motion(value, "length", "speed", "displacement")


def is_moving(position: object) -> bool:
    """Return whether a point of the ground is written with a coordinate that is a motion."""
    return isinstance(position, list | tuple) and any(isinstance(coordinate, Mapping | list | tuple) for coordinate in position)


def parse_moving_point(
    name: str,
    position: object,  # both coordinates as written: a length, a table or a formula
) -> tuple[SketchedBody, list[Joint]]:
    """Return a moving point of the ground: a massless body, and the drivers of its coordinates."""
    if not isinstance(position, list | tuple) or len(position) != 2:
        raise wrong_value(position, "must be [x, y], each a length or a motion")
    motions = parse_each(_parse_coordinate, position, paths=[f"{KEY} x:", f"{KEY} y:"])
    x, y = (float(CubicTimeFunction(motion)(np.zeros(1))[0]) for motion in motions)
    axes = (("x", Point(body=GROUND, y=y), 0.0), ("y", Point(body=GROUND, x=x), math.pi / 2))
    drivers: list[Joint] = [
        TranslationalDriver(name=f"{axis} of {name}", first=start, second=Point(body=name), motion=motion, angle=angle)
        for (axis, start, angle), motion in zip(axes, motions, strict=True)
    ]
    return SketchedBody(name=name, shape=BodyShape(element=MassElement(mass=0.0)), can_rotate=False, origin=(x, y)), drivers


def _parse_coordinate(value: object) -> PrescribedMotion:
    """Return the motion of a coordinate; a length is at rest."""
    if isinstance(value, Mapping | list | tuple):
        return _parse_displacement_motion({"start": 0.0, **value} if isinstance(value, Mapping) else value)(0.0)
    return PrescribedMotion.constant_rate(quantities.parse_si(value, "length"), 0.0)


POINT: Final[quantities.JsonSchema] = {"type": ["string", "array"], "description": 'a point, as "crank.end", or ["crank", "10 mm", 0]'}
MOTION: Final[quantities.JsonSchema] = {
    "type": ["array", "object"],
    "description": "a list of [time, value], or { start, rate, harmonics }",
}
"""Schemas of points and motions."""


def _reference(read: Callable[[Any, PointRegistry], Any], schema: quantities.JsonSchema) -> quantities.ValueType:
    """Return the type of values that refer to the bodies of a registry."""
    return quantities.ValueType(lambda declared, value, registry: read(value, registry), schema)


CUSTOM_TYPES: Final[Mapping[str, quantities.ValueType]] = {
    **LOAD_TYPES,
    "point": _reference(_parse_point, POINT),
    "point or body": _reference(lambda value, registry: _parse_point(value, registry, allow_body=True), POINT),
    "point or outline": _reference(_parse_point_or_outline, POINT),
    "two points": _reference(_parse_two_points, quantities.pair_of(POINT)),
    "body": _reference(lambda value, registry: registry.require_body(quantities.check_label(value)), quantities.TEXT),
    "new body": quantities.without_context(_parse_body_name, quantities.TEXT),
    "points": quantities.without_context(parse_named_points, quantities.TABLE),
    "curve": quantities.without_context(_parse_curve, quantities.TABLE),
    "angle motion": quantities.without_context(_parse_angle_motion, MOTION),
    "displacement motion": quantities.without_context(_parse_displacement_motion, MOTION),
    "table": TABLE_TYPE,
}
"""How values are written; their context is the `PointRegistry`. Those of motions are read as `MotionBuilder`."""
