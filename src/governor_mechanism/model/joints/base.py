"""Points on bodies, and what every joint has: data, constraint rows, keys in scene files, parts for engine impulse, and a drawing."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum, auto
from typing import Any, ClassVar, Protocol, Self

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.curves import Curve
from governor_mechanism.model.time_functions import PrescribedMotion
from governor_mechanism.units.fields import Declaration, class_words, quantity, require_valid_fields


class RowKind(IntEnum):
    """Kind of a constraint row; d is the vector from the point of the first body to that of the second.

    DISTANCE: |d|. FIXED_DIRECTION: the component of d along a direction fixed in the plane, plus multiples of both body
    angles and of the angle of a third body. BODY_NORMAL: the component of d normal to a line of the first body, or the
    distance from a curve on that line. POLAR_CURVE: |d| less the radius of a closed curve of the first body in that
    direction. LINE_ANGLE: the angle of d from the downward vertical (rad). FOLLOWER_HEIGHT: the height of a follower that
    hangs by a link from a rod through the second point, plus the height of the first point. ARC_POSITION: the angle of d in
    the axes of the first body, times a radius. CURVE_DISTANCE, PIECES_DISTANCE: the distance of the second point from a
    closed curve, or from lines and arcs, of the first body. CURVE_SLIP, PIECES_SLIP: no value, but the velocity at which a roller
    about the second point slides along them. PROFILE_DISTANCE, PROFILE_SLIP: the distance of a closed convex curve about the second
    point from lines and arcs of the first body, and the velocity at which it slides along them. LINE_ANGLE and all after it but
    POLAR_CURVE serve as outputs only, the slips also as the constraint that nothing slides. Of each the constant of the row is
    subtracted.
    """

    DISTANCE = 0
    FIXED_DIRECTION = 1
    BODY_NORMAL = 2
    LINE_ANGLE = 3
    FOLLOWER_HEIGHT = 4
    ARC_POSITION = 5
    POLAR_CURVE = 6
    CURVE_DISTANCE = 7
    PIECES_DISTANCE = 8
    CURVE_SLIP = 9
    PIECES_SLIP = 10
    PROFILE_DISTANCE = 11
    PROFILE_SLIP = 12


@dataclass(frozen=True)
class ConstraintRow:
    """One constraint equation of a joint.

    `parameters` are the fields of `CONSTRAINT_ROW_DTYPE` that its kind has. `motion` drives the row, in units of `drive_scale` (m per
    unit of the motion). `curve` is the guide curve of a curve slot. `third` is the name of a third body, or the ground, whose angle
    the row contains.
    """

    kind: RowKind
    parameters: Mapping[str, float]
    motion: PrescribedMotion | None = None
    drive_scale: float = 1.0
    curve: Curve | None = None
    third: str | None = None


def coincidence_rows() -> list[ConstraintRow]:
    """Return the rows that make two points coincide."""
    return [ConstraintRow(RowKind.FIXED_DIRECTION, {name: 1.0}) for name in ("direction_x", "direction_y")]


def direction(angle: float) -> dict[str, float]:
    """Return the unit vector at an angle (rad) as fields of a row."""
    return {"direction_x": math.cos(angle), "direction_y": math.sin(angle)}


def relative_angle_row(angle: float, length_scale: float, motion: PrescribedMotion | None = None) -> ConstraintRow:
    """Return the row that keeps the angle (rad) of the second body relative to the first, or drives it by a motion."""
    factors = {"first_angle_factor": -length_scale, "second_angle_factor": length_scale}
    return ConstraintRow(RowKind.FIXED_DIRECTION, {**factors, "constant": length_scale * angle}, motion, length_scale)


@dataclass(frozen=True)
class ImpulsePart:
    """Base class of a constraint between the points or angles of two bodies."""


@dataclass(frozen=True)
class Pivot(ImpulsePart):
    """Both points coincide."""


@dataclass(frozen=True)
class FixedDistance(ImpulsePart):
    """The points keep a distance, m."""

    distance: float


@dataclass(frozen=True)
class FixedAngle(ImpulsePart):
    """The bodies keep a relative angle, rad."""

    angle: float


@dataclass(frozen=True)
class AngleRatio(ImpulsePart):
    """The angle of the second body is ratio times that of the first, plus an offset (rad)."""

    ratio: float
    offset: float


@dataclass(frozen=True)
class Guide(ImpulsePart):
    """The second point stays on a line of the first body at an angle (rad), or on an open or closed curve in axes at that angle."""

    angle: float
    curve: Curve | None = None


@dataclass(frozen=True)
class DrivenOffset(ImpulsePart):
    """The second point has a prescribed distance from a line of the first body at an angle (rad)."""

    angle: float


@dataclass(frozen=True)
class DrivenAngle(ImpulsePart):
    """The bodies have a prescribed relative angle."""


GROUND = "ground"
"""Name of the plane that the mechanism moves in. The plane is fixed or turns with the spindle."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A body-fixed point.

    Attributes
    ----------
    body
        Name of the body, or GROUND.
    x, y
        Coordinates in the axes of the body, m, from its mass centre; on GROUND in the axes of the plane.
    """

    body: str
    x: float = quantity("length", sign="any", default=0.0)
    y: float = quantity("length", sign="any", default=0.0)

    def __post_init__(self) -> None:
        require_valid_fields(self, f"a point on body {self.body!r}")


class FirstConfiguration(Protocol):
    """Poses of the bodies at the start, from which values follow that a scene file leaves out."""

    @property
    def poses(self) -> Mapping[str, tuple[float, float, float]]:
        """Pose of each body by name, m and rad."""

    def relative_angle(self, first: Point, second: Point, ratio: float = 1.0) -> float:
        """Return the angle of the second body minus ratio times that of the first, rad."""

    def distance(self, first: Point, second: Point) -> float:
        """Return the distance of two points, m."""

    def displacement_along(self, first: Point, second: Point, angle: float, body: str = GROUND) -> float:
        """Return the displacement from the first to the second point along a direction at `angle` (rad) from the x axis of a body, m."""


class Glyph(Enum):
    """What the generic drawing shows of a joint."""

    BAR = auto()
    """A bar between the points."""
    PINS = auto()
    """Pins at both points."""
    PIN = auto()
    """A pin at the second point."""
    PIN_IN_SLOT = auto()
    """A pin at the second point, unless that is a bead."""
    PIN_ON_BLOCK = auto()
    """A pin at the second point where one of the bodies rotates."""
    FEET = auto()
    """A foot under each point on the ground."""
    FOOT = auto()
    """A foot under the second point if it is on the ground."""
    GUIDE = auto()
    """A straight guide, and a block at the second point."""
    SLOT = auto()
    """A slot along a curve."""
    PATH = auto()
    """A line along which the second point is driven."""
    WHEELS = auto()
    """Two meshing wheels."""
    RACK = auto()
    """A wheel at the first point, and a rack that is the second body."""


@dataclass(frozen=True, kw_only=True)
class Joint:
    """Base class of a holonomic constraint between two points.

    Attributes
    ----------
    name
        Name in messages and results.
    first, second
        Points on two different bodies.
    """

    noun: ClassVar[str] = ""
    """Word for it in messages, if that is not the name of the class."""
    type_name: ClassVar[str] = ""
    """Its `type` in [[joint]] of a scene file; empty if no file can have it."""
    keys: ClassVar[Mapping[str, Declaration]] = {}
    """Keys of its table that are no fields."""
    joins_bodies: ClassVar[bool] = False
    """Whether its ends in a scene file may be bodies without a point."""
    glyphs: ClassVar[frozenset[Glyph]] = frozenset()
    """What the generic drawing shows of it."""

    name: str
    first: Point
    second: Point

    def __post_init__(self) -> None:
        if self.first.body == self.second.body:
            raise MechanismError(f"joint {self.name!r} joins body {self.first.body!r} to itself; a joint needs two different bodies")
        require_valid_fields(self, f"{self.noun or class_words(self)} {self.name!r}")

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that it joins, the ground among them."""
        return self.first.body, self.second.body

    @classmethod
    def create(cls, **values: Any) -> Self:
        """Return the joint with the values of its table in a scene file."""
        return cls(**values)

    @classmethod
    def initial_values(cls, given: Mapping[str, Any], first_configuration: FirstConfiguration) -> Mapping[str, Any]:
        """Return the values that follow from the first configuration where a table leaves them out; `given` has all keys."""
        return {}

    @classmethod
    def find_conflicts(cls, given: Mapping[str, Any]) -> Iterator[str]:
        """Yield the problems of keys that are missing, or exclude each other."""
        yield from ()

    def constraint_rows(self, length_scale: float) -> list[ConstraintRow]:
        """Return the equations of the joint, with residual, Jacobian and gamma; `length_scale` (m) converts angles to lengths."""
        raise NotImplementedError

    def impulse_parts(self) -> tuple[ImpulsePart, ...]:
        """Return the pymunk constraints that make up the joint; none if engine impulse refuses it."""
        return ()
