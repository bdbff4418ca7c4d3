"""One planar mechanism: bodies, joints, and the readings a user asks for. Frozen values, no maths."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property

from governor_mechanism.errors import MechanismError, did_you_mean, require_finite, require_positive
from governor_mechanism.model.force_elements import Load
from governor_mechanism.model.joints import GROUND, Joint, Point


@dataclass(frozen=True, kw_only=True)
class SecondMoments:
    """Second moments of mass about the mass centre, in body axes (kg m2): xx = sum of xi^2 dm, and so on.

    zz is the moment out of the plane. The planar moment of inertia is xx + yy. All zero: the mass is in one point.
    """

    xx: float = 0.0
    yy: float = 0.0
    xy: float = 0.0
    zz: float = 0.0

    @property
    def in_plane(self) -> tuple[float, float, float]:
        """xx, yy, xy."""
        return self.xx, self.yy, self.xy

    def __post_init__(self) -> None:
        for name in ("xx", "yy", "xy", "zz"):
            require_finite(getattr(self, name), "kg m2", f"second moment {name}")


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid part. Its axes: origin at the mass centre; pose (x, y, angle) in m, m, rad.

    A body that does not turn (`turns=False`: a point mass, a guided sleeve) has no angle of its own; its angle stays 0.
    """

    name: str
    mass: float
    moments: SecondMoments = field(default_factory=SecondMoments)
    turns: bool = True

    def __post_init__(self) -> None:
        require_positive(self.mass, "kg", f"mass of body {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A named number read off the mechanism; `quantity` is 'angle' (rad) or 'length' (m)."""

    name: str
    quantity: str


@dataclass(frozen=True, kw_only=True)
class LineAngle(Reading):
    """Angle of the line start -> end from the downward vertical, positive toward +x (rad, within -pi..pi).

    `zero` is subtracted.
    """

    start: Point
    end: Point
    zero: float = 0.0


@dataclass(frozen=True, kw_only=True)
class BodyAngle(Reading):
    """Angle of a body's axes less that of another's (rad, anticlockwise, counted on over whole turns)."""

    body: str
    against: str = GROUND


@dataclass(frozen=True, kw_only=True)
class Separation(Reading):
    """Distance of two points (m)."""

    first: Point
    second: Point


@dataclass(frozen=True, kw_only=True)
class Coordinate(Reading):
    """Position of a point along a direction (m): along_x * x + along_y * y - zero.

    x and y are counted from `origin` and along its body's axes, where one is given; else in the plane.
    """

    point: Point
    along_x: float
    along_y: float
    zero: float = 0.0
    origin: Point = field(default_factory=lambda: Point(body=GROUND))


@dataclass(frozen=True, kw_only=True)
class FollowerHeight(Reading):
    """Height (m) of a massless follower hung by a link from a rod, and guided on the line x = `line`.

    The link of `length` starts on the rod top -> knee, at `fraction` of its length; the follower is below;
    `zero` is subtracted. With `against` it is that point's height above the follower instead, less `zero`.
    """

    top: Point
    knee: Point
    fraction: float
    line: float
    length: float
    zero: float = 0.0
    against: Point | None = None


@dataclass(frozen=True, kw_only=True)
class Output:
    """A named force (N) that follows from where the mechanism stands; unlike along a reading, nothing acts along it."""

    name: str


@dataclass(frozen=True, kw_only=True)
class SpringForce(Output):
    """The pull of a Spring among the loads; `spring` is its name."""

    spring: str


@dataclass(frozen=True, kw_only=True)
class StaticForce(Output):
    """With what force springs and weights draw a reading down at standstill; `part` of it.

    So much has to push along the reading, a length, to hold a mechanism of mobility one. Infinite at a dead centre.
    """

    reading: str
    part: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Limit:
    """The range within which the description holds; leaving it ends a run by name.

    `below` and `above` are sentences that say what happens there.
    """

    reading: str
    low: float
    high: float
    below: str
    above: str


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """Bodies held by joints, with one leading coordinate (a reading's name) for mechanisms of mobility one.

    loads act on the bodies beside a scene's effects. outputs follow from the poses; notes are sentences worth telling
    about the dimensions. `watched` are readings that limits refer to but no user asks for.
    size (m) is the length that accuracies refer to. sketch holds one pose (x, y, angle) per body, from which the
    mechanism is assembled.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    readings: tuple[Reading, ...]
    coordinate: str
    size: float
    sketch: tuple[tuple[float, float, float], ...]
    limits: tuple[Limit, ...] = ()
    watched: tuple[Reading, ...] = ()
    loads: tuple[Load, ...] = ()
    outputs: tuple[Output, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_positive(self.size, "m", "size of the mechanism")
        names = [body.name for body in self.bodies]
        problems = [
            f"{what} {name!r} stands {count} times; names must differ"
            for what, group in (
                ("body", names),
                ("joint", [joint.name for joint in self.joints]),
                ("load", [load.name for load in self.loads]),
            )
            for name, count in Counter(group).items()
            if count > 1
        ]
        ends = [("joint", joint.name, {joint.first.body, joint.second.body}) for joint in self.joints]
        ends += [("load", load.name, set(load.bodies)) for load in self.loads]
        problems += [
            f"{what} {name!r} refers to body {body!r}; bodies are {names}.{did_you_mean(body, names)}"
            for what, name, bodies in ends
            for body in sorted(bodies - {GROUND, *names})
        ]
        if len(self.sketch) != len(self.bodies):
            problems.append(
                f"the sketch has {len(self.sketch)} poses for {len(self.bodies)} bodies; one each is needed"
            )
        if problems:
            raise MechanismError(*problems)

    def body_index(self, name: str) -> int:
        """Position of a body in `bodies`; -1 for the ground."""
        return -1 if name == GROUND else self._places[name]

    @cached_property
    def _places(self) -> dict[str, int]:
        return {body.name: index for index, body in enumerate(self.bodies)}

    def reading(self, name: str) -> Reading:
        """The reading of that name."""
        for reading in (*self.readings, *self.watched):
            if reading.name == name:
                return reading
        names = [reading.name for reading in self.readings]
        raise MechanismError(f"no reading {name!r}; readings are {names}.{did_you_mean(name, names)}")
