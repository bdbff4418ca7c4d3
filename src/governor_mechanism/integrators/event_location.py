"""Bracket the first event within a step: an upward zero crossing of an event function; compiled."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_event_functions, evaluate_state_derivative_inline
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_SAMPLE_FRACTIONS, EventFunctionKind
from governor_mechanism.numerics.hermite import interpolate_quintic_hermite
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, IntArray

OVERSHOOT_RATIO = 0.05
"""Allowance for a maximum between three samples above that of their parabola, relative to the spread of the samples."""


@jit_internal
def bracket_first_event(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    local_time: float,
    h: float,
    state_start: FloatArray,
    derivative_start: FloatArray,
    state_end: FloatArray,
    derivative_end: FloatArray,
    trial_state: FloatArray,
    trial_derivative: FloatArray,
    event_values: FloatArray,
    counters: IntArray,
) -> tuple[float, float]:
    """Return the step fractions (low, high) that bracket the first upward zero crossing, or (2, 2) if there is none.

    Row 0 and the last row of event_values (samples, functions) are given; the rows between them are filled in. A function
    that starts at zero, as after a body has left a stop, must become negative before it can trigger, unless it rises at once.
    """
    event_table, last_sample = system.event_functions, EVENT_SAMPLE_FRACTIONS.size - 1
    has_force_events = False
    for i in range(event_table.size):
        has_force_events = has_force_events or event_table[i].kind == EventFunctionKind.FORCE
    for j in range(1, last_sample):
        _evaluate_events_within_step(
            system, workspace, input_cubics, local_time, h, state_start, derivative_start, state_end, derivative_end, trial_state,
            trial_derivative, EVENT_SAMPLE_FRACTIONS[j], has_force_events, counters, event_values[j],
        )  # fmt: skip
    trial_values = np.empty(event_table.size)
    low = high = 2.0
    for i in range(event_table.size):
        tolerance = event_table[i].tolerance
        armed = event_values[0, i] < -tolerance
        for j in range(1, last_sample + 1):
            if event_values[j, i] > (0.0 if armed else tolerance):
                if EVENT_SAMPLE_FRACTIONS[j] < high:
                    low, high = EVENT_SAMPLE_FRACTIONS[j - 1], EVENT_SAMPLE_FRACTIONS[j]
                break
            armed = armed or event_values[j, i] < -tolerance
            if j == last_sample or not armed:
                continue
            fraction, maximum = locate_parabola_maximum(
                EVENT_SAMPLE_FRACTIONS[j], EVENT_SAMPLE_FRACTIONS[1], event_values[j - 1, i], event_values[j, i], event_values[j + 1, i]
            )
            negative_before = fraction > EVENT_SAMPLE_FRACTIONS[j] or event_values[j - 1, i] < -tolerance
            if not (maximum > 0.0 and fraction < high and negative_before):
                continue
            _evaluate_events_within_step(
                system, workspace, input_cubics, local_time, h, state_start, derivative_start, state_end, derivative_end, trial_state,
                trial_derivative, fraction, has_force_events, counters, trial_values,
            )  # fmt: skip
            if trial_values[i] > 0.0:
                low, high = (
                    (EVENT_SAMPLE_FRACTIONS[j - 1] if fraction <= EVENT_SAMPLE_FRACTIONS[j] else EVENT_SAMPLE_FRACTIONS[j]),
                    fraction,
                )
                break
    return low, high


@jit_internal
def locate_parabola_maximum(
    midpoint: float, spacing: float, value_before: float, value_middle: float, value_after: float
) -> tuple[float, float]:
    """Locate the maximum of the parabola through three equally spaced samples.

    Parameters
    ----------
    midpoint
        Abscissa of the middle sample.
    spacing
        Distance of the samples.
    value_before
        First sample.
    value_middle
        Middle sample.
    value_after
        Last sample.

    Returns
    -------
    tuple[float, float]
        Abscissa and an upper estimate of the maximum, raised by OVERSHOOT_RATIO of the spread of the samples.
        The estimate is -1 if the parabola has no maximum between the samples.
    """
    second_difference, central_difference = (value_before - 2.0 * value_middle + value_after, 0.5 * (value_after - value_before))
    if not second_difference < 0.0 or abs(central_difference) > -second_difference:
        return midpoint, -1.0
    spread = max(value_before, value_middle, value_after) - min(value_before, value_middle, value_after)
    return (
        midpoint - spacing * central_difference / second_difference,
        value_middle - 0.5 * central_difference * central_difference / second_difference + OVERSHOOT_RATIO * spread,
    )


@jit_internal
def _evaluate_events_within_step(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    local_time: float,
    h: float,
    state_start: FloatArray,
    derivative_start: FloatArray,
    state_end: FloatArray,
    derivative_end: FloatArray,
    trial_state: FloatArray,
    trial_derivative: FloatArray,
    fraction: float,
    has_force_events: bool,
    counters: IntArray,
    event_values: FloatArray,
) -> None:
    """Evaluate the event functions at a fraction of the step, on the quintic interpolant of the poses."""
    interpolate_quintic_hermite(state_start, derivative_start, state_end, derivative_end, 3 * system.bodies.size, h, fraction, trial_state)
    if has_force_events:
        evaluate_state_derivative_inline(system, workspace, input_cubics, local_time + fraction * h, trial_state, trial_derivative)
        counters[2] += 1
    evaluate_event_functions(system, workspace, trial_state, event_values)
