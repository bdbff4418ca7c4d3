"""Integration of the reduced model over an interval: DOP853 steps, events and contact transitions; compiled. Settings of the engine."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.certificate import FIRST_TOLERANCE_RATIO, ErrorControlSettings
from governor_mechanism.engines.reduced.contact import (
    apply_transition,
    begin_phases,
    change_table_segments,
    end_phases,
    evaluate_reduced_event_functions,
    is_jammed,
    make_event_tolerances,
    set_table_terms,
)
from governor_mechanism.integrators import dop853, step_record
from governor_mechanism.integrators.equation import (
    LAST_SAMPLE,
    EquationFunctions,
    EventStep,
    StepBuffers,
    forget_gap_slopes,
    make_step_buffers,
)
from governor_mechanism.integrators.event_location import is_any_positive
from governor_mechanism.integrators.stages import END_STAGE, Stages, StepCounter, make_take_step
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.integrators.tableau import FIRST_NONZERO_STAGE, STAGES
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.contact.transition import EventLog
from governor_mechanism.mechanics.reduction.equation_of_motion import evaluate_equation_of_motion
from governor_mechanism.mechanics.reduction.lagrangian import TableColumn
from governor_mechanism.mechanics.reduction.reduced_model import N_STATES, ReducedModel, StateIndex
from governor_mechanism.mechanics.reduction.table import ON_TABLE, PeriodIndex, find_piece, local_coordinate
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.interpolation import cubic_hermite_jit, evaluate_piece, quintic_hermite_jit
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class ReducedSettings(ErrorControlSettings):
    """Numerical settings of the reduced engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    comparison_width_ratio
        Factor on the piece width of the comparison run, so that the certificate includes the interpolation error of the tables.
    max_monitor_travel
        Travel between two of these states, in coordinate scales, above which more are inserted.
    table_end_approach
        Step towards the end of the table relative to the time in which the motion would reach it at its present rate.
    table_end_step_ratio
        Factor by which such a step is shortened that leads beyond the end.
    min_end_step_ratio
        Step at which the end of the table is reached, relative to the remaining time and to the time scale: rounding.
    min_remaining_travel
        Distance from the end of the table at which it is reached, relative to the coordinate and to its scale: rounding.
    """

    max_step_work: float = 5e6
    monitor_interval_ratio: float = 0.1
    comparison_width_ratio: float = 0.7
    max_monitor_travel: float = 0.2
    table_end_approach: float = 0.99
    table_end_step_ratio: float = 0.25
    min_end_step_ratio: float = 1e-12
    min_remaining_travel: float = 1e-14


MAX_SIMULTANEOUS_REDUCED_EVENTS = 40
"""Number of events at one time at which an integration stops as stalled."""

POST_EVENT_STEP_RATIO = 0.1
"""Largest first step after an event, relative to the largest step."""

# Forces then change slowly.
HELD_STEP_FACTOR = 8.0
"""Factor on the largest step while the mechanism is held, the given spindle speed does not fluctuate and no load depends on a reading."""

TURNING_POINT_BISECTIONS = 20
"""Bisections of a turning point within a step: its time is good to 1e-6 of the step, and its value to the square of that."""

MAX_STEP_OUTSIDE_TABLE = 3.0
"""Displacement of a step, in coordinate scales, from which a step that leaves the table is shortened before the table is extended."""


class ReducedEquation(NamedTuple):
    """Equation along a table."""

    model: ReducedModel  # the reduced model
    piece: IntArray  # piece of its table found last, from which the next search starts; shape (1,)
    counts: IntArray  # counters, indexed by `StepCounter`
    accuracy: float  # how far the coordinate may lie beyond the table between two stages, SI: the accuracy of the motion
    # result: state at the start of the step in which a shaft turns back, and its local time, s; shape
    # (N_STATES + 1,)
    step_start: FloatArray


def make_reduced_equation(model: ReducedModel, counts: IntArray, tolerance: float) -> ReducedEquation:
    """Return the equation of a model on a table, with counters and the tolerance of the steps."""
    accuracy = tolerance / FIRST_TOLERANCE_RATIO * float(model.parameters["coordinate_scale"][0])
    return ReducedEquation(model, np.zeros(1, dtype=np.int64), counts, accuracy, np.zeros(N_STATES + 1))


def make_reduced_buffers(model: ReducedModel, counts: IntArray) -> StepBuffers:
    """Return the buffers of an integration; only what changes is integrated."""
    parameters = model.parameters[0]
    coordinate_scale, time_scale, energy_scale = (float(parameters[name]) for name in ("coordinate_scale", "time_scale", "energy_scale"))
    error_scale = np.array([coordinate_scale, coordinate_scale / time_scale, energy_scale, energy_scale, 1.0, 1.0 / time_scale])
    n_coupled = n_integrated = N_STATES
    if not parameters["has_shaft"]:
        n_coupled = 2
        n_integrated = 2 if parameters["is_conservative"] else int(StateIndex.SHAFT_ANGLE)
    tolerances = make_event_tolerances(model)
    low_stops = model.event_layout.low_stops
    is_gap = np.zeros(tolerances.size, dtype=np.bool_)
    is_gap[low_stops : low_stops + len(model.contacts)] = model.contacts["is_gap"] != 0
    return make_step_buffers(N_STATES, n_coupled, error_scale[:n_integrated], tolerances, counts, len(model.kinks), is_gap=is_gap)


@jit_in_place
def _evaluate(equation: ReducedEquation, local_time: float, state: FloatArray, derivatives: FloatArray, k: int) -> float:
    model = equation.model
    piece, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, state[0], equation.piece[0])
    if side != ON_TABLE:
        return step_record.BELOW_DOMAIN - side
    equation.piece[0] = piece
    equation.counts[StepCounter.EVALUATIONS] += 1
    angle, speed = state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED]
    derivatives[0, k] = state[1]
    derivatives[1, k] = evaluate_equation_of_motion(model, piece, t, state[1], angle, speed, local_time, derivatives[2:], k)
    return 1.0


_take_general_step = jit_in_place(make_take_step(_evaluate))


@jit_in_place
def _take_step(equation: ReducedEquation, local_time: float, h: float, state: FloatArray, stages: Stages) -> float:
    parameters = equation.model.parameters[0]
    if parameters.is_conservative != 0:
        quality = _take_conservative_step(equation, h, state, stages)
    else:
        quality = _take_general_step(equation, local_time, h, state, stages)
    is_far = abs(stages.end[0] - state[0]) > MAX_STEP_OUTSIDE_TABLE * parameters.coordinate_scale
    if quality < 0.0:
        return step_record.FAR_OUTSIDE_DOMAIN if is_far else quality
    side = _find_excursion(equation, h, state, stages) if state[1] * stages.end[1] < 0.0 else ON_TABLE
    return quality if side == ON_TABLE else step_record.BELOW_DOMAIN - side


@jit_in_place
def _find_excursion(equation: ReducedEquation, h: float, state: FloatArray, stages: Stages) -> int:
    """Return the side on which the motion may leave the table and come back between two stages: 0 below, 1 above, or ON_TABLE."""
    # Where the interpolants are too rough to say, a shorter step tells.
    q = state[0]
    v = state[1]
    q_end = stages.end[0]
    v_end = stages.end[1]
    a, a_end = stages.derivatives[1, 0], stages.derivatives[1, END_STAGE]
    low, high = 0.0, 1.0
    for _ in range(TURNING_POINT_BISECTIONS):
        middle = 0.5 * (low + high)
        if quintic_hermite_jit(q, v, a, q_end, v_end, a_end, h, middle)[1] * v > 0.0:
            low = middle
        else:
            high = middle
    turning_point = quintic_hermite_jit(q, v, a, q_end, v_end, a_end, h, low)[0]
    interpolation_error = abs(turning_point - cubic_hermite_jit(q, q_end, v, v_end, h, low))
    excess = interpolation_error - equation.accuracy
    farthest = turning_point + (excess if v > 0.0 else -excess)
    model = equation.model
    return find_piece(model.intervals, model.neighbours, model.periodicity, farthest, equation.piece[0])[2]


@jit_in_place
def _take_conservative_step(equation: ReducedEquation, h: float, state: FloatArray, stages: Stages) -> float:
    """Take a step of a conservative model, in one loop without calls: five times as fast."""
    model = equation.model
    rates = stages.derivatives[0]
    accelerations = stages.derivatives[1]
    q = state[0]
    v = state[1]
    piece = equation.piece[0]
    side = ON_TABLE
    is_periodic = model.periodicity[PeriodIndex.PERIOD] > 0.0
    q_end, v_end = q, v
    for stage in range(1, END_STAGE + 1):
        mean_rate = STAGES[stage, 0] * rates[0]
        mean_acceleration = STAGES[stage, 0] * accelerations[0]
        for k in range(FIRST_NONZERO_STAGE[stage], stage):
            mean_rate += STAGES[stage, k] * rates[k]
            mean_acceleration += STAGES[stage, k] * accelerations[k]
        q_end, v_end = q + h * mean_rate, v + h * mean_acceleration
        t = local_coordinate(model.intervals, piece, q_end)
        if is_periodic or abs(t) > 1.0:
            piece, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, q_end, piece)
            if side != ON_TABLE:
                break
        rates[stage] = v_end
        quadratic = evaluate_piece(model.coefficients, piece, TableColumn.QUADRATIC, t)
        accelerations[stage] = quadratic * v_end * v_end + evaluate_piece(model.coefficients, piece, TableColumn.POTENTIAL, t)
    stages.end[0], stages.end[1] = q_end, v_end
    equation.piece[0] = piece
    equation.counts[StepCounter.EVALUATIONS] += END_STAGE
    return 1.0 if side == ON_TABLE else step_record.BELOW_DOMAIN - side


@jit_in_place
def _finish_step(equation: ReducedEquation, local_time: float, quality: float, stages: Stages) -> float:
    for i in range(stages.errors.shape[1]):
        stages.next_state[i], stages.next_derivative[i, 0] = stages.end[i], stages.derivatives[i, END_STAGE]
    return quality


@jit_in_place
def _check_step(equation: ReducedEquation, local_time: float, h: float, state: FloatArray, stages: Stages, quality: float) -> float:
    """Return a negative quality if a shaft turns back within a step."""
    parameters, end = equation.model.parameters[0], stages.next_state
    is_turning = parameters.stall_ratio * end[StateIndex.SHAFT_SPEED] >= 0.0
    if is_turning and end[StateIndex.RATE] >= parameters.min_rate:
        return quality
    copy_array(equation.step_start[: state.size], state)
    equation.step_start[state.size] = local_time
    return step_record.TURNED_BACK


@jit_in_place
def _finish_output(equation: ReducedEquation, step: EventStep, fraction: float, state: FloatArray) -> None:
    """Leave the state, which is in the domain."""


@jit_in_place
def _project_errors(equation: ReducedEquation, errors: FloatArray) -> None:
    """Leave the errors."""


@jit_in_place
def _evaluate_events(equation: ReducedEquation, local_time: float, state: FloatArray, event_values: FloatArray) -> None:
    evaluate_reduced_event_functions(equation.model, state, local_time, equation.piece[0], event_values)


@jit_in_place
def _sample_events(equation: ReducedEquation, step: EventStep, fraction: float, event_values: FloatArray) -> None:
    start = step.state
    stages = step.buffers.stages
    h = step.h
    end, sample = stages.next_state, stages.stage_state
    for i in (0, 4):  # the coordinate and the angle of the shaft, with their rates after them
        start_acceleration = stages.derivatives[i + 1, 0]
        end_acceleration = stages.next_derivative[i + 1, 0]
        sample[i], sample[i + 1] = quintic_hermite_jit(
            start[i], start[i + 1], start_acceleration, end[i], end[i + 1], end_acceleration, h, fraction
        )
    _evaluate_events(equation, step.local_time + fraction * h, sample, event_values)


_EQUATION = EquationFunctions(
    _evaluate, _take_step, _finish_step, _finish_output, _project_errors, _evaluate_events, _sample_events, _check_step
)
_integrate_to_event = jit_in_place(dop853.make_dop853(_EQUATION))


@jit_in_place
def integrate_reduced(
    equation: ReducedEquation,
    buffers: StepBuffers,
    span: tuple[float, float],  # start and end, s
    time_origin: float,  # time at which the input cubics of the equation begin, s
    times: FloatArray,  # reported times in (start, end], s; shape (n,)
    state: FloatArray,  # see StateIndex; advanced in place
    limits: dop853.StepLimits,
    states: FloatArray,  # result: states at the times; shape (n, N_STATES)
    modes: IntArray,  # result: contact modes at the times; shape (n, mode)
    event_log: EventLog,
    selects_mode: bool,
) -> tuple[int, float, int, float]:
    """Integrate over a span with contact transitions at events; return status, next step (s), times reached, and time of the state (s)."""
    # With `selects_mode`, select the contact mode at the start first; that is all if the span is empty.
    model = equation.model
    counts = buffers.stages.counts
    mode = equation.model.mode
    time, end = span
    step = limits.step
    n_reached = 0
    is_released = False
    time_scale = model.parameters[0].time_scale
    set_table_terms(model)
    while True:
        if selects_mode:  # the only call: the machine code of the transition is a third of that of this function
            apply_transition(model, time, time - time_origin, equation.piece[0], is_released, state, event_log)
            if end == span[0]:
                return IntegrationStatus.DONE, step, n_reached, time
        is_held = mode[model.mode_layout.held] != 0
        n_steps = counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED]
        if is_held and is_jammed(model, state[0], equation.piece[0]):
            end_phases(model)
            return IntegrationStatus.UNDETERMINED, step, n_reached, time
        if buffers.n_kinks > 0:
            begin_phases(model, state, time - time_origin, equation.piece[0], buffers.event_values[LAST_SAMPLE])
        min_stiff_steps = math.inf if is_held or model.parameters[0].is_conservative != 0 else 0.0
        max_step = _choose_max_step(model, limits.max_step, is_held)
        forget_gap_slopes(buffers)
        segment_limits = dop853.StepLimits(
            limits.tolerance, step, max_step, limits.max_steps, min_stiff_steps, limits.coarser_steps, limits.steps
        )
        status, step, n_new, segment_end = _integrate_to_event(
            equation, buffers, (time, end), time_origin, state, segment_limits, times[n_reached:], states[n_reached:]
        )
        if not is_held:
            counts[StepCounter.MOVING_EVALUATIONS] += END_STAGE * (counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED] - n_steps)
        for row in range(n_reached, n_reached + n_new):
            copy_array(modes[row], mode)
        n_reached += n_new
        is_simultaneous = segment_end - time <= SIMULTANEITY_TOLERANCE * time_scale
        event_log.counts[1] = event_log.counts[1] + 1 if status == IntegrationStatus.EVENT and is_simultaneous else 0
        if status != IntegrationStatus.EVENT or event_log.counts[1] >= MAX_SIMULTANEOUS_REDUCED_EVENTS:
            end_phases(model)
            return (IntegrationStatus.ENDLESS_EVENTS if status == IntegrationStatus.EVENT else status), step, n_reached, segment_end
        time, values = segment_end, buffers.event_values[LAST_SAMPLE]
        change_table_segments(model, values)
        selects_mode = is_any_positive(values, model.event_layout.table_ends)
        if selects_mode:
            is_released = is_held and max(values[model.event_layout.release_up], values[model.event_layout.release_down]) > 0.0
            step = min(step, POST_EVENT_STEP_RATIO * limits.max_step)


@jit_in_place
def _choose_max_step(model: ReducedModel, max_step: float, is_held: bool) -> float:
    """Return the largest step (s) up to the next event."""
    is_load_steady = model.parameters[0].fluctuation_amplitude == 0.0 and model.input_terms.size == 0
    return max_step * (HELD_STEP_FACTOR if is_held and is_load_steady else 1.0)


def initialise_contact_mode(equation: ReducedEquation, buffers: StepBuffers, time: float, state: FloatArray, event_log: EventLog) -> None:
    """Select the contact mode at a start or after a discontinuity of an input; the state must be on the table."""
    no_states = np.empty((0, state.size))
    no_modes = np.empty((0, equation.model.mode.size), dtype=np.int64)
    limits = dop853.StepLimits(1.0, 1.0, 1.0, 1, 0.0)
    integrate_reduced(equation, buffers, (time, time), time, np.empty(0), state, limits, no_states, no_modes, event_log, True)
