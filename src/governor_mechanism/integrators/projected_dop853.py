"""DOP853 with error control for a mechanism's state, projected onto its joints at every accepted step; compiled."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.integrators.event_location import bracket_first_event, evaluate_events_at_state
from governor_mechanism.integrators.tableau import DENSE_NODES, DENSE_STAGES, DENSE_WEIGHTS, ERROR_3, ERROR_5, NODES, STAGES, WEIGHTS
from governor_mechanism.mechanics.dynamics.constraint_solver import apply_jacobian, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative_inline, project_state_inline
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_SAMPLE_FRACTIONS
from governor_mechanism.numerics.banded_cholesky import solve_band_system
from governor_mechanism.numerics.jit import jit, jit_internal
from governor_mechanism.types import FloatArray, IntArray

INTEGRATION_DONE, INTEGRATION_STALLED, INTEGRATION_STEP_LIMIT, INTEGRATION_STIFF, INTEGRATION_EVENT = 0, 1, 2, 3, 4
"""How an integration ends: at its end; with a step too short to matter; with too many steps; where it gets stiff; where
something watched rose above nought."""

STALL_WINDOW_STEPS, MIN_PROGRESS_RATIO = 2000, 1e-6
"""So many steps that together get no farther than this fraction of the way get nowhere."""

STABILITY_LIMIT = 6.1
"""Step times largest rate of decay (Hairer's estimate) up to which the method is stable."""

NEAR_SINGULAR_PIVOT_RATIO, MIN_STAGE_PIVOT_RATIO = 1e-3, 1e-6
"""Independence of the rows (see `schur.solve`) below which stages are closed first, and at which no stage is taken.

Off its joints by d, a mechanism an angle e away from a change point has accelerations wrong by d / e^3. So the motion
is stepped across it: a step begins so far before it that it falls into the widest gap between stages, and one with a
stage within is tried at another length.
"""

STAGE_GAP_FRACTION = 0.466
"""The middle of the widest gap between stages, as a fraction of the step."""

STEERING_PIVOT_RATIO = 0.1
"""Independence of the rows below which steps are aimed."""

SINGULAR_CONSTRAINT_TOLERANCE_RATIO = 1e-3
"""So much tighter are joints closed near a change point: what they leave open counts there e times more."""

MAX_SINGULAR_RETRIES = 60
"""So many other lengths are tried."""

N_STIFF_STEPS, N_NONSTIFF_STEPS = 15, 6
"""So many steps at the limit of stability make a motion stiff, unless so many others come in between."""

MIN_STEPS_TO_SWITCH, MIN_STEPS_TO_SWITCH_PER_STATE = 300, 0.5
"""Fewer explicit steps than this, and for each number of the state so many more, are not worth implicit ones."""

N_COUNTERS = 4
"""Length of the counts: steps, rejected steps, evaluations, evaluations with joints that depend on each other."""


@jit
def integrate_projected_dop853(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    span: tuple[float, float],
    output_times: FloatArray,
    state: FloatArray,
    error_scale: FloatArray,
    tolerance: float,
    step: float,
    max_step: float,
    constraint_tolerance: float,
    max_steps: int,
    output_states: FloatArray,
    counters: IntArray,
    event_bracket: FloatArray,
) -> tuple[int, float, int, float]:
    """Take `state` in place from span[0] to span[1] (s), and fill `found` at the `times` (n,) in between.

    tolerance is the error of one step, relative to `scale`; longest (s) bounds the step. cubics (programs, 4) are of
    the time since span[0]. Returns how it ended, the last length of a step, how many of the times were reached, and the
    time (s) that state is at. Where something watched crosses nought within a step, state is as before that step, and
    crossed (2,) holds the times (s) between which it does.
    """
    start, end = span
    stage_derivatives, stage_state, state_end = np.zeros((16, state.size)), np.empty(state.size), np.empty(state.size)
    last_stage_state = np.empty(state.size)
    dense_coefficients = np.empty((7, state.size))
    is_full_rank = (
        _evaluate_stage_derivative(system, workspace, input_cubics, 0.0, state, stage_derivatives[0], counters, constraint_tolerance) > 0.0
    )  # else joints are redundant
    t, n_reached, n_stiff, n_nonstiff, n_retries = start, 0, 0, 0, 0
    pivot_ratio = previous_pivot_ratio = 1.0
    progress_time, progress_steps = start, counters[0]
    has_events = system.event_functions.size > 0
    event_values = np.empty((EVENT_SAMPLE_FRACTIONS.size, system.event_functions.size))
    state_start, derivative_start = np.empty(state.size), np.empty(state.size)
    if has_events:
        evaluate_events_at_state(system, workspace, input_cubics, 0.0, state, event_values[0])
    while t < end:
        if counters[0] + counters[1] >= max_steps:
            return INTEGRATION_STEP_LIMIT, step, n_reached, t
        if step < 1e-13 * (end - start) or not math.isfinite(step):
            return INTEGRATION_STALLED, step, n_reached, t
        if counters[0] - progress_steps >= STALL_WINDOW_STEPS:
            if t - progress_time < MIN_PROGRESS_RATIO * (end - start):
                return INTEGRATION_STALLED, step, n_reached, t
            progress_time, progress_steps = t, counters[0]
        step = min(step, max_step)
        is_last_step = t + step >= end
        h = end - t if is_last_step else step
        min_pivot_ratio = pivot_ratio
        for stage in range(1, 12):
            _combine_stages(state, stage_derivatives, STAGES[stage], stage, h, stage_state)
            local_time = t - start + NODES[stage] * h
            min_pivot_ratio = min(
                min_pivot_ratio,
                _evaluate_stage_derivative(
                    system, workspace, input_cubics, local_time, stage_state, stage_derivatives[stage], counters, constraint_tolerance
                ),
            )
        last_stage_state[:] = stage_state
        _combine_stages(state, stage_derivatives, WEIGHTS, 12, h, state_end)
        min_pivot_ratio = min(
            min_pivot_ratio,
            _evaluate_stage_derivative(
                system, workspace, input_cubics, t - start + h, state_end, stage_derivatives[12], counters, constraint_tolerance
            ),
        )
        if is_full_rank and min_pivot_ratio < MIN_STAGE_PIVOT_RATIO and n_retries < MAX_SINGULAR_RETRIES:
            n_retries += 1
            counters[1] += 1
            step = h * (0.83 if n_retries % 8 else 3.1)  # shorter and shorter, then longer again
            continue
        error_norm = (
            _compute_error_norm(
                system, workspace, stage_derivatives, error_scale, h, is_full_rank and min_pivot_ratio < NEAR_SINGULAR_PIVOT_RATIO
            )
            / tolerance
        )
        if not error_norm <= 1.0:
            counters[1] += 1
            step = h * (max(0.2, 0.9 * error_norm**-0.125) if math.isfinite(error_norm) else 0.1)
            continue
        counters[0] += 1
        n_retries = 0
        t_next = end if is_last_step else t + h
        t_start, n_reached_before = t, n_reached
        if n_reached < output_times.size and output_times[n_reached] <= t_next:
            for extra_stage in range(3):
                _combine_stages(state, stage_derivatives, DENSE_STAGES[extra_stage], 13 + extra_stage, h, stage_state)
                _evaluate_stage_derivative(
                    system,
                    workspace,
                    input_cubics,
                    t - start + DENSE_NODES[extra_stage] * h,
                    stage_state,
                    stage_derivatives[13 + extra_stage],
                    counters,
                    constraint_tolerance,
                )
            _prepare_dense_output(state, state_end, stage_derivatives, h, dense_coefficients)
            while n_reached < output_times.size and output_times[n_reached] <= t_next:
                _evaluate_dense_output(state, dense_coefficients, (output_times[n_reached] - t) / h, output_states[n_reached])
                _project_state_vector(
                    system, workspace, input_cubics, output_times[n_reached] - start, output_states[n_reached], constraint_tolerance
                )
                n_reached += 1
        at_stability_limit = (
            h * _estimate_dominant_eigenvalue(stage_derivatives, state_end, last_stage_state, error_scale) > STABILITY_LIMIT
        )
        if has_events:
            state_start[:], derivative_start[:] = state, stage_derivatives[0]
        state[:] = state_end
        t = t_next
        _project_state_vector(
            system,
            workspace,
            input_cubics,
            t - start,
            state,
            constraint_tolerance
            if min_pivot_ratio > NEAR_SINGULAR_PIVOT_RATIO
            else SINGULAR_CONSTRAINT_TOLERANCE_RATIO * constraint_tolerance,
        )
        previous_pivot_ratio, pivot_ratio = (
            pivot_ratio,
            _evaluate_stage_derivative(
                system, workspace, input_cubics, t - start, state, stage_derivatives[0], counters, constraint_tolerance
            ),
        )
        if has_events:
            evaluate_events_at_state(system, workspace, input_cubics, t - start, state, event_values[EVENT_SAMPLE_FRACTIONS.size - 1])
            low, high = bracket_first_event(
                system,
                workspace,
                input_cubics,
                t_start - start,
                h,
                state_start,
                derivative_start,
                state,
                stage_derivatives[0],
                stage_state,
                last_stage_state,
                event_values,
                counters,
            )
            if high <= 1.0:
                event_bracket[0], event_bracket[1] = t_start + low * h, t_start + high * h if high < 1.0 else t
                state[:] = state_start
                return INTEGRATION_EVENT, h, n_reached_before, t_start
            event_values[0] = event_values[EVENT_SAMPLE_FRACTIONS.size - 1]
        step_factor = min(6.0, max(0.3, 0.9 * max(error_norm, 1e-30) ** -0.125))
        step = max(step, h * step_factor) if is_last_step else h * step_factor  # a last step may be cut to next to nothing
        n_stiff, n_nonstiff = (n_stiff + 1, 0) if at_stability_limit else (n_stiff, n_nonstiff + 1)
        if n_nonstiff >= N_NONSTIFF_STEPS:
            n_stiff = 0
        if is_full_rank and pivot_ratio < min(previous_pivot_ratio, STEERING_PIVOT_RATIO):
            step = _steer_step_over_singularity(math.sqrt(pivot_ratio), math.sqrt(previous_pivot_ratio), h, step)
        if n_stiff >= N_STIFF_STEPS and not has_events and end - t > (MIN_STEPS_TO_SWITCH + MIN_STEPS_TO_SWITCH_PER_STATE * state.size) * h:
            return INTEGRATION_STIFF, step, n_reached, t
    return INTEGRATION_DONE, step, n_reached, t


@jit_internal
def _steer_step_over_singularity(angle: float, previous_angle: float, h: float, step: float) -> float:
    """The next step so that a change point lies in the gap between stages; near, far: angles from it, h apart."""
    time_to_singularity = angle * h / (previous_angle - angle)
    time_to_step_start = time_to_singularity - STAGE_GAP_FRACTION * step
    if time_to_step_start > step:  # two steps or more away
        return step
    if time_to_step_start > 0.0:  # stop where the step after this one crosses it in its gap
        return max(time_to_step_start, 0.02 * step)
    return time_to_singularity / STAGE_GAP_FRACTION if time_to_singularity > 0.1 * step else step


@jit_internal
def _evaluate_stage_derivative(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    local_time: float,
    state: FloatArray,
    derivative: FloatArray,
    counters: IntArray,
    constraint_tolerance: float,
) -> float:
    """The slope at a state, with joints closed first near a change point; how independent their rows are."""
    pivot_ratio = evaluate_state_derivative_inline(system, workspace, input_cubics, local_time, state, derivative)
    counters[2] += 1
    if 0.0 < pivot_ratio < NEAR_SINGULAR_PIVOT_RATIO:
        projected_state = state.copy()
        _project_state_vector(
            system, workspace, input_cubics, local_time, projected_state, SINGULAR_CONSTRAINT_TOLERANCE_RATIO * constraint_tolerance
        )
        pivot_ratio = evaluate_state_derivative_inline(system, workspace, input_cubics, local_time, projected_state, derivative)
        counters[2] += 1
    if pivot_ratio == 0.0:
        counters[3] += 1
    return pivot_ratio


@jit_internal
def _project_state_vector(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray, constraint_tolerance: float
) -> None:
    n_bodies = system.bodies.size
    poses, velocities = (state[: 3 * n_bodies].reshape(n_bodies, 3), state[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3))
    project_state_inline(system, workspace, input_cubics, local_time, poses, velocities, constraint_tolerance)


@jit_internal
def _combine_stages(
    state: FloatArray, stage_derivatives: FloatArray, weights: FloatArray, n_stages: int, h: float, result: FloatArray
) -> None:
    for i in range(state.size):
        total = 0.0
        for k in range(n_stages):
            total += weights[k] * stage_derivatives[k, i]
        result[i] = state[i] + h * total


@jit_internal
def _compute_error_norm(
    system: System, workspace: SystemWorkspace, stage_derivatives: FloatArray, error_scale: FloatArray, h: float, near_singular: bool
) -> float:
    """The error of one step, as Hairer combines those of order 5 and 3.

    Near a change point what opens joints is taken out of it first: the projection after the step does the same.
    """
    error_5, error_3 = np.empty(error_scale.size), np.empty(error_scale.size)
    for i in range(error_scale.size):
        error_5[i] = error_3[i] = 0.0
        for k in range(13):
            error_5[i] += ERROR_5[k] * stage_derivatives[k, i]
            error_3[i] += ERROR_3[k] * stage_derivatives[k, i]
    if near_singular:
        _project_error(system, workspace, error_5)
        _project_error(system, workspace, error_3)
    sum_5 = sum_3 = 0.0
    for i in range(error_scale.size):
        sum_5 += (error_5[i] / error_scale[i]) ** 2
        sum_3 += (error_3[i] / error_scale[i]) ** 2
    if sum_5 == 0.0 and sum_3 == 0.0:
        return 0.0
    return h * sum_5 / math.sqrt((sum_5 + 0.01 * sum_3) * error_scale.size)


@jit_internal
def _project_error(system: System, workspace: SystemWorkspace, error: FloatArray) -> None:
    """Leave of an error in poses and velocities what opens no joint, at the poses last evaluated."""
    n_bodies = system.bodies.size
    for block in range(2):
        error_block = error[3 * n_bodies * block : 3 * n_bodies * (block + 1)].reshape(n_bodies, 3)
        apply_jacobian(system.constraint_rows.row_bodies, workspace.jacobian, error_block, workspace.multipliers)
        solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
        subtract_minv_jt(system.constraint_rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, error_block)


@jit_internal
def _estimate_dominant_eigenvalue(
    stage_derivatives: FloatArray, state_end: FloatArray, last_stage_state: FloatArray, error_scale: FloatArray
) -> float:
    """The fastest rate (1/s) at which neighbouring motions come together, as the last two stages tell it."""
    derivative_difference = state_difference = 0.0
    for i in range(error_scale.size):
        derivative_difference += ((stage_derivatives[12, i] - stage_derivatives[11, i]) / error_scale[i]) ** 2
        state_difference += ((state_end[i] - last_stage_state[i]) / error_scale[i]) ** 2
    return math.sqrt(derivative_difference / state_difference) if state_difference > 0.0 else 0.0


@jit_internal
def _prepare_dense_output(
    state: FloatArray, state_end: FloatArray, stage_derivatives: FloatArray, h: float, dense_coefficients: FloatArray
) -> None:
    for i in range(state.size):
        increment = state_end[i] - state[i]
        dense_coefficients[0, i] = increment
        dense_coefficients[1, i] = h * stage_derivatives[0, i] - increment
        dense_coefficients[2, i] = 2.0 * increment - h * (stage_derivatives[12, i] + stage_derivatives[0, i])
        for r in range(4):
            total = 0.0
            for k in range(16):
                total += DENSE_WEIGHTS[r, k] * stage_derivatives[k, i]
            dense_coefficients[3 + r, i] = h * total


@jit_internal
def _evaluate_dense_output(state: FloatArray, dense_coefficients: FloatArray, theta: float, result: FloatArray) -> None:
    for i in range(state.size):
        total = 0.0
        for r in range(6, -1, -1):
            total = (total + dense_coefficients[r, i]) * (theta if r % 2 == 0 else 1.0 - theta)
        result[i] = state[i] + total
