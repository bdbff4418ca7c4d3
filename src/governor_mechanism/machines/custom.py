"""A mechanism of the user's own: bodies sketched with their marked points, and what follows from the sketch. SI."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Final

from governor_mechanism.machines.base import SMALLEST
from governor_mechanism.model.curves import Table
from governor_mechanism.model.force_elements import Damper, Load, Spring, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, CurveSlot, Distance, DrivenSlide, DrivenTurn, Joint, Point
from governor_mechanism.model.mechanism import Body, Coordinate, Limit, Mechanism, Reading, SecondMoments

CUSTOM: Final = "custom"
"""The name of such a machine in scene files."""

Pair = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Shape:
    """How the mass of a body lies: moments about the mass centre, and marks in axes of its own."""

    moments: SecondMoments
    centre: Pair = (0.0, 0.0)
    points: Mapping[str, Pair] = field(default_factory=dict)
    extent: float = 0.0


def rod(mass: float, length: float) -> Shape:
    """A slender uniform rod along x, its first end in the origin."""
    return Shape(
        moments=SecondMoments(xx=mass * length**2 / 12),
        centre=(length / 2, 0.0),
        points={"start": (0.0, 0.0), "end": (length, 0.0)},
        extent=length,
    )


def disc(mass: float, radius: float, thickness: float = 0.0) -> Shape:
    """A uniform disc in the plane, its centre in the origin."""
    across = mass * radius**2 / 4
    return Shape(moments=SecondMoments(xx=across, yy=across, zz=mass * thickness**2 / 12), extent=2 * radius)


def plate(mass: float, width: float, height: float, thickness: float = 0.0) -> Shape:
    """A uniform plate in the plane, width along x, its centre in the origin."""
    return Shape(
        moments=SecondMoments(xx=mass * width**2 / 12, yy=mass * height**2 / 12, zz=mass * thickness**2 / 12),
        extent=math.hypot(width, height),
    )


@dataclass(frozen=True, kw_only=True)
class Sketched:
    """A body as its user draws it: points in axes of its own, whose origin stands at `at`, turned by `angle` (rad)."""

    name: str
    mass: float
    shape: Shape
    turns: bool = True
    points: Mapping[str, Pair] = field(default_factory=dict)
    at: Pair = (0.0, 0.0)
    angle: float = 0.0

    @property
    def marks(self) -> dict[str, Pair]:
        """Every point with a name, in the body's own axes."""
        return {"origin": (0.0, 0.0), "centre": self.shape.centre, **self.shape.points, **self.points}

    @property
    def body(self) -> Body:
        """The same body as engines know it."""
        return Body(name=self.name, mass=self.mass, moments=self.shape.moments, turns=self.turns)

    @property
    def pose(self) -> tuple[float, float, float]:
        """Of the mass centre, in the sketch."""
        x, y = _turned(self.shape.centre, self.angle)
        return self.at[0] + x, self.at[1] + y, self.angle

    def point(self, place: Pair) -> Point:
        """A place in the body's own axes as a point counted from the mass centre."""
        return Point(body=self.name, x=place[0] - self.shape.centre[0], y=place[1] - self.shape.centre[1])


class Sketch:
    """Where everything stands at the start, as drawn."""

    def __init__(self, bodies: Iterable[Sketched]) -> None:
        self.poses = {GROUND: (0.0, 0.0, 0.0)} | {body.name: body.pose for body in bodies}

    def place(self, point: Point) -> Pair:
        """Where a point is (m)."""
        x, y, angle = self.poses[point.body]
        dx, dy = _turned((point.x, point.y), angle)
        return x + dx, y + dy

    def turn(self, first: Point, second: Point, ratio: float = 1.0) -> float:
        """The second body's angle less ratio * the first's (rad)."""
        return self.poses[second.body][2] - ratio * self.poses[first.body][2]

    def distance(self, first: Point, second: Point) -> float:
        """From point to point (m)."""
        return math.dist(self.place(first), self.place(second))

    def way(self, first: Point, second: Point, angle: float, body: str = GROUND) -> float:
        """From the first point to the second along a direction at `angle` (rad) from the body's x axis (m)."""
        direction = angle + self.poses[body][2]
        (x1, y1), (x2, y2) = self.place(first), self.place(second)
        return (x2 - x1) * math.cos(direction) + (y2 - y1) * math.sin(direction)


def _turned(place: Pair, angle: float) -> Pair:
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * place[0] - sine * place[1], sine * place[0] + cosine * place[1]


def size_of(bodies: Sequence[Sketched], joints: Iterable[Joint], loads: Iterable[Load]) -> float:
    """The length that accuracies refer to: of the widest body or longest link, else of the sketch; 0 if there is none.

    A body is as wide as its marked points lie apart, whether they have names or only joints and loads use them.
    """
    marked = {body.name: [body.point(place) for place in body.marks.values()] for body in bodies}
    joints = list(joints)
    for point in (*_ends(joints), *_ends(loads)):
        if point.body in marked:
            marked[point.body].append(point)
    widths = [math.hypot(p.x - q.x, p.y - q.y) for points in marked.values() for p, q in combinations(points, 2)]
    widest = max([*widths, *(joint.length for joint in joints if isinstance(joint, Distance))], default=0.0)
    sketch = Sketch(bodies)
    places = [
        sketch.place(point) for point in (*_ends(joints), *_ends(loads), *(body.point((0.0, 0.0)) for body in bodies))
    ]
    apart = (math.dist(p, q) for p, q in combinations(set(places), 2))
    extent = max((body.shape.extent for body in bodies), default=0.0)
    # Places reckoned in different ways differ by rounding, which is no width.
    return next((size for size in (widest, extent, max(apart, default=0.0)) if size >= SMALLEST), 0.0)


def _ends(held: Iterable[Joint | Load]) -> list[Point]:
    return [end for one in held for end in vars(one).values() if isinstance(end, Point)]


def unheld(bodies: Iterable[str], joints: Iterable[Joint], loads: Iterable[Load]) -> list[str]:
    """The bodies without any chain of joints, springs or dampers to the ground."""
    holding = (Spring, Damper, TorsionSpring, TorsionDamper)
    ties = [(joint.first.body, joint.second.body) for joint in joints]
    ties += [load.bodies for load in loads if isinstance(load, holding)]
    held, before = {GROUND}, 0
    while len(held) > before:
        before = len(held)
        held |= {body for tie in ties if held & set(tie) for body in tie}
    return [body for body in bodies if body not in held]


def contradictory_drives(joints: Iterable[Joint]) -> list[tuple[Joint, Joint]]:
    """Pairs of drives that turn the same two bodies, or move them along the same direction."""
    drives = [joint for joint in joints if isinstance(joint, DrivenTurn | DrivenSlide)]
    return [(one, other) for one, other in combinations(drives, 2) if _contradict(one, other)]


def _contradict(one: Joint, other: Joint) -> bool:
    if {one.first.body, one.second.body} != {other.first.body, other.second.body}:
        return False
    if isinstance(one, DrivenSlide) and isinstance(other, DrivenSlide):
        return one.first.body != other.first.body or abs(math.sin(one.angle - other.angle)) < 1e-9
    return isinstance(one, DrivenTurn) and isinstance(other, DrivenTurn)


def custom_mechanism(
    bodies: Sequence[Sketched],
    joints: Sequence[Joint],
    loads: Sequence[Load],
    readings: Sequence[Reading],
    coordinate: str,
    size: float,
) -> Mechanism:
    """The mechanism of a sketch; a run ends by name where a point leaves the table of its slot."""
    slots = [(slot, slot.curve) for slot in joints if isinstance(slot, CurveSlot) and isinstance(slot.curve, Table)]
    return Mechanism(
        bodies=tuple(body.body for body in bodies),
        joints=tuple(joints),
        readings=tuple(readings),
        coordinate=coordinate,
        size=size,
        sketch=tuple(body.pose for body in bodies),
        limits=tuple(_end_of_table(slot, curve) for slot, curve in slots),
        watched=tuple(_way_in(slot) for slot, _ in slots),
        loads=tuple(loads),
    )


def _way_in(slot: CurveSlot) -> Coordinate:
    return Coordinate(
        name=f"way in {slot.name}",
        quantity="length",
        point=slot.second,
        along_x=math.cos(slot.angle),
        along_y=math.sin(slot.angle),
        origin=slot.first,
    )


def _end_of_table(slot: CurveSlot, curve: Table) -> Limit:
    leaves = f"the point leaves the table of curve slot {slot.name!r} at its"
    return Limit(
        reading=_way_in(slot).name,
        low=curve.x[0],
        high=curve.x[-1],
        below=f"{leaves} first point",
        above=f"{leaves} last point",
    )
