"""Readings of a motion, by name: forces of joints, velocities of points and others; a run names them: readings = ["velocity.foot"]."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, Final

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.joints import GROUND, Point, Prismatic, Slider
from governor_mechanism.model.mechanism import GROUND_LINK, Link, LinkGraph, Mechanism, joint_between
from governor_mechanism.model.output_variables import (
    ContactForce,
    DerivedReading,
    JointForce,
    JointMoment,
    OutlineGap,
    readings_of_reaction,
)

VECTOR_COMPONENTS: Final = ("x", "y", "magnitude")
"""Components of a vector in the plane: along the axes of the plane of its part, and its length."""


@dataclass(frozen=True, kw_only=True)
class PointReading(DerivedReading):
    """A component of a vector of a point, along an axis of the plane of its part, or the magnitude of the vector."""

    point: Point  # the point
    component: str  # 'x', 'y' or 'magnitude'


class PathCoordinate(PointReading):
    """Coordinate of a point whose path is requested, m, in the plane of its part."""

    unit: ClassVar[str] = "m"


class PointVelocity(PointReading):
    """Velocity of a point relative to the plane of its part, m/s."""

    unit: ClassVar[str] = "m/s"


class PointAcceleration(PointReading):
    """Acceleration of a point relative to the plane of its part, m/s2."""

    unit: ClassVar[str] = "m/s2"


@dataclass(frozen=True, kw_only=True)
class TransmissionAngle(DerivedReading):
    """Transmission angle of a coupler, rad, 0 to pi: the angle between the coupler and the output link at the pin that joins them.

    The line of a link on a pivot leads from the pin to the pivot, and that of a slider is normal to its guide.
    """

    unit: ClassVar[str] = "rad"

    start: Point  # pin of the coupler on the side of the drive
    pin: Point  # pin between the coupler and the output link
    pivot: Point | None = None  # pivot of the output link; None if a straight guide leads it
    normal: float = 0.0  # direction normal to the guide, rad
    output: str = ""  # name of the output link


@dataclass(frozen=True, kw_only=True)
class PathCurvature(DerivedReading):
    """Curvature of the path of a point in the plane of its part, 1/m, positive where the path turns left in the sense of the motion.

    It is not defined where the point stands still, as in a cusp.
    """

    unit: ClassVar[str] = "1/m"

    point: Point  # the point


@dataclass(frozen=True, kw_only=True)
class InstantaneousCentre(DerivedReading):
    """Instantaneous centre of two bodies, m: a coordinate of the point at which both have the same velocity.

    It is not defined where the bodies do not turn against each other: the centre is at infinity.
    """

    unit: ClassVar[str] = "m"

    # first, second: names of the bodies; one may be the ground
    first: str
    second: str
    pin: Point | None  # point of a pin that joins both, which is their centre at any time; None without one
    component: str  # 'x' or 'y'


@dataclass(frozen=True, kw_only=True)
class MechanicalAdvantage(DerivedReading):
    """Mechanical advantage: the force along the output reading over the force along the input reading, without losses and inertia.

    By virtual work it is the rate of the input over that of the output; its unit is 1, or that of their ratio, rad/m or m/rad, in SI. It
    is not defined where the output stands still, at a dead centre.
    """

    unit: ClassVar[str] = "1"

    # input, output: names of the readings
    input: str
    output: str


def _find_reactions(mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    yield from (reading for joint in mechanism.joints if joint.name == name for reading in readings_of_reaction(joint))


def _contacts(mechanism: Mechanism) -> list[str]:
    """Return the names of the contacts, each once."""
    return list(dict.fromkeys(gap.contact for gap in mechanism.readings if isinstance(gap, OutlineGap)))


def _find_contact_forces(mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    """Yield the normal force of a contact, and its friction."""
    if name in _contacts(mechanism):
        yield ContactForce(name=f"contact.{name}.force", contact=name)
        yield ContactForce(name=f"contact.{name}.friction", contact=name, is_friction=True)


def _find_components(kind: str, reading: type[PointReading], mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    """Yield the components of a kind of vector of a point."""
    if point := mechanism.path_points.get(name):
        yield from (reading(name=f"{kind}.{name}.{one}", point=point, component=one) for one in VECTOR_COMPONENTS)


def _find_curvatures(mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    if name in mechanism.path_points:
        yield PathCurvature(name=f"curvature.{name}", point=mechanism.path_points[name])


def _find_centres(mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    for first, second in _split_pair(name, _bodies(mechanism)):
        joint = joint_between(mechanism, first, second)
        for axis in "xy":
            pin = joint.second if joint else None
            yield InstantaneousCentre(name=f"instantaneous_centre.{name}.{axis}", first=first, second=second, pin=pin, component=axis)


def _find_advantages(mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    for first, second in _split_pair(name, _readings(mechanism)):
        yield MechanicalAdvantage(name=f"mechanical_advantage.{name}", input=first, output=second)


def _split_pair(name: str, known: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield the two different known names that a text "first.second" holds; names may have dots themselves."""
    names, words = set(known), name.split(".")
    pairs = [(".".join(words[:k]), ".".join(words[k:])) for k in range(1, len(words))]
    yield from (pair for pair in pairs if names.issuperset(pair) and pair[0] != pair[1])


def find_transmissions(mechanism: Mechanism) -> dict[str, TransmissionAngle]:
    """Return the transmission angles of a mechanism by the name of the coupler; if it moves several links, "coupler.link"."""
    # A coupler lies between two pins: one toward the drive, which are the drivers, or else the leading
    # coordinate, and one on a link that the ground guides by a pivot or a straight guide.
    graph = LinkGraph(mechanism)
    inputs = graph.inputs()
    found = list(_transmissions_of(graph, inputs)) if inputs else []
    couplers = [coupler for coupler, _ in found]
    named = {one.name if couplers.count(one) == 1 else f"{one.name}.{angle.output}": angle for one, angle in found}
    return {name: replace(angle, name=f"transmission_angle.{name}") for name, angle in named.items()}


def _transmissions_of(graph: LinkGraph, inputs: set[Link]) -> Iterator[tuple[Link, TransmissionAngle]]:
    """Yield each coupler with its transmission angle."""
    distances = graph.distances_from(inputs)
    for output, pivot, normal in _guided_links(graph, inputs):
        for hinge in graph.hinges_of(output):
            nearer = [link for link in hinge.links if 0 < distances.get(link, 0) < distances.get(output, 0)]
            coupler = min(nearer, key=lambda link: distances[link], default=None)
            start = _pin_toward_drive(graph, coupler, distances) if coupler else None
            if coupler and start and GROUND not in hinge.points:
                guide = TransmissionAngle(name="", start=start, pin=hinge.point, pivot=pivot, normal=normal, output=output.name)
                yield coupler, guide
    for slider in graph.guides():  # a coupler whose own end slides
        coupler = Link(slider.second.body)
        start = _pin_toward_drive(graph, coupler, distances)
        if coupler not in inputs and start and _turns(graph.mechanism, slider):
            normal = slider.angle + math.pi / 2
            yield coupler, TransmissionAngle(name="", start=start, pin=slider.second, normal=normal, output=slider.name)


def _guided_links(graph: LinkGraph, inputs: set[Link]) -> Iterator[tuple[Link, Point | None, float]]:
    """Yield the links that the ground guides, but for those of the drive: with their pivot, or the normal (rad) of their guide."""
    for hinge in graph.hinges_of(GROUND_LINK):
        yield from ((link, hinge.points[GROUND], 0.0) for link in hinge.links if link != GROUND_LINK and link not in inputs)
    for slider in graph.guides():
        link = Link(slider.second.body)
        if link not in inputs and not _turns(graph.mechanism, slider):
            yield link, None, slider.angle + math.pi / 2


def _pin_toward_drive(graph: LinkGraph, coupler: Link, distances: Mapping[Link, int]) -> Point | None:
    """Return the pin of a coupler on the link from which it is driven; None if it has none."""
    nearer = {link for link, distance in distances.items() if distance < distances.get(coupler, 0)}
    return next((hinge.point for hinge in graph.hinges_of(coupler) if nearer.intersection(hinge.links)), None)


def _turns(mechanism: Mechanism, slider: Slider) -> bool:
    """Return whether the second body of a slider turns as it slides."""
    return not isinstance(slider, Prismatic) and mechanism.bodies[mechanism.body_index(slider.second.body)].can_rotate


def _find_angles(mechanism: Mechanism, name: str) -> Iterator[DerivedReading]:
    yield from (angle for coupler, angle in find_transmissions(mechanism).items() if coupler == name)


@dataclass(frozen=True)
class ReadingKind:
    """A kind of readings that are named "kind.name" or "kind.name.component"."""

    find: Callable[[Mechanism, str], Iterator[DerivedReading]]  # function that yields those of a name
    noun: str  # what the name is of
    known: Callable[[Mechanism], Iterable[str]]  # function that returns the names


def _joints(mechanism: Mechanism) -> list[str]:
    return [joint.name for joint in mechanism.joints]


def _points(mechanism: Mechanism) -> list[str]:
    return list(mechanism.path_points)


def _couplers(mechanism: Mechanism) -> list[str]:
    return list(find_transmissions(mechanism))


def _bodies(mechanism: Mechanism) -> list[str]:
    return [GROUND, *(body.name for body in mechanism.bodies)]


def _readings(mechanism: Mechanism) -> list[str]:
    return [reading.name for reading in mechanism.readings]


RUN_KINDS: Final[Mapping[str, ReadingKind]] = {
    "reaction": ReadingKind(_find_reactions, "joint", _joints),
    "contact": ReadingKind(_find_contact_forces, "contact", _contacts),
    "velocity": ReadingKind(partial(_find_components, "velocity", PointVelocity), "point", _points),
    "acceleration": ReadingKind(partial(_find_components, "acceleration", PointAcceleration), "point", _points),
    "transmission_angle": ReadingKind(_find_angles, "coupler", _couplers),
}
"""Kinds of readings that a run reports: those that have a value at any time."""

KINEMATIC_KINDS: Final[Mapping[str, ReadingKind]] = {
    **{kind: one for kind, one in RUN_KINDS.items() if kind not in ("reaction", "contact")},
    "curvature": ReadingKind(_find_curvatures, "point", _points),
    "instantaneous_centre": ReadingKind(_find_centres, "pair of bodies", _bodies),
    "mechanical_advantage": ReadingKind(_find_advantages, "pair of readings", _readings),
}
"""Kinds of readings of an analysis without forces. Some have no value at single positions."""


def find_named_readings(
    mechanism: Mechanism,
    names: Iterable[str],  # "kind.name", for all components, or "kind.name.component"
    kinds: Mapping[str, ReadingKind],
    owner: str,  # what names them, for messages
) -> list[DerivedReading]:
    """Return readings by their names, each once. Raise MechanismError with a sentence for each that the mechanism does not have."""
    readings, problems = dict[str, DerivedReading](), list[str]()
    for name in names:
        kind, _, rest = name.partition(".")
        found = list(kinds[kind].find(mechanism, rest)) if kind in kinds else []
        whole, _, component = rest.rpartition(".")
        if not found and kind in kinds and whole:
            found = [one for one in kinds[kind].find(mechanism, whole) if one.name == f"{kind}.{whole}.{component}"]
        readings |= {one.name: one for one in found}
        if not found:
            problems.append(f"{owner} names {name!r}: {_explain_unknown(mechanism, kind, rest, kinds)}")
    if problems:
        raise MechanismError(*problems)
    return list(readings.values())


def _explain_unknown(mechanism: Mechanism, kind: str, rest: str, kinds: Mapping[str, ReadingKind]) -> str:
    """Return why there is no such reading, and what there is."""
    if kind not in kinds:
        if kind in KINEMATIC_KINDS:
            return f"a run has no {kind}, which is not defined at every time; gm.kinematics and the command kinematics have it"
        if kind in RUN_KINDS:
            return "forces need a run; name it in [run], as readings = [...]"
        listed = ", ".join(f"{one}.NAME" for one in kinds)
        return f"there is no such kind of reading; there are {listed}.{did_you_mean(kind, list(kinds))}"
    one, known = kinds[kind], list(kinds[kind].known(mechanism))
    if one.noun.startswith("pair"):
        return f"{kind} needs two different names of {one.noun.rpartition(' ')[2]}, as {kind}.FIRST.SECOND; they are {known}"
    if not known:
        reason = "no coupler between two pins leads from its drive to a link that the ground guides" if one.noun == "coupler" else "none"
        return f"the mechanism has no {kind}: {reason}"
    start = f"no {one.noun} {rest!r}" if rest else f"it names no {one.noun}, as {kind}.NAME does"
    return f"{start}; {one.noun}s are {known}.{did_you_mean(rest, known)}"


def with_run_readings(mechanism: Mechanism, names: Iterable[str], paths: Iterable[str]) -> Mechanism:
    """Return a mechanism with the readings and the coordinates of points of paths that a run names; MechanismError lists unknown names."""
    known = mechanism.path_points
    problems = list[str]()
    readings = list[DerivedReading]()
    try:
        readings += find_named_readings(mechanism, names, RUN_KINDS, "run.readings")
    except MechanismError as error:
        problems += error.problems
    for name in paths:
        if name in known:
            readings += (PathCoordinate(name=f"{name}.{axis}", point=known[name], component=axis) for axis in "xy")
        else:
            problems.append(f"run.paths: no point {name!r}; points are {list(known)}.{did_you_mean(name, known)}")
    if problems:
        raise MechanismError(*problems)
    return replace(mechanism, derived_readings=(*mechanism.derived_readings, *readings))


def joints_of_reactions(mechanism: Mechanism) -> list[str]:
    """Return the joints whose forces are readings, in their order."""
    forces = [one.joint for one in mechanism.derived_readings if isinstance(one, JointForce | JointMoment)]
    return list(dict.fromkeys(forces))
