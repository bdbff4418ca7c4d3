"""Excursions beyond the limits of a mechanism between two monitor times: a motion that passes a limit and comes back has ended there."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import evaluate_limited_readings
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

CUBIC_ERROR_FACTOR = 1 / 384
"""Largest error of a cubic Hermite interpolant, relative to the fourth derivative times the fourth power of the interval."""


@dataclass(frozen=True)
class Excursion:
    """Excursion beyond a limit: index of the sample after it, the time (s) at which it is farthest, and the sentence that describes it."""

    index: int
    time: float
    sentence: str


def find_first_excursion(
    mechanism: Mechanism,
    states: StateHistory,
    # times of contact events, s; shape (events,). An interval with an event is not smooth and is left out.
    # The motion begins after the events of its start
    event_times: FloatArray,
    # accuracy of the states relative to the scales: a motion within it of a limit has not passed it
    accuracy: float,
) -> Excursion | None:
    """Return the first excursion beyond a limit between two monitor times, or None."""
    times, excursions = states.times, list[Excursion]()
    if len(times) < 2 or not mechanism.limits:
        return None
    is_smooth = np.ones(len(times) - 1, dtype=np.bool_)
    for side in ("left", "right"):  # an event at a monitor time may belong to either interval
        is_smooth[np.clip(np.searchsorted(times, event_times[event_times > times[0]], side) - 1, 0, len(times) - 2)] = False
    longest = np.max(np.diff(times))
    for limit, value, rate in zip(mechanism.limits, *evaluate_limited_readings(mechanism, states.poses, states.velocities), strict=True):
        tolerance = accuracy * mechanism.output_scale(limit.reading)
        reach = float(np.max(np.abs(rate)) * longest)
        for excess, rise, message in ((limit.low - value, -rate, limit.low_message), (value - limit.high, rate, limit.high_message)):
            if np.max(excess) + reach <= tolerance:
                continue
            largest, largest_times = _largest_within(times, excess, rise)
            is_outside = is_smooth & (largest > tolerance)
            if is_outside.any():
                k = int(np.argmax(is_outside))
                excursions.append(Excursion(k + 1, float(largest_times[k]), f"{limit.reading}: {message}"))
    return min(excursions, key=lambda one: one.time, default=None)


def _largest_within(times: FloatArray, values: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least certain value (n - 1,) of a maximum within each interval, and its time (n - 1,) s, by cubic interpolation.

    The value is minus infinity without a maximum.
    """
    lengths, change = np.diff(times), np.diff(values)
    start, end = lengths * rates[:-1], lengths * rates[1:]
    cubic, quadratic = start + end - 2 * change, 3 * change - 2 * start - end
    has_maximum = (start > 0.0) & (end < 0.0)
    with np.errstate(all="ignore"):  # where there is no maximum
        fraction = start / (np.sqrt(quadratic**2 - 3 * cubic * start) - quadratic)
        maximum = values[:-1] + fraction * (start + fraction * (quadratic + fraction * cubic))
    # The third derivative differs from one interval to the next by the fourth times their distance.
    third = np.pad(6 * cubic / lengths**3, 1, mode="edge")
    jump = np.maximum(np.abs(third[1:-1] - third[:-2]), np.abs(third[2:] - third[1:-1]))
    error = CUBIC_ERROR_FACTOR * jump * lengths**3
    result: FloatArray = np.where(has_maximum, maximum - error, -np.inf)
    return result, times[:-1] + np.where(has_maximum, fraction, 0.0) * lengths
