"""Named crossings of readings and speeds through values, located on a finished motion by root finding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, wrap_difference
from governor_mechanism.model.coupling.coupled_system import CoupledSystem
from governor_mechanism.model.events import Event, EventKind, NamedCrossing
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.speeds import find_speeds
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.observables.crossing_intervals import find_crossing_intervals
from governor_mechanism.observables.sampled_motion import EVENT_TIME_MARGIN, BodyState, SampledMotion, SampledReading
from governor_mechanism.observables.speed_crossings import CrossedSpeed
from governor_mechanism.types import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

ROUNDING_TOLERANCE = 1e-12
"""Deviation of a reading from a value that is rounding, in units of its scale."""

N_SUBDIVISIONS = 8
"""Parts of an interval of which each has at most one extreme: an interval is a quarter of the time in which the motion changes."""


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
        self._mechanism, self._motion, self._name = mechanism, motion, name
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
        starts, lengths = self._motion.times[intervals], np.diff(self._motion.times)[intervals]
        parts = np.repeat(intervals, N_SUBDIVISIONS)
        edges = starts[:, np.newaxis] + lengths[:, np.newaxis] * np.linspace(0.0, 1.0, N_SUBDIVISIONS + 1)
        low, high = edges[:, :-1].ravel(), edges[:, 1:].ravel()
        interpolants = self._sampled.interpolant(parts, 2)
        turns = np.flatnonzero(interpolants.evaluate(low)[1] * interpolants.evaluate(high)[1] < 0)
        times, _ = self._sampled.find_extremes(parts[turns], low[turns], high[turns])
        return times, self._sampled.interpolant(parts[turns], 2).evaluate(times)[0]

    def _interpolant(self, k: int) -> PPoly:
        """Return the Hermite interpolant between samples k and k + 1, with a kink at each contact event between them."""
        from scipy.interpolate import BPoly, PPoly

        start, end = self._motion.times[k : k + 2].tolist()
        margin, contact_times = EVENT_TIME_MARGIN * (end - start), self._motion.contact_times
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
        """Return the values at contact events between samples k and k + 1.

        Without a dense output, the motion before the first and after the last event is continued from the samples with constant
        acceleration, and changes linearly between these events.
        """
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
