"""Readings of a piston and of the ports of its slide valve. The valve admits steam with its outer edges."""

from governor_mechanism.machines.base import x_coordinate
from governor_mechanism.model.joints import Point
from governor_mechanism.model.output_variables import PointCoordinate

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
