"""Mass, mass centre and second moments of rigid bodies that consist of rods, balls and blocks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from governor_mechanism.model.mechanism import SecondMoments
from governor_mechanism.types import Vector2


@dataclass(frozen=True, kw_only=True)
class MassElement:
    """A part of a rigid body.

    Attributes
    ----------
    mass
        Mass, kg.
    centre
        Position of the mass centre, m.
    moments
        Second moments of mass about the mass centre.
    """

    mass: float
    centre: Vector2 = (0.0, 0.0)
    moments: SecondMoments = field(default_factory=SecondMoments)


def slender_rod(mass: float, end: Vector2) -> MassElement:
    """Return a slender uniform rod (kg) from the origin to its end (m)."""
    u, v = end
    moments = SecondMoments(xx=mass * u**2 / 12, yy=mass * v**2 / 12, xy=mass * u * v / 12)
    return MassElement(mass=mass, centre=(u / 2, v / 2), moments=moments)


def thin_arc(mass: float, radius: float, half_angle: float) -> MassElement:
    """Return a thin uniform arc (kg) about the origin (m), symmetric about the direction of -x, from -half_angle to half_angle (rad)."""
    centre = -radius * math.sin(half_angle) / half_angle
    half_mean_square, variation = 0.5 * radius**2, radius**2 * math.sin(2 * half_angle) / (4 * half_angle)
    along, across = half_mean_square + variation - centre**2, half_mean_square - variation
    return MassElement(mass=mass, centre=(centre, 0.0), moments=SecondMoments(xx=mass * along, yy=mass * across))


def solid_ball(mass: float, centre: Vector2, radius: float) -> MassElement:
    """Return a uniform solid ball (kg) with its centre and radius (m)."""
    moment = mass * radius**2 / 5
    return MassElement(mass=mass, centre=centre, moments=SecondMoments(xx=moment, yy=moment, zz=moment))


def join_elements(elements: Sequence[MassElement]) -> MassElement:
    """Return the rigid body of all elements, with its second moments about the common mass centre."""
    if len(elements) == 1:
        return elements[0]
    mass = sum(part.mass for part in elements)
    x, y = (sum(part.mass * part.centre[axis] for part in elements) / mass for axis in (0, 1))
    moments = SecondMoments(
        xx=sum(part.moments.xx + part.mass * (part.centre[0] - x) ** 2 for part in elements),
        yy=sum(part.moments.yy + part.mass * (part.centre[1] - y) ** 2 for part in elements),
        xy=sum(part.moments.xy + part.mass * (part.centre[0] - x) * (part.centre[1] - y) for part in elements),
        zz=sum(part.moments.zz for part in elements),
    )
    return MassElement(mass=mass, centre=(x, y), moments=moments)
