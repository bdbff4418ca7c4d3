"""The bodies of a user's own mechanism, and the points that its other tables name."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Any

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.custom import BodyShape, SketchedBody, disc_shape, plate_shape, rod_shape
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.model.scene import TURNING_PLANE
from governor_mechanism.scenes.custom.schema import BodyTable
from governor_mechanism.scenes.custom.values import PointReference
from governor_mechanism.scenes.quantities import join_names
from governor_mechanism.types import Vector2
from governor_mechanism.units.quantities import format_value

_SHAPE_KEYS = ("rod", "disc", "plate", "point")
_MASS_PROPERTY_KEYS = ("inertia", "moments", "centre")


class PointRegistry:
    """What bodies and points there are. `faulty` are bodies whose own tables are wrong; naming them is no mistake."""

    def __init__(self) -> None:
        self.ground: dict[str, Vector2] = {"origin": (0.0, 0.0)}
        self.bodies: dict[str, SketchedBody] = {}
        self.invalid_bodies: set[str] = set()
        self._used_names: set[str] = set()

    def require_body(self, name: str, key: str) -> str:
        """The name of a body; refuses an unknown one, and one that is wrong itself without another word."""
        if name in self.invalid_bodies:
            raise MechanismError
        known_names = [GROUND, *self.bodies, *sorted(self.invalid_bodies - {GROUND})]
        if name not in known_names:
            raise MechanismError(
                f"{key} names the unknown body {format_value(name)}; bodies are {join_names(known_names)}.{did_you_mean(name, known_names)}"
            )
        return name

    def find_point(self, reference: PointReference, key: str) -> Point:
        """The point that an end names; a body alone is its mass centre."""
        name = self.require_body(reference.body, key)
        body = self.bodies.get(name)
        named_points = self.ground if body is None else body.named_points
        position = reference.position or named_points.get(reference.point or ("origin" if body is None else "centre"))
        if position is None:
            location = "[ground]" if body is None else f"the points of body {format_value(name)}"
            raise MechanismError(
                f"{key} names the unknown point {format_value(reference.point)} of {format_value(name)}; "
                f"known are {join_names(named_points)}, and more may stand in {location}.{did_you_mean(reference.point, named_points)}"
            )
        return Point(body=GROUND, x=position[0], y=position[1]) if body is None else body.point(position)

    def find_two_points(self, parsed: Mapping[str, Any]) -> tuple[Point, Point]:
        """The points `first` and `second`; both are told when both are wrong."""
        first, second = evaluate_all(lambda: self.find_point(parsed["first"], "first"), lambda: self.find_point(parsed["second"], "second"))
        _require_different_bodies(first.body, second.body)
        return first, second

    def require_two_bodies(self, first: str, second: str, keys: tuple[str, str] = ("first", "second")) -> tuple[str, str]:
        """The names of two bodies; both are told when both are wrong."""
        first_name, second_name = evaluate_all(lambda: self.require_body(first, keys[0]), lambda: self.require_body(second, keys[1]))
        _require_different_bodies(first_name, second_name)
        return first_name, second_name

    def make_unique_name(self, base_name: str, used_names: set[Any]) -> str:
        """The plain name, numbered where another has it."""
        number, name = 1, base_name
        while name in self._used_names or name in used_names:
            number += 1
            name = f"{base_name} {number}"
        self._used_names.add(name)
        return name


def _require_different_bodies(first: str, second: str) -> None:
    if first == second:
        raise MechanismError(f"first and second must be of two different bodies; both are of {format_value(first)}")


def evaluate_all(*builders: Callable[[], Any]) -> tuple[Any, ...]:
    """What each makes; the mistakes of all together."""
    results: list[Any] = []
    problems: list[str] = []
    has_failed = False
    for build in builders:
        try:
            results.append(build())
        except MechanismError as error:
            has_failed = True
            problems += error.problems
    if has_failed:
        raise MechanismError(*problems)
    return tuple(results)


def parse_body(values: Mapping[str, Any], parsed: Mapping[str, Any] | None, plane: str, problems: list[str]) -> SketchedBody | None:
    """The body that a table describes, `meaning` being None where it cannot be understood; notes what contradicts."""
    new_problems = [*_find_contradictions(values), *_find_missing_mass_properties(values, plane)]
    if parsed is not None:
        new_problems += _find_invalid_values(values, parsed)
    problems += new_problems
    if parsed is None or new_problems:
        return None
    return SketchedBody(
        name=parsed["name"],
        mass=parsed["mass"],
        shape=_build_shape(parsed),
        can_rotate=_can_rotate(values),
        points=parsed.get("points", {}),
        origin=parsed.get("at", (0.0, 0.0)),
        angle=parsed.get("angle", 0.0),
    )


def _given_shapes(values: Mapping[str, Any]) -> list[str]:
    return [key for key in _SHAPE_KEYS if key in values and values[key] is not False]


def _can_rotate(values: Mapping[str, Any]) -> bool:
    return values.get("turns") is not False and values.get("point") is not True


def _find_contradictions(values: Mapping[str, Any]) -> list[str]:
    """What one table says twice."""
    shapes, mass_properties = _given_shapes(values), [key for key in _MASS_PROPERTY_KEYS if key in values]
    problems = []
    if len(shapes) > 1:
        problems.append(f"{' and '.join(shapes)} stand together; a body has one shape, or inertia and centre")
    elif shapes and mass_properties:
        problems.append(f"{' and '.join(mass_properties)} cannot stand beside {shapes[0]}, which tells how the mass lies")
    if "inertia" in values and "moments" in values:
        problems.append("inertia and moments stand together; moments tell the inertia too, as xx + yy")
    if values.get("point") is True and values.get("turns") is True:
        problems.append("a point mass does not turn; leave out turns = true, or point = true")
    return problems


def _find_missing_mass_properties(values: Mapping[str, Any], plane: str) -> list[str]:
    """A body that turns must tell how its mass lies."""
    unknown_keys = [key for key in values if isinstance(key, str) and key not in BodyTable.model_fields]
    misspelt_keys = [key for key in unknown_keys if difflib.get_close_matches(key, [*_SHAPE_KEYS, "inertia", "moments", "turns"], n=1)]
    if not _can_rotate(values) or _given_shapes(values):
        return []
    if "inertia" in values and "moments" not in values and plane == TURNING_PLANE:
        return [
            "inertia does not tell how a turning plane pulls at the body; "
            'give moments = { xx = "0.5 kg m^2", ... } or a shape (rod, disc, plate) instead'
        ]
    if "inertia" in values or "moments" in values or misspelt_keys:
        return []
    return ["inertia is missing; give inertia or moments, a shape (rod, disc, plate, point), or turns = false for a body that never turns"]


def _find_invalid_values(values: Mapping[str, Any], parsed: Mapping[str, Any]) -> list[str]:
    """What numbers cannot be, and names that are taken."""
    problems = []
    moments = parsed.get("moments")
    if moments is not None:
        xx, yy, xy = (moments.get(key, 0.0) for key in ("xx", "yy", "xy"))
        if _can_rotate(values) and xx + yy <= 0:
            problems.append("moments must have xx or yy above 0; a body without extent has point = true")
        if xy**2 > xx * yy * (1 + 1e-9):
            problems.append(f"moments.xy must not exceed the square root of xx * yy; found {format_value(xy)}")
    if parsed.get("angle") and not _can_rotate(values):
        problems.append(f"angle must be left out for a body that never turns; found {format_value(values['angle'])}")
    reserved_names = {"origin", "centre"} | ({"start", "end"} if "rod" in parsed else set())
    problems += [
        f"points.{name} is a name that this body has already; choose another" for name in parsed.get("points", {}) if name in reserved_names
    ]
    return problems


def _build_shape(parsed: Mapping[str, Any]) -> BodyShape:
    mass = parsed["mass"]
    if "rod" in parsed:
        return rod_shape(mass, **parsed["rod"])
    if "disc" in parsed:
        return disc_shape(mass, **parsed["disc"])
    if "plate" in parsed:
        return plate_shape(mass, **parsed["plate"])
    # Only the sum counts in a plane that does not turn.
    half_inertia = parsed.get("inertia", 0.0) / 2
    moments = SecondMoments(**parsed["moments"]) if "moments" in parsed else SecondMoments(xx=half_inertia, yy=half_inertia)
    return BodyShape(second_moments=moments, mass_centre=parsed.get("centre", (0.0, 0.0)))
