"""When within a step something watched rises above nought: looked for between its ends, found by shorter steps.

Compiled. What lies within a step is known to order 5 from its ends alone; where something crosses is found by steps
that end there, which are as exact as any other.
"""

from __future__ import annotations

import numpy as np

from governor_mechanism.engines.reduced.event_functions import evaluate_reduced_event_functions
from governor_mechanism.integrators.event_location import locate_parabola_maximum
from governor_mechanism.integrators.reduced_dop853 import Stages, take_step
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_SAMPLE_FRACTIONS
from governor_mechanism.mechanics.reduction.equation_of_motion import ReducedModel
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import BoolArray, FloatArray, IntArray

MAX_ARMING_BISECTIONS = 40
"""So often is a time sought at which something that begins at nought is below it."""

MIN_POSITIVE_EVENT_VALUE = 1e-300
"""A mark that counts as above nought."""

BRACKET_INSET = 1e-3
"""Of a bracket: a chord that meets nought nearer to an end is taken this far off it, so that the end comes nearer."""

MAX_ROOT_ITERATIONS = 100
"""So many shorter steps find a crossing to rounding."""


@jit_internal
def locate_first_event(
    model: ReducedModel,
    local_time: float,
    h: float,
    q: float,
    v: float,
    q_end: float,
    v_end: float,
    piece_index: int,
    stages: Stages,
    trial_stages: Stages,
    event_values: FloatArray,
    event_tolerances: FloatArray,
    counts: IntArray,
) -> tuple[bool, float]:
    """Whether a mark rises above nought in a step, and after which part of it; marks[-1] are then those there.

    marks (PARTS, n) are known at the step's beginning. Something that begins at nought, as a body that has just left a
    stop, must have been below it first, unless it rises at once.
    """
    last = EVENT_SAMPLE_FRACTIONS.size - 1
    for j in range(1, last):
        q_inside, v_inside = _quintic_hermite_state(
            q, v, stages.accelerations[0], q_end, v_end, stages.accelerations[12], h, EVENT_SAMPLE_FRACTIONS[j]
        )
        evaluate_reduced_event_functions(
            model, q_inside, v_inside, local_time + EVENT_SAMPLE_FRACTIONS[j] * h, piece_index, event_values[j]
        )
    evaluate_reduced_event_functions(model, q_end, v_end, local_time + h, piece_index, event_values[last])
    high, trial_values = 2.0, np.empty(event_tolerances.size)
    low = 0.0
    for i in range(event_tolerances.size):
        is_armed = event_values[0, i] < -event_tolerances[i]
        for j in range(1, last + 1):
            if event_values[j, i] > (0.0 if is_armed else event_tolerances[i]):
                if EVENT_SAMPLE_FRACTIONS[j] < high:
                    low, high = EVENT_SAMPLE_FRACTIONS[j - 1], EVENT_SAMPLE_FRACTIONS[j]
                break
            is_armed = is_armed or event_values[j, i] < -event_tolerances[i]
            if j == last or not is_armed:
                continue
            fraction, peak_value = locate_parabola_maximum(
                EVENT_SAMPLE_FRACTIONS[j], EVENT_SAMPLE_FRACTIONS[1], event_values[j - 1, i], event_values[j, i], event_values[j + 1, i]
            )
            below_first = fraction > EVENT_SAMPLE_FRACTIONS[j] or event_values[j - 1, i] < -event_tolerances[i]
            if peak_value > 0.0 and fraction < high and below_first:
                _evaluate_after_step(model, local_time, fraction * h, q, v, piece_index, stages, trial_stages, trial_values, counts)
                if trial_values[i] > 0.0:
                    low, high = (
                        (EVENT_SAMPLE_FRACTIONS[j - 1] if fraction <= EVENT_SAMPLE_FRACTIONS[j] else EVENT_SAMPLE_FRACTIONS[j]),
                        fraction,
                    )
                    break
    if high > 1.0:
        return False, 1.0
    _evaluate_after_step(model, local_time, high * h, q, v, piece_index, stages, trial_stages, trial_values, counts)
    if not np.any(trial_values > 0.0):
        if not np.any(event_values[last] > event_tolerances):
            return False, 1.0
        low, high, trial_values[:] = high, 1.0, event_values[last]
    return True, _locate_in_bracket(model, local_time, h, q, v, piece_index, stages, trial_stages, event_values, event_tolerances, counts,
                           low, high, trial_values)  # fmt: skip


@jit_internal
def _locate_in_bracket(
    model: ReducedModel,
    local_time: float,
    h: float,
    q: float,
    v: float,
    piece_index: int,
    stages: Stages,
    trial_stages: Stages,
    event_values: FloatArray,
    event_tolerances: FloatArray,
    counts: IntArray,
    low: float,
    high: float,
    trial_values: FloatArray,
) -> float:
    """The part of the step at which the first of the marks that are above nought at `high` rises above it.

    found are the marks there; marks[-1] becomes those just above nought.
    """
    last = EVENT_SAMPLE_FRACTIONS.size - 1
    event_values[last], rising = trial_values, trial_values > 0.0
    if low > 0.0:
        _evaluate_after_step(model, local_time, low * h, q, v, piece_index, stages, trial_stages, trial_values, counts)
    else:
        trial_values[:] = event_values[0]
    fraction = high
    max_value = _max_rising_value(trial_values, rising)
    for halving in range(MAX_ARMING_BISECTIONS):
        if max_value < 0.0 and not _is_not_armed(trial_values, rising, event_values[0], event_tolerances, halving > 0 or low > 0.0):
            break
        fraction *= 0.5  # it begins at nought, or above by rounding: it must have been below it in between
        _evaluate_after_step(model, local_time, fraction * h, q, v, piece_index, stages, trial_stages, trial_values, counts)
        max_value, low = _max_rising_value(trial_values, rising), fraction
        if max_value > 0.0:
            high, event_values[last] = fraction, trial_values
    else:
        for i in range(trial_values.size):  # it rises at once
            event_values[last, i] = max(trial_values[i], MIN_POSITIVE_EVENT_VALUE) if rising[i] else trial_values[i]
        return fraction
    for i in range(trial_values.size):
        if rising[i] and event_values[last, i] > 0.0:  # else it rises later than what was found before it
            high = _regula_falsi(
                model, local_time, h, q, v, piece_index, stages, trial_stages, event_values[last], counts, i, low, high, trial_values
            )
    return high


@jit_internal
def _regula_falsi(
    model: ReducedModel, local_time: float, h: float, q: float, v: float, piece_index: int, stages: Stages, trial_stages: Stages, values_high: FloatArray,
    counts: IntArray, event_index: int, low: float, high: float, trial_values: FloatArray,
) -> float:  # fmt: skip
    """The part just after which a mark rises above nought, from below it at `low`; above are the marks at `high`, and
    become those there."""
    _evaluate_after_step(model, local_time, low * h, q, v, piece_index, stages, trial_stages, trial_values, counts)
    at_low, at_high, bisect = min(trial_values[event_index], -MIN_POSITIVE_EVENT_VALUE), values_high[event_index], False
    for _ in range(MAX_ROOT_ITERATIONS):
        width = high - low
        middle = 0.5 * (low + high) if bisect else (low * at_high - high * at_low) / (at_high - at_low)
        middle = min(max(middle, low + BRACKET_INSET * width), high - BRACKET_INSET * width)
        if not low < middle < high or width <= 4e-16 * (high + abs(local_time / h)):
            break
        _evaluate_after_step(model, local_time, middle * h, q, v, piece_index, stages, trial_stages, trial_values, counts)
        if trial_values[event_index] > 0.0:
            high, at_high, values_high[:] = middle, trial_values[event_index], trial_values
        else:
            low, at_low = middle, min(trial_values[event_index], -MIN_POSITIVE_EVENT_VALUE)
        bisect = high - low > 0.5 * width  # a chord that left most of the bracket is followed by a halving
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
    """Whether a mark that rises in the step, and begins at nought but for rounding, has not been seen below that."""
    not_armed = False
    for i in range(trial_values.size):
        if rising[i] and start_values[i] >= -event_tolerances[i]:
            not_armed = not_armed or not is_past_start or trial_values[i] >= min(start_values[i], 0.0)
    return not_armed


@jit_internal
def _evaluate_after_step(
    model: ReducedModel, local_time: float, h: float, q: float, v: float,
    piece_index: int, stages: Stages, trial_stages: Stages, trial_values: FloatArray, counts: IntArray,
) -> None:  # fmt: skip
    """Fill found with the marks after a step from where another one begins; quiet where no piece is laid."""
    trial_stages.rates[0], trial_stages.accelerations[0] = stages.rates[0], stages.accelerations[0]
    trial_stages.quadrature_rates[0] = stages.quadrature_rates[0]
    q_end, v_end, piece, side = take_step(model, local_time, h, q, v, piece_index, trial_stages)
    counts[2] += 12
    trial_values[:] = -1.0
    if side < 0:
        evaluate_reduced_event_functions(model, q_end, v_end, local_time + h, piece, trial_values)


@jit_internal
def _quintic_hermite_state(
    q: float, v: float, acceleration: float, q_end: float, v_end: float, acceleration_end: float, h: float, fraction: float
) -> tuple[float, float]:
    """Coordinate and rate within a step, by the polynomial of order 5 through both its ends."""
    first_difference, second_difference = h * v, h * h * acceleration
    position_residual, velocity_residual, acceleration_residual = (
        q_end - q - first_difference - 0.5 * second_difference,
        h * v_end - first_difference - second_difference,
        h * h * acceleration_end - second_difference,
    )
    c3, c4, c5 = (
        10 * position_residual - 4 * velocity_residual + 0.5 * acceleration_residual,
        -15 * position_residual + 7 * velocity_residual - acceleration_residual,
        6 * position_residual - 3 * velocity_residual + 0.5 * acceleration_residual,
    )
    q_inside = q + fraction * (first_difference + fraction * (0.5 * second_difference + fraction * (c3 + fraction * (c4 + fraction * c5))))
    return q_inside, (first_difference + fraction * (second_difference + fraction * (3 * c3 + fraction * (4 * c4 + fraction * 5 * c5)))) / h
