"""Points on bodies, and what every joint has: data, constraint rows, keys in scene files, parts for engine impulse, and a drawing."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, ClassVar, Protocol, Self

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints.constraint_row import ConstraintRow
from governor_mechanism.model.joints.impulse_parts import ImpulsePart
from governor_mechanism.units.fields import Declaration, class_words, quantity, require_valid_fields

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
