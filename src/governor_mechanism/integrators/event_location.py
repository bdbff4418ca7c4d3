"""Location of the first event in a step: bracket it on four sub-intervals, then refine by false positions; compiled.

The quintic Hermite interpolant brackets an upward zero crossing of the event functions. Steps that are integrated again up to the
trial time locate it with the accuracy of the integrator.
"""

from collections.abc import Callable

import numpy as np

from governor_mechanism.integrators.equation import (
    ARMING,
    EVENT_SAMPLE_FRACTIONS,
    INACTIVE_EVENT_VALUE,
    LAST_SAMPLE,
    ROUNDING,
    EventStep,
    count_located,
)
from governor_mechanism.integrators.stages import Equation, Stages
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import BoolArray, FloatArray

OVERSHOOT_RATIO = 0.05
"""Allowance for a maximum between three samples above that of their parabola, relative to the spread of the samples."""

MAX_ARMING_BISECTIONS = 40
"""Number of bisections that look for a negative value of an event function that is zero at the start of the step."""

MIN_POSITIVE_EVENT_VALUE = 1e-300
"""Smallest value of an event function that counts as positive."""

BRACKET_INSET = 1e-6
"""Distance of a false position from the ends of its bracket, relative to the bracket."""

AT_ZERO = 1e-4
"""Event function just after its zero, relative to its rounding level, at which the zero is located."""

MAX_ROOT_ITERATIONS = 100
"""Largest number of false positions; six locate the zero of a smooth function, and 80 a jump."""

LOW_VALUES = 1
"""Row of the samples that holds the event functions at the start of the bracket, once there is one."""

NO_EVENT = 2.0
"""Fraction of the step that stands for no event in it."""


@jit_in_place
def is_any_positive(
    event_values: FloatArray,  # values of the event functions; shape (n,)
    n_functions: int,
) -> bool:
    """Return whether any of the first event functions has risen through zero."""
    is_positive = False
    for i in range(n_functions):
        is_positive = is_positive or event_values[i] > 0.0
    return is_positive


@jit_in_place
def is_any_above(event_values: FloatArray, tolerances: FloatArray, n_functions: int) -> bool:
    """Return whether any of the first event functions is above its rounding."""
    is_above = False
    for i in range(n_functions):
        is_above = is_above or event_values[i] > tolerances[i]
    return is_above


@jit_in_place
def _locate_parabola_maximum(event_values: FloatArray, i: int, j: int) -> tuple[float, float]:
    """Return fraction and an upper estimate of the maximum of the parabola through sample j of function i and its neighbours, or -1."""
    # The estimate is raised by OVERSHOOT_RATIO of the spread of the samples. It is -1 if there is no
    # maximum between the samples.
    before = event_values[j - 1, i]
    middle = event_values[j, i]
    after = event_values[j + 1, i]
    second_difference = before - 2.0 * middle + after
    central_difference = 0.5 * (after - before)
    if not second_difference < 0.0 or abs(central_difference) > -second_difference:
        return EVENT_SAMPLE_FRACTIONS[j], -1.0
    spread = max(before, middle, after) - min(before, middle, after)
    return (
        EVENT_SAMPLE_FRACTIONS[j] - EVENT_SAMPLE_FRACTIONS[1] * central_difference / second_difference,
        middle - 0.5 * central_difference * central_difference / second_difference + OVERSHOOT_RATIO * spread,
    )


@jit_in_place
def _max_rising_value(values: FloatArray, rising: BoolArray) -> float:
    value = -np.inf
    for i in range(values.size):
        if rising[i]:
            value = max(value, values[i])
    return value


@jit_in_place
def _is_not_armed(values: FloatArray, rising: BoolArray, start_values: FloatArray, tolerances: FloatArray, is_past_start: bool) -> bool:
    """Return whether an event function that starts at zero within rounding has not been negative yet."""
    not_armed = False
    for i in range(values.size):
        if rising[i] and start_values[i] >= -tolerances[i]:
            not_armed = not_armed or not is_past_start or values[i] >= min(start_values[i], 0.0)
    return not_armed


TrialEvaluation = Callable[[Equation, EventStep, float, FloatArray], None]
"""Function that fills the event functions after a fraction of a step, integrated again."""


def make_trial_evaluation(
    take_step: Callable[[Equation, float, float, FloatArray, Stages], float],
    finish_step: Callable[[Equation, float, float, Stages], float],
    evaluate_events: Callable[[Equation, float, FloatArray, FloatArray], None],
) -> TrialEvaluation[Equation]:
    """Return the function that takes a trial step of an equation; the functions are those of `EquationFunctions`."""

    def evaluate_after_fraction(equation: Equation, step: EventStep, fraction: float, values: FloatArray) -> None:
        """Fill the event functions (event functions,) after a fraction of the step, or INACTIVE_EVENT_VALUE if it leaves the domain."""
        trial = step.buffers.trial_stages
        local_end = step.local_time + fraction * step.h
        copy_array(trial.derivatives[:, 0], step.buffers.stages.derivatives[:, 0])
        quality = take_step(equation, step.local_time, fraction * step.h, step.state, trial)
        values[:] = INACTIVE_EVENT_VALUE
        if quality >= 0.0:
            finish_step(equation, local_end, quality, trial)
            evaluate_events(equation, local_end, trial.next_state, values)

    return evaluate_after_fraction


def make_bracketing(evaluate_after_fraction: TrialEvaluation[Equation]) -> Callable[[Equation, EventStep], tuple[float, float]]:
    """Return the function that brackets the first event in a step between two fractions; (2, 2) if there is none."""

    def bracket_first_event(equation: Equation, step: EventStep) -> tuple[float, float]:
        """Return the fractions of a step before and after its first event, or NO_EVENT twice."""
        event_values = step.buffers.event_values
        trial_values = step.buffers.trial_event_values
        low, high = NO_EVENT, NO_EVENT
        for i in range(count_located(step.buffers)):
            tolerance = step.buffers.event_tolerances[ARMING, i]
            is_armed = event_values[0, i] < -tolerance
            for j in range(1, LAST_SAMPLE + 1):
                if event_values[j, i] > (0.0 if is_armed else tolerance):
                    if EVENT_SAMPLE_FRACTIONS[j] < high:
                        low, high = EVENT_SAMPLE_FRACTIONS[j - 1], EVENT_SAMPLE_FRACTIONS[j]
                    break
                is_armed = is_armed or event_values[j, i] < -tolerance
                if j == LAST_SAMPLE or not is_armed:
                    continue
                fraction, peak_value = _locate_parabola_maximum(event_values, i, j)
                is_negative_before = fraction > EVENT_SAMPLE_FRACTIONS[j] or event_values[j - 1, i] < -tolerance
                if peak_value > 0.0 and fraction < high and is_negative_before:
                    evaluate_after_fraction(equation, step, fraction, trial_values)
                    if trial_values[i] > 0.0:
                        low = EVENT_SAMPLE_FRACTIONS[j - 1 if fraction <= EVENT_SAMPLE_FRACTIONS[j] else j]
                        high = fraction
                        break
        return low, high

    return bracket_first_event


def make_zero_search(evaluate_after_fraction: TrialEvaluation[Equation]) -> Callable[[Equation, EventStep, int, float, float], float]:
    """Return the function that locates the zero of one event function, by false positions."""
    # N. Anderson, A. Bjorck, A new high order method of regula falsi type, BIT 13 (1973): where false
    # positions stay on one side of the zero, the value at the other end of the bracket is reduced.

    def locate_zero(equation: Equation, step: EventStep, i: int, low: float, high: float) -> float:
        """Return the fraction of the step just after a zero of an event function, between negative and positive values."""
        # The row of event functions at LOW_VALUES is that at `low`; the last row is that at `high`,
        # and becomes that at the result.
        values_high = step.buffers.event_values[LAST_SAMPLE]
        trial_values = step.buffers.trial_event_values
        at_low = min(step.buffers.event_values[LOW_VALUES, i], -MIN_POSITIVE_EVENT_VALUE)
        at_high = values_high[i]
        at_zero, side = AT_ZERO * step.buffers.event_tolerances[ROUNDING, i], 0
        for _ in range(MAX_ROOT_ITERATIONS):
            width = high - low
            middle = low + (0.5 * at_zero - at_low) * width / (at_high - at_low)
            middle = min(max(middle, low + BRACKET_INSET * width), high - BRACKET_INSET * width)
            if not low < middle < high or values_high[i] <= at_zero or width <= 4e-16 * (high + abs(step.local_time / step.h)):
                break
            evaluate_after_fraction(equation, step, middle, trial_values)
            value = trial_values[i]
            if value > 0.0:
                if side > 0:
                    at_low *= 1.0 - value / at_high if value < 0.5 * at_high else 0.5
                high = middle
                at_high = value
                side = 1
                copy_array(values_high, trial_values)
            else:
                if side < 0:
                    at_high *= 1.0 - value / at_low if value > 0.5 * at_low else 0.5
                low = middle
                at_low = min(value, -MIN_POSITIVE_EVENT_VALUE)
                side = -1
        return high

    return locate_zero


def make_event_location(evaluate_after_fraction: TrialEvaluation[Equation]) -> Callable[[Equation, EventStep], float]:
    """Return the function that locates the first event in a step: the fraction of the step after which an event function is positive."""
    # A function that starts at zero, as at a body that just left a stop, must be negative first, unless
    # it rises at once.
    bracket_first_event = jit_in_place(make_bracketing(evaluate_after_fraction))
    locate_in_bracket = jit_in_place(_make_location_in_bracket(evaluate_after_fraction))

    def locate_first_event(equation: Equation, step: EventStep) -> float:
        """Return the fraction of the step after its first event, or NO_EVENT; the last row of event functions becomes that there."""
        buffers, n_located = step.buffers, count_located(step.buffers)
        trial_values = buffers.trial_event_values
        end_values = buffers.event_values[LAST_SAMPLE]
        low, high = bracket_first_event(equation, step)
        if high > 1.0:
            return NO_EVENT
        if high < 1.0:
            evaluate_after_fraction(equation, step, high, trial_values)
        else:
            copy_array(trial_values, end_values)
        if not is_any_positive(trial_values, n_located):
            if not is_any_above(end_values, buffers.event_tolerances[ARMING], n_located):
                return NO_EVENT
            low, high = high, 1.0
            copy_array(trial_values, end_values)
        return locate_in_bracket(equation, step, low, high)

    return locate_first_event


def _make_location_in_bracket(evaluate_after_fraction: TrialEvaluation[Equation]) -> Callable[[Equation, EventStep, float, float], float]:
    """Return the function that locates the first event in a bracket."""
    locate_zero = jit_in_place(make_zero_search(evaluate_after_fraction))

    def locate_in_bracket(equation: Equation, step: EventStep, low: float, high: float) -> float:
        """Return where the first of the functions that are positive at `high` becomes positive; the last row becomes that just after."""
        buffers, n_located = step.buffers, count_located(step.buffers)
        trial_values = buffers.trial_event_values
        start_values = buffers.event_values[0]
        tolerances = buffers.event_tolerances[ARMING]
        at_event, rising = buffers.event_values[LAST_SAMPLE], buffers.is_rising
        for i in range(rising.size):
            rising[i] = i < n_located and trial_values[i] > 0.0
        copy_array(at_event, trial_values)
        if low > 0.0:
            evaluate_after_fraction(equation, step, low, trial_values)
        else:
            copy_array(trial_values, start_values)
        fraction, max_value = high, _max_rising_value(trial_values, rising)
        for halving in range(MAX_ARMING_BISECTIONS):
            is_past_start = halving > 0 or low > 0.0
            if max_value < 0.0 and not _is_not_armed(trial_values, rising, start_values, tolerances, is_past_start):
                break
            fraction *= 0.5  # it starts at zero, or above by rounding: it must be negative in between
            evaluate_after_fraction(equation, step, fraction, trial_values)
            max_value, low = _max_rising_value(trial_values, rising), fraction
            if max_value > 0.0:
                high = fraction
                copy_array(at_event, trial_values)
        else:
            for i in range(trial_values.size):  # it rises at once
                at_event[i] = max(trial_values[i], MIN_POSITIVE_EVENT_VALUE) if rising[i] else trial_values[i]
            return fraction
        copy_array(buffers.event_values[LOW_VALUES], trial_values)
        for i in range(trial_values.size):
            if rising[i] and at_event[i] > 0.0:  # else its zero is after the one found before
                high = locate_zero(equation, step, i, low, high)
        return high

    return locate_in_bracket
