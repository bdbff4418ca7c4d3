"""Turning and change points on a finished motion, and passes near a change point where rounding, not mechanics, decides how it goes on.

Where a closed chain of links lies in line, two branches of its motion cross. If its lengths miss that configuration by a defect d,
the branches avoid each other at a distance of order sqrt(d), and the motion bends from one line to the other. A run that goes
straight through, because d is below what keeps its joints closed, is on the wrong branch afterwards; other tolerances show the same.
"""

from functools import partial

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import singular_value_ratio
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
    """Return turning points and change points between the samples, in the order of time."""
    # At a turning point the rate of a reading changes sign while the mechanism, with one degree of
    # freedom or driven, moves on. At a change point the mechanism gains a degree of freedom and may
    # change its branch.
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
    before = angle[:-2]
    here = angle[1:-1]
    after = angle[2:]
    return 1 + np.flatnonzero((here < NEAR_CHANGE_POINT_ANGLE) & (before >= here) & (here < after))


def locate_nearly_singular_poses(
    mechanism: Mechanism, motion: SampledMotion, samples: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times (m,) s, poses (m, bodies, 3) and singular values (m,) next to samples, where rows are nearest to dependence."""
    # The singular value is the smallest one of the scaled constraint Jacobian, relative to the largest.
    # Near a change point its square is a parabola in time, whose vertex is found from three points
    # closer and closer to each other.
    position_solver, times = PositionSolver(mechanism), motion.times[samples]
    half_widths = np.minimum(times - motion.times[samples - 1], motion.times[samples + 1] - times)

    # Engines avoid stopping at a change point, so there is no dense output.
    def poses_at(instants: FloatArray) -> FloatArray:
        return motion.interpolate(np.where(instants >= motion.times[samples], samples, samples - 1), instants)[0]

    def squares_at(instants: FloatArray) -> FloatArray:
        ratios = [singular_value_ratio(rows) for rows in position_solver.scaled_joint_jacobian(poses_at(instants))]
        squares: FloatArray = np.array(ratios) ** 2
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


EXACT_DEFECT = 1e-13
"""Defect, in length scales, up to which lengths meet a change point exactly: rounding of dimensions and of their sums."""

N_CLOSING_STEPS = 4
"""Newton steps that close the joints after a displacement of `STENCIL_STEP`; they converge quadratically."""

STENCIL_STEP = 1e-3
"""Step of the differences of the defect, in length scales and rad: its third derivatives then matter by 1e-3 only."""

MAX_ITERATIONS = 6
"""Largest number of Newton steps to the saddle of the defect; they converge quadratically."""

MAX_STEP = 0.1
"""Largest of these steps, in length scales and rad."""

MAX_SINGULAR_VALUE_RATIO = 0.02
"""Largest ratio of singular values at which branches cross nearby: a run that goes through between two branches comes closer."""

SADDLE_TOLERANCE = 1e-7
"""Last Newton step, in length scales and rad: the defect, stationary there, is then exact to rounding."""

SAME_CONFIGURATION = 0.2
"""Largest difference of poses, in length scales and rad, of passes through one configuration: samples of fast motions are as far apart."""


def may_branch(mechanism: Mechanism) -> bool:
    """Return whether the passes of a mechanism can be examined: a closed chain of links with one degree of freedom, without drives."""
    position_solver = PositionSolver(mechanism)
    n_rows = len(position_solver.equations.joint_indices)
    n_coordinates = int(position_solver.free_mask.sum())
    is_driven = bool(position_solver.equations.is_driven.any())
    return not is_driven and n_rows + 1 == n_coordinates and len(mechanism.joints) > len(mechanism.bodies)


def find_unresolved_branch(
    mechanism: Mechanism,  # the mechanism, with one degree of freedom and no redundant joints
    motion: SampledMotion,
) -> tuple[float, float] | None:
    """Return when a motion first goes straight through where branches avoid each other, and the last clear time before (s), or None."""
    position_solver, exact_poses = PositionSolver(mechanism), list[FloatArray]()
    for k in find_nearly_singular_samples(motion).tolist():
        before, after = (_orientation(position_solver, motion.poses[i], motion.velocities[i]) for i in (k - 1, k + 1))
        goes_on = np.sum(motion.velocities[k - 1] * motion.velocities[k + 1]) > 0
        if before * after >= 0 or not goes_on or any(_are_close(position_solver, motion.poses[k], poses) for poses in exact_poses):
            continue
        (time,), (poses,), (singular_value,) = locate_nearly_singular_poses(mechanism, motion, np.array([k]))
        if singular_value < MAX_SINGULAR_VALUE_RATIO and abs(_defect_at_saddle(position_solver, poses, time)) > EXACT_DEFECT:
            return float(time), float(motion.times[k - 1])
        exact_poses.append(poses)
    return None


def _are_close(position_solver: PositionSolver, poses: FloatArray, others: FloatArray) -> bool:
    """Return whether two poses (bodies, 3) are nearly the same, whole turns aside."""
    differences = (poses - others) / position_solver.pose_scales
    differences[:, 2] = np.remainder(differences[:, 2] + np.pi, 2 * np.pi) - np.pi
    return bool(np.max(np.abs(differences)) < SAME_CONFIGURATION)


def _orientation(position_solver: PositionSolver, poses: FloatArray, velocities: FloatArray) -> float:
    """Return the sign of the determinant of constraint Jacobian and velocity, which changes only where branches cross."""
    velocity = velocities.ravel()[position_solver.free_mask] / position_solver.free_coordinate_scales
    return float(np.linalg.slogdet(np.vstack([position_solver.scaled_joint_jacobian(poses), velocity]))[0])


def _defect_at_saddle(position_solver: PositionSolver, poses: FloatArray, time: float) -> float:
    """Return the defect, in length scales, at the singular configuration next to given poses."""
    # It is what the constraints leave open in the direction in which they depend on each other, while
    # all others are closed.
    for _ in range(MAX_ITERATIONS):
        defect, step_length, poses = _step_to_saddle(position_solver, poses, time)
        if step_length < SADDLE_TOLERANCE:
            return defect
    return 0.0  # no singular configuration is near


def _step_to_saddle(position_solver: PositionSolver, poses: FloatArray, time: float) -> tuple[float, float, FloatArray]:
    """Return the defect at the saddle of its quadratic model, the length of the step to it, and the poses after the step."""
    left, _, right = np.linalg.svd(position_solver.scaled_joint_jacobian(poses))
    weak_row = left[:, -1]
    plane = right[-2:]
    h = STENCIL_STEP

    def defect_at(first: float, second: float) -> float:
        moved = _moved(position_solver, poses, first * plane[0] + second * plane[1])
        closed = _closed(position_solver, moved, time, weak_row)
        return float(weak_row @ position_solver.equations.residuals(closed, time)) / position_solver.mechanism.length_scale

    middle = defect_at(0, 0)
    right_value = defect_at(h, 0)
    left_value = defect_at(-h, 0)
    up = defect_at(0, h)
    down = defect_at(0, -h)
    mixed = (defect_at(h, h) - defect_at(h, -h) - defect_at(-h, h) + defect_at(-h, -h)) / (4 * h**2)
    gradient = np.array([right_value - left_value, up - down]) / (2 * h)
    hessian = np.array([[(right_value - 2 * middle + left_value) / h**2, mixed], [mixed, (up - 2 * middle + down) / h**2]])
    step = -np.linalg.lstsq(hessian, gradient, rcond=1e-3)[0]
    length = float(np.max(np.abs(step)))
    shortened = step * min(1.0, MAX_STEP / length) if length else step
    stepped = _closed(position_solver, _moved(position_solver, poses, shortened @ plane), time, weak_row)
    return middle + 0.5 * float(gradient @ step), length, stepped


def _moved(position_solver: PositionSolver, poses: FloatArray, displacement: FloatArray) -> FloatArray:
    """Return poses displaced by free coordinates, in length scales and rad."""
    moved = poses.ravel().copy()
    moved[position_solver.free_mask] += displacement * position_solver.free_coordinate_scales
    return moved.reshape(poses.shape)


def _closed(position_solver: PositionSolver, poses: FloatArray, time: float, weak_row: FloatArray) -> FloatArray:
    """Return poses at which all constraints except the weak combination are closed."""
    for _ in range(N_CLOSING_STEPS):
        residuals = position_solver.equations.residuals(poses, time) / position_solver.mechanism.length_scale
        residuals -= weak_row * (weak_row @ residuals)
        jacobian = position_solver.scaled_joint_jacobian(poses)
        jacobian -= np.outer(weak_row, weak_row @ jacobian)
        poses = _moved(position_solver, poses, -np.linalg.pinv(jacobian, rcond=1e-8) @ residuals)
    return poses
