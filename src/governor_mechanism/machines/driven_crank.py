"""What driven crank machines share: the crank, turned steadily by its drive, and masses for parts without any.

A fixed plane: the shaft in the origin, x along the line of crosshead and valve, away from the shaft, y up; the crank
turns anticlockwise.
"""

from __future__ import annotations

import math

from governor_mechanism.model.joints import GROUND, Joint, Pin, Point, RotationalDriver
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.time_functions import PrescribedMotion

CRANK, CROSSHEAD, VALVE, CONNECTING_ROD = "crank", "crosshead", "valve", "connecting rod"
SHAFT, CRANK_DRIVER, CRANK_PIN, GUDGEON_PIN, CROSSHEAD_GUIDE = ("shaft", "drive", "crank pin", "gudgeon", "crosshead guide")

PLACEHOLDER_MASS = 1e-6
"""kg: what a part without mass has in the engines. Its motion is the drive's whatever it weighs (a test holds that),
and so little loads no bearing."""

PLACEHOLDER_INERTIA_RATIO = 10.0
"""How many times the moment of inertia of what it moves the crank has for the engines, where it has no mass itself:
joints that are solved in turns then close sooner."""


def driven_crank_joints(speed: float, start_angle: float, mass_centre: float = 0.0) -> tuple[Joint, ...]:
    """Shaft and drive: the crank's angle follows start + speed * time (rad); centre (m) is where its mass lies."""
    on_crank = Point(body=CRANK, x=-mass_centre)
    return (
        Pin(name=SHAFT, first=Point(body=GROUND), second=on_crank),
        RotationalDriver(
            name=CRANK_DRIVER, first=Point(body=GROUND), second=on_crank, motion=PrescribedMotion.constant_rate(start_angle, speed)
        ),
    )


def placeholder_crank(radius: float, moved_mass: float) -> Body:
    """A crank of stand-in mass, its centre in the shaft; moved (kg) is what it moves at its radius (m)."""
    inertia = PLACEHOLDER_INERTIA_RATIO * moved_mass * radius**2
    return Body(name=CRANK, mass=PLACEHOLDER_MASS, second_moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def rotate_point(x: float, y: float, angle: float) -> tuple[float, float]:
    """A place turned about the origin (m, rad)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y
