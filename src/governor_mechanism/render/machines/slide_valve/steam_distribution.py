"""Which phase the steam at an end of a cylinder is in: the sizes that decide it, and the position of valve and piston."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, Flexible, Frame, fixed_axes
from governor_mechanism.render.geometry.primitives import DrawnShape, Polygon, Vec2
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


def phase_parts(phase_at: Callable[[Any], str], outline: tuple[Vec2, ...], frame: Frame = fixed_axes) -> Iterator[Attached]:
    """Yield a space that steam fills, in the colour of each phase, of which one is there; `phase_at` is that of a moment."""
    yield from (Attached(frame=frame, shapes=(Polygon(role, outline),), shown=partial(_is_phase, phase_at, role)) for role in STEAM_PHASES)


def _is_phase(phase_at: Callable[[Any], str], role: str, moment: Any) -> bool:
    return phase_at(moment) == role


def changing_space_parts(
    roles: Iterable[str], role_at: Callable[[Any], str], outline_at: Callable[[Any], tuple[Vec2, ...]]
) -> Iterator[Flexible]:
    """Yield a space whose outline changes, in the colours of some roles, of which one is there; `role_at` is that of a moment."""
    yield from (Flexible(shapes_at=partial(_changing_space, role_at, outline_at, role)) for role in roles)


def _changing_space(
    role_at: Callable[[Any], str], outline_at: Callable[[Any], tuple[Vec2, ...]], role: str, moment: Any
) -> list[DrawnShape]:
    return [Polygon(role, outline_at(moment) if role_at(moment) == role else ())]


def sense_of_rotation(times: FloatArray, angles: FloatArray, time: float) -> float:
    """Return 1 if the angle of a crank at times (n,) s grows just before a time (s), -1 if it falls."""
    k = min(int(np.searchsorted(times, time)), len(angles) - 1)
    return -1.0 if angles[k] < angles[max(k - 1, 0)] else 1.0
