"""What driven crank machines share: the crank, turned steadily by its drive, and masses for parts without any.

A fixed plane: the shaft in the origin, x along the line of crosshead and valve, away from the shaft, y up; the crank
turns anticlockwise.
"""

from __future__ import annotations

import math

from governor_mechanism.model.joints import GROUND, DrivenTurn, Joint, Pin, Point
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.time_functions import Motion

CRANK, CROSSHEAD, VALVE, ROD = "crank", "crosshead", "valve", "connecting rod"
SHAFT, DRIVE, CRANK_PIN, GUDGEON, GUIDE = "shaft", "drive", "crank pin", "gudgeon", "crosshead guide"

STAND_IN = 1e-6
"""kg: what a part without mass has in the engines. Its motion is the drive's whatever it weighs (a test holds that),
and so little loads no bearing."""

FLYWHEEL = 10.0
"""How many times the moment of inertia of what it moves the crank has for the engines, where it has no mass itself:
joints that are solved in turns then close sooner."""


def driven_crank(speed: float, start: float, centre: float = 0.0) -> tuple[Joint, ...]:
    """Shaft and drive: the crank's angle follows start + speed * time (rad); centre (m) is where its mass lies."""
    on_crank = Point(body=CRANK, x=-centre)
    return (
        Pin(name=SHAFT, first=Point(body=GROUND), second=on_crank),
        DrivenTurn(name=DRIVE, first=Point(body=GROUND), second=on_crank, motion=Motion.steady(start, speed)),
    )


def massless_crank(radius: float, moved: float) -> Body:
    """A crank of stand-in mass, its centre in the shaft; moved (kg) is what it moves at its radius (m)."""
    inertia = FLYWHEEL * moved * radius**2
    return Body(name=CRANK, mass=STAND_IN, moments=SecondMoments(xx=inertia / 2, yy=inertia / 2))


def turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """A place turned about the origin (m, rad)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y
