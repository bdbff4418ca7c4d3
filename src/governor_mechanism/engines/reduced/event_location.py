"""Location of the first event in a step: bracket it on four sub-intervals, then refine by regula falsi; compiled.

The quintic Hermite interpolant brackets a zero crossing of the event functions. Steps that are integrated again up to the trial
time locate it with the accuracy of the integrator.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.reduced.event_functions import evaluate_reduced_event_functions
from governor_mechanism.integrators.event_location import locate_parabola_maximum
from governor_mechanism.integrators.reduced_dop853 import Stages, StepCounter, take_step
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_SAMPLE_FRACTIONS
from governor_mechanism.mechanics.reduction.equation_of_motion import N_STATES, ReducedModel, StateIndex
from governor_mechanism.numerics.hermite import quintic_hermite_jit
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import BoolArray, FloatArray, IntArray

MAX_ARMING_BISECTIONS = 40
"""Number of bisections that look for a negative value of an event function that is zero at the start of the step."""

MIN_POSITIVE_EVENT_VALUE = 1e-300
"""Smallest value of an event function that counts as positive."""

BRACKET_INSET = 1e-3
"""Distance of a regula-falsi point from the ends of its bracket, relative to the bracket; it moves the nearer end as well."""

MAX_ROOT_ITERATIONS = 100
"""Largest number of regula-falsi iterations; far fewer locate a zero to rounding."""


class EventStep(NamedTuple):
    """A step in which events are located: its start, its stages, and buffers for steps integrated again from the same start."""

    model: ReducedModel
    local_time: float
    h: float
    state: FloatArray
    piece_index: int
    stages: Stages
    trial_stages: Stages
    event_tolerances: FloatArray
    counts: IntArray


@jit_internal
def locate_first_event(step: EventStep, event_values: FloatArray) -> tuple[bool, float]:
    """Return whether an event function becomes positive in a step, and the fraction of the step after which it does.

    event_values (sample fractions, n) holds the values at the start in its first row, and the values at the event in its last one on
    return. A function that starts at zero, as at a body that just left a stop, must be negative first, unless it rises at once.
    """
    last, tolerances, sample = EVENT_SAMPLE_FRACTIONS.size - 1, step.event_tolerances, np.empty(N_STATES)
    for j in range(1, last + 1):
        fraction = EVENT_SAMPLE_FRACTIONS[j]
        _interpolate_motion(step, 0, step.stages.accelerations, fraction, sample)
        _interpolate_motion(step, StateIndex.SHAFT_ANGLE, step.stages.further_rates[3], fraction, sample)
        evaluate_reduced_event_functions(step.model, sample, step.local_time + fraction * step.h, step.piece_index, event_values[j])
    low, high, trial_values = 0.0, 2.0, np.empty(tolerances.size)
    for i in range(tolerances.size):
        is_armed = event_values[0, i] < -tolerances[i]
        for j in range(1, last + 1):
            if event_values[j, i] > (0.0 if is_armed else tolerances[i]):
                if EVENT_SAMPLE_FRACTIONS[j] < high:
                    low, high = EVENT_SAMPLE_FRACTIONS[j - 1], EVENT_SAMPLE_FRACTIONS[j]
                break
            is_armed = is_armed or event_values[j, i] < -tolerances[i]
            if j == last or not is_armed:
                continue
            fraction, peak_value = locate_parabola_maximum(
                EVENT_SAMPLE_FRACTIONS[j], EVENT_SAMPLE_FRACTIONS[1], event_values[j - 1, i], event_values[j, i], event_values[j + 1, i]
            )
            below_first = fraction > EVENT_SAMPLE_FRACTIONS[j] or event_values[j - 1, i] < -tolerances[i]
            if peak_value > 0.0 and fraction < high and below_first:
                _evaluate_after_fraction(step, fraction, trial_values)
                if trial_values[i] > 0.0:
                    low, high = EVENT_SAMPLE_FRACTIONS[j - 1 if fraction <= EVENT_SAMPLE_FRACTIONS[j] else j], fraction
                    break
    if high > 1.0:
        return False, 1.0
    _evaluate_after_fraction(step, high, trial_values)
    if not np.any(trial_values > 0.0):
        if not np.any(event_values[last] > tolerances):
            return False, 1.0
        low, high, trial_values[:] = high, 1.0, event_values[last]
    return True, _locate_in_bracket(step, event_values, low, high, trial_values)


@jit_internal
def _interpolate_motion(step: EventStep, k: int, accelerations: FloatArray, fraction: float, sample: FloatArray) -> None:
    """Fill component k of a state, a coordinate or the angle of the shaft, and its rate after it, at a fraction of the step."""
    start, end = step.state, step.stages.states[1]
    sample[k], sample[k + 1] = quintic_hermite_jit(
        start[k], start[k + 1], accelerations[0], end[k], end[k + 1], accelerations[12], step.h, fraction
    )
    if fraction == 1.0:
        sample[k], sample[k + 1] = end[k], end[k + 1]


@jit_internal
def _locate_in_bracket(step: EventStep, event_values: FloatArray, low: float, high: float, trial_values: FloatArray) -> float:
    """Return the fraction of the step at which the first of the functions positive at `high` becomes positive.

    trial_values are the values at `high`; the last row of event_values becomes the values just after the event.
    """
    last = EVENT_SAMPLE_FRACTIONS.size - 1
    event_values[last], rising = trial_values, trial_values > 0.0
    if low > 0.0:
        _evaluate_after_fraction(step, low, trial_values)
    else:
        trial_values[:] = event_values[0]
    fraction = high
    max_value = _max_rising_value(trial_values, rising)
    for halving in range(MAX_ARMING_BISECTIONS):
        if max_value < 0.0 and not _is_not_armed(trial_values, rising, event_values[0], step.event_tolerances, halving > 0 or low > 0.0):
            break
        fraction *= 0.5  # it starts at zero, or above by rounding: it must be negative in between
        _evaluate_after_fraction(step, fraction, trial_values)
        max_value, low = _max_rising_value(trial_values, rising), fraction
        if max_value > 0.0:
            high, event_values[last] = fraction, trial_values
    else:
        for i in range(trial_values.size):  # it rises at once
            event_values[last, i] = max(trial_values[i], MIN_POSITIVE_EVENT_VALUE) if rising[i] else trial_values[i]
        return fraction
    for i in range(trial_values.size):
        if rising[i] and event_values[last, i] > 0.0:  # else its zero is after the one found before
            high = _regula_falsi(step, event_values[last], i, low, high, trial_values)
    return high


@jit_internal
def _regula_falsi(step: EventStep, values_high: FloatArray, event_index: int, low: float, high: float, trial_values: FloatArray) -> float:
    """Return the fraction just after the zero of one event function, which is negative at `low`.

    values_high are the values at `high`, and become those at the returned fraction.
    """
    _evaluate_after_fraction(step, low, trial_values)
    at_low, at_high, bisect = min(trial_values[event_index], -MIN_POSITIVE_EVENT_VALUE), values_high[event_index], False
    for _ in range(MAX_ROOT_ITERATIONS):
        width = high - low
        middle = 0.5 * (low + high) if bisect else (low * at_high - high * at_low) / (at_high - at_low)
        middle = min(max(middle, low + BRACKET_INSET * width), high - BRACKET_INSET * width)
        if not low < middle < high or width <= 4e-16 * (high + abs(step.local_time / step.h)):
            break
        _evaluate_after_fraction(step, middle, trial_values)
        if trial_values[event_index] > 0.0:
            high, at_high, values_high[:] = middle, trial_values[event_index], trial_values
        else:
            low, at_low = middle, min(trial_values[event_index], -MIN_POSITIVE_EVENT_VALUE)
        bisect = high - low > 0.5 * width  # bisect after a secant step that kept most of the bracket
    return high


@jit_internal
def _max_rising_value(trial_values: FloatArray, rising: BoolArray) -> float:
    value = -np.inf
    for i in range(trial_values.size):
        if rising[i]:
            value = max(value, trial_values[i])
    return value


@jit_internal
def _is_not_armed(
    trial_values: FloatArray, rising: BoolArray, start_values: FloatArray, event_tolerances: FloatArray, is_past_start: bool
) -> bool:
    """Return whether an event function that starts at zero within rounding has not been negative yet."""
    not_armed = False
    for i in range(trial_values.size):
        if rising[i] and start_values[i] >= -event_tolerances[i]:
            not_armed = not_armed or not is_past_start or trial_values[i] >= min(start_values[i], 0.0)
    return not_armed


@jit_internal
def _evaluate_after_fraction(step: EventStep, fraction: float, trial_values: FloatArray) -> None:
    """Fill trial_values with the event functions after a fraction of the step, integrated again; inactive outside the table."""
    stages, trial_stages, h = step.stages, step.trial_stages, fraction * step.h
    trial_stages.rates[0], trial_stages.accelerations[0] = stages.rates[0], stages.accelerations[0]
    trial_stages.further_rates[:, 0] = stages.further_rates[:, 0]
    piece, side = take_step(step.model, step.local_time, h, step.state, step.piece_index, trial_stages)
    step.counts[StepCounter.EVALUATIONS] += 12
    trial_values[:] = -1.0
    if side < 0:
        evaluate_reduced_event_functions(step.model, trial_stages.states[1], step.local_time + h, piece, trial_values)
