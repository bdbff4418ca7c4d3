"""Turning points of a reading, located between reported times, and the mean, the amplitude and the frequency that follow from them."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from governor_mechanism.types import BoolArray, FloatArray, IntArray

NODES_AROUND = 4
"""Reported times whose values and rates locate a turning point: a polynomial of degree 7, so that the error falls with the eighth power
of their distance."""

NEWTON_STEPS = 2
"""Newton steps from the turning point of the cubic between two times: the cubic is right to about the third power of their distance."""


class ReadingSamples(NamedTuple):
    """A reading at the reported times of a run.

    Attributes
    ----------
    times
        Times, s; shape (n,).
    values
        Values, SI; shape (n,).
    rates
        Rates, SI per second; shape (n,), or empty for a reading that is no position.
    min_swing
        Change between two turning points below which they count as noise, SI.
    is_smooth
        Whether nothing sticks or strikes, so that a polynomial through several times holds.
    """

    times: FloatArray
    values: FloatArray
    rates: FloatArray
    min_swing: float
    is_smooth: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class TurningPoints:
    """Turning points of a reading in order of time, upper and lower ones by turns.

    Attributes
    ----------
    times
        Times, s; shape (n,).
    values
        Values, SI; shape (n,).
    is_upper
        Whether each is a maximum; shape (n,).
    """

    times: FloatArray
    values: FloatArray
    is_upper: BoolArray

    def whole_oscillations(self) -> tuple[float, float, int] | None:
        """Return the times (s) of the first and the last maximum, or minimum if there is only one maximum, and the periods between them."""
        for is_chosen in (self.is_upper, ~self.is_upper):
            times = self.times[is_chosen]
            if len(times) > 1:
                return float(times[0]), float(times[-1]), len(times) - 1
        return None

    def amplitude(self, start: float) -> float | None:
        """Return half the difference of the highest and the lowest turning point from a time (s) on, SI; None if one is missing."""
        is_late = self.times >= start
        upper, lower = self.values[is_late & self.is_upper], self.values[is_late & ~self.is_upper]
        return float(upper.max() - lower.min()) / 2 if upper.size and lower.size else None


def find_turning_points(samples: ReadingSamples) -> TurningPoints:
    """Return the turning points of a position.

    Result: none for a reading that is no position; of a position those between which it moves by more than
    `min_swing`. Where it comes to rest before it turns back, the turning point is where it comes to rest.
    """
    times, values, rates = samples.times, samples.values, samples.rates
    moving = np.flatnonzero(rates)
    before, after = moving[:-1], moving[1:]
    turns = np.signbit(rates[before]) != np.signbit(rates[after])
    before, after = before[turns], after[turns]
    turning_times, turning_values = times[np.minimum(before + 1, after)].copy(), values[np.minimum(before + 1, after)].copy()
    is_between = after == before + 1
    located = _locate_between(samples, before[is_between])
    turning_times[is_between], turning_values[is_between] = located
    kept = _without_small_swings(turning_values, rates[before] > 0.0, samples.min_swing)
    return TurningPoints(times=turning_times[kept], values=turning_values[kept], is_upper=(rates[before] > 0.0)[kept])


def _without_small_swings(values: FloatArray, is_upper: BoolArray, min_swing: float) -> IntArray:
    """Return the indices of turning points that remain when swings below a size are left out; upper and lower ones still alternate."""
    kept: list[int] = []
    for k, value in enumerate(values.tolist()):
        if kept and is_upper[kept[-1]] == is_upper[k]:
            if (value > values[kept[-1]]) == bool(is_upper[k]):
                kept[-1] = k
        elif not kept or abs(value - values[kept[-1]]) > min_swing:
            kept.append(k)
    # A single turning point is no swing; two that are further apart than the smallest one are.
    return np.array(kept if len(kept) > 1 else [], dtype=np.int64)


def _locate_between(samples: ReadingSamples, first: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and values of the turning points between samples `first` and the ones after them; shape (n,) each."""
    times, values, rates = samples.times, samples.values, samples.rates
    n_nodes = NODES_AROUND if samples.is_smooth and len(times) >= NODES_AROUND else 2
    window = np.clip(first - (n_nodes // 2 - 1), 0, len(times) - n_nodes)[:, None] + np.arange(n_nodes)
    low, high = times[first], times[first + 1]
    guesses = low + (high - low) * _cubic_turning_fraction(values[first], values[first + 1], rates[first], rates[first + 1], high - low)
    nodes, coefficients = _newton_form(times[window] - low[:, None], values[window], rates[window])
    arguments = guesses - low
    for _ in range(NEWTON_STEPS if n_nodes > 2 else 0):
        _, slopes, curvatures = _evaluate(nodes, coefficients, arguments)
        steps = np.divide(-slopes, curvatures, out=np.zeros_like(slopes), where=curvatures != 0.0)
        arguments = np.clip(arguments + steps, 0.0, high - low)
    return low + arguments, _evaluate(nodes, coefficients, arguments)[0]


def _cubic_turning_fraction(
    first: FloatArray, last: FloatArray, first_rate: FloatArray, last_rate: FloatArray, step: FloatArray
) -> FloatArray:
    """Return where, as a fraction of the step, the cubics with values and rates at both ends turn back; the rates have opposite signs."""
    # The rate at a fraction s is first_rate + linear * s + square * s^2; of its two zeros this form gives the one within the step, without
    # cancellation. Its denominator does not vanish: the discriminant exceeds linear^2 where square and first_rate differ in sign, and
    # otherwise linear has the sign of -first_rate, as the rate changes its sign.
    secant = (last - first) / step
    square = 3.0 * (first_rate + last_rate) - 6.0 * secant
    linear = last_rate - first_rate - square
    root = np.sqrt(np.maximum(linear * linear - 4.0 * square * first_rate, 0.0))
    fraction: FloatArray = 2.0 * first_rate / (-linear + np.copysign(root, first_rate))
    return np.clip(fraction, 0.0, 1.0)


def _newton_form(nodes: FloatArray, values: FloatArray, rates: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """Return nodes, each twice, and Newton coefficients of the polynomials with values and rates at nodes; shape (functions, nodes)."""
    doubled = np.repeat(nodes, 2, axis=1)
    differences = np.repeat(values, 2, axis=1)
    coefficients = [differences[:, 0]]
    for order in range(1, doubled.shape[1]):
        intervals = doubled[:, order:] - doubled[:, :-order]
        if order == 1:
            intervals[:, ::2] = 1.0
        differences = np.diff(differences, axis=1) / intervals
        if order == 1:
            differences[:, ::2] = rates  # the difference over one node alone is the derivative there
        coefficients.append(differences[:, 0])
    return doubled, coefficients


def _evaluate(nodes: FloatArray, coefficients: list[FloatArray], arguments: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value and first two derivatives of each polynomial at an argument of its own; shape (functions,) each."""
    value, rate, acceleration = coefficients[-1], np.zeros_like(arguments), np.zeros_like(arguments)
    for order in range(len(coefficients) - 2, -1, -1):
        distance = arguments - nodes[:, order]
        acceleration = acceleration * distance + 2.0 * rate
        rate = rate * distance + value
        value = value * distance + coefficients[order]
    return value, rate, acceleration


def mean_value(samples: ReadingSamples, turning_points: TurningPoints) -> float:
    """Return the mean of a reading over time: over its whole oscillations if it oscillates, and over the run otherwise.

    Result: the mean, SI; exact for cubics between the times of a position.
    """
    times, values, rates = samples.times, samples.values, samples.rates
    span = turning_points.whole_oscillations()
    if span is not None:
        # The turning points at both ends join the samples between them.
        start, end, _ = span
        at_ends = turning_points.values[np.searchsorted(turning_points.times, (start, end))]
        inside = (times > start) & (times < end)
        times = np.concatenate([[start], times[inside], [end]])
        values = np.concatenate([at_ends[:1], values[inside], at_ends[1:]])
        rates = np.concatenate([[0.0], rates[inside], [0.0]])
    steps = np.diff(times)
    if not steps.size:
        return float(values[-1])
    integral = np.sum(steps * (values[1:] + values[:-1])) / 2
    if rates.size:
        integral -= np.sum(steps * steps * np.diff(rates)) / 12
    return float(integral / (times[-1] - times[0]))
