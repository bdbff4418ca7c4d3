"""One planar mechanism: bodies, joints, and the readings a user asks for. Frozen values, no maths."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property

from governor_mechanism.errors import MechanismError, did_you_mean, require_finite, require_positive
from governor_mechanism.model.force_elements import ForceElement
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
    second_moments: SecondMoments = field(default_factory=SecondMoments)
    can_rotate: bool = True

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
    reference_body: str = GROUND


@dataclass(frozen=True, kw_only=True)
class PointDistance(Reading):
    """Distance of two points (m)."""

    first: Point
    second: Point


@dataclass(frozen=True, kw_only=True)
class PointCoordinate(Reading):
    """Position of a point along a direction (m): along_x * x + along_y * y - zero.

    x and y are counted from `origin` and along its body's axes, where one is given; else in the plane.
    """

    point: Point
    direction_x: float
    direction_y: float
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
    guide_x: float
    length: float
    zero: float = 0.0
    reference_point: Point | None = None


@dataclass(frozen=True, kw_only=True)
class DerivedForce:
    """A named force (N) that follows from where the mechanism stands; unlike along a reading, nothing acts along it."""

    name: str


@dataclass(frozen=True, kw_only=True)
class SpringForce(DerivedForce):
    """The pull of a Spring among the loads; `spring` is its name."""

    spring: str


@dataclass(frozen=True, kw_only=True)
class StaticForce(DerivedForce):
    """With what force springs and weights draw a reading down at standstill; `part` of it.

    So much has to push along the reading, a length, to hold a mechanism of mobility one. Infinite at a dead centre.
    """

    reading: str
    fraction: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Limit:
    """The range within which the description holds; leaving it ends a run by name.

    `below` and `above` are sentences that say what happens there.
    """

    reading: str
    low: float
    high: float
    low_message: str
    high_message: str


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
    length_scale: float
    initial_guess: tuple[tuple[float, float, float], ...]
    limits: tuple[Limit, ...] = ()
    internal_outputs: tuple[Reading, ...] = ()
    force_elements: tuple[ForceElement, ...] = ()
    derived_forces: tuple[DerivedForce, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_positive(self.length_scale, "m", "size of the mechanism")
        names = [body.name for body in self.bodies]
        problems = [
            f"{what} {name!r} stands {count} times; names must differ"
            for what, group in (
                ("body", names),
                ("joint", [joint.name for joint in self.joints]),
                ("load", [load.name for load in self.force_elements]),
            )
            for name, count in Counter(group).items()
            if count > 1
        ]
        body_references = [("joint", joint.name, {joint.first.body, joint.second.body}) for joint in self.joints]
        body_references += [("load", load.name, set(load.bodies)) for load in self.force_elements]
        problems += [
            f"{what} {name!r} refers to body {body!r}; bodies are {names}.{did_you_mean(body, names)}"
            for what, name, bodies in body_references
            for body in sorted(bodies - {GROUND, *names})
        ]
        if len(self.initial_guess) != len(self.bodies):
            problems.append(f"the sketch has {len(self.initial_guess)} poses for {len(self.bodies)} bodies; one each is needed")
        if problems:
            raise MechanismError(*problems)

    def body_index(self, name: str) -> int:
        """Position of a body in `bodies`; -1 for the ground."""
        return -1 if name == GROUND else self._body_indices[name]

    @cached_property
    def _body_indices(self) -> dict[str, int]:
        return {body.name: index for index, body in enumerate(self.bodies)}

    def reading(self, name: str) -> Reading:
        """The reading of that name."""
        for reading in (*self.readings, *self.internal_outputs):
            if reading.name == name:
                return reading
        names = [reading.name for reading in self.readings]
        raise MechanismError(f"no reading {name!r}; readings are {names}.{did_you_mean(name, names)}")
