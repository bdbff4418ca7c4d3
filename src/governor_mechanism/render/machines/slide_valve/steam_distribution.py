"""Which phase the steam at an end of a cylinder is in: the sizes that decide it, and the position of valve and piston."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from governor_mechanism.types import FloatArray

STEAM_PHASES = ("live steam", "expanding steam", "spent steam", "pressed steam")


@dataclass(frozen=True, kw_only=True)
class ValveGearPosition:
    """Valve gear at a pose: crank angle (rad), valve displacement away from the shaft (m), piston position (m), sense of rotation.

    The crank angle counts from the dead centre of the crank end, and the dead centre of the head end lies at `head_end_angle`. The piston
    position along the stroke is -crank at the head end (left) to crank at the crank end (right).
    """

    crank_angle: float
    valve_displacement: float
    piston_position: float
    sense: float = 1.0
    head_end_angle: float = math.pi

    @property
    def is_outstroke(self) -> bool:
        """Whether the piston moves away from the crank end."""
        return (self.crank_angle % math.tau < self.head_end_angle) == (self.sense > 0)


class SteamDistribution(Protocol):
    """Crank radius, eccentricity or half the travel of the valve, and laps, m; laps have a sign.

    `outward_sign` is 1 if a displacement of the valve away from the shaft opens the steam port of the crank end, as with outside
    admission, and -1 if it opens that of the head end.
    """

    @property
    def crank(self) -> float:
        """Crank radius, m."""

    @property
    def eccentric(self) -> float:
        """Eccentricity, or half the travel of the valve, m."""

    @property
    def outside_lap(self) -> float:
        """Lap over the edges that admit steam, m; those of a valve with inside admission are its inner ones."""

    @property
    def inside_lap(self) -> float:
        """Lap over the edges of the exhaust, m."""

    @property
    def outward_sign(self) -> float:
        """Sign of the displacement that admits steam to the crank end."""


def steam_phase(distribution: SteamDistribution, position: ValveGearPosition, side: float) -> str:
    """Return the phase of the steam at one end; `side` is 1 at the crank end, -1 at the head end."""
    admission, expansion, exhaust, compression = STEAM_PHASES
    port_displacement = side * distribution.outward_sign * position.valve_displacement
    if port_displacement > distribution.outside_lap:
        return admission
    if -port_displacement > distribution.inside_lap:
        return exhaust
    return expansion if (side > 0) == position.is_outstroke else compression


def sense_of_rotation(times: FloatArray, angles: FloatArray, time: float) -> float:
    """Return 1 if the angle of a crank at times (n,) s grows just before a time (s), -1 if it falls."""
    k = min(int(np.searchsorted(times, time)), len(angles) - 1)
    return -1.0 if angles[k] < angles[max(k - 1, 0)] else 1.0
