"""Common parts of crank machines: a crank driven at constant speed, and placeholder masses for massless parts.

The plane is fixed. The origin is in the shaft; x points along the line of crosshead and valve, away from the shaft; y points up. The
crank turns anticlockwise.
"""

import math
from collections.abc import Iterator

from governor_mechanism.machines.base import unit_hint, x_coordinate
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, RotationalDriver, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import PointCoordinate
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


VALVE_DISPLACEMENT, CRANK_END_TRAVEL = "valve_displacement", "crank_end_travel"
"""Names of the readings of valve and piston, which grow away from the shaft."""
PORT_OPENINGS = ("crank_end_steam", "crank_end_exhaust", "head_end_steam", "head_end_exhaust")
"""Names of the openings of the ports; a negative opening is the overlap of a closed port."""

STEAM_READING_MEANINGS = {
    VALVE_DISPLACEMENT: "displacement of the valve from the centre of its motion, away from the shaft",
    CRANK_END_TRAVEL: "travel of the piston from the crank end of its stroke",
    "head_end_travel": "travel of the piston from the head end of its stroke",
    "crank_end_steam": "opening of the crank-end port to steam; negative where it is closed",
    "crank_end_exhaust": "opening of the crank-end port to the exhaust; negative where it is closed",
    "head_end_steam": "opening of the head-end port to steam; negative where it is closed",
    "head_end_exhaust": "opening of the head-end port to the exhaust; negative where it is closed",
}
"""What the readings of valve, piston and ports are, by name."""


def piston_readings(crosshead: Point, crank: float, crank_end: float, side: float = 1.0) -> tuple[PointCoordinate, ...]:
    """Return the travel of the piston from both ends of its stroke.

    Parameters
    ----------
    crosshead
        Point of the crosshead, on the valve line.
    crank
        Crank radius, m.
    crank_end
        Distance of the crosshead from the shaft with the piston at the crank end, m.
    side
        1 if the valve line leads away from the shaft along x, -1 if it does along -x.

    Returns
    -------
    tuple[PointCoordinate, ...]
        Readings crank_end_travel and head_end_travel.
    """
    return (
        x_coordinate(CRANK_END_TRAVEL, crosshead, sign=side, zero=crank_end),
        x_coordinate("head_end_travel", crosshead, sign=-side, zero=-crank_end - 2 * crank),
    )


def port_readings(valve: Point, centre: float, outside_lap: float, inside_lap: float, side: float = 1.0) -> tuple[PointCoordinate, ...]:
    """Return the openings of the ports; negative: closed.

    Parameters
    ----------
    valve
        Point of the valve, on the valve line.
    centre
        Distance of the centre of the valve's motion from the shaft, m.
    outside_lap
        Outside lap, m.
    inside_lap
        Inside lap, m.
    side
        1 if the valve line leads away from the shaft along x, -1 if it does along -x.

    Returns
    -------
    tuple[PointCoordinate, ...]
        Readings of steam port and exhaust at the crank end and at the head end.
    """
    crank_end_steam, crank_end_exhaust, head_end_steam, head_end_exhaust = PORT_OPENINGS
    return (
        x_coordinate(crank_end_steam, valve, sign=side, zero=centre + outside_lap),
        x_coordinate(crank_end_exhaust, valve, sign=-side, zero=-centre + inside_lap),
        x_coordinate(head_end_steam, valve, sign=-side, zero=-centre + outside_lap),
        x_coordinate(head_end_exhaust, valve, sign=side, zero=centre + inside_lap),
    )
