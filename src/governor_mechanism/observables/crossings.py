"""Named crossings of readings through values, located on a finished motion by root finding."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, unwrap_output, wrap_difference
from governor_mechanism.model.events import Event, EventKind, NamedCrossing
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.observables.singular_configurations import BodyState, SampledMotion
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

ROUNDING_TOLERANCE = 1e-12
"""Deviation of a reading from a value that is rounding, in units of its scale."""

EVENT_TIME_MARGIN = 1e-6
"""A contact event closer to a sample than this fraction of the interval is at the sample."""


def find_crossings(
    mechanism: Mechanism,
    motion: SampledMotion,
    crossings: Sequence[NamedCrossing],
    errors: Mapping[str, float],
    start: tuple[float, Mapping[str, float]],
) -> list[Event]:
    """Return the events of named crossings, crossing by crossing.

    Parameters
    ----------
    mechanism
        Mechanism with the readings.
    motion
        Sampled motion.
    crossings
        Crossings to find.
    errors
        Errors of the readings, SI: smaller deviations from a value are none.
    start
        A time, s, and the readings that the run reports there, SI: they fix the full turns of angles.

    Returns
    -------
    list[Event]
        Events of kind CROSSING.
    """
    if len(motion.times) < 2:
        return []
    readings = {name: SampledReading(mechanism, motion, name, start) for name in dict.fromkeys(item.reading for item in crossings)}
    events = []
    for crossing in crossings:
        tolerance = max(errors[crossing.reading], ROUNDING_TOLERANCE * mechanism.output_scale(crossing.reading))
        times = readings[crossing.reading].find_times(crossing.value, crossing.direction, tolerance)
        events += [Event(time=time, kind=EventKind.CROSSING, subject=crossing.name) for time in times]
    return events


class SampledReading:
    """A reading along a sampled motion, with its first two derivatives at the samples."""

    def __init__(self, mechanism: Mechanism, motion: SampledMotion, name: str, start: tuple[float, Mapping[str, float]]) -> None:
        self._mechanism, self._motion, self._name = mechanism, motion, name
        start_time, start_values = start
        output = evaluate_output(mechanism, name, motion.poses, motion.velocities)
        values = unwrap_output(mechanism.reading(name), output.value)
        shift = start_values.get(name, 0.0) - float(np.interp(start_time, motion.times, values))
        self._values = values + (math.tau * round(shift / math.tau) if isinstance(mechanism.reading(name), LineAngle) else 0.0)
        self._rates, self._accelerations = output.rate(motion.velocities), output.acceleration(motion.accelerations)

    def find_times(self, value: float, direction: str, tolerance: float) -> list[float]:
        """Return the times, s, at which the reading passes a value (SI) in a direction, from beyond the tolerance to beyond it."""
        times, values = self._insert_extremes(value)
        deviations = values - value
        signs = {"up": (1.0,), "down": (-1.0,), "both": (1.0, -1.0)}[direction]
        crossing_times = []
        for before, after in pairwise(np.flatnonzero(np.abs(deviations) > tolerance).tolist()):
            sign = math.copysign(1.0, deviations[after])
            if sign in signs and deviations[before] * sign < 0:
                # Between two neighbouring points the reading is monotonic. After a rest at the value the last pair counts.
                low = before + int(np.flatnonzero(deviations[before:after] * sign <= 0)[-1])
                crossing_times.append(self._locate(value, times[low : low + 2].tolist()))
        return crossing_times

    def _insert_extremes(self, value: float) -> tuple[FloatArray, FloatArray]:
        """Return times and values of the samples, and of the extremes between them in all intervals that may contain the value."""
        sample_times, rates = self._motion.times, np.abs(self._rates)
        intervals, distances = np.diff(sample_times), np.abs(self._values - value)
        reach = intervals * (np.maximum(rates[:-1], rates[1:]) + intervals * np.max(np.abs(self._accelerations)))
        may_contain = np.minimum(distances[:-1], distances[1:]) <= reach
        times, values = [sample_times], [self._values]
        for k in np.flatnonzero(may_contain).tolist():
            path = self._interpolant(k)
            extremes = path.derivative().roots(extrapolate=False)
            times.append(extremes[np.isfinite(extremes)])
            values.append(path(times[-1]))
        all_times, all_values = np.concatenate(times), np.concatenate(values)
        order = np.argsort(all_times, kind="stable")
        return all_times[order], all_values[order]

    def _interpolant(self, k: int) -> PPoly:
        """Return the Hermite interpolant between samples k and k + 1, with a kink at each contact event between them."""
        from scipy.interpolate import BPoly, PPoly  # slow to import

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
        values = [self._values[k] + self._deviation(self._values[k], state)[0] for state in states if state is not None]
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

    def _deviation(self, value: float, state: BodyState) -> tuple[float, float]:
        """Return the deviation of the reading from a value, SI, and its rate; of an angle that wraps, the deviation within half a turn."""
        output = evaluate_output(self._mechanism, self._name, state[0])
        deviation = float(output.value) - value
        return wrap_difference(self._mechanism.reading(self._name), deviation), float(output.rate(state[1]))

    def _locate(self, value: float, bracket: list[float]) -> float:
        """Return the time, s, between two points at which the reading passes a value."""
        k = min(int(np.searchsorted(self._motion.times, bracket[0], side="right")), len(self._motion.times) - 1) - 1
        path = self._interpolant(k)
        time = find_root(lambda time: float(path(time)) - value, *bracket)
        return self._motion.polish_root(k, time, partial(self._deviation, value), bracket)
