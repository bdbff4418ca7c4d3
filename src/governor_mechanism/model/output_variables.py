"""Output variables of a mechanism: readings, derived forces and limits of validity. Frozen values without mathematics."""

from dataclasses import dataclass, field
from typing import ClassVar

from governor_mechanism.model.curves import CurveOutline, Outline
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Base class of a named output variable of the mechanism.

    Attributes
    ----------
    name
        Name of the reading.
    quantity
        'angle' (rad), 'length' (m) or 'ratio'.
    """

    name: str
    quantity: str


@dataclass(frozen=True, kw_only=True)
class LineAngle(Reading):
    """Angle of the line start -> end from the downward vertical, minus zero.

    The angle is positive toward +x and lies within -pi..pi.

    Attributes
    ----------
    start, end
        End points of the line.
    zero
        Angle to subtract, rad.
    """

    start: Point
    end: Point
    zero: float = 0.0


@dataclass(frozen=True, kw_only=True)
class BodyAngle(Reading):
    """Angle of a body relative to another one, rad, anticlockwise, continuous over full turns.

    Attributes
    ----------
    body
        Name of the body.
    reference_body
        Name of the body whose angle is subtracted; the ground by default.
    """

    body: str
    reference_body: str = GROUND


@dataclass(frozen=True, kw_only=True)
class PointDistance(Reading):
    """Distance of two points, m.

    Attributes
    ----------
    first, second
        The points.
    """

    first: Point
    second: Point


@dataclass(frozen=True, kw_only=True)
class PointCoordinate(Reading):
    """Position of a point along a direction: direction_x * x + direction_y * y - zero, m.

    Attributes
    ----------
    point
        The point.
    direction_x, direction_y
        Components of the direction.
    zero
        Position to subtract, m.
    origin
        Point that x and y are measured from, along the axes of its body; by default the origin of the plane.
    """

    point: Point
    direction_x: float
    direction_y: float
    zero: float = 0.0
    origin: Point = field(default_factory=lambda: Point(body=GROUND))


@dataclass(frozen=True, kw_only=True)
class ArcPosition(Reading):
    """Position of a point along a circular arc of a body: radius * angle, m, positive anticlockwise, within half a turn.

    Attributes
    ----------
    centre
        Centre of the arc on its body.
    point
        The point, as a die block in a curved slot.
    radius
        Radius of the arc, m; negative for a position that is positive clockwise.
    angle
        Direction of the zero, rad, anticlockwise from the x axis of the body of the centre.
    zero
        Position to subtract, m.
    """

    centre: Point
    point: Point
    radius: float
    angle: float = 0.0
    zero: float = 0.0


@dataclass(frozen=True, kw_only=True)
class FollowerHeight(Reading):
    """Height of a massless follower that hangs by a link from a rod and slides on the line x = guide_x, m.

    Attributes
    ----------
    top, knee
        End points of the rod.
    fraction
        Position of the upper end of the link on the rod, as a fraction of top -> knee.
    guide_x
        Position of the guide, m.
    length
        Length of the link, m. The follower is below the rod.
    zero
        Height to subtract, m.
    reference_point
        If given, the reading is the height of this point above the follower, minus zero.
    """

    top: Point
    knee: Point
    fraction: float
    guide_x: float
    length: float
    zero: float = 0.0
    reference_point: Point | None = None


@dataclass(frozen=True, kw_only=True)
class OutlineGap(Reading):
    """Distance of a roller, or of a closed convex curve, from an outline that it may touch, m: 0 where they touch, and never negative.

    Attributes
    ----------
    contact
        Name of the contact.
    origin
        Origin of the axes of the outline on its body; they have the direction of those of the body.
    roller
        Centre of the roller, or origin of the curve.
    outline
        The outline; one of lines and arcs if a curve touches it.
    chain
        Which of the parts of the outline between hollow corners it is, from 0.
    radius
        Radius of the roller, m; 0 for a point.
    restitution
        Coefficient of restitution, 0 to 1.
    profile
        Outline of the body of the roller, in its axes, where this one touches instead of a roller.
    friction
        Coefficient of Coulomb friction.
    others
        Centres of equal rollers of the same body; the gap is that of the nearest one.
    """

    contact: str
    origin: Point
    roller: Point
    outline: Outline
    chain: int = 0
    radius: float = 0.0
    restitution: float = 0.0
    profile: CurveOutline | None = None
    friction: float = 0.0
    others: tuple[Point, ...] = ()

    @property
    def slip(self) -> "OutlineSlip":
        """The sliding along the outline, against which friction acts."""
        name = f"{self.contact}_slip{self.name.removeprefix(f'{self.contact}_gap')}"
        return OutlineSlip(name=name, quantity="length", gap=self)


@dataclass(frozen=True, kw_only=True)
class OutlineSlip(Reading):
    """Sliding of a roller, or a closed curve, along an outline where they touch, whose rate is the sliding velocity, m/s. Its value is 0.

    The roller does not turn on its body. The rate is positive where what touches slides round the outline anticlockwise.

    Attributes
    ----------
    gap
        The gap between both.
    """

    gap: OutlineGap


@dataclass(frozen=True, kw_only=True)
class DerivedReading:
    """Base class of a named value that follows from the state of the mechanism. No force acts along it, and nothing depends on it.

    Attributes
    ----------
    name
        Name of the reading.
    unit
        Its unit.
    """

    unit: ClassVar[str] = "N"

    name: str


@dataclass(frozen=True, kw_only=True)
class SpringForce(DerivedReading):
    """Force in a spring of the mechanism, N, positive in tension.

    Attributes
    ----------
    spring
        Name of the Spring.
    """

    spring: str


@dataclass(frozen=True, kw_only=True)
class StaticForce(DerivedReading):
    """Fraction of the static force of springs and weights along a reading at zero speed, N.

    It is the force along the reading, a length, that holds a mechanism with one degree of freedom. It is infinite at a turning point
    of the reading.

    Attributes
    ----------
    reading
        Name of the reading.
    fraction
        Factor on the force.
    """

    reading: str
    fraction: float = 1.0


@dataclass(frozen=True, kw_only=True)
class ShaftSpeed(DerivedReading):
    """Rate of an angle, rad/s.

    Attributes
    ----------
    reading
        Name of the angle.
    """

    unit: ClassVar[str] = "rad/s"

    reading: str


@dataclass(frozen=True, kw_only=True)
class AppliedTorque(DerivedReading):
    """Torque of force elements along an angle by virtual work, N m.

    Attributes
    ----------
    reading
        Name of the angle, the coordinate of the mechanism.
    elements
        Names of the force elements.
    sign
        Factor on the torque; -1 for a torque that is positive against the angle.
    """

    unit: ClassVar[str] = "N m"

    reading: str
    elements: tuple[str, ...]
    sign: float = 1.0


@dataclass(frozen=True, kw_only=True)
class CylinderPressure(DerivedReading):
    """Absolute pressure of the gas on one face of a piston, Pa. It jumps at dead centres, where the faces change their parts.

    Attributes
    ----------
    elements
        Names of the gas; the pressures add up.
    reading
        Name of the crank angle.
    scale
        Scale of the pressure, Pa.
    """

    unit: ClassVar[str] = "Pa"

    elements: tuple[str, ...]
    reading: str
    scale: float


@dataclass(frozen=True, kw_only=True)
class ControlledValue(DerivedReading):
    """Opening of a throttle or travel at a cut-off, 0 to 1; a run ends where it leaves this range.

    Attributes
    ----------
    element
        Name of the gas that it acts on.
    is_switch
        Whether it is the travel at which the pressure of the gas switches.
    """

    unit: ClassVar[str] = "1"

    element: str
    is_switch: bool = False


@dataclass(frozen=True, kw_only=True)
class StoredWork(DerivedReading):
    """Kinetic energy of the mechanism less that at the start, J."""

    unit: ClassVar[str] = "J"


@dataclass(frozen=True, kw_only=True)
class JointForce(DerivedReading):
    """Force of a joint on its second body, N: a component along an axis of the plane of its part, or the magnitude.

    Attributes
    ----------
    joint
        Name of the joint.
    component
        'x', 'y' or 'magnitude'.
    """

    joint: str
    component: str


@dataclass(frozen=True, kw_only=True)
class JointMoment(DerivedReading):
    """Moment of a joint on its second body about the point of the joint on that body, N m, anticlockwise.

    Attributes
    ----------
    joint
        Name of the joint.
    """

    unit: ClassVar[str] = "N m"

    joint: str


@dataclass(frozen=True, kw_only=True)
class ContactForce(DerivedReading):
    """Force of an outline on a roller that touches it, N: the normal one, or the friction along the outline.

    Where both sides of a hollow corner are touched, it is the sum of their forces.

    Attributes
    ----------
    contact
        Name of the contact.
    is_friction
        Whether it is the friction.
    """

    contact: str
    is_friction: bool = False


def readings_of_reaction(joint: Joint) -> tuple[DerivedReading, ...]:
    """Return the readings of the force of a joint, and of its moment if it is of a kind that may have one."""
    start = f"reaction.{joint.name}"
    forces = [JointForce(name=f"{start}.{part}", joint=joint.name, component=part) for part in ("x", "y", "magnitude")]
    return (*forces, *([] if isinstance(joint, Pin | Distance) else [JointMoment(name=f"{start}.moment", joint=joint.name)]))


@dataclass(frozen=True, kw_only=True)
class Limit:
    """Range of a reading within which the description is valid. A run ends where it leaves the range.

    Attributes
    ----------
    reading
        Name of the reading.
    low, high
        Ends of the range, SI.
    low_message, high_message
        Sentences on what happens at each end.
    """

    reading: str
    low: float
    high: float
    low_message: str
    high_message: str


@dataclass(frozen=True, kw_only=True)
class StallLimit:
    """An angle that must not turn back: a run ends where its rate falls below zero.

    Attributes
    ----------
    reading
        Name of the angle.
    body
        Body whose angle it is.
    message
        Sentence on what happens there.
    """

    reading: str
    body: str
    message: str
