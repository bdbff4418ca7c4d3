"""What holds bodies together: points marked on bodies, and the joints between them. Frozen values, no maths."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_positive

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
            raise MechanismError(
                f"joint {self.name!r} joins body {self.first.body!r} to itself; a joint needs two different bodies"
            )


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
