"""Guide curves y = f(x) and closed curves r = f(angle) for points, and outlines that touch. Frozen values without mathematics."""

import math
from dataclasses import dataclass
from itertools import accumulate, pairwise

from governor_mechanism.errors import MechanismError, require_finite, require_not_negative, require_positive, require_rising
from governor_mechanism.model.time_functions import AngleHarmonic
from governor_mechanism.units.fields import entry, quantity, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Base class of a curve that guides a point; lengths in m."""


@dataclass(frozen=True, kw_only=True)
class PolynomialCurve(Curve):
    """A polynomial y = c0 + c1 x + c2 x^2 + ... of any degree.

    Attributes
    ----------
    coefficients
        c0, c1, ... in m, 1, 1/m, ...; one or more. A parabola has three.
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.coefficients:
            raise MechanismError("a polynomial curve needs at least one coefficient; [0] is the x axis")
        for value in self.coefficients:
            require_finite(value, "", "coefficient of a curve")


@dataclass(frozen=True, kw_only=True)
class SplineCurve(Curve):
    """A cubic spline through given points. It ends at the first and at the last point.

    Attributes
    ----------
    x
        Abscissas, m, strictly rising; two or more.
    y
        Ordinates, m; as many as x.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.x) != len(self.y) or len(self.x) < 2:
            raise MechanismError(f"the table of a curve needs two points or more, x and y each; got {len(self.x)} and {len(self.y)}")
        for x, y in zip(self.x, self.y, strict=True):
            require_finite(x, "m", "x of a curve's point")
            require_finite(y, "m", "y of a curve's point")
        require_rising(self.x, "x of a curve's points", " m")


@dataclass(frozen=True, kw_only=True)
class PolarCurve(Curve):
    """Base class of a closed curve about its origin, with one radius (m) in each direction."""

    @property
    def typical_radius(self) -> float:
        """A radius between the smallest and the largest, m."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class PolarSpline(PolarCurve):
    """A periodic cubic spline of the radius over the angle, with continuous curvature everywhere.

    Attributes
    ----------
    angles
        Directions, rad, strictly rising within one turn; three or more.
    radii
        Radii, m, positive; as many as angles.
    """

    angles: tuple[float, ...]
    radii: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.angles) != len(self.radii) or len(self.angles) < 3:
            raise MechanismError(
                "the table of a closed curve needs three points or more, angle and radius each; "
                f"got {len(self.angles)} and {len(self.radii)}"
            )
        for angle, radius in zip(self.angles, self.radii, strict=True):
            require_finite(angle, "rad", "angle of a closed curve's point")
            require_positive(radius, "m", "radius of a closed curve's point")
        require_rising(self.angles, "angles of a closed curve's points", " rad")
        span = self.angles[-1] - self.angles[0]
        if span >= math.tau:
            raise MechanismError(
                "the angles of a closed curve's points must lie within one turn; "
                f"from the first to the last it is {math.degrees(span):.6g} deg. "
                "The curve closes by itself: leave out a point that repeats the first"
            )

    @property
    def typical_radius(self) -> float:
        """The radius of the first point, m."""
        return self.radii[0]


@dataclass(frozen=True, kw_only=True)
class PolarHarmonics(PolarCurve):
    """A closed curve with the radius r = radius + the sum of amplitude * sin(order * angle + phase).

    Attributes
    ----------
    radius
        Mean radius, m; larger than the sum of all amplitudes.
    harmonics
        The harmonics, of whole orders, so that the curve closes.
    """

    radius: float
    harmonics: tuple[AngleHarmonic, ...] = ()

    def __post_init__(self) -> None:
        require_positive(self.radius, "m", "radius of a closed curve")
        for one in self.harmonics:
            if one.order != round(one.order) or one.order < 1:
                raise MechanismError(f"a closed curve has a harmonic of order {one.order:g}; it closes with orders 1, 2, 3, ... only")
        if (total := sum(abs(one.amplitude) for one in self.harmonics)) >= self.radius:
            raise MechanismError(
                f"the amplitudes of a closed curve add up to {total:g} m and must be less than its radius, {self.radius:g} m: "
                "it goes round its origin"
            )

    @property
    def typical_radius(self) -> float:
        """The mean radius, m."""
        return self.radius


CYCLOIDAL, HARMONIC = "cycloidal", "harmonic"
"""Laws of a lift: s = h (u - sin(2 pi u) / 2 pi), without a jump of the acceleration, and s = h (1 - cos(pi u)) / 2, u from 0 to 1."""


ROLLER, FLAT = "roller", "flat"
"""What a cam lifts: the centre of a roller, whose path is the curve, or a flat follower."""


@dataclass(frozen=True, kw_only=True)
class Lift:
    """A part of a turn of a cam in which its radius rises, falls or stays.

    Attributes
    ----------
    over
        Angle of this part, rad.
    lift
        Rise of the radius, m; negative where it falls, 0 for a dwell.
    law
        Law of the lift: "cycloidal" or "harmonic".
    """

    over: float = quantity("angle", meaning="the angle of this part of a turn")
    lift: float = quantity("length", sign="any", default=0.0, meaning="the rise of the radius; negative where it falls, 0 for a dwell")
    law: str = entry("choice", words=(CYCLOIDAL, HARMONIC), default=CYCLOIDAL, meaning="the law of the lift")

    def __post_init__(self) -> None:
        require_valid_fields(self, "a lift")


@dataclass(frozen=True, kw_only=True)
class LiftCurve(PolarCurve):
    """A closed curve with a radius that rises and falls by laws of cams, from angle 0 on anticlockwise.

    Attributes
    ----------
    radius
        Radius at angle 0, m.
    lifts
        The parts of the turn, one after the other: their angles are a whole turn, and their lifts add up to 0.
    follower
        What is lifted: "roller" if the radius is that of the path of a roller's centre, or "flat" if it is the distance of a flat follower
        from the centre of the cam, which touches the curve.
    """

    radius: float
    lifts: tuple[Lift, ...]
    follower: str = ROLLER

    def __post_init__(self) -> None:
        require_positive(self.radius, "m", "radius of a cam")
        if self.follower not in (ROLLER, FLAT):
            raise MechanismError(f"the follower of a cam is {ROLLER!r} or {FLAT!r}; got {self.follower!r}")
        turn = math.fsum(one.over for one in self.lifts)
        lift = math.fsum(one.lift for one in self.lifts)
        if not math.isclose(turn, math.tau, rel_tol=1e-9):
            raise MechanismError(f"the angles of a cam's lifts must add up to a turn; they are {math.degrees(turn):.9g} deg together")
        if abs(lift) > 1e-12 * self.radius:
            raise MechanismError(f"the lifts of a cam must add up to 0, so that its curve closes; they are {lift:g} m together")
        if min(self.radii_at_starts) <= 0.0:
            raise MechanismError("a cam falls to a radius that is not positive; give it a larger radius, or smaller lifts")

    @property
    def radii_at_starts(self) -> tuple[float, ...]:
        """The radius where each part of the turn begins, m."""
        return tuple(accumulate((one.lift for one in self.lifts[:-1]), initial=self.radius))

    @property
    def typical_radius(self) -> float:
        """The radius at angle 0, m."""
        return self.radius


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
