"""Outlines of bodies, along which other parts touch them. Frozen values without mathematics."""

import math
from dataclasses import dataclass
from itertools import pairwise

from governor_mechanism.errors import MechanismError, require_finite, require_not_negative
from governor_mechanism.model.curves import PolarCurve


@dataclass(frozen=True, kw_only=True)
class Outline:
    """Base class of an outline in axes of its own; lengths in m."""


@dataclass(frozen=True, kw_only=True)
class CurveOutline(Outline):
    """A closed curve about the origin, or the curve at a distance inside of it, as a cam inside of the path of its roller.

    Attributes
    ----------
    curve
        The curve.
    inset
        Distance of the outline inside of the curve, m.
    """

    curve: PolarCurve
    inset: float = 0.0

    def __post_init__(self) -> None:
        require_not_negative(self.inset, "m", "inset of an outline")


@dataclass(frozen=True, kw_only=True)
class Corner:
    """A corner of an outline, and the edge from there to the next one.

    Attributes
    ----------
    x, y
        Position, m.
    radius
        Radius of the edge, which is the shorter arc, m: positive where it bulges out of the part, negative where it is hollow, and 0 for
        a straight edge.
    """

    x: float
    y: float
    radius: float = 0.0

    def __post_init__(self) -> None:
        for name in ("x", "y", "radius"):
            require_finite(getattr(self, name), "m", f"{name} of a corner")


@dataclass(frozen=True, kw_only=True)
class CornerOutline(Outline):
    """A closed outline of straight edges and arcs.

    Attributes
    ----------
    corners
        The corners, in either direction round the part; two or more.
    """

    corners: tuple[Corner, ...]

    def __post_init__(self) -> None:
        if len(self.corners) < 2 or (len(self.corners) == 2 and not any(corner.radius for corner in self.corners)):
            raise MechanismError("an outline needs three corners or more; two with an arc between them make part of a disc")
        problems = []
        for number, (start, end) in enumerate(pairwise((*self.corners, self.corners[0])), start=1):
            length = math.dist((start.x, start.y), (end.x, end.y))
            if length == 0.0:
                problems.append(f"edge {number} of an outline has no length: it begins and ends at ({start.x:g} m, {start.y:g} m)")
            elif start.radius and 2.0 * abs(start.radius) < length * (1.0 - 1e-12):
                bound = f"must be at least half the distance of its ends, {length / 2:g} m"
                problems.append(f"edge {number} of an outline is an arc with the radius {abs(start.radius):g} m, which {bound}")
        if problems:
            raise MechanismError(*problems)
