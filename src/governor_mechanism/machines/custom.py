"""User-defined mechanisms: bodies with named points in an initial configuration. SI units."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Final

from governor_mechanism.machines.base import MIN_DIMENSION, MassElement, join_elements, rotate_point, slender_rod, solid_ball
from governor_mechanism.model.curves import Outline, SplineCurve
from governor_mechanism.model.force_elements import Damper, ForceElement, Spring, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, CurveSlot, Distance, Joint, Point, RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Body, BodyOutline, Mechanism, NamedPoint, SecondMoments
from governor_mechanism.model.output_variables import Limit, OutlineGap, PointCoordinate, Reading
from governor_mechanism.model.valve import Valve
from governor_mechanism.types import Vector2

CUSTOM_MACHINE: Final = "custom"
"""Name of a user-defined machine in scene files."""


@dataclass(frozen=True, kw_only=True)
class BodyShape:
    """Mass distribution of a body and named points in its own axes.

    Attributes
    ----------
    element
        Mass, mass centre and second moments of mass.
    points
        Positions of named points, m.
    extent
        Largest dimension, m.
    """

    element: MassElement
    points: Mapping[str, Vector2] = field(default_factory=dict)
    extent: float = 0.0


def rod_shape(mass: float, length: float) -> BodyShape:
    """Return a slender uniform rod of a mass (kg) and length (m) along x from the origin, with the points `start` and `end`."""
    ends = {"start": (0.0, 0.0), "end": (length, 0.0)}
    return BodyShape(element=slender_rod(mass, ends["end"]), points=ends, extent=length)


def disc_shape(mass: float, radius: float, thickness: float = 0.0) -> BodyShape:
    """Return a uniform disc of a mass (kg), radius and thickness (m) in the plane with its centre at the origin."""
    moment_in_plane = mass * radius**2 / 4
    moments = SecondMoments(xx=moment_in_plane, yy=moment_in_plane, zz=mass * thickness**2 / 12)
    return BodyShape(element=MassElement(mass=mass, moments=moments), extent=2 * radius)


def plate_shape(mass: float, width: float, height: float, thickness: float = 0.0) -> BodyShape:
    """Return a uniform plate of a mass (kg), width along x, height along y, thickness (m) in the plane with its centre at the origin."""
    moments = SecondMoments(xx=mass * width**2 / 12, yy=mass * height**2 / 12, zz=mass * thickness**2 / 12)
    return BodyShape(element=MassElement(mass=mass, moments=moments), extent=math.hypot(width, height))


def add_point_masses(shape: BodyShape, point_masses: Sequence[tuple[float, Vector2, float]]) -> BodyShape:
    """Return the rigid body of a shape and solid balls: mass (kg), position in its axes and radius (m); a point has no radius."""
    elements = [shape.element, *(solid_ball(*ball) for ball in point_masses)]
    distances = [math.dist(one.centre, other.centre) for one, other in combinations(elements, 2)]
    extent = max([shape.extent, *distances, *(2 * radius for _, _, radius in point_masses)])
    return replace(shape, element=join_elements(elements), extent=extent)


@dataclass(frozen=True, kw_only=True)
class SketchedBody:
    """A body of the user: points in its own axes, and the pose of these axes in the initial configuration."""

    name: str
    shape: BodyShape
    can_rotate: bool = True
    points: Mapping[str, Vector2] = field(default_factory=dict)  # named by the user, m
    origin: Vector2 = (0.0, 0.0)  # of its axes, m
    angle: float = 0.0  # of its axes, rad
    outline: Outline | None = None  # in its axes, which other parts may touch

    @property
    def named_points(self) -> dict[str, Vector2]:
        """All named points in the axes of the body, m."""
        return {"origin": (0.0, 0.0), "centre": self.shape.element.centre, **self.shape.points, **self.points}

    @property
    def body(self) -> Body:
        """The body of the model."""
        element = self.shape.element
        return Body(name=self.name, mass=element.mass, second_moments=element.moments, can_rotate=self.can_rotate)

    @property
    def pose(self) -> tuple[float, float, float]:
        """Initial pose of the mass centre (m, m, rad)."""
        x, y = rotate_point(*self.shape.element.centre, self.angle)
        return self.origin[0] + x, self.origin[1] + y, self.angle

    def point(self, position: Vector2) -> Point:
        """Return a position in the axes of the body as a point relative to the mass centre."""
        x, y = self.shape.element.centre
        return Point(body=self.name, x=position[0] - x, y=position[1] - y)


class InitialConfiguration:
    """Initial poses of all bodies."""

    def __init__(self, bodies: Iterable[SketchedBody]) -> None:
        self.poses = {GROUND: (0.0, 0.0, 0.0)} | {body.name: body.pose for body in bodies}

    def position(self, point: Point) -> Vector2:
        """Return the position of a point, m."""
        x, y, angle = self.poses[point.body]
        dx, dy = rotate_point(point.x, point.y, angle)
        return x + dx, y + dy

    def relative_angle(self, first: Point, second: Point, ratio: float = 1.0) -> float:
        """Return the angle of the second body minus ratio times that of the first, rad."""
        return self.poses[second.body][2] - ratio * self.poses[first.body][2]

    def distance(self, first: Point, second: Point) -> float:
        """Return the distance of two points, m."""
        return math.dist(self.position(first), self.position(second))

    def displacement_along(self, first: Point, second: Point, angle: float, body: str = GROUND) -> float:
        """Return the displacement from the first to the second point along a direction at `angle` (rad) from the x axis of a body, m."""
        direction = angle + self.poses[body][2]
        (x1, y1), (x2, y2) = self.position(first), self.position(second)
        return (x2 - x1) * math.cos(direction) + (y2 - y1) * math.sin(direction)


@dataclass(frozen=True, kw_only=True)
class MechanismSketch:
    """The elements of a mechanism, with bodies in their initial configuration."""

    bodies: Sequence[SketchedBody]
    joints: Sequence[Joint]
    force_elements: Sequence[ForceElement]
    ground: Mapping[str, Vector2] = field(default_factory=dict)  # points of the ground that rest, m
    gaps: Sequence[OutlineGap] = ()  # between rollers and outlines

    @property
    def length_scale(self) -> float:
        """Length, m, that scales: the largest distance in a body, the longest link, else an extent, of a body or the start; or 0."""
        attachment_points = [end for one in (*self.joints, *self.force_elements) for end in vars(one).values() if isinstance(end, Point)]
        distances_on_body = [joint.length for joint in self.joints if isinstance(joint, Distance)]
        for body in self.bodies:
            points = [body.point(place) for place in body.named_points.values()]
            points += [point for point in attachment_points if point.body == body.name]
            distances_on_body += [math.hypot(p.x - q.x, p.y - q.y) for p, q in combinations(points, 2)]
        configuration = InitialConfiguration(self.bodies)
        positions = {configuration.position(point) for point in (*attachment_points, *(body.point((0.0, 0.0)) for body in self.bodies))}
        distances = [math.dist(p, q) for p, q in combinations(positions, 2)]
        extents = [body.shape.extent for body in self.bodies]
        # Equal positions computed in different ways differ by rounding.
        sizes = (max(values, default=0.0) for values in (distances_on_body, extents, distances))
        return next((size for size in sizes if size >= MIN_DIMENSION), 0.0)

    @property
    def unconnected_bodies(self) -> list[str]:
        """Names of the bodies that no chain of joints, springs, dampers or contacts connects to the ground."""
        connecting_types = (Spring, Damper, TorsionSpring, TorsionDamper)
        connections = [joint.bodies for joint in self.joints]
        connections += [load.bodies for load in self.force_elements if isinstance(load, connecting_types)]
        connections += [(gap.roller.body, gap.origin.body) for gap in self.gaps]
        connected, previous_count = {GROUND}, 0
        while len(connected) > previous_count:
            previous_count = len(connected)
            connected |= {body for tie in connections if connected & set(tie) for body in tie}
        return [body.name for body in self.bodies if body.name not in connected]

    @property
    def conflicting_drivers(self) -> list[tuple[Joint, Joint]]:
        """Pairs of drivers that rotate the same two bodies or move them along the same direction."""
        drivers = [joint for joint in self.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
        return [(one, other) for one, other in combinations(drivers, 2) if _are_conflicting(one, other)]

    def build(self, readings: Sequence[Reading], coordinate: str, length_scale: float, valve: Valve | None = None) -> Mechanism:
        """Build the mechanism with its leading coordinate and length scale (m); a run ends where a point leaves the table of its slot."""
        slots = [slot for slot in self.joints if isinstance(slot, CurveSlot)]
        ranges = [_slot_range(slot, slot.curve) for slot in slots if isinstance(slot.curve, SplineCurve)]
        return Mechanism(
            bodies=tuple(body.body for body in self.bodies),
            joints=tuple(self.joints),
            readings=tuple(readings),
            coordinate=coordinate,
            length_scale=length_scale,
            initial_guess=tuple(body.pose for body in self.bodies),
            limits=tuple(limit for _, limit in ranges),
            internal_outputs=(*(coordinate for coordinate, _ in ranges), *(gap.slip for gap in self.gaps if gap.friction > 0.0)),
            force_elements=tuple(self.force_elements),
            valve=valve,
            points=tuple(self._named_points()),
            ends=tuple(self._ends()),
            outlines=tuple(
                BodyOutline(origin=body.point((0.0, 0.0)), outline=body.outline) for body in self.bodies if body.outline is not None
            ),
        )

    def _named_points(self) -> Iterator[NamedPoint]:
        """Yield the points that the user named; those of the same name have that of their body in front."""
        counts = Counter(name for body in self.bodies for name in body.points)
        for body in self.bodies:
            for name, position in body.points.items():
                yield NamedPoint(name=name if counts[name] == 1 else f"{body.name}.{name}", point=body.point(position))

    def _ends(self) -> Iterator[NamedPoint]:
        """Yield the ends of rods and the points of the ground, as joints name them."""
        for body in self.bodies:
            for name, position in body.shape.points.items():
                yield NamedPoint(name=f"{body.name}.{name}", point=body.point(position))
        for name, (x, y) in self.ground.items():
            yield NamedPoint(name=f"{GROUND}.{name}", point=Point(body=GROUND, x=x, y=y))


def _are_conflicting(one: Joint, other: Joint) -> bool:
    if {one.first.body, one.second.body} != {other.first.body, other.second.body}:
        return False
    if isinstance(one, TranslationalDriver) and isinstance(other, TranslationalDriver):
        return one.first.body != other.first.body or abs(math.sin(one.angle - other.angle)) < 1e-9
    return isinstance(one, RotationalDriver) and isinstance(other, RotationalDriver)


def _slot_range(slot: CurveSlot, table: SplineCurve) -> tuple[PointCoordinate, Limit]:
    """Return the coordinate along the axis of a slot, and its range in the table of the slot."""
    direction = {"direction_x": math.cos(slot.angle), "direction_y": math.sin(slot.angle)}
    coordinate = PointCoordinate(name=f"way in {slot.name}", quantity="length", point=slot.second, origin=slot.first, **direction)
    text = f"the point leaves the table of curve slot {slot.name!r} at its"
    messages = {"low_message": f"{text} first point", "high_message": f"{text} last point"}
    return coordinate, Limit(reading=coordinate.name, low=table.x[0], high=table.x[-1], **messages)
