"""Integration of the reduced model over an interval: DOP853 steps with event location; compiled."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.engines.reduced.contact import apply_transition
from governor_mechanism.engines.reduced.event_functions import (
    count_event_functions,
    evaluate_reduced_event_functions,
    fill_event_tolerances,
)
from governor_mechanism.engines.reduced.event_location import EventStep, locate_first_event
from governor_mechanism.integrators.projected_dop853 import N_NONSTIFF_STEPS, N_STIFF_STEPS, STABILITY_LIMIT
from governor_mechanism.integrators.reduced_dop853 import (
    Stages,
    StepCounter,
    error_norm,
    estimate_stiffness,
    evaluate_dense_output,
    make_stages_jit,
    mean_stage_derivative,
    prepare_dense_output,
    take_step,
)
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.contact.transition import EventLog
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_SAMPLE_FRACTIONS
from governor_mechanism.mechanics.reduction.equation_of_motion import (
    MODE_HELD,
    N_FURTHER_STATES,
    N_STATES,
    ReducedModel,
    StateIndex,
    evaluate_equation_of_motion,
)
from governor_mechanism.mechanics.reduction.lowering import ForceParameter
from governor_mechanism.mechanics.reduction.table import find_piece
from governor_mechanism.numerics.jit import jit, jit_internal
from governor_mechanism.types import FloatArray, IntArray

MAX_SIMULTANEOUS_REDUCED_EVENTS = 40
"""Number of events at one time at which an integration stops as stalled."""

POST_EVENT_STEP_RATIO = 0.1
"""Largest first step after an event, relative to the largest step."""

HELD_STEP_FACTOR = 8.0
"""Factor on the largest step while the mechanism is held, the given spindle speed does not fluctuate and no load depends on a reading.

Forces then change slowly.
"""

MAX_STEP_OUTSIDE_TABLE = 3.0
"""Displacement of a step, in coordinate scales, from which a step that leaves the table is shortened before the table is extended."""


@jit
def integrate_reduced(
    model: ReducedModel,
    span: tuple[float, float],
    times: FloatArray,
    state: FloatArray,
    limits: tuple[float, float, float, int],
    stages: Stages,
    states: FloatArray,
    modes: IntArray,
    event_log: EventLog,
    counts: IntArray,
) -> tuple[int, float, int, float]:
    """Integrate the reduced model over a time span, with event location and dense output.

    state (see `StateIndex`) is advanced in place from span[0] to span[1], s; states and modes are filled at the times.
    limits are the tolerance of one step relative to the coordinate scale (and to that per time scale), first and largest step (s), and
    the number of steps. The model's input cubics begin at span[0]. Returns status, last step (s), number of times reached, and time
    of the state (s).
    """
    start, end = span
    tolerance, step, max_step, max_steps = limits
    time, n_reached, piece_index = start, 0, 0
    rates, accelerations, further_rates, dense = stages.rates, stages.accelerations, stages.further_rates, stages.dense
    mode, parameters, stiff_steps, calm_steps = model.mode, model.parameters, 0, 0
    is_conservative = parameters[ForceParameter.IS_CONSERVATIVE] != 0.0
    coordinate_scale, time_scale = parameters[ForceParameter.COORDINATE_SCALE], parameters[ForceParameter.TIME_SCALE]
    monitors_events = model.contacts.shape[0] + model.one_sided_springs.shape[0] > 0
    event_tolerances = np.empty(count_event_functions(model))
    event_values = np.full((EVENT_SAMPLE_FRACTIONS.size, event_tolerances.size), -1.0)
    fill_event_tolerances(model, event_tolerances)
    trial_stages = make_stages_jit()
    piece_index, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_index)
    if side >= 0:
        return IntegrationStatus.BELOW_TABLE + side, step, n_reached, time
    _evaluate_first_stage(model, piece_index, t, state, 0.0, stages)
    if monitors_events:
        evaluate_reduced_event_functions(model, state, 0.0, piece_index, event_values[0])
    while time < end:
        if counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED] >= max_steps:
            return IntegrationStatus.STEP_LIMIT, step, n_reached, time
        if step < 1e-13 * (end - start) or not math.isfinite(step):
            return IntegrationStatus.STALLED, step, n_reached, time
        is_load_steady = parameters[ForceParameter.FLUCTUATION_AMPLITUDE] == 0.0 and model.input_terms.size == 0
        can_use_long_step = mode[MODE_HELD] != 0 and is_load_steady
        step = min(step, max_step * (HELD_STEP_FACTOR if can_use_long_step else 1.0))
        is_last = time + step >= end
        h = end - time if is_last else step
        local_time = time - start
        piece_end, side = take_step(model, local_time, h, state, piece_index, stages)
        counts[StepCounter.EVALUATIONS] += 12
        counts[StepCounter.MOVING_EVALUATIONS] += 12 if mode[MODE_HELD] == 0 else 0
        if side >= 0 and abs(stages.states[1, 0] - state[0]) > MAX_STEP_OUTSIDE_TABLE * coordinate_scale:  # a shorter step may stay inside
            counts[StepCounter.REJECTED] += 1
            step = 0.25 * h
            continue
        if side >= 0:
            return IntegrationStatus.BELOW_TABLE + side, step, n_reached, time
        error = error_norm(stages, parameters, h) / tolerance
        if not error <= 1.0:
            counts[StepCounter.REJECTED] += 1
            step = h * (max(0.2, 0.9 * error**-0.125) if math.isfinite(error) else 0.1)
            continue
        counts[StepCounter.ACCEPTED] += 1
        stiffness = 0.0 if is_conservative else estimate_stiffness(stages)
        has_event, time_end = False, end if is_last else time + h
        if monitors_events:
            event_step = EventStep(model, local_time, h, state, piece_index, stages, trial_stages, event_tolerances, counts)
            has_event, event_fraction = locate_first_event(event_step, event_values)
            if has_event:
                time_end = time + event_fraction * h if event_fraction < 1.0 else time_end
                h *= event_fraction
                piece_end, side = take_step(model, local_time, h, state, piece_index, stages)
        if n_reached < times.size and times[n_reached] <= time_end and h > 0.0:
            side = prepare_dense_output(model, local_time, h, state, piece_index, stages)
            counts[StepCounter.EVALUATIONS] += 3
            if side >= 0:
                return IntegrationStatus.BELOW_TABLE + side, step, n_reached, time
            while n_reached < times.size and times[n_reached] <= time_end:
                fraction = (times[n_reached] - time) / h
                for c in range(2 if is_conservative else N_STATES):
                    states[n_reached, c] = state[c] + evaluate_dense_output(dense, c, fraction)
                for c in range(mode.size if monitors_events else 0):
                    modes[n_reached, c] = mode[c]
                n_reached += 1
        if not is_conservative:
            for c in range(N_FURTHER_STATES):
                state[2 + c] += h * mean_stage_derivative(further_rates[c])
                further_rates[c, 0] = further_rates[c, 12]
        state[0], state[1] = stages.states[1, 0], stages.states[1, 1]
        rates[0], accelerations[0] = rates[12], accelerations[12]
        piece_index = piece_end
        if has_event:
            event_log.counts[1] = event_log.counts[1] + 1 if time_end - time <= SIMULTANEITY_TOLERANCE * time_scale else 0
            if event_log.counts[1] >= MAX_SIMULTANEOUS_REDUCED_EVENTS:
                return IntegrationStatus.STALLED, step, n_reached, time
            time = time_end
            is_released = mode[MODE_HELD] != 0 and max(event_values[-1, -2], event_values[-1, -1]) > 0.0
            apply_transition(model, time, time - start, piece_index, is_released, state, event_log)
            piece_index, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], piece_index)
            _evaluate_first_stage(model, piece_index, t, state, time - start, stages)
            evaluate_reduced_event_functions(model, state, time - start, piece_index, event_values[0])
            step = min(step, POST_EVENT_STEP_RATIO * max_step)
            continue
        time = time_end
        if monitors_events:
            event_values[0] = event_values[-1]
        step_factor = min(6.0, max(0.3, 0.9 * max(error, 1e-30) ** -0.125))
        step = max(step, h * step_factor) if is_last else h * step_factor
        at_stability_limit = not is_conservative and mode[MODE_HELD] == 0 and h * stiffness > STABILITY_LIMIT
        stiff_steps, calm_steps = (stiff_steps + 1, 0) if at_stability_limit else (stiff_steps, calm_steps + 1)
        if calm_steps >= N_NONSTIFF_STEPS:
            stiff_steps = 0
        if stiff_steps >= N_STIFF_STEPS and time < end:
            return IntegrationStatus.STIFF, step, n_reached, time
    return IntegrationStatus.DONE, step, n_reached, time


@jit
def initialise_contact_mode(model: ReducedModel, time: float, state: FloatArray, event_log: EventLog) -> None:
    """Select the contact mode at a start or after a discontinuity of an input; the state must be on the table."""
    apply_transition(model, time, 0.0, 0, False, state, event_log)


@jit_internal
def _evaluate_first_stage(model: ReducedModel, piece: int, t: float, state: FloatArray, local_time: float, stages: Stages) -> None:
    """Evaluate the derivatives of a state into stage 0."""
    angle, speed = state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED]
    stages.rates[0] = state[1]
    stages.accelerations[0] = evaluate_equation_of_motion(model, piece, t, state[1], angle, speed, local_time, stages.further_rates, 0)
