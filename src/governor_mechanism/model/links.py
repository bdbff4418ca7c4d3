"""The links of a mechanism and the hinges where they meet: bodies and massless bars, and the pins and pivots between them."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, RotationalDriver, Slider, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import ArcPosition, BodyAngle, LineAngle, OutlineGap, PointCoordinate, PointDistance, Reading

SAME_POINT_DIGITS = 12
"""Significant decimal places, m, by which two points of one body are the same."""


@dataclass(frozen=True)
class Link:
    """A link: a body, or a massless bar by the name of its joint; the ground is one, too."""

    name: str
    is_bar: bool = False


@dataclass(frozen=True, eq=False)
class Hinge:
    """A point where links meet and can turn against each other."""

    points: dict[str, Point] = field(default_factory=dict)  # the point in the axes of each body that meets there
    bars: set[str] = field(default_factory=set)  # names of the bars that end there

    @property
    def links(self) -> list[Link]:
        """The links that meet there."""
        return [*map(Link, self.points), *(Link(bar, is_bar=True) for bar in sorted(self.bars))]

    @property
    def point(self) -> Point:
        """The point in the axes of one of the bodies, one that moves if there is any."""
        return next((point for body, point in self.points.items() if body != GROUND), next(iter(self.points.values())))


GROUND_LINK = Link(GROUND)


class LinkGraph:
    """The links of a mechanism and their hinges."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    @cached_property
    def hinges(self) -> tuple[Hinge, ...]:
        """All hinges of two or more links; points that pins join are one."""
        hinges: dict[tuple[str, float, float], Hinge] = {}
        for joint in self.mechanism.joints:
            if isinstance(joint, Pin):
                self._join(hinges, joint)
            elif isinstance(joint, Distance):
                for point in (joint.first, joint.second):
                    hinges.setdefault(_key(point), Hinge({point.body: point})).bars.add(joint.name)
        distinct = {id(hinge): hinge for hinge in hinges.values()}
        return tuple(hinge for hinge in distinct.values() if len(hinge.links) > 1)

    @staticmethod
    def _join(hinges: dict[tuple[str, float, float], Hinge], pin: Pin) -> None:
        """Make one hinge of both points of a pin."""
        first, second = (hinges.get(_key(point), Hinge({point.body: point})) for point in (pin.first, pin.second))
        joined = Hinge(first.points | second.points, first.bars | second.bars)
        for point in joined.points.values():
            hinges[_key(point)] = joined

    def hinges_of(self, link: Link) -> list[Hinge]:
        """Return the hinges of a link."""
        return [hinge for hinge in self.hinges if link in hinge.links]

    def inputs(self, drive: str = "") -> set[Link]:
        """Return the links that a reading drives; without one those that the drivers move, or else the leading coordinate."""
        drivers = [joint for joint in self.mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
        if not drive and drivers:
            return {Link(point.body) for joint in drivers for point in (joint.first, joint.second) if point.body != GROUND}
        name = drive or self.mechanism.coordinate
        readings = [one for one in self.mechanism.readings if one.name == name]
        return {Link(body) for reading in readings for body in bodies_of_reading(reading) if body != GROUND}

    def distances_from(self, starts: set[Link]) -> dict[Link, int]:
        """Return the number of joints on the shortest way from links to each other one; not through the ground."""
        distances, reached = dict.fromkeys(starts, 0), list(starts)
        for link in reached:  # it grows
            for other in self._neighbours.get(link, ()):
                if other not in distances:
                    distances[other] = distances[link] + 1
                    reached.append(other)
        return distances

    @cached_property
    def _neighbours(self) -> dict[Link, list[Link]]:
        """Links that joints of any kind connect to each link, without the ground."""
        groups = [hinge.links for hinge in self.hinges]
        groups += [[Link(joint.first.body), Link(joint.second.body)] for joint in self.mechanism.joints if not isinstance(joint, Distance)]
        neighbours: dict[Link, list[Link]] = {}
        for group in groups:
            moving = [link for link in group if link != GROUND_LINK]
            for link in moving:
                neighbours.setdefault(link, []).extend(other for other in moving if other != link)
        return neighbours

    def guides(self) -> Iterator[Slider]:
        """Yield the straight guides on the ground."""
        yield from (joint for joint in self.mechanism.joints if isinstance(joint, Slider) and joint.first.body == GROUND)


def bodies_of_reading(reading: Reading) -> tuple[str, ...]:
    """Return the bodies whose motion a reading reads, the one that counts first."""
    match reading:
        case BodyAngle():
            return (reading.body, reading.reference_body)
        case LineAngle():
            return (reading.end.body, reading.start.body)
        case PointCoordinate():
            return (reading.point.body, reading.origin.body)
        case PointDistance():
            return (reading.second.body, reading.first.body)
        case ArcPosition():
            return (reading.point.body, reading.centre.body)
        case OutlineGap():
            return (reading.roller.body, reading.origin.body)
    return ()


def joint_between(mechanism: Mechanism, first: str, second: str) -> Joint | None:
    """Return a pin that joins two bodies, or None."""
    pins = (joint for joint in mechanism.joints if isinstance(joint, Pin))
    return next((pin for pin in pins if {pin.first.body, pin.second.body} == {first, second}), None)


def _key(point: Point) -> tuple[str, float, float]:
    return point.body, round(point.x, SAME_POINT_DIGITS), round(point.y, SAME_POINT_DIGITS)
