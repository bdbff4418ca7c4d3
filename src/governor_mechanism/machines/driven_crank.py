"""Common parts of crank machines: a crank driven at constant speed, and placeholder masses for massless parts.

The plane is fixed. The origin is in the shaft; x points along the line of crosshead and valve, away from the shaft; y points up. The
crank turns anticlockwise.
"""

import math
from collections.abc import Iterator

from governor_mechanism.machines.base import unit_hint
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, RotationalDriver, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.time_functions import PrescribedMotion

CRANK, CROSSHEAD, VALVE, CONNECTING_ROD = "crank", "crosshead", "valve", "connecting rod"
SHAFT, CRANK_DRIVER, CRANK_PIN, GUDGEON_PIN, CROSSHEAD_GUIDE = ("shaft", "drive", "crank pin", "gudgeon", "crosshead guide")

PLACEHOLDER_MASS = 1e-6
"""Mass of a massless part in the engines, kg. The driver prescribes its motion whatever the mass (a test verifies this), and the mass is
too small to load a bearing.
"""

PLACEHOLDER_INERTIA_RATIO = 10.0
"""Moment of inertia of a massless crank, relative to that of the parts it moves: the iterative joint solver converges faster with it."""


def crank_joints(speed: float | None, start_angle: float, mass_centre: float = 0.0) -> tuple[Joint, ...]:
    """Return shaft and driver: the crank angle is start_angle + speed * time (rad); without a speed the crank is free.

    mass_centre is its distance from the shaft (m).
    """
    ground, on_crank = Point(body=GROUND), Point(body=CRANK, x=-mass_centre)
    if speed is None:
        return (Pin(name=SHAFT, first=ground, second=on_crank),)
    motion = PrescribedMotion.constant_rate(start_angle, speed)
    driver = RotationalDriver(name=CRANK_DRIVER, first=ground, second=on_crank, motion=motion)
    return Pin(name=SHAFT, first=ground, second=on_crank), driver


def placeholder_crank(radius: float, moved_mass: float) -> Body:
    """Return a crank of placeholder mass centred on the shaft; it moves the mass moved_mass (kg) at its radius (m)."""
    return shaft_with_crank(PLACEHOLDER_INERTIA_RATIO * moved_mass * radius**2)


def shaft_with_crank(inertia: float) -> Body:
    """Return a crank of placeholder mass centred on the shaft, with a moment of inertia (kg m2)."""
    return Body(name=CRANK, mass=PLACEHOLDER_MASS, second_moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def rod_joint(name: str, driving: Point, driven: Point, length: float | None) -> Joint:
    """Return a massless rod (m). An infinite one is a slide normal to the line, in which the driving point moves."""
    if length is None:
        return Slider(name=name, first=driven, second=driving, angle=math.pi / 2)
    return Distance(name=name, first=driving, second=driven, length=length)


def advance_problems(advance: float) -> Iterator[str]:
    """Yield a sentence about an angle of advance (rad) that is a right angle or more."""
    if not abs(advance) < math.pi / 2:
        yield (
            f"advance ({math.degrees(advance):.6g} deg) must lie between -90 and 90 deg: it is measured from "
            f"the right angle to the crank{unit_hint(advance, math.pi, '30 deg')}"
        )
