"""Dead centres and change points that a motion passes, found between its stations by root finding."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BPoly
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.equations.constraints import JointEquations
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import measure
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.trajectory import Event

MOVING = 1e-3
"""A mechanism stands, and does not pass a dead centre, where it is slower than this fraction of its fastest."""

NEAR = 0.1
"""A change point is looked for where the joint rows are less independent than this (an angle, about, in rad)."""

AT = 1e-5
"""At a change point the least singular value falls below this fraction of the largest."""


def find_events(
    mechanism: Mechanism, times: Array, poses: Array, velocities: Array, accelerations: Array, independence: Array,
    mobility: int,
) -> tuple[Event, ...]:  # fmt: skip
    """Events between times (n,) s with poses, velocities and accelerations (n, bodies, 3), in the order of time.

    A reading stands at a dead centre where its rate changes sign while the mechanism moves on (mobility one only). At a
    change point the joints leave more freedoms than elsewhere, and the mechanism may change its way.
    """
    if len(times) < 3:
        return ()
    path = BPoly.from_derivatives(times, np.stack([poses, velocities, accelerations], axis=1))
    found = _change_points(mechanism, path, times, independence)
    if mobility == 1:
        found += _dead_centres(mechanism, path, times, poses, velocities)
    return tuple(sorted(found, key=lambda event: event.time))


def _dead_centres(mechanism: Mechanism, path: BPoly, times: Array, poses: Array, velocities: Array) -> list[Event]:
    moving = path.derivative()
    speed = _speed(mechanism, velocities)
    fastest = float(np.max(speed))
    found = []
    for reading in mechanism.readings:

        def rate(time: float, name: str = reading.name) -> float:
            return float(np.sum(measure(mechanism, name, path(time)).gradient * moving(time)))

        rates = np.sum(measure(mechanism, reading.name, poses).gradient * velocities, axis=(-2, -1))
        for k in np.flatnonzero(rates[:-1] * rates[1:] < 0):
            if not rate(times[k]) * rate(times[k + 1]) < 0:
                continue  # a path so rough that it does not show what its ends say
            time = float(brentq(rate, times[k], times[k + 1], xtol=1e-15, rtol=1e-14))
            if _speed(mechanism, moving(time)) > MOVING * fastest:
                found.append(Event(time=time, kind="dead centre", subject=reading.name))
    return found


def _change_points(mechanism: Mechanism, path: BPoly, times: Array, independence: Array) -> list[Event]:
    equations = JointEquations(mechanism)
    turns = np.array([[True, True, body.turns] for body in mechanism.bodies], dtype=np.bool_).ravel()
    unit = np.tile([1.0, 1.0, 1.0 / mechanism.size], len(mechanism.bodies))[turns]

    def least(time: float) -> float:
        rows = equations.gradients(path(time)).reshape(len(equations.owner), -1)[:, turns] * unit
        values = np.linalg.svd(rows, compute_uv=False)
        return float(values[-1] / values[0])

    angle = np.sqrt(independence)
    found = []
    for k in range(1, len(times) - 1):
        if angle[k] < NEAR and angle[k - 1] >= angle[k] < angle[k + 1]:
            result = minimize_scalar(
                least, bounds=(times[k - 1], times[k + 1]), method="bounded", options={"xatol": 1e-12}
            )
            if result.fun < AT:
                found.append(Event(time=float(result.x), kind="change point", subject="the mechanism"))
    return found


def _speed(mechanism: Mechanism, velocities: Array) -> Array:
    """How fast the bodies move altogether (m/s), at velocities (..., bodies, 3)."""
    unit = np.array([1.0, 1.0, mechanism.size])
    speed: Array = np.sqrt(np.sum((velocities * unit) ** 2, axis=(-2, -1)))
    return speed
