"""Valve timing: opening and closing of a slide valve's ports, from the kinematics of the mechanism."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from governor_mechanism.model.scene import Scene
from governor_mechanism.model.valve import Valve
from governor_mechanism.numerics.roots import find_root, find_roots
from governor_mechanism.observables.valve_motion import ANGLE_TOLERANCE, ValveMotion, find_turning_angles, valve_motion_of
from governor_mechanism.types import FloatArray

CYLINDER_ENDS = ("crank end", "head end")

PORT_EVENTS = {"steam": ("admission", "cut-off"), "exhaust": ("release", "compression")}
"""Names of the opening and the closing event of each port."""


@dataclass(frozen=True, kw_only=True)
class PortTiming:
    """Openings and closings of a port in a turn of the crank.

    Attributes
    ----------
    end
        End of the cylinder: one of CYLINDER_ENDS.
    port
        One of PORT_EVENTS.
    openings
        Crank angles at which the port opens, rad, from 0 to 2 pi, ascending.
    closings
        Crank angles at which it closes.
    largest_opening
        Displacement of the valve less the lap where it is largest, m; negative if the port never opens.
    """

    end: str
    port: str
    openings: tuple[float, ...]
    closings: tuple[float, ...]
    largest_opening: float

    @property
    def events(self) -> dict[str, float]:
        """Crank angles of the opening and the closing by name, such as "crank end cut-off"; none unless the port opens once in a turn."""
        if len(self.openings) != 1:
            return {}
        names = (f"{self.end} {event}" for event in PORT_EVENTS[self.port])
        return dict(zip(names, (*self.openings, *self.closings), strict=True))

    @property
    def statement(self) -> str:
        """A sentence on a port that does not open once in a turn; empty for one that does."""
        if len(self.openings) == 1:
            return ""
        name = f"the {self.port} port of the {self.end}"
        if not self.openings:
            if self.largest_opening > 0:
                return f"{name} never closes"
            return f"{name} never opens: it stays covered by {-1e3 * self.largest_opening:.4g} mm or more"
        opens, closes = (", ".join(f"{math.degrees(angle):.6g}" for angle in angles) for angles in (self.openings, self.closings))
        return f"{name} opens {len(self.openings)} times in a turn, at {opens} deg, and closes at {closes} deg"


class _Crossing(NamedTuple):
    """A zero of sign * position - threshold between two crank angles (rad), upward or downward; port is an index of the timings."""

    port: int
    opens: bool
    sign: float
    threshold: float
    low: float
    high: float


def find_port_timings(scene: Scene) -> tuple[PortTiming, ...]:
    """Return the openings and closings of the ports at both ends of the cylinder, to about 1e-13 rad.

    Result: steam port and exhaust of the crank end, then those of the head end.
    """
    motion = valve_motion_of(scene)
    position = motion.turn[motion.valve.displacement]
    turning_angles = find_turning_angles(position)
    extremes = position(turning_angles)
    ports = [(end, port, *_port_edge(motion.valve, end, port)) for end in CYLINDER_ENDS for port in PORT_EVENTS]
    crossings, largest_openings = list[_Crossing](), list[float]()
    for k, (_, _, sign, lap) in enumerate(ports):
        threshold = sign * motion.centre + lap
        openings = sign * extremes - threshold
        largest_openings.append(float(np.max(openings)))
        for (low, before), (high, after) in pairwise(zip(turning_angles.tolist(), openings.tolist(), strict=True)):
            if (before > 0) != (after > 0):
                crossings.append(_Crossing(k, after > 0, sign, threshold, low, high))
    angles = _locate_crossings(motion, crossings) if crossings else []
    return tuple(
        PortTiming(
            end=end,
            port=port,
            openings=_angles_of(crossings, angles, k, opens=True),
            closings=_angles_of(crossings, angles, k, opens=False),
            largest_opening=largest_openings[k],
        )
        for k, (end, port, _, _) in enumerate(ports)
    )


def find_event_angles(scene: Scene) -> dict[str, float]:
    """Return the crank angles of the valve events, eight if every port opens once in a turn, to about 1e-13 rad.

    Result: crank angles, rad, from 0 to 2 pi, by names such as "crank end cut-off".
    """
    return {name: angle for timing in find_port_timings(scene) for name, angle in timing.events.items()}


def _port_edge(valve: Valve, end: str, port: str) -> tuple[float, float]:
    """Return the sign of the displacement that opens a port, and the lap over it, m."""
    steam_sign = valve.outward_sign if end == CYLINDER_ENDS[0] else -valve.outward_sign
    return (steam_sign, valve.steam_lap) if port == "steam" else (-steam_sign, valve.exhaust_lap)


def _angles_of(crossings: list[_Crossing], angles: list[float], port: int, *, opens: bool) -> tuple[float, ...]:
    pairs = zip(crossings, angles, strict=True)
    return tuple(sorted(angle for crossing, angle in pairs if crossing.port == port and crossing.opens == opens))


def _locate_crossings(motion: ValveMotion, crossings: list[_Crossing]) -> list[float]:
    """Return the crank angles of crossings, rad, from 0 to 2 pi."""
    position = motion.turn[motion.valve.displacement]
    signs, thresholds, low, high = (np.array([getattr(one, name) for one in crossings]) for name in ("sign", "threshold", "low", "high"))

    def openings(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        positions, derivatives = (arrays[motion.valve.displacement] for arrays in motion.evaluate(angles % math.tau)[:2])
        return signs * positions - thresholds, signs * derivatives

    def interpolated_root(crossing: _Crossing) -> float:
        return find_root(lambda angle: float(crossing.sign * position(angle) - crossing.threshold), crossing.low, crossing.high)

    angles, steps = np.array([interpolated_root(one) for one in crossings]), np.zeros(len(crossings))
    for _ in range(2):  # Newton's method, from angles that are almost right
        values, derivatives = openings(angles)
        steps = -values / derivatives
        angles = angles + steps
    if not np.all((np.abs(steps) < ANGLE_TOLERANCE) & (low < angles) & (angles < high)):
        angles = find_roots(openings, low, high, ANGLE_TOLERANCE)
    located: list[float] = (angles % math.tau).tolist()
    return located
