"""Dead centres and change points that a motion passes, found between its stations by root finding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BPoly
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

REVERSAL_SPEED_RATIO = 0.05
"""Where all bodies together slow down to this fraction of their speed while a rate changes sign, they turn back."""

NEAR_CHANGE_POINT_ANGLE = 0.1
"""A change point is looked for where the joint rows are less independent than this (an angle, about, in rad)."""

ZERO_RATE_RATIO = 1e-9
"""A rate this much smaller than that at the other end of a step is nought."""

N_NEWTON_POLISH_STEPS = 3
"""Newton steps on the engine's own motion, each some thousand times nearer."""

CHANGE_POINT_SINGULAR_VALUE_RATIO = 1e-5
"""At a change point the least singular value falls below this fraction of the largest."""


MotionPath = Callable[[float], tuple[FloatArray, FloatArray]]
DenseOutput = Callable[[int, float], tuple[FloatArray, FloatArray] | None]


@dataclass(frozen=True)
class SampledMotion:
    """A motion at times (n,) s: poses, velocities, accelerations (n, bodies, 3), independence of joint rows (n,).

    exactly(k, time) gives poses and velocities between station k and the next, or None where the engine cannot.
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    pivot_ratios: FloatArray
    dense_output: DenseOutput | None = None

    def quintic_interpolant(self, k: int) -> MotionPath:
        """A path of order 5 from station k to the next."""
        ends = slice(k, k + 2)
        parts = (self.poses[ends], self.velocities[ends], self.accelerations[ends])
        path = BPoly.from_derivatives(self.times[ends], np.stack(parts, axis=1))
        velocity = path.derivative()
        return lambda time: (path(time), velocity(time))


def find_singular_configurations(mechanism: Mechanism, motion: SampledMotion, mobility: int) -> tuple[Event, ...]:
    """Events between stations, in the order of time.

    A reading stands at a dead centre where its rate changes sign while the mechanism, of mobility one or driven, moves
    on. At a change point the joints leave more freedoms than elsewhere, and the mechanism may change its way.
    """
    events = _find_change_points(mechanism, motion)
    if mobility <= 1:
        events += _find_turning_points(mechanism, motion)
    return tuple(sorted(events, key=lambda event: event.time))


def _find_turning_points(mechanism: Mechanism, motion: SampledMotion) -> list[Event]:
    poses, velocities = motion.poses, motion.velocities
    speed = _overall_speed(mechanism, velocities)
    events = []
    for reading in mechanism.readings:
        rates = np.sum(evaluate_output(mechanism, reading.name, poses).gradient * velocities, axis=(-2, -1))
        for k in np.flatnonzero(rates[:-1] * rates[1:] < 0).tolist():
            reversal_speed = REVERSAL_SPEED_RATIO * float(np.max(speed[k : k + 2]))
            fraction = rates[k] / (rates[k] - rates[k + 1])
            interpolated_velocities = (1 - fraction) * velocities[k] + fraction * velocities[k + 1]
            if _overall_speed(mechanism, interpolated_velocities) <= reversal_speed:
                continue  # everything turns back here, and nothing passes
            time, turning_velocities = _locate_turning_point(mechanism, reading.name, motion, k)
            is_at_start = time == motion.times[0]  # there, and does not pass
            if _overall_speed(mechanism, turning_velocities) > reversal_speed and not is_at_start:
                events.append(Event(time=time, kind=EventKind.TURNING_POINT, subject=reading.name))
    return events


def _locate_turning_point(mechanism: Mechanism, name: str, motion: SampledMotion, k: int) -> tuple[float, FloatArray]:
    """When between stations k and k + 1 the reading stands, and how fast the bodies move then (bodies, 3).

    Found on the smooth path, and mended by the engine's own motion where it has one.
    """
    path = motion.quintic_interpolant(k)

    def rate(state: tuple[FloatArray, FloatArray]) -> float:
        return float(np.sum(evaluate_output(mechanism, name, state[0]).gradient * state[1]))

    start, end = float(motion.times[k]), float(motion.times[k + 1])
    start_rate, end_rate = rate(path(start)), rate(path(end))
    if not start_rate * end_rate < 0:
        slow_end, fast_end = sorted((start, end), key=lambda time: abs(rate(path(time))))
        if abs(rate(path(slow_end))) < ZERO_RATE_RATIO * abs(rate(path(fast_end))):
            return slow_end, path(slow_end)[1]
        # So rough a path that it does not show what its ends say.
        return 0.5 * (start + end), path(0.5 * (start + end))[1]
    time = float(brentq(lambda time: rate(path(time)), start, end, xtol=1e-12 * (end - start)))
    time_offset = 1e-3 * (end - start)
    rate_derivative = (rate(path(time + time_offset)) - rate(path(time - time_offset))) / (2 * time_offset)
    for _ in range(N_NEWTON_POLISH_STEPS if motion.dense_output else 0):
        state = motion.dense_output(k, time) if motion.dense_output else None
        if state is None:
            break
        time = min(max(time - rate(state) / rate_derivative, start), end)
    return time, path(time)[1]


def _find_change_points(mechanism: Mechanism, motion: SampledMotion) -> list[Event]:
    position_solver, times = PositionSolver(mechanism), motion.times
    singularity_angle = np.sqrt(motion.pivot_ratios)
    events = []
    for k in range(1, len(times) - 1):
        if not (
            singularity_angle[k] < NEAR_CHANGE_POINT_ANGLE and singularity_angle[k - 1] >= singularity_angle[k] < singularity_angle[k + 1]
        ):
            continue
        paths = (motion.quintic_interpolant(k - 1), motion.quintic_interpolant(k))  # no engine likes to stop within a change point

        def singular_value_ratio(time: float, middle: float = times[k], paths: tuple[MotionPath, MotionPath] = paths) -> float:
            poses, _ = paths[int(time >= middle)](time)
            singular_values = np.linalg.svd(position_solver.scaled_joint_jacobian(poses), compute_uv=False)
            return float(singular_values[-1] / singular_values[0])

        result = minimize_scalar(singular_value_ratio, bounds=(times[k - 1], times[k + 1]), method="bounded", options={"xatol": 1e-12})
        if result.fun < CHANGE_POINT_SINGULAR_VALUE_RATIO:
            events.append(Event(time=float(result.x), kind=EventKind.CHANGE_POINT, subject="the mechanism"))
    return events


def _overall_speed(mechanism: Mechanism, velocities: FloatArray) -> FloatArray:
    """How fast the bodies move altogether (m/s), at velocities (..., bodies, 3)."""
    coordinate_scale = np.array([1.0, 1.0, mechanism.length_scale])
    speed: FloatArray = np.sqrt(np.sum((velocities * coordinate_scale) ** 2, axis=(-2, -1)))
    return speed
