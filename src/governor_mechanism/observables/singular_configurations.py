"""Turning points of readings and change points of the mechanism, located on a finished motion by root finding."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

REVERSAL_SPEED_RATIO = 0.05
"""Ratio of speeds: if all bodies slow down below this fraction while a rate changes sign, the whole motion reverses."""

NEAR_CHANGE_POINT_ANGLE = 0.1
"""A change point is searched where the constraint rows are closer to dependence than this angle, rad."""

ZERO_RATE_RATIO = 1e-9
"""A rate is zero if it is below this fraction of the rate at the other end of the interval."""

MAX_NEWTON_POLISH_STEPS = 8
"""Largest number of Newton steps with the engine's own dense output; two or three are usual."""

POLISH_TOLERANCE = 1e-12
"""Newton steps shorter than this fraction of the bracket end the search: rounding."""

CHANGE_POINT_SINGULAR_VALUE_RATIO = 1e-5
"""At a change point the smallest singular value of the constraint Jacobian is below this fraction of the largest."""


BodyState = tuple[FloatArray, FloatArray]
"""Poses and velocities (bodies, 3)."""
MotionPath = Callable[[float], BodyState]
"""Function of time (s) that returns poses and velocities."""
DenseOutput = Callable[[int, float], BodyState | None]
"""Function of interval index and time (s) that returns poses and velocities, or None if it cannot."""


@dataclass(frozen=True)
class SampledMotion:
    """A motion sampled at n times (s).

    Poses, velocities and accelerations have shape (n, bodies, 3); pivot_ratios (n,) measure the independence of the
    constraint rows. dense_output(k, time) gives the engine's own state between samples k and k + 1, if it can. contact_times are the times
    of contact events, s, ascending.
    """

    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    pivot_ratios: FloatArray
    dense_output: DenseOutput
    contact_times: FloatArray

    def quintic_interpolant(self, k: int) -> MotionPath:
        """Return the quintic Hermite interpolant between samples k and k + 1."""
        from scipy.interpolate import BPoly  # slow to import

        ends = slice(k, k + 2)
        parts = (self.poses[ends], self.velocities[ends], self.accelerations[ends])
        path = BPoly.from_derivatives(self.times[ends], np.stack(parts, axis=1))
        velocity = path.derivative()
        return lambda time: (path(time), velocity(time))

    def polish_root(self, k: int, time: float, function: Callable[[BodyState], tuple[float, float]], bracket: Sequence[float]) -> float:
        """Return a root (s) between samples k and k + 1, refined by Newton steps with the engine's own dense output.

        The function returns a value and its rate.
        """
        for _ in range(MAX_NEWTON_POLISH_STEPS):
            state = self.dense_output(k, time)
            value, slope = (0.0, 0.0) if state is None else function(state)
            if state is None or not slope:
                break
            time = min(max(time - value / slope, bracket[0]), bracket[1])
            if abs(value) <= POLISH_TOLERANCE * (bracket[1] - bracket[0]) * abs(slope):
                break
        return time


def find_singular_configurations(mechanism: Mechanism, motion: SampledMotion, mobility: int) -> tuple[Event, ...]:
    """Return turning points and change points between the samples, in the order of time.

    At a turning point the rate of a reading changes sign while the mechanism, with one degree of freedom or driven, moves
    on. At a change point the mechanism gains a degree of freedom and may change its branch.
    """
    events = _find_change_points(mechanism, motion)
    if mobility <= 1:
        events += _find_turning_points(mechanism, motion)
    return tuple(sorted(events, key=lambda event: event.time))


def _find_turning_points(mechanism: Mechanism, motion: SampledMotion) -> list[Event]:
    """Return the turning points of all readings."""
    poses, velocities = motion.poses, motion.velocities
    speed = _overall_speed(mechanism, velocities)
    events = []
    for reading in mechanism.readings:
        rates = evaluate_output(mechanism, reading.name, poses).rate(velocities)
        for k in np.flatnonzero(rates[:-1] * rates[1:] < 0).tolist():
            reversal_speed = REVERSAL_SPEED_RATIO * float(np.max(speed[k : k + 2]))
            fraction = rates[k] / (rates[k] - rates[k + 1])
            interpolated_velocities = (1 - fraction) * velocities[k] + fraction * velocities[k + 1]
            if _overall_speed(mechanism, interpolated_velocities) <= reversal_speed:
                continue  # the whole motion reverses here
            time, turning_velocities = _locate_turning_point(mechanism, reading.name, motion, k)
            is_at_start = time == motion.times[0]  # it starts there and does not pass
            if _overall_speed(mechanism, turning_velocities) > reversal_speed and not is_at_start:
                events.append(Event(time=time, kind=EventKind.TURNING_POINT, subject=reading.name))
    return events


def _locate_turning_point(mechanism: Mechanism, name: str, motion: SampledMotion, k: int) -> tuple[float, FloatArray]:
    """Return the time at which a reading turns between samples k and k + 1, and the velocities (bodies, 3) then.

    The root is found on the quintic interpolant and refined with the engine's dense output where there is one.
    """
    from scipy.optimize import brentq  # slow to import

    path = motion.quintic_interpolant(k)

    def rate(state: BodyState) -> float:
        return float(evaluate_output(mechanism, name, state[0]).rate(state[1]))

    start, end = float(motion.times[k]), float(motion.times[k + 1])
    start_rate, end_rate = rate(path(start)), rate(path(end))
    if not start_rate * end_rate < 0:
        slow_end, fast_end = sorted((start, end), key=lambda time: abs(rate(path(time))))
        if abs(rate(path(slow_end))) < ZERO_RATE_RATIO * abs(rate(path(fast_end))):
            return slow_end, path(slow_end)[1]
        middle = 0.5 * (start + end)  # the interpolant is too inaccurate to show the sign change of its end rates
        return middle, path(middle)[1]
    time = float(brentq(lambda time: rate(path(time)), start, end, xtol=1e-12 * (end - start)))
    time_offset = 1e-3 * (end - start)
    rate_derivative = (rate(path(time + time_offset)) - rate(path(time - time_offset))) / (2 * time_offset)
    time = motion.polish_root(k, time, lambda state: (rate(state), rate_derivative), (start, end))
    return time, path(time)[1]


def _find_change_points(mechanism: Mechanism, motion: SampledMotion) -> list[Event]:
    """Return the change points: minima of the singular value ratio of the constraint Jacobian close to zero."""
    position_solver = PositionSolver(mechanism)
    nearest = (locate_nearly_singular_poses(position_solver, motion, k) for k in find_nearly_singular_samples(motion))
    return [
        Event(time=time, kind=EventKind.CHANGE_POINT, subject="the mechanism")
        for time, _, singular_value in nearest
        if singular_value < CHANGE_POINT_SINGULAR_VALUE_RATIO
    ]


def find_nearly_singular_samples(motion: SampledMotion) -> list[int]:
    """Return the inner samples at which the constraint rows are nearest to dependence."""
    angle = np.sqrt(motion.pivot_ratios)
    before, here, after = angle[:-2], angle[1:-1], angle[2:]
    indices: list[int] = (1 + np.flatnonzero((here < NEAR_CHANGE_POINT_ANGLE) & (before >= here) & (here < after))).tolist()
    return indices


def locate_nearly_singular_poses(position_solver: PositionSolver, motion: SampledMotion, k: int) -> tuple[float, FloatArray, float]:
    """Return time (s), poses (bodies, 3) and singular value next to a sample, where the constraint rows are nearest to dependence.

    The singular value is the smallest one of the scaled constraint Jacobian, relative to the largest.
    """
    from scipy.optimize import minimize_scalar  # slow to import

    times = motion.times
    # Engines avoid stopping at a change point, so there is no dense output.
    paths = motion.quintic_interpolant(k - 1), motion.quintic_interpolant(k)

    def poses_at(time: float) -> FloatArray:
        return paths[int(time >= times[k])](time)[0]

    def singular_value_ratio(time: float) -> float:
        singular_values = np.linalg.svd(position_solver.scaled_joint_jacobian(poses_at(time)), compute_uv=False)
        return float(singular_values[-1] / singular_values[0])

    result = minimize_scalar(singular_value_ratio, bounds=(times[k - 1], times[k + 1]), method="bounded", options={"xatol": 1e-12})
    return float(result.x), poses_at(float(result.x)), float(result.fun)


def _overall_speed(mechanism: Mechanism, velocities: FloatArray) -> FloatArray:
    """Return the root sum of squares of all velocities (..., bodies, 3), m/s; rotations count by the length scale."""
    coordinate_scale = np.array([1.0, 1.0, mechanism.length_scale])
    speed: FloatArray = np.sqrt(np.sum((velocities * coordinate_scale) ** 2, axis=(-2, -1)))
    return speed
