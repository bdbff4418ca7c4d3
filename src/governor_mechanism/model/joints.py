"""What holds bodies together: points marked on bodies, and the joints between them. Frozen values, no maths."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.model.curves import Curve
from governor_mechanism.model.time_functions import PrescribedMotion

GROUND = "ground"
"""The plane the mechanism lives in: fixed, or turning with the spindle."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A point marked on a body, in the body's own axes (m, from its mass centre); on GROUND in the plane's axes."""

    body: str
    x: float = 0.0
    y: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self.x, "m", f"x of a point on body {self.body!r}")
        require_finite(self.y, "m", f"y of a point on body {self.body!r}")


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A holonomic constraint between two points; `name` is what messages call it."""

    name: str
    first: Point
    second: Point

    def __post_init__(self) -> None:
        if self.first.body == self.second.body:
            raise MechanismError(f"joint {self.name!r} joins body {self.first.body!r} to itself; a joint needs two different bodies")


@dataclass(frozen=True, kw_only=True)
class Pin(Joint):
    """The two points coincide; the bodies may turn about each other. Takes two freedoms."""


@dataclass(frozen=True, kw_only=True)
class Distance(Joint):
    """A massless link: the two points keep `length` (m). Takes one freedom."""

    length: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_positive(self.length, "m", f"length of link {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Slider(Joint):
    """The second point runs on a straight line of the first body. Takes one freedom.

    The line passes through the first point at `angle` (rad, anticlockwise from that body's x axis).
    """

    angle: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(self.angle, "rad", f"angle of slider {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Weld(Joint):
    """The two points coincide and the bodies keep `turn` (rad): the second's angle less the first's. Takes three."""

    relative_angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(self.relative_angle, "rad", f"turn of weld {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Prismatic(Slider):
    """A slider whose bodies also keep `turn` (rad): the second's angle less the first's. Takes two freedoms."""

    relative_angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(self.relative_angle, "rad", f"turn of prismatic joint {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class ArcSlot(Joint):
    """The second point runs in a slot of the first body, an arc of `radius` (m) about the first point. Takes one."""

    radius: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_positive(self.radius, "m", f"radius of arc slot {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class CurveSlot(Joint):
    """The second point runs on a curve of the first body, y = curve(x). Takes one freedom.

    The curve's axes have their origin in the first point, x at `angle` (rad, anticlockwise) from the body's x axis.
    """

    curve: Curve
    angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(self.angle, "rad", f"angle of curve slot {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Gear(Joint):
    """The second body's angle is ratio * the first's + offset (rad), each against the plane. Takes one freedom.

    Toothed wheels that mesh outside have a negative ratio. The points only say where the wheels' centres are.
    """

    ratio: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(self.ratio, "", f"ratio of gear {self.name!r}")
        require_finite(self.offset, "rad", f"offset of gear {self.name!r}")
        if self.ratio == 0.0:
            raise MechanismError(f"ratio of gear {self.name!r} must not be 0; to hold a body still use a weld")


@dataclass(frozen=True, kw_only=True)
class RackAndPinion(Joint):
    """A pinion, the first body, drives a rack: the second point's way along a direction is radius * angle + offset.

    The way (m) is counted from the first point, the pinion's centre, along `angle` (rad, anticlockwise from the plane's
    x axis). A negative radius (m) drives the other way. Takes one freedom.
    """

    radius: float
    angle: float = 0.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, unit in (("radius", "m"), ("angle", "rad"), ("offset", "m")):
            require_finite(getattr(self, name), unit, f"{name} of rack {self.name!r}")
        if self.radius == 0.0:
            raise MechanismError(f"radius of rack {self.name!r} must not be 0")


@dataclass(frozen=True, kw_only=True)
class ProportionalDisplacement(Joint):
    """A linkage without mass moves the second point along a direction ratio times as far as the first, plus offset (m).

    Both ways are counted in the plane, along `angle` (rad, anticlockwise from x). Takes one freedom.
    """

    ratio: float
    angle: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, unit in (("ratio", ""), ("angle", "rad"), ("offset", "m")):
            require_finite(getattr(self, name), unit, f"{name} of proportion {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class RotationalDriver(Joint):
    """A drive turns the second body against the first: its angle less the first's follows `motion` (rad)."""

    motion: PrescribedMotion


@dataclass(frozen=True, kw_only=True)
class TranslationalDriver(Joint):
    """A drive moves the second point along a line of the first body: its way from the first point follows `motion` (m).

    The line has `angle` (rad, anticlockwise from the first body's x axis). Across the line the point is free.
    """

    motion: PrescribedMotion
    angle: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite(self.angle, "rad", f"angle of drive {self.name!r}")


JOINT_TYPES: frozenset[type[Joint]] = frozenset(
    {
        Pin,
        Distance,
        Slider,
        Weld,
        Prismatic,
        ArcSlot,
        CurveSlot,
        Gear,
        RackAndPinion,
        ProportionalDisplacement,
        RotationalDriver,
        TranslationalDriver,
    }
)
