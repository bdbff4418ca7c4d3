"""Mechanisms and scenes built in Python for the tests: bodies, points, readings, and what a mechanism of them needs besides."""

from collections.abc import Mapping, Sequence

import governor_mechanism as gm
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.force_elements import Damper, ForceElement, Spring
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle, Limit, PointCoordinate, Reading
from governor_mechanism.model.part import FIXED_PLANE, Part, Start
from governor_mechanism.model.scene import RunSettings
from governor_mechanism.model.time_functions import InputFunction

Pose = tuple[float, float, float]


def make_mechanism(
    bodies: Sequence[Body],
    joints: Sequence[Joint],
    readings: Sequence[Reading],
    sketch: Sequence[Pose],  # first guess of the pose of each body
    *,
    loads: Sequence[ForceElement] = (),
    size: float = 1.0,
    limits: Sequence[Limit] = (),
) -> Mechanism:
    """A mechanism whose leading coordinate is its first reading."""
    return Mechanism(
        bodies=tuple(bodies),
        joints=tuple(joints),
        readings=tuple(readings),
        coordinate=readings[0].name,
        length_scale=size,
        initial_guess=tuple(sketch),
        force_elements=tuple(loads),
        limits=tuple(limits),
    )


def fixed_part(mechanism: Mechanism, *effects: Effect, start: Start | None = None) -> Part:
    """A part in a fixed plane."""
    start = start or Start()
    return Part(name="part", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE, effects=effects, start=start)


def scene_of(
    mechanism: Mechanism,
    *effects: Effect,
    values: Mapping[str, float] | None = None,
    rates: Mapping[str, float] | None = None,
    duration: float = 1.0,
    output_interval: float = 0.1,
    accuracy: float = 1e-6,
) -> gm.Scene:
    """A scene of one mechanism in a fixed plane."""
    part = fixed_part(mechanism, *effects, start=Start(values=values or {}, rates=rates or {}))
    run = RunSettings(duration=duration, output_interval=output_interval, accuracy=accuracy)
    return gm.Scene(title="test", parts=(part,), run=run)


def body_point(body: str, x: float = 0.0, y: float = 0.0) -> Point:
    """A point of a body."""
    return Point(body=body, x=x, y=y)


def ground_point(x: float = 0.0, y: float = 0.0) -> Point:
    """A point of the ground."""
    return Point(body=GROUND, x=x, y=y)


def rotating_body(name: str, mass: float, inertia: float) -> Body:
    """A body of this moment of inertia about its mass centre."""
    return Body(name=name, mass=mass, second_moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def rod_body(name: str, mass: float, length: float) -> Body:
    """A uniform slender rod along its x axis."""
    return Body(name=name, mass=mass, second_moments=SecondMoments(xx=mass * length**2 / 12))


def point_mass(name: str, mass: float) -> Body:
    """A mass in one point."""
    return Body(name=name, mass=mass, can_rotate=False)


def body_angle(body: str, name: str = "") -> BodyAngle:
    """Return a reading of the angle of a body, named after the body by default."""
    return BodyAngle(name=name or body, quantity="angle", body=body)


def x_reading(body: str, name: str = "x", zero: float = 0.0) -> PointCoordinate:
    """Return a reading of the x coordinate of a mass centre."""
    return PointCoordinate(name=name, quantity="length", point=body_point(body), direction_x=1.0, direction_y=0.0, zero=zero)


def y_reading(body: str, name: str = "y") -> PointCoordinate:
    """Return a reading of the y coordinate of a mass centre."""
    return PointCoordinate(name=name, quantity="length", point=body_point(body), direction_x=0.0, direction_y=1.0)


def pin(name: str, first: Point, second: Point) -> Pin:
    """A pin joint of two points."""
    return Pin(name=name, first=first, second=second)


def slider(name: str, first: Point, second: Point, angle: float = 0.0) -> Slider:
    """A second point on a line through the first one, at an angle in its body."""
    return Slider(name=name, first=first, second=second, angle=angle)


def link(name: str, first: Point, second: Point, length: float) -> Distance:
    """A massless link between two points."""
    return Distance(name=name, first=first, second=second, length=length)


def spring(name: str, first: Point, second: Point, stiffness: float, free_length: float) -> Spring:
    """A linear spring between two points."""
    return Spring(name=name, first=first, second=second, stiffness=stiffness, free_length=free_length)


def damper(name: str, first: Point, second: Point, damping: float) -> Damper:
    """A linear damper between two points."""
    return Damper(name=name, first=first, second=second, damping=damping)


def constant(value: float) -> InputFunction:
    """An input that stays as it is."""
    return InputFunction(values=(value,))
