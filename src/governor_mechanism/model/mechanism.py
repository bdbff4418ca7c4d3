"""A planar mechanism: bodies, joints, force elements, output variables, and the graph of its links. Frozen values without mathematics."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from governor_mechanism.errors import MechanismError, did_you_mean, require_finite, require_not_negative, require_positive
from governor_mechanism.later_module import LaterModule
from governor_mechanism.model.curves import Outline
from governor_mechanism.model.force_elements import ForceElement
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, RotationalDriver, Slider, TranslationalDriver
from governor_mechanism.model.output_variables import (
    ArcPosition,
    BodyAngle,
    DerivedReading,
    Limit,
    LineAngle,
    OutlineGap,
    PointCoordinate,
    PointDistance,
    Reading,
    StallLimit,
)
from governor_mechanism.model.valve import Valve
from governor_mechanism.units.fields import optional_size, quantity
from governor_mechanism.units.quantities import format_value
from governor_mechanism.units.text_table import summarise

if TYPE_CHECKING:
    from governor_mechanism.building import mechanism_builder
else:
    mechanism_builder = LaterModule("building.mechanism_builder")


@dataclass(frozen=True, kw_only=True)
class SecondMoments:
    """Second moments of mass about the mass centre in body axes, kg m2.

    xx is the integral of xi^2 dm, and so on. The planar moment of inertia is xx + yy. A point mass has zeros only.
    """

    # xx, yy, xy: moments in the plane
    xx: float = optional_size("moment_of_inertia", meaning="the integral of x^2 over the mass, about the mass centre")
    yy: float = optional_size("moment_of_inertia", meaning="the integral of y^2 over the mass")
    xy: float = quantity("moment_of_inertia", sign="any", built=True, default=0.0, meaning="the integral of x y over the mass")
    zz: float = optional_size("moment_of_inertia", meaning="the integral of z^2 over the mass")  # moment normal to the plane

    @property
    def in_plane(self) -> tuple[float, float, float]:
        """xx, yy and xy, kg m2."""
        return self.xx, self.yy, self.xy

    def __post_init__(self) -> None:
        for name in ("xx", "yy", "xy", "zz"):
            require_finite(getattr(self, name), "kg m2", f"second moment {name}")


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body. Its axes have their origin at the mass centre; its pose is (x, y, angle) in m, m, rad."""

    name: str  # name of the body
    mass: float  # mass, kg; 0 for a massless lever or a point whose motion is prescribed
    # second moments of mass about the mass centre; zeros for a body whose mass is in one point
    second_moments: SecondMoments = field(default_factory=SecondMoments)
    can_rotate: bool = True  # false for a point mass or a guided sleeve, whose angle is always 0

    def __post_init__(self) -> None:
        require_not_negative(self.mass, "kg", f"mass of body {self.name!r}")

    @property
    def moves(self) -> tuple[bool, bool, bool]:
        """Whether x, y and the angle can change."""
        return True, True, self.can_rotate

    @property
    def planar_inertia(self) -> float:
        """Moment of inertia about the mass centre in the plane, kg m2."""
        return self.second_moments.xx + self.second_moments.yy


@dataclass(frozen=True, kw_only=True)
class Shaft(Body):
    """A free or coupled spindle as a body that only rotates; its angle is that of the plane that turns with it.

    Its moment of inertia is that of the spindle alone; the bodies of the plane add to it.
    """

    mass: float = 0.0

    @property
    def moves(self) -> tuple[bool, bool, bool]:
        """Only the angle can change."""
        return False, False, True


@dataclass(frozen=True, kw_only=True)
class NamedPoint:
    """A point that the user named."""

    name: str  # its name; with that of its body in front, "body.point", if bodies have points of the same name
    point: Point  # the point


@dataclass(frozen=True, kw_only=True)
class BodyOutline:
    """The outline of a body."""

    origin: Point  # origin of the axes of the outline on the body; they have the direction of those of the body
    outline: Outline  # the outline


@dataclass(frozen=True, kw_only=True)
class FixedLoad:
    """A load that no control can move in a mechanism, although others of its kind let it move."""

    name: str  # name of the load, as a control would name it
    reason: str  # why it is constant, and the cure


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """A planar mechanism: bodies, joints and force elements, with one leading coordinate if it has one degree of freedom.

    Attributes
    ----------
    bodies
        Bodies.
    joints
        Joints.
    readings
        Output variables of the user.
    coordinate
        Name of the reading that is the leading coordinate.
    length_scale
        Characteristic length, m; accuracies are relative to it.
    initial_guess
        One pose (x, y, angle) per body; the assembly starts from it.
    limits
        Ranges of validity.
    stall_limits
        Angles that must not turn back.
    internal_outputs
        Output variables that only the limits refer to.
    force_elements
        Force elements, in addition to the effects of a scene.
    derived_readings
        Readings that follow from the state, and along which nothing acts.
    fixed_loads
        Loads that no control can move here.
    notes
        Sentences for the user about the dimensions.
    reading_scales
        Scales of readings whose scale is not that of the mechanism, m; those of parts of different size.
    valve
        Slide valve that the mechanism moves; None if it has none.
    points
        Points that the user named, whose paths can be shown.
    ends
        Ends of rods and points of the ground, by the names that joints have for them: "crank.end", "ground.O".
    outlines
        Outlines of bodies, which rollers may touch.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    readings: tuple[Reading, ...]
    coordinate: str
    length_scale: float
    initial_guess: tuple[tuple[float, float, float], ...]
    limits: tuple[Limit, ...] = ()
    stall_limits: tuple[StallLimit, ...] = ()
    internal_outputs: tuple[Reading, ...] = ()
    force_elements: tuple[ForceElement, ...] = ()
    derived_readings: tuple[DerivedReading, ...] = ()
    fixed_loads: tuple[FixedLoad, ...] = ()
    notes: tuple[str, ...] = field(default=(), compare=False)
    reading_scales: Mapping[str, float] = field(default_factory=dict, hash=False)
    valve: Valve | None = None
    points: tuple[NamedPoint, ...] = ()
    ends: tuple[NamedPoint, ...] = ()
    outlines: tuple[BodyOutline, ...] = ()

    def __post_init__(self) -> None:
        require_positive(self.length_scale, "m", "length scale of the mechanism")
        names = [body.name for body in self.bodies]
        references = [("joint", joint.name, set(joint.bodies)) for joint in self.joints]
        references += [("force element", element.name, set(element.bodies)) for element in self.force_elements]
        counts = Counter([*(("body", name) for name in names), *((what, name) for what, name, _ in references)])
        problems = [f"{what} {name!r} occurs {n} times; names must differ" for (what, name), n in counts.items() if n > 1]
        problems += [
            f"{what} {name!r} refers to body {body!r}; bodies are {names}.{did_you_mean(body, names)}"
            for what, name, bodies in references
            for body in sorted(bodies - {GROUND, *names})
        ]
        if len(self.initial_guess) != len(self.bodies):
            problems.append(f"the initial guess has {len(self.initial_guess)} poses for {len(self.bodies)} bodies; one each is needed")
        problems += self._valve_problems()
        if problems:
            raise MechanismError(*problems)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: bodies, joints and readings."""
        from governor_mechanism.notebook.result_table import result_html

        return result_html(self)

    def __repr__(self) -> str:
        """Return the bodies, and the numbers of joints, force elements and readings."""
        bodies = summarise({body.name: body for body in self.bodies})
        counts = f"{len(self.joints)} joints, {len(self.force_elements)} force elements, {len(self.readings)} readings"
        return f"Mechanism(bodies {bodies}; {counts}; coordinate {self.coordinate!r})"

    def _valve_problems(self) -> list[str]:
        """Return sentences about readings of the valve that are missing or no lengths."""
        quantities = {reading.name: reading.quantity for reading in self.readings}
        names = self.valve.readings if self.valve else ()
        problems = [f"the valve refers to reading {name!r}; readings are {list(quantities)}" for name in names if name not in quantities]
        return problems + [f"reading {name!r} of the valve must be a length" for name in names if quantities.get(name) == "angle"]

    @staticmethod
    def build(title: str, *, plane: str = "fixed", size: float | str | None = None) -> "mechanism_builder.MechanismBuilder":
        """Return the builder of a mechanism of one's own.

        Parameters
        ----------
        title
            Title of the scene.
        plane
            "fixed", or "turning" for a mechanism that turns with a spindle.
        size
            Characteristic length, m or text with a unit; None for the longest distance on a body.

        Returns
        -------
        MechanismBuilder
            The builder; its method `scene` returns the scene.

        Examples
        --------
        >>> import governor_mechanism as gm
        >>> gm.Mechanism.build("Six-bar")
        MechanismBuilder('Six-bar')
        """
        from governor_mechanism.building.mechanism_builder import MechanismBuilder

        return MechanismBuilder(title, plane=plane, size=size)

    def body_index(self, name: str) -> int:
        """Return the position of a body in `bodies`; GROUND_INDEX for the ground. Raise MechanismError if there is none of this name."""
        if isinstance(name, str) and name in self._body_indices:
            return self._body_indices[name]
        if isinstance(name, str) and name == GROUND:
            return -1  # GROUND_INDEX, whose module imports numpy
        raise _unknown_name("body", name, list(self._body_indices), "bodies")

    def joint_index(self, name: str) -> int:
        """Return the position of a joint in `joints`. Raise MechanismError if there is none of this name."""
        names = [joint.name for joint in self.joints]
        if not isinstance(name, str) or name not in names:
            raise _unknown_name("joint", name, names, "joints")
        return names.index(name)

    @property
    def path_points(self) -> dict[str, Point]:
        """Points that have paths, by name: first those that the user named, then pins that move, mass centres of bodies, and `ends`."""
        moving = [joint for joint in self.joints if isinstance(joint, Pin) and GROUND not in (joint.first.body, joint.second.body)]
        kinds = [
            {one.name: one.point for one in self.points},
            {pin.name: pin.second for pin in moving},
            {body.name: Point(body=body.name) for body in self.bodies if not isinstance(body, Shaft)},
            {one.name: one.point for one in self.ends},
        ]
        points: dict[str, Point] = {}
        for kind in kinds:
            points |= {name: point for name, point in kind.items() if name not in points}
        return points

    def count_drivers(self) -> int:
        """Return the number of drivers."""
        return sum(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in self.joints)

    def count_free_shafts(self) -> int:
        """Return the number of shafts that no joint couples to another body."""
        coupled = {body for joint in self.joints for body in joint.bodies}
        return sum(isinstance(body, Shaft) and body.name not in coupled for body in self.bodies)

    @cached_property
    def _body_indices(self) -> dict[str, int]:
        return {body.name: index for index, body in enumerate(self.bodies)}

    def reading(self, name: str) -> Reading:
        """Return the reading of a name. Raise MechanismError if there is none."""
        return self.all_readings[self.reading_index(name)]

    def reading_index(self, name: str) -> int:
        """Return the position of a reading in `all_readings`. Raise MechanismError if there is none of this name."""
        if isinstance(name, str) and name in self._reading_indices:
            return self._reading_indices[name]
        raise _unknown_name("reading", name, [reading.name for reading in self.readings], "readings")

    @cached_property
    def all_readings(self) -> tuple[Reading, ...]:
        """The readings, and then the internal outputs."""
        return *self.readings, *self.internal_outputs

    @cached_property
    def _reading_indices(self) -> dict[str, int]:
        return {reading.name: index for index, reading in reversed([*enumerate(self.all_readings)])}  # of equal names the first counts

    def output_scale(self, name: str) -> float:
        """Return the scale of a reading: 1 rad, 1 for a ratio, or the length scale in m."""
        return 1.0 if self.reading(name).quantity != "length" else self.reading_scales.get(name, self.length_scale)


def _unknown_name(noun: str, name: object, known: list[str], nouns: str) -> MechanismError:
    """Return the error of a name that the mechanism does not have."""
    found = repr(name) if isinstance(name, str) else format_value(name)
    return MechanismError(f"no {noun} {found}; {nouns} are {known}.{did_you_mean(name, known)}")


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
