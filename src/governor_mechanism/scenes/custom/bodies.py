"""The bodies of a user's own mechanism, and the points that its other tables name."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Any

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.custom import Pair, Shape, Sketched, disc, plate, rod
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.model.scene import TURNING
from governor_mechanism.scenes.custom.schema import BodyTable
from governor_mechanism.scenes.custom.values import End
from governor_mechanism.scenes.quantities import listed
from governor_mechanism.units.quantities import shown

_SHAPES = ("rod", "disc", "plate", "point")
_INSTEAD = ("inertia", "moments", "centre")


class Places:
    """What bodies and points there are. `faulty` are bodies whose own tables are wrong; naming them is no mistake."""

    def __init__(self) -> None:
        self.ground: dict[str, Pair] = {"origin": (0.0, 0.0)}
        self.bodies: dict[str, Sketched] = {}
        self.faulty: set[str] = set()
        self._names: set[str] = set()

    def body(self, name: str, key: str) -> str:
        """The name of a body; refuses an unknown one, and one that is wrong itself without another word."""
        if name in self.faulty:
            raise MechanismError
        known = [GROUND, *self.bodies, *sorted(self.faulty - {GROUND})]
        if name not in known:
            raise MechanismError(
                f"{key} names the unknown body {shown(name)}; bodies are {listed(known)}.{did_you_mean(name, known)}"
            )
        return name

    def point(self, end: End, key: str) -> Point:
        """The point that an end names; a body alone is its mass centre."""
        name = self.body(end.body, key)
        body = self.bodies.get(name)
        marks = self.ground if body is None else body.marks
        place = end.place or marks.get(end.point or ("origin" if body is None else "centre"))
        if place is None:
            where = "[ground]" if body is None else f"the points of body {shown(name)}"
            raise MechanismError(
                f"{key} names the unknown point {shown(end.point)} of {shown(name)}; "
                f"known are {listed(marks)}, and more may stand in {where}.{did_you_mean(end.point, marks)}"
            )
        return Point(body=GROUND, x=place[0], y=place[1]) if body is None else body.point(place)

    def two(self, meaning: Mapping[str, Any]) -> tuple[Point, Point]:
        """The points `first` and `second`; both are told when both are wrong."""
        first, second = gathered(
            lambda: self.point(meaning["first"], "first"), lambda: self.point(meaning["second"], "second")
        )
        _require_two(first.body, second.body)
        return first, second

    def two_bodies(self, first: str, second: str, keys: tuple[str, str] = ("first", "second")) -> tuple[str, str]:
        """The names of two bodies; both are told when both are wrong."""
        one, other = gathered(lambda: self.body(first, keys[0]), lambda: self.body(second, keys[1]))
        _require_two(one, other)
        return one, other

    def unused(self, plain: str, taken: set[Any]) -> str:
        """The plain name, numbered where another has it."""
        number, name = 1, plain
        while name in self._names or name in taken:
            number += 1
            name = f"{plain} {number}"
        self._names.add(name)
        return name


def _require_two(first: str, second: str) -> None:
    if first == second:
        raise MechanismError(f"first and second must be of two different bodies; both are of {shown(first)}")


def gathered(*makes: Callable[[], Any]) -> tuple[Any, ...]:
    """What each makes; the mistakes of all together."""
    made: list[Any] = []
    problems: list[str] = []
    failed = False
    for make in makes:
        try:
            made.append(make())
        except MechanismError as error:
            failed = True
            problems += error.problems
    if failed:
        raise MechanismError(*problems)
    return tuple(made)


def sketched(
    values: Mapping[str, Any], meaning: Mapping[str, Any] | None, plane: str, problems: list[str]
) -> Sketched | None:
    """The body that a table describes, `meaning` being None where it cannot be understood; notes what contradicts."""
    found = [*_contradictions(values), *_missing(values, plane)]
    if meaning is not None:
        found += _faults(values, meaning)
    problems += found
    if meaning is None or found:
        return None
    return Sketched(
        name=meaning["name"],
        mass=meaning["mass"],
        shape=_shape(meaning),
        turns=_turns(values),
        points=meaning.get("points", {}),
        at=meaning.get("at", (0.0, 0.0)),
        angle=meaning.get("angle", 0.0),
    )


def _shapes(values: Mapping[str, Any]) -> list[str]:
    return [key for key in _SHAPES if key in values and values[key] is not False]


def _turns(values: Mapping[str, Any]) -> bool:
    return values.get("turns") is not False and values.get("point") is not True


def _contradictions(values: Mapping[str, Any]) -> list[str]:
    """What one table says twice."""
    shapes, instead = _shapes(values), [key for key in _INSTEAD if key in values]
    found = []
    if len(shapes) > 1:
        found.append(f"{' and '.join(shapes)} stand together; a body has one shape, or inertia and centre")
    elif shapes and instead:
        found.append(f"{' and '.join(instead)} cannot stand beside {shapes[0]}, which tells how the mass lies")
    if "inertia" in values and "moments" in values:
        found.append("inertia and moments stand together; moments tell the inertia too, as xx + yy")
    if values.get("point") is True and values.get("turns") is True:
        found.append("a point mass does not turn; leave out turns = true, or point = true")
    return found


def _missing(values: Mapping[str, Any], plane: str) -> list[str]:
    """A body that turns must tell how its mass lies."""
    unknown = [key for key in values if isinstance(key, str) and key not in BodyTable.model_fields]
    misspelt = [
        key for key in unknown if difflib.get_close_matches(key, [*_SHAPES, "inertia", "moments", "turns"], n=1)
    ]
    if not _turns(values) or _shapes(values):
        return []
    if "inertia" in values and "moments" not in values and plane == TURNING:
        return [
            "inertia does not tell how a turning plane pulls at the body; "
            'give moments = { xx = "0.5 kg m^2", ... } or a shape (rod, disc, plate) instead'
        ]
    if "inertia" in values or "moments" in values or misspelt:
        return []
    return [
        "inertia is missing; give inertia or moments, a shape (rod, disc, plate, point), "
        "or turns = false for a body that never turns"
    ]


def _faults(values: Mapping[str, Any], meaning: Mapping[str, Any]) -> list[str]:
    """What numbers cannot be, and names that are taken."""
    found = []
    moments = meaning.get("moments")
    if moments is not None:
        xx, yy, xy = (moments.get(key, 0.0) for key in ("xx", "yy", "xy"))
        if _turns(values) and xx + yy <= 0:
            found.append("moments must have xx or yy above 0; a body without extent has point = true")
        if xy**2 > xx * yy * (1 + 1e-9):
            found.append(f"moments.xy must not exceed the square root of xx * yy; found {shown(xy)}")
    if meaning.get("angle") and not _turns(values):
        found.append(f"angle must be left out for a body that never turns; found {shown(values['angle'])}")
    taken = {"origin", "centre"} | ({"start", "end"} if "rod" in meaning else set())
    found += [
        f"points.{name} is a name that this body has already; choose another"
        for name in meaning.get("points", {})
        if name in taken
    ]
    return found


def _shape(meaning: Mapping[str, Any]) -> Shape:
    mass = meaning["mass"]
    if "rod" in meaning:
        return rod(mass, **meaning["rod"])
    if "disc" in meaning:
        return disc(mass, **meaning["disc"])
    if "plate" in meaning:
        return plate(mass, **meaning["plate"])
    # Only the sum counts in a plane that does not turn.
    half = meaning.get("inertia", 0.0) / 2
    moments = SecondMoments(**meaning["moments"]) if "moments" in meaning else SecondMoments(xx=half, yy=half)
    return Shape(moments=moments, centre=meaning.get("centre", (0.0, 0.0)))
