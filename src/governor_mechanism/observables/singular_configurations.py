"""Dead centres and change points that a motion passes, found between its stations by root finding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BPoly
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import measure
from governor_mechanism.model.events import Event
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

MOVING = 0.05
"""Where all bodies together slow down to this fraction of their speed while a rate changes sign, they turn back."""

NEAR = 0.1
"""A change point is looked for where the joint rows are less independent than this (an angle, about, in rad)."""

ROUNDING = 1e-9
"""A rate this much smaller than that at the other end of a step is nought."""

MENDED = 3
"""Newton steps on the engine's own motion, each some thousand times nearer."""

AT = 1e-5
"""At a change point the least singular value falls below this fraction of the largest."""


Path = Callable[[float], tuple[FloatArray, FloatArray]]
Between = Callable[[int, float], tuple[FloatArray, FloatArray] | None]


@dataclass(frozen=True)
class Stations:
    """A motion at times (n,) s: poses, velocities, accelerations (n, bodies, 3), independence of joint rows (n,).

    exactly(k, time) gives poses and velocities between station k and the next, or None where the engine cannot.
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    independence: FloatArray
    exactly: Between | None = None

    def smooth(self, k: int) -> Path:
        """A path of order 5 from station k to the next."""
        ends = slice(k, k + 2)
        parts = (self.poses[ends], self.velocities[ends], self.accelerations[ends])
        path = BPoly.from_derivatives(self.times[ends], np.stack(parts, axis=1))
        moving = path.derivative()
        return lambda time: (path(time), moving(time))


def find_events(mechanism: Mechanism, stations: Stations, mobility: int) -> tuple[Event, ...]:
    """Events between stations, in the order of time.

    A reading stands at a dead centre where its rate changes sign while the mechanism, of mobility one or driven, moves
    on. At a change point the joints leave more freedoms than elsewhere, and the mechanism may change its way.
    """
    found = _change_points(mechanism, stations)
    if mobility <= 1:
        found += _dead_centres(mechanism, stations)
    return tuple(sorted(found, key=lambda event: event.time))


def _dead_centres(mechanism: Mechanism, stations: Stations) -> list[Event]:
    poses, velocities = stations.poses, stations.velocities
    speed = _speed(mechanism, velocities)
    found = []
    for reading in mechanism.readings:
        rates = np.sum(measure(mechanism, reading.name, poses).gradient * velocities, axis=(-2, -1))
        for k in np.flatnonzero(rates[:-1] * rates[1:] < 0).tolist():
            slow = MOVING * float(np.max(speed[k : k + 2]))
            part = rates[k] / (rates[k] - rates[k + 1])
            about = (1 - part) * velocities[k] + part * velocities[k + 1]
            if _speed(mechanism, about) <= slow:
                continue  # everything turns back here, and nothing passes
            time, there = _stands(mechanism, reading.name, stations, k)
            begins = time == stations.times[0]  # there, and does not pass
            if _speed(mechanism, there) > slow and not begins:
                found.append(Event(time=time, kind="dead centre", subject=reading.name))
    return found


def _stands(mechanism: Mechanism, name: str, stations: Stations, k: int) -> tuple[float, FloatArray]:
    """When between stations k and k + 1 the reading stands, and how fast the bodies move then (bodies, 3).

    Found on the smooth path, and mended by the engine's own motion where it has one.
    """
    path = stations.smooth(k)

    def rate(state: tuple[FloatArray, FloatArray]) -> float:
        return float(np.sum(measure(mechanism, name, state[0]).gradient * state[1]))

    start, end = float(stations.times[k]), float(stations.times[k + 1])
    first, last = rate(path(start)), rate(path(end))
    if not first * last < 0:
        near, far = sorted((start, end), key=lambda time: abs(rate(path(time))))
        if abs(rate(path(near))) < ROUNDING * abs(rate(path(far))):
            return near, path(near)[1]
        # So rough a path that it does not show what its ends say.
        return 0.5 * (start + end), path(0.5 * (start + end))[1]
    time = float(brentq(lambda time: rate(path(time)), start, end, xtol=1e-12 * (end - start)))
    beside = 1e-3 * (end - start)
    slope = (rate(path(time + beside)) - rate(path(time - beside))) / (2 * beside)
    for _ in range(MENDED if stations.exactly else 0):
        state = stations.exactly(k, time) if stations.exactly else None
        if state is None:
            break
        time = min(max(time - rate(state) / slope, start), end)
    return time, path(time)[1]


def _change_points(mechanism: Mechanism, stations: Stations) -> list[Event]:
    assembler, times = Assembler(mechanism), stations.times
    angle = np.sqrt(stations.independence)
    found = []
    for k in range(1, len(times) - 1):
        if not (angle[k] < NEAR and angle[k - 1] >= angle[k] < angle[k + 1]):
            continue
        paths = stations.smooth(k - 1), stations.smooth(k)  # no engine likes to stop within a change point

        def least(time: float, middle: float = times[k], paths: tuple[Path, Path] = paths) -> float:
            poses, _ = paths[int(time >= middle)](time)
            values = np.linalg.svd(assembler.joint_rows(poses), compute_uv=False)
            return float(values[-1] / values[0])

        result = minimize_scalar(least, bounds=(times[k - 1], times[k + 1]), method="bounded", options={"xatol": 1e-12})
        if result.fun < AT:
            found.append(Event(time=float(result.x), kind="change point", subject="the mechanism"))
    return found


def _speed(mechanism: Mechanism, velocities: FloatArray) -> FloatArray:
    """How fast the bodies move altogether (m/s), at velocities (..., bodies, 3)."""
    unit = np.array([1.0, 1.0, mechanism.size])
    speed: FloatArray = np.sqrt(np.sum((velocities * unit) ** 2, axis=(-2, -1)))
    return speed
