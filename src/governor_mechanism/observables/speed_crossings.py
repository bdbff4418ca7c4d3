"""Crossings of speeds through values, located on a finished motion by root finding."""

from collections.abc import Mapping

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.speeds import AngleRate
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.observables.crossing_intervals import find_crossing_intervals
from governor_mechanism.observables.sampled_motion import EVENT_TIME_MARGIN, BodyState, SampledMotion, SampledReading
from governor_mechanism.types import BoolArray, FloatArray

N_SUBDIVISIONS = 8
"""Parts of an interval of which each has at most one extreme: an interval is a quarter of the time in which the motion changes."""

JERK_MARGIN = 2.0
"""Factor on the change of the acceleration over an interval and its neighbours, which bounds the change inside the interval.

A kink, as of the torque of an engine at a dead centre, may lie inside: then the change between the ends is smaller than that inside.
"""

EXTREME_TIME_TOLERANCE = 1e-4
"""Error of the time of an extreme, relative to the distance of the points around it: that of its speed is of the order of the square."""


class CrossedSpeed:
    """A speed along a sampled motion, whose crossings of values are found.

    Unlike a position, a speed may have a kink in its slope inside an interval without a known event: at each change of the gas in a
    cylinder the slope of the acceleration jumps. So what lies between the samples is taken from the engine's own dense output where
    there is one, and from the samples only where there is none.

    Parameters
    ----------
    mechanism
        Mechanism with the angle.
    motion
        Sampled motion.
    speed
        The angle whose rate is the speed, and the ratio of both.
    """

    def __init__(self, mechanism: Mechanism, motion: SampledMotion, speed: AngleRate) -> None:
        self._mechanism, self._motion, self._speed = mechanism, motion, speed
        self._angle = SampledReading(mechanism, motion, speed.angle)
        self._speeds, self._accelerations = speed.ratio * self._angle.rates, speed.ratio * self._angle.accelerations
        self._is_smooth = motion.is_smooth(np.arange(len(motion.times) - 1), np.arange(1, len(motion.times)))

    @property
    def scale(self) -> float:
        """Largest speed, rad/s."""
        return float(np.max(np.abs(self._speeds), initial=0.0))

    def find_times(self, value: float, direction: str, tolerance: float) -> list[float]:
        """Return the times, s, at which the speed passes a value (rad/s) in a direction, from beyond the tolerance to beyond it."""
        times, speeds = self._insert_points(value, tolerance)
        indices = find_crossing_intervals(speeds - value, direction, tolerance)
        return [self._locate(value, (float(times[i]), float(times[i + 1]))) for i in indices.tolist()]

    def _insert_points(self, value: float, tolerance: float) -> tuple[FloatArray, FloatArray]:
        """Return times and speeds of the samples, of points between them where the speed may turn near a value, and of its extremes."""
        points = dict(zip(self._motion.times.tolist(), self._speeds.tolist(), strict=True))
        fractions = np.linspace(0.0, 1.0, N_SUBDIVISIONS + 1)[1:-1]
        for k in np.flatnonzero(self._may_turn_at(value, tolerance)).tolist():
            start, end = self._motion.times[k : k + 2].tolist()
            points |= {time: self._speed_at(k, time) for time in (start + fractions * (end - start)).tolist()}
        times, speeds = _in_order(points)
        differences = np.diff(speeds)
        overshoots = np.maximum(np.abs(differences[:-1]), np.abs(differences[1:]))  # of an extreme over the highest or lowest point
        turns = (differences[:-1] * differences[1:] < 0) & (np.abs(speeds[1:-1] - value) <= overshoots) & (overshoots > tolerance)
        for i in np.flatnonzero(turns).tolist():
            time = self._locate_extreme((float(times[i]), float(times[i + 2])), is_highest=bool(differences[i] > 0))
            points[time] = self._speed_at(self._interval_of(time), time)
        return _in_order(points)

    def _may_turn_at(self, value: float, tolerance: float) -> BoolArray:
        """Return which intervals between samples may contain an extreme and the value, and change by more than the tolerance."""
        slopes, lengths = np.abs(self._accelerations), np.diff(self._motion.times)
        changes = np.pad(np.abs(np.diff(self._accelerations)), 1, mode="edge")
        change = JERK_MARGIN * np.max([changes[:-2], changes[1:-1], changes[2:]], axis=0)
        may_turn = ~self._is_smooth | (np.minimum(slopes[:-1], slopes[1:]) <= change)
        reach = lengths * (np.maximum(slopes[:-1], slopes[1:]) + change) + np.where(self._is_smooth, 0.0, np.abs(np.diff(self._speeds)))
        distances = np.abs(self._speeds - value)
        may_turn_there: BoolArray = may_turn & (np.minimum(distances[:-1], distances[1:]) <= reach) & (reach > tolerance)
        return may_turn_there

    def _interval_of(self, time: float) -> int:
        """Return the index of the interval between samples that a time (s) lies in."""
        return min(int(np.searchsorted(self._motion.times, time, side="right")), len(self._motion.times) - 1) - 1

    def _speed_at(self, k: int, time: float) -> float:
        """Return the speed (rad/s) at a time (s) between samples k and k + 1."""
        state = self._motion.dense_output(k, time)
        return self._interpolate(k, time) if state is None else self._speed_of(state)

    def _interpolate(self, k: int, time: float) -> float:
        """Return the speed (rad/s) at a time (s) between samples k and k + 1, from these samples."""
        if self._is_smooth[k]:
            return self._speed.ratio * float(self._angle.interpolant(np.array([k]), 2).evaluate(np.array([time]))[1][0])
        # A polynomial through the slopes on both sides of a jump has extremes that the motion has not.
        (start, end), (first, last) = self._motion.times[k : k + 2].tolist(), self._speeds[k : k + 2].tolist()
        fraction, linear = (time - start) / (end - start), last - first
        slope = linear if self._jumps_inside(k) else (end - start) * float(self._accelerations[k])  # a jump at the end is one of its slope
        return float(first + fraction * (slope + fraction * (linear - slope)))

    def _jumps_inside(self, k: int) -> bool:
        """Return whether an event or a jump of an input lies between samples k and k + 1, not at one of them."""
        start, end = self._motion.times[k : k + 2].tolist()
        jumps, margin = np.concatenate([self._motion.contact_times, self._motion.breakpoints]), EVENT_TIME_MARGIN * (end - start)
        return bool(np.any((jumps > start + margin) & (jumps < end - margin)))

    def _speed_of(self, state: BodyState) -> float:
        poses, velocities = state
        return self._speed.ratio * float(evaluate_output(self._mechanism, self._speed.angle, poses).rate(velocities))

    def _locate_extreme(self, span: tuple[float, float], *, is_highest: bool) -> float:
        """Return the time, s, of the highest or lowest speed between two times that contain one."""
        from scipy.optimize import minimize_scalar  # slow to import

        sign, tolerance = -1.0 if is_highest else 1.0, EXTREME_TIME_TOLERANCE * (span[1] - span[0])
        found = minimize_scalar(
            lambda time: sign * self._speed_at(self._interval_of(time), time), bounds=span, method="bounded", options={"xatol": tolerance}
        )
        return float(found.x)

    def _locate(self, value: float, bracket: tuple[float, float]) -> float:
        """Return the time, s, between two neighbouring points at which the speed passes a value."""
        k = self._interval_of(bracket[0])
        time = find_root(lambda instant: self._interpolate(k, instant) - value, *bracket)
        return self._motion.refine_root(k, time, lambda state: self._speed_of(state) - value, bracket)


def _in_order(points: Mapping[float, float]) -> tuple[FloatArray, FloatArray]:
    """Return the times and speeds of points in the order of time."""
    times = np.array(sorted(points))
    return times, np.array([points[time] for time in times.tolist()])
