"""Bodies and points of a mechanism that is being built, as the user's variables hold them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from governor_mechanism.building.call_checks import check_mass, check_name, check_point
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.joints import GROUND
from governor_mechanism.units.quantities import format_value

Quantity: TypeAlias = float | str
"""A number in SI, or text with a unit."""

Program: TypeAlias = float | str | Sequence[Any] | Mapping[str, Any]
"""A quantity, or what scene files write for one that changes: [[time, value], ...], a formula, harmonics, or a function of a reading."""

OWN_POINTS: Final = ("origin", "centre")
"""Points that every body has: the origin of its axes, and its mass centre."""


@dataclass(frozen=True)
class BuiltPoint:
    """A point of a body, or of the ground.

    Attributes
    ----------
    body
        Name of the body.
    reference
        What scene files write for it: "body.point", or [body, x, y].
    """

    body: str
    reference: str | tuple[str, Quantity, Quantity]

    def __repr__(self) -> str:
        """Return the point as scene files write it."""
        return self.reference if isinstance(self.reference, str) else f"{self.body}({self.reference[1]}, {self.reference[2]})"


@dataclass(frozen=True, eq=False)
class BuiltBody:
    """A body of a mechanism that is being built.

    Attributes
    ----------
    name
        Name of the body.
    table
        Its table in the document.
    check
        Check of a table that shall take the place of its own.
    shape_points
        Names of the points that its shape brings.
    """

    name: str
    table: dict[str, Any]
    check: Callable[[Mapping[str, Any]], None]
    shape_points: tuple[str, ...] = ()

    @property
    def origin(self) -> BuiltPoint:
        """The origin of its axes: the start of a rod, the centre of a disc or plate."""
        return BuiltPoint(self.name, f"{self.name}.origin")

    @property
    def centre(self) -> BuiltPoint:
        """Its mass centre."""
        return BuiltPoint(self.name, f"{self.name}.centre")

    @property
    def point_names(self) -> tuple[str, ...]:
        """Names of its points."""
        return (*self.shape_points, *self.table.get("points", ()), *OWN_POINTS)

    def point(
        self,
        # coordinate x in the axes of the body, m or text with a unit. A rod lies along x from its start
        x: Quantity,
        y: Quantity = 0.0,
        name: str = "",  # name of the point in the document; none if empty
    ) -> BuiltPoint:
        """Return a point of the body.

        Raises MechanismError if a coordinate is no length, the name is none, or the body has a point of this
        name.
        """
        if not isinstance(name, str) or name:
            check_name(f"a point of body {self.name!r}", name)
        check_point(f"point of body {self.name!r}", x, y)
        if not name:
            return BuiltPoint(self.name, (self.name, x, y))
        if name in self.point_names:
            raise MechanismError(f"body {self.name!r} already has a point {name!r}; choose another name")
        points = {**self.table.get("points", {}), name: [x, y]}
        self.check({**self.table, "points": points})
        self.table["points"] = points
        return BuiltPoint(self.name, f"{self.name}.{name}")

    def add_mass(
        self,
        mass: Quantity,  # mass, kg or text with a unit
        at: BuiltPoint | Sequence[Quantity],  # position [x, y] in the axes of the body, or a point of `point`
        # radius of a solid ball, m or text with a unit; None for a mass in a point
        radius: Quantity | None = None,
    ) -> None:
        """Add a mass that is fixed to the body.

        Raises MechanismError if the position is none of this body, or a quantity is wrong.
        """
        position = self._position_of(at) if isinstance(at, BuiltPoint) else list(at) if isinstance(at, Iterable) else at
        ball = {"mass": mass, "at": position} | ({} if radius is None else {"radius": radius})
        check_mass(f"mass on body {self.name!r}", ball)
        balls = [*self.table.get("point_masses", ()), ball]
        self.check({**self.table, "point_masses": balls})
        self.table["point_masses"] = balls

    def _position_of(self, point: BuiltPoint) -> list[Any]:
        """Return the coordinates of a point of this body."""
        if point.body != self.name:
            raise MechanismError(f"a mass on body {self.name!r} needs a point of that body; found {point!r}")
        if not isinstance(point.reference, str):
            return list(point.reference[1:])
        name = point.reference.removeprefix(f"{self.name}.")
        known = {"origin": [0.0, 0.0], "start": [0.0, 0.0], **self.table.get("points", {})}
        known |= {"end": [self.table["rod"]["length"], 0.0]} if "rod" in self.table else {}
        if name not in known:
            raise MechanismError(f"the position of {point!r} follows from the masses; give [x, y] in the axes of the body")
        return list(known[name])

    def __getitem__(self, name: str) -> BuiltPoint:
        """Return a point of the body by its name."""
        if name not in self.point_names:
            names = ", ".join(self.point_names)
            raise MechanismError(
                f"body {self.name!r} has no point {format_value(name)}; known are {names}.{did_you_mean(name, self.point_names)}"
            )
        return BuiltPoint(self.name, f"{self.name}.{name}")

    def __repr__(self) -> str:
        """Return the name and the points of the body."""
        return f"{type(self).__name__}({self.name!r}; points {', '.join(self.point_names)})"


@dataclass(frozen=True, eq=False, repr=False)
class BuiltRod(BuiltBody):
    """A slender rod of a mechanism that is being built."""

    shape_points: tuple[str, ...] = ("start", "end")

    @property
    def start(self) -> BuiltPoint:
        """Its first end, the origin of its axes."""
        return BuiltPoint(self.name, f"{self.name}.start")

    @property
    def end(self) -> BuiltPoint:
        """Its second end."""
        return BuiltPoint(self.name, f"{self.name}.end")


def point_reference(what: str, point: object) -> Any:
    """Return a point as the document writes it; `what` needs it."""
    if isinstance(point, BuiltPoint):
        return point.reference if isinstance(point.reference, str) else list(point.reference)
    if isinstance(point, BuiltBody):
        names = ", ".join(f"{point.name}.{name}" for name in point.point_names)
        raise MechanismError(f"{what} takes points; found body {point.name!r}, whose points are {names}; others are made by point(x, y)")
    raise MechanismError(f"{what} takes points, as crank.end, or what ground(x, y) returns; found {format_value(point)}")


def body_reference(what: str, body: object) -> str:
    """Return a body as the document writes it; None is the ground."""
    if body is None:
        return GROUND
    if isinstance(body, BuiltBody):
        return body.name
    raise MechanismError(
        f"{what} takes a body, as what rod(...) returns; found {body if isinstance(body, BuiltPoint) else format_value(body)}"
    )


def body_or_point_reference(what: str, end: object) -> Any:
    """Return a body or a point as the document writes it; None is the ground."""
    return point_reference(what, end) if isinstance(end, BuiltPoint) else body_reference(what, end)
