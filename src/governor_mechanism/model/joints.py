"""Points on bodies and the joints between them. Frozen values without mathematics."""

from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.curves import Curve
from governor_mechanism.model.measured_fields import class_words, measured, require_valid_fields
from governor_mechanism.model.time_functions import PrescribedMotion

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
    x: float = measured("m", default=0.0)
    y: float = measured("m", default=0.0)

    def __post_init__(self) -> None:
        require_valid_fields(self, f"a point on body {self.body!r}")


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

    name: str
    first: Point
    second: Point

    def __post_init__(self) -> None:
        if self.first.body == self.second.body:
            raise MechanismError(f"joint {self.name!r} joins body {self.first.body!r} to itself; a joint needs two different bodies")
        require_valid_fields(self, f"{self.noun or class_words(self)} {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Pin(Joint):
    """A revolute joint: the two points coincide. It removes two degrees of freedom."""


@dataclass(frozen=True, kw_only=True)
class Distance(Joint):
    """A massless link: the two points keep their distance. It removes one degree of freedom.

    Attributes
    ----------
    length
        Distance of the points, m; positive.
    """

    noun = "link"

    length: float = measured("m", positive=True)


@dataclass(frozen=True, kw_only=True)
class Slider(Joint):
    """The second point moves on a straight line of the first body. The joint removes one degree of freedom.

    Attributes
    ----------
    angle
        Direction of the line through the first point, rad, anticlockwise from the x axis of the first body.
    """

    angle: float = measured("rad")


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """A rigid connection: the points coincide and the relative angle is constant. It removes three degrees of freedom.

    Attributes
    ----------
    relative_angle
        Angle of the second body minus that of the first, rad.
    """

    relative_angle: float = measured("rad", default=0.0)


@dataclass(frozen=True, kw_only=True)
class Prismatic(Slider):
    """A slider whose bodies keep their relative angle. It removes two degrees of freedom.

    Attributes
    ----------
    relative_angle
        Angle of the second body minus that of the first, rad.
    """

    noun = "prismatic joint"

    relative_angle: float = measured("rad", default=0.0)


@dataclass(frozen=True, kw_only=True)
class ArcSlot(Joint):
    """The second point moves in a circular slot of the first body about the first point. It removes one degree of freedom.

    Attributes
    ----------
    radius
        Radius of the slot, m; positive.
    """

    radius: float = measured("m", positive=True)


@dataclass(frozen=True, kw_only=True)
class CurveSlot(Joint):
    """The second point moves on a curve y = curve(x) of the first body. It removes one degree of freedom.

    Attributes
    ----------
    curve
        Curve in axes with their origin at the first point.
    angle
        Direction of the curve's x axis, rad, anticlockwise from the x axis of the first body.
    """

    curve: Curve
    angle: float = measured("rad", default=0.0)


@dataclass(frozen=True, kw_only=True)
class Gear(Joint):
    """A gear pair: the angle of the second body is ratio * angle of the first + offset. It removes one degree of freedom.

    Both angles are measured in the plane. The points only give the centres of the wheels.

    Attributes
    ----------
    ratio
        Ratio of the angles; negative for external teeth, not 0.
    offset
        Angle of the second body at zero angle of the first, rad.
    """

    ratio: float = measured("")
    offset: float = measured("rad", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ratio == 0.0:
            raise MechanismError(f"ratio of gear {self.name!r} must not be 0; to fix a body use a weld")


@dataclass(frozen=True, kw_only=True)
class RackAndPinion(Joint):
    """A pinion, the first body, drives a rack: the displacement of the second point is radius * angle + offset.

    The displacement is measured from the first point, the centre of the pinion. The joint removes one degree of freedom.

    Attributes
    ----------
    radius
        Pitch radius, m; negative for the opposite direction, not 0.
    angle
        Direction of the displacement, rad, anticlockwise from the x axis of the plane.
    offset
        Displacement at zero angle of the pinion, m.
    """

    noun = "rack"

    radius: float = measured("m")
    angle: float = measured("rad", default=0.0)
    offset: float = measured("m", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.radius == 0.0:
            raise MechanismError(f"radius of rack {self.name!r} must not be 0")


@dataclass(frozen=True, kw_only=True)
class ProportionalDisplacement(Joint):
    """A massless linkage: the displacement of the second point is ratio * displacement of the first + offset.

    Both displacements are measured in the plane along one direction. The joint removes one degree of freedom.

    Attributes
    ----------
    ratio
        Ratio of the displacements.
    angle
        Direction, rad, anticlockwise from the x axis of the plane.
    offset
        Displacement of the second point at zero displacement of the first, m.
    """

    noun = "proportion"

    ratio: float = measured("")
    angle: float = measured("rad")
    offset: float = measured("m", default=0.0)


@dataclass(frozen=True, kw_only=True)
class RotationalDriver(Joint):
    """A rotational driver: the angle of the second body minus that of the first follows a prescribed motion.

    Attributes
    ----------
    motion
        Relative angle over time, rad.
    """

    motion: PrescribedMotion


@dataclass(frozen=True, kw_only=True)
class TranslationalDriver(Joint):
    """A translational driver: the displacement of the second point along a line of the first body follows a prescribed motion.

    The displacement is measured from the first point. Across the line the point is free.

    Attributes
    ----------
    motion
        Displacement over time, m.
    angle
        Direction of the line, rad, anticlockwise from the x axis of the first body.
    """

    noun = "driver"

    motion: PrescribedMotion
    angle: float = measured("rad")


_SLOTS_AND_PINS = (Pin, Distance, Slider, Weld, Prismatic, ArcSlot, CurveSlot)
_TRANSMISSIONS = (Gear, RackAndPinion, ProportionalDisplacement, RotationalDriver, TranslationalDriver)
JOINT_TYPES: frozenset[type[Joint]] = frozenset((*_SLOTS_AND_PINS, *_TRANSMISSIONS))
"""All types of joints."""
