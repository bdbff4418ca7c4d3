"""Named crossings of readings and speeds through values, located on a finished motion by root finding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, wrap_difference
from governor_mechanism.model.coupling.coupled_system import AngleRate, CoupledSystem, find_speeds
from governor_mechanism.model.events import Event, EventKind, NamedCrossing
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.observables.sampled_motion import EVENT_TIME_MARGIN, BodyState, SampledMotion, SampledReading
from governor_mechanism.types import BoolArray, FloatArray, IntArray

_SIGNS = {"up": (1.0,), "down": (-1.0,), "both": (1.0, -1.0)}
"""Signs of the deviation behind a crossing, by direction."""


def find_crossing_intervals(
    # deviations from the value that is passed, at points in the order of time; shape (n,)
    deviations: FloatArray,
    direction: str,
    tolerance: float,
) -> IntArray:
    """Return the last points (crossings,) before a value passes from beyond a tolerance on one side to beyond it on the other."""
    beyond = np.flatnonzero(np.abs(deviations) > tolerance)
    signs = np.sign(deviations[beyond])
    low_indices = list[int]()
    for k in np.flatnonzero((signs[1:] != signs[:-1]) & np.isin(signs[1:], _SIGNS[direction])).tolist():
        before, after = beyond[k : k + 2].tolist()
        # Between two neighbouring points the value is monotonic. After a rest at it the last pair counts.
        low_indices.append(before + int(np.flatnonzero(deviations[before:after] * signs[k + 1] <= 0)[-1]))
    return np.array(low_indices, dtype=np.int64)


N_SUBDIVISIONS = 8
"""Parts of an interval of which each has at most one extreme: an interval is a quarter of the time in which the motion changes."""

# A kink, as of the torque of an engine at a dead centre, may lie inside: then the change between the ends is
# smaller than that inside.
JERK_MARGIN = 2.0
"""Factor on the change of the acceleration over an interval and its neighbours, which bounds the change inside the interval."""

EXTREME_TIME_TOLERANCE = 1e-4
"""Error of the time of an extreme, relative to the distance of the points around it: that of its speed is of the order of the square."""


class CrossedSpeed:
    """A speed along a sampled motion, whose crossings of values are found.

    Unlike a position, a speed may have a kink in its slope inside an interval without a known event: at each change of the gas in a
    cylinder the slope of the acceleration jumps. So what lies between the samples is taken from the engine's own dense output where
    there is one, and from the samples only where there is none.
    """

    def __init__(
        self,
        mechanism: Mechanism,  # mechanism with the angle
        motion: SampledMotion,  # sampled motion
        speed: AngleRate,  # the angle whose rate is the speed, and the ratio of both
    ) -> None:
        self._mechanism = mechanism
        self._motion = motion
        self._speed = speed
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
            return self._speed.ratio * float(self._angle.curve.evaluate(np.array([k]), 2, np.array([time]))[1, 0])
        # A polynomial through the slopes on both sides of a jump has extremes that the motion has not.
        start, end = self._motion.times[k : k + 2].tolist()
        first, last = self._speeds[k : k + 2].tolist()
        fraction, linear = (time - start) / (end - start), last - first
        slope = linear if self._jumps_inside(k) else (end - start) * float(self._accelerations[k])  # a jump at the end is one of its slope
        return float(first + fraction * (slope + fraction * (linear - slope)))

    def _jumps_inside(self, k: int) -> bool:
        """Return whether an event or a jump of an input lies between samples k and k + 1, not at one of them."""
        start, end = self._motion.times[k : k + 2].tolist()
        jumps = np.concatenate([self._motion.contact_times, self._motion.breakpoints])
        margin = EVENT_TIME_MARGIN * (end - start)
        return bool(np.any((jumps > start + margin) & (jumps < end - margin)))

    def _speed_of(self, state: BodyState) -> float:
        poses, velocities = state
        return self._speed.ratio * float(evaluate_output(self._mechanism, self._speed.angle, poses).rate(velocities))

    def _locate_extreme(self, span: tuple[float, float], *, is_highest: bool) -> float:
        """Return the time, s, of the highest or lowest speed between two times that contain one."""
        from scipy.optimize import minimize_scalar  # slow to import

        sign = -1.0 if is_highest else 1.0
        tolerance = EXTREME_TIME_TOLERANCE * (span[1] - span[0])
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


if TYPE_CHECKING:
    from scipy.interpolate import PPoly

ROUNDING_TOLERANCE = 1e-12
"""Deviation of a reading from a value that is rounding, in units of its scale."""


def find_crossings(
    system: CoupledSystem,
    motion: SampledMotion,
    crossings: Sequence[NamedCrossing],
    errors: Mapping[str, float],  # errors of the readings, SI: smaller deviations from a value are none
    # a time, s, and the readings that the run reports there, SI: they fix the full turns of angles
    start: tuple[float, Mapping[str, float]],
) -> list[Event]:
    """Return the events of named crossings, crossing by crossing."""
    if len(motion.times) < 2:
        return []
    mechanism, speeds = system.mechanism, find_speeds(system)
    names = dict.fromkeys(item.reading for item in crossings)
    readings = {
        name: CrossedSpeed(mechanism, motion, speeds[name]) if name in speeds else CrossedReading(mechanism, motion, name, start)
        for name in names
    }
    events = []
    for crossing in crossings:
        reading = readings[crossing.reading]
        tolerance = max(errors[crossing.reading], ROUNDING_TOLERANCE * reading.scale)
        times = reading.find_times(crossing.value, crossing.direction, tolerance)
        events += [Event(time=time, kind=EventKind.CROSSING, subject=crossing.name) for time in times]
    return events


class CrossedReading:
    """A reading along a sampled motion, whose crossings of values are found."""

    def __init__(self, mechanism: Mechanism, motion: SampledMotion, name: str, start: tuple[float, Mapping[str, float]]) -> None:
        self._mechanism = mechanism
        self._motion = motion
        self._name = name
        self._sampled = SampledReading(mechanism, motion, name, start)
        self._values, self._rates, self._accelerations = self._sampled.values, self._sampled.rates, self._sampled.accelerations

    @property
    def scale(self) -> float:
        """Scale of the reading, SI."""
        return self._mechanism.output_scale(self._name)

    def find_times(self, value: float, direction: str, tolerance: float) -> list[float]:
        """Return the times, s, at which the reading passes a value (SI) in a direction, from beyond the tolerance to beyond it."""
        times, values = self._insert_extremes(value)
        lows = find_crossing_intervals(values - value, direction, tolerance)
        return self._locate(value, times[lows], times[lows + 1]).tolist() if len(lows) else []

    def _insert_extremes(self, value: float) -> tuple[FloatArray, FloatArray]:
        """Return times and values of the samples, and of the extremes between them in all intervals that may contain the value."""
        sample_times, rates = self._motion.times, np.abs(self._rates)
        intervals, distances = np.diff(sample_times), np.abs(self._values - value)
        reach = intervals * (np.maximum(rates[:-1], rates[1:]) + intervals * np.max(np.abs(self._accelerations)))
        may_contain = np.minimum(distances[:-1], distances[1:]) <= reach
        intervals_to_search = np.flatnonzero(may_contain)
        is_smooth = self._motion.is_smooth(intervals_to_search, intervals_to_search + 1)
        times, values = self._find_smooth_extremes(intervals_to_search[is_smooth])
        all_times, all_values = [sample_times, times], [self._values, values]
        for k in intervals_to_search[~is_smooth].tolist():
            path = self._interpolant(k)
            extremes = path.derivative().roots(extrapolate=False)
            all_times.append(extremes[np.isfinite(extremes)])
            all_values.append(path(all_times[-1]))
        order = np.argsort(np.concatenate(all_times), kind="stable")
        return np.concatenate(all_times)[order], np.concatenate(all_values)[order]

    def _find_smooth_extremes(self, intervals: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return times and values of the extremes in intervals (m,) without kinks."""
        starts = self._motion.times[intervals]
        lengths = np.diff(self._motion.times)[intervals]
        parts = np.repeat(intervals, N_SUBDIVISIONS)
        edges = starts[:, np.newaxis] + lengths[:, np.newaxis] * np.linspace(0.0, 1.0, N_SUBDIVISIONS + 1)
        low, high = edges[:, :-1].ravel(), edges[:, 1:].ravel()
        curve = self._sampled.curve
        turns = np.flatnonzero(curve.evaluate(parts, 2, low)[1] * curve.evaluate(parts, 2, high)[1] < 0)
        times, _ = self._sampled.find_extremes(parts[turns], low[turns], high[turns])
        return times, curve.evaluate(parts[turns], 2, times)[0]

    def _interpolant(self, k: int) -> PPoly:
        """Return the Hermite interpolant between samples k and k + 1, with a kink at each contact event between them."""
        from scipy.interpolate import BPoly, PPoly  # slow to import

        start, end = self._motion.times[k : k + 2].tolist()
        margin = EVENT_TIME_MARGIN * (end - start)
        contact_times = self._motion.contact_times
        contact_times = contact_times[(contact_times > start + margin) & (contact_times <= end + margin)]
        inner_times = contact_times[contact_times < end - margin]
        # Between two events in one interval the samples show nothing of the motion.
        inner_times = np.sort(np.concatenate([inner_times, 0.5 * (inner_times[:-1] + inner_times[1:])]))
        at_ends = [[values[j] for values in (self._values, self._rates, self._accelerations)] for j in (k, k + 1)]
        if len(contact_times) > len(inner_times):
            at_ends[1] = at_ends[1][:1]  # the derivatives are those after the event
        inner_values = [[value] for value in self._values_at_contact_events(k, inner_times)]
        return PPoly.from_bernstein_basis(BPoly.from_derivatives([start, *inner_times, end], [at_ends[0], *inner_values, at_ends[1]]))

    def _values_at_contact_events(self, k: int, times: FloatArray) -> list[float]:
        """Return the values at contact events between samples k and k + 1."""
        # Without a dense output, the motion before the first and after the last event is continued
        # from the samples with constant acceleration, and changes linearly between these events.
        if not len(times):
            return []
        states = [self._motion.dense_output(k, float(time)) for time in times]
        values = [self._values[k] + self._deviation(self._values[k], state) for state in states if state is not None]
        if len(values) == len(times):
            return values
        first, last = (self._continue_sample(j, float(time)) for j, time in ((k, times[0]), (k + 1, times[-1])))
        if len(times) == 1:
            return [first if times[0] - self._motion.times[k] < self._motion.times[k + 1] - times[0] else last]
        return list(np.interp(times, times[[0, -1]], [first, last]))

    def _continue_sample(self, j: int, time: float) -> float:
        """Return the value at a time (s) near sample j for constant acceleration."""
        interval = time - float(self._motion.times[j])
        return float(self._values[j] + interval * (self._rates[j] + 0.5 * interval * self._accelerations[j]))

    def _deviation(self, value: float, state: BodyState) -> float:
        """Return the deviation of the reading from a value, SI; of an angle that wraps, the deviation within half a turn."""
        deviation = float(evaluate_output(self._mechanism, self._name, state[0]).value) - value
        return wrap_difference(self._mechanism.reading(self._name), deviation)

    def _locate(self, value: float, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the times (m,) s between pairs of neighbouring points at which the reading passes a value."""
        n_samples = len(self._motion.times)
        intervals = np.minimum(np.searchsorted(self._motion.times, low, side="right"), n_samples - 1) - 1
        times, is_certain = self._sampled.find_crossings(value, intervals, low, high)
        for i in np.flatnonzero(~is_certain).tolist():
            k, bracket = int(intervals[i]), (float(low[i]), float(high[i]))
            path = self._interpolant(k)
            time = find_root(partial(_deviation_from, path, value), *bracket)
            times[i] = self._motion.refine_root(k, time, partial(self._deviation, value), bracket)
        return times


def _deviation_from(path: PPoly, value: float, time: float) -> float:
    return float(path(time)) - value
