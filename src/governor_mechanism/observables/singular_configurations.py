"""Turning points of readings and change points of the mechanism, located on a finished motion by root finding."""

from functools import partial

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.observables.sampled_motion import BodyState, SampledMotion, SampledReading
from governor_mechanism.types import FloatArray, IntArray

REVERSAL_SPEED_RATIO = 0.05
"""Ratio of speeds: if all bodies slow down below this fraction while a rate changes sign, the whole motion reverses."""

NEAR_CHANGE_POINT_ANGLE = 0.1
"""A change point is searched where the constraint rows are closer to dependence than this angle, rad."""

ZERO_RATE_RATIO = 1e-9
"""A rate is zero if it is below this fraction of the rate at the other end of the interval."""

REST_RATE_RATIO = 1e-12
"""A reading rests if its rate, in its scale, is below this fraction of the overall speed in length scales: what remains is rounding."""

N_PARABOLAS = 7
"""Number of parabolas on the way to a change point: the last one is narrower than the interval by 2e-6, still far from rounding."""

PARABOLA_SHRINKAGE = 0.1
"""Ratio of the widths of successive parabolas: more than the error of the vertex, which is of third order in the width."""

CHANGE_POINT_SINGULAR_VALUE_RATIO = 1e-5
"""At a change point the smallest singular value of the constraint Jacobian is below this fraction of the largest."""


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
    speed = _overall_speed(mechanism, motion.velocities)
    return [
        Event(time=time, kind=EventKind.TURNING_POINT, subject=reading.name)
        for reading in mechanism.readings
        for time in _find_turning_times(mechanism, motion, reading.name, speed).tolist()
    ]


def _find_turning_times(mechanism: Mechanism, motion: SampledMotion, name: str, speed: FloatArray) -> FloatArray:
    """Return the times (m,) s at which a reading turns, from the overall speed at the samples (n,), m/s."""
    sampled = SampledReading(mechanism, motion, name)
    before, after = sampled.rates[:-1], sampled.rates[1:]
    rest_rates = REST_RATE_RATIO * speed * mechanism.output_scale(name) / mechanism.length_scale
    is_moving = np.abs(sampled.rates) > rest_rates
    intervals = np.flatnonzero((before * after < 0) & (is_moving[:-1] | is_moving[1:]))
    fractions = (before[intervals] / (before - after)[intervals])[:, np.newaxis, np.newaxis]
    velocities = (1 - fractions) * motion.velocities[intervals] + fractions * motion.velocities[intervals + 1]
    intervals = intervals[_overall_speed(mechanism, velocities) > _reversal_speed(speed, intervals)]  # else the whole motion reverses
    if not len(intervals):
        return np.zeros(0)
    starts, ends = motion.times[intervals], motion.times[intervals + 1]
    start_rates, end_rates = np.abs(before[intervals]), np.abs(after[intervals])
    times, is_certain = sampled.find_extremes(intervals, starts, ends)
    times = np.where(start_rates < ZERO_RATE_RATIO * end_rates, starts, times)
    times = np.where(end_rates < ZERO_RATE_RATIO * start_rates, ends, times)
    passing_speed = _overall_speed(mechanism, motion.interpolate(intervals, times)[1])
    is_passed = (passing_speed > _reversal_speed(speed, intervals)) & (times != motion.times[0])
    for i in np.flatnonzero(is_passed & ~is_certain & (times > starts) & (times < ends)).tolist():
        rate = partial(_rate_in_state, mechanism, name)
        times[i] = motion.refine_root(int(intervals[i]), float(times[i]), rate, (float(starts[i]), float(ends[i])))
    passed: FloatArray = times[is_passed]
    return passed


def _rate_in_state(mechanism: Mechanism, name: str, state: BodyState) -> float:
    """Return the rate of a reading, SI/s."""
    return float(evaluate_output(mechanism, name, state[0]).rate(state[1]))


def _reversal_speed(speed: FloatArray, intervals: IntArray) -> FloatArray:
    """Return the overall speed (m,) below which the whole motion reverses in an interval, from that at the samples (n,)."""
    limit: FloatArray = REVERSAL_SPEED_RATIO * np.maximum(speed[intervals], speed[intervals + 1])
    return limit


def _find_change_points(mechanism: Mechanism, motion: SampledMotion) -> list[Event]:
    """Return the change points: minima of the singular value ratio of the constraint Jacobian close to zero."""
    times, _, singular_values = locate_nearly_singular_poses(mechanism, motion, find_nearly_singular_samples(motion))
    found = times[singular_values < CHANGE_POINT_SINGULAR_VALUE_RATIO]
    return [Event(time=time, kind=EventKind.CHANGE_POINT, subject="the mechanism") for time in found.tolist()]


def find_nearly_singular_samples(motion: SampledMotion) -> IntArray:
    """Return the inner samples (m,) at which the constraint rows are nearest to dependence."""
    angle = np.sqrt(motion.pivot_ratios)
    before, here, after = angle[:-2], angle[1:-1], angle[2:]
    return 1 + np.flatnonzero((here < NEAR_CHANGE_POINT_ANGLE) & (before >= here) & (here < after))


def locate_nearly_singular_poses(
    mechanism: Mechanism, motion: SampledMotion, samples: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times (m,) s, poses (m, bodies, 3) and singular values (m,) next to samples, where rows are nearest to dependence.

    The singular value is the smallest one of the scaled constraint Jacobian, relative to the largest. Near a change point its square is
    a parabola in time, whose vertex is found from three points closer and closer to each other.
    """
    position_solver, times = PositionSolver(mechanism), motion.times[samples]
    half_widths = np.minimum(times - motion.times[samples - 1], motion.times[samples + 1] - times)

    # Engines avoid stopping at a change point, so there is no dense output.
    def poses_at(instants: FloatArray) -> FloatArray:
        return motion.interpolate(np.where(instants >= motion.times[samples], samples, samples - 1), instants)[0]

    def squares_at(instants: FloatArray) -> FloatArray:
        singular_values = np.linalg.svd(position_solver.scaled_joint_jacobian(poses_at(instants)), compute_uv=False)
        squares: FloatArray = (singular_values[:, -1] / singular_values[:, 0]) ** 2
        return squares

    low, high = motion.times[samples - 1], motion.times[samples + 1]
    for _ in range(N_PARABOLAS if len(samples) else 0):
        before, here, after = (squares_at(np.clip(times + side * half_widths, low, high)) for side in (-1, 0, 1))
        curvature = before - 2 * here + after
        steps = 0.5 * half_widths * np.divide(before - after, curvature, out=np.sign(before - after), where=curvature > 0)
        times = np.clip(times + np.clip(steps, -half_widths, half_widths), low, high)
        half_widths = half_widths * PARABOLA_SHRINKAGE
    return times, poses_at(times), np.sqrt(squares_at(times))


def _overall_speed(mechanism: Mechanism, velocities: FloatArray) -> FloatArray:
    """Return the root sum of squares of all velocities (..., bodies, 3), m/s; rotations count by the length scale."""
    coordinate_scale = np.array([1.0, 1.0, mechanism.length_scale])
    speed: FloatArray = np.sqrt(np.sum((velocities * coordinate_scale) ** 2, axis=(-2, -1)))
    return speed
