"""DOP853 with error control for the state of a mechanism, projected onto its constraints after every accepted step; compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from governor_mechanism.integrators.event_location import bracket_first_event
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.tableau import DENSE_NODES, DENSE_STAGES, DENSE_WEIGHTS, ERROR_3, ERROR_5, NODES, STAGES, WEIGHTS
from governor_mechanism.mechanics.dynamics.constraint_solver import apply_jacobian, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.equations_of_motion import (
    evaluate_event_functions,
    evaluate_state_derivative_inline,
    project_state_inline,
)
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.output_forces import EVENT_SAMPLE_FRACTIONS
from governor_mechanism.numerics.banded_cholesky import solve_band_system
from governor_mechanism.numerics.jit import jit, jit_internal
from governor_mechanism.types import FloatArray, IntArray

STALL_WINDOW_STEPS, MIN_PROGRESS_RATIO = 2000, 1e-6
"""An integration stalls when this many accepted steps advance less than this fraction of the interval."""

STABILITY_LIMIT = 6.1
"""Limit of step size times dominant eigenvalue (Hairer's estimate) up to which DOP853 is stable."""

NEAR_SINGULAR_PIVOT_RATIO, MIN_STAGE_PIVOT_RATIO = 1e-3, 1e-6
"""Pivot ratio of J M^-1 J^T (see `solve_band_system`) below which stages are projected, and below which a step is retried.

At an angle e from a change point, a constraint violation d causes an acceleration error of order d / e^3. The step is
therefore placed so that the change point falls into the widest gap between stages. A step with a stage too close to
the change point is repeated with another length.
"""

STAGE_GAP_FRACTION = 0.466
"""Middle of the widest gap between the stage nodes, as a fraction of the step."""

STEERING_PIVOT_RATIO = 0.1
"""Pivot ratio below which step sizes are steered so that the change point falls into the gap between stages."""

SINGULAR_CONSTRAINT_TOLERANCE_RATIO = 1e-3
"""Factor on the constraint tolerance near a change point, where the error that a violation causes grows like 1 / e."""

MAX_SINGULAR_RETRIES = 60
"""Largest number of other step lengths tried at one change point."""

N_STIFF_STEPS, N_NONSTIFF_STEPS = 15, 6
"""Number of steps at the stability limit that make a motion stiff, and number of other steps that resets the count."""

MIN_STEPS_TO_SWITCH, MIN_STEPS_TO_SWITCH_PER_STATE = 300, 0.5
"""Fewest remaining explicit steps, and additional ones per component of the state, that justify an implicit method."""


class StepLimits(NamedTuple):
    """Limits of one integration.

    Attributes
    ----------
    tolerance
        Error of one step, relative to the error scale.
    step
        First step size, s.
    max_step
        Largest step size, s.
    max_steps
        Largest number of accepted and rejected steps together.
    """

    tolerance: float
    step: float
    max_step: float
    max_steps: int


N_COUNTERS = 4
"""Number of counters: accepted steps, rejected steps, evaluations, evaluations with linearly dependent constraint rows."""


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
) -> tuple[IntegrationStatus, float, int, float]:
    """Integrate the state of a mechanism in place over an interval without breakpoints of its inputs.

    Parameters
    ----------
    system
        Mechanism, force elements and contact mode as arrays.
    workspace
        Arrays of one evaluation, overwritten.
    input_cubics
        Local cubics of the input functions, in the time since span[0], and their integrals; shape (functions, 5).
    span
        Start and end of the interval, s.
    output_times
        Times in (start, end] at which the state is wanted, s, ascending; shape (n,).
    state
        Poses and velocities of the body origins the energy states and the lags, overwritten; shape (6 bodies + N_ENERGY_STATES + lags,).
    error_scale
        Scale of every component of the state; shape of `state`.
    tolerance
        Error of one step, relative to `error_scale`.
    step
        First step size, s.
    max_step
        Largest step size, s.
    constraint_tolerance
        Largest constraint violation left by the projection, m.
    max_steps
        Largest number of accepted and rejected steps together.
    output_states
        States at `output_times`, filled in; shape (n, states).
    counters
        Counters, increased; shape (N_COUNTERS,).
    event_bracket
        Times between which an event function first becomes positive, s, filled in; shape (2,).

    Returns
    -------
    tuple[IntegrationStatus, float, int, float]
        How the integration ended, the next step size (s), the number of output times reached, and the time of `state` (s).
        When an event function becomes positive within a step, `state` is the one before that step.

    References
    ----------
    E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd edition 1993, section II.10.
    """
    start, end = span
    stage_derivatives, stage_state, state_end = np.zeros((16, state.size)), np.empty(state.size), np.empty(state.size)
    last_stage_state = np.empty(state.size)
    dense_coefficients = np.empty((7, state.size))
    is_full_rank = (
        _evaluate_stage_derivative(system, workspace, input_cubics, 0.0, state, stage_derivatives[0], counters, constraint_tolerance) > 0.0
    )  # otherwise constraints are redundant
    t, n_reached, n_stiff, n_nonstiff, n_retries = start, 0, 0, 0, 0
    pivot_ratio = previous_pivot_ratio = 1.0
    progress_time, progress_steps = start, counters[0]
    has_events = system.event_functions.size > 0
    event_values = np.empty((EVENT_SAMPLE_FRACTIONS.size, system.event_functions.size))
    state_start, derivative_start = np.empty(state.size), np.empty(state.size)
    if has_events:
        evaluate_event_functions(system, workspace, state, event_values[0])
    while t < end:
        if counters[0] + counters[1] >= max_steps:
            return IntegrationStatus.STEP_LIMIT, step, n_reached, t
        if step < 1e-13 * (end - start) or not math.isfinite(step):
            return IntegrationStatus.STALLED, step, n_reached, t
        if counters[0] - progress_steps >= STALL_WINDOW_STEPS:
            if t - progress_time < MIN_PROGRESS_RATIO * (end - start):
                return IntegrationStatus.STALLED, step, n_reached, t
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
            step = h * (0.83 if n_retries % 8 else 3.1)  # ever shorter, then longer once
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
            evaluate_event_functions(system, workspace, state, event_values[EVENT_SAMPLE_FRACTIONS.size - 1])
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
                return IntegrationStatus.EVENT, step, n_reached_before, t_start  # not h, which the end may have cut very short
            event_values[0] = event_values[EVENT_SAMPLE_FRACTIONS.size - 1]
        step_factor = min(6.0, max(0.3, 0.9 * max(error_norm, 1e-30) ** -0.125))
        step = max(step, h * step_factor) if is_last_step else h * step_factor  # the last step may be cut very short
        n_stiff, n_nonstiff = (n_stiff + 1, 0) if at_stability_limit else (n_stiff, n_nonstiff + 1)
        if n_nonstiff >= N_NONSTIFF_STEPS:
            n_stiff = 0
        if is_full_rank and pivot_ratio < min(previous_pivot_ratio, STEERING_PIVOT_RATIO):
            step = _steer_step_over_singularity(math.sqrt(pivot_ratio), math.sqrt(previous_pivot_ratio), h, step)
        if n_stiff >= N_STIFF_STEPS and not has_events and end - t > (MIN_STEPS_TO_SWITCH + MIN_STEPS_TO_SWITCH_PER_STATE * state.size) * h:
            return IntegrationStatus.STIFF, step, n_reached, t
    return IntegrationStatus.DONE, step, n_reached, t


@dataclass(frozen=True)
class ProjectedDop853:
    """DOP853 with projection for the states of one mechanism.

    Attributes
    ----------
    error_scale
        Scale of every component of the state.
    constraint_tolerance
        Largest constraint violation left by the projection, m.
    """

    error_scale: FloatArray
    constraint_tolerance: float

    def integrate(
        self,
        model: tuple[System, SystemWorkspace],
        input_cubics: FloatArray,
        span: tuple[float, float],
        state: FloatArray,
        limits: StepLimits,
        counters: IntArray,
        outputs: tuple[FloatArray, FloatArray] | None = None,
        event_bracket: FloatArray | None = None,
    ) -> tuple[IntegrationStatus, float, int, float]:
        """Call `integrate_projected_dop853`; outputs are the output times and the states to fill in."""
        (system, workspace), (tolerance, step, max_step, max_steps) = model, limits
        output_times, output_states = outputs or (np.empty(0), np.empty((0, state.size)))
        bracket = np.empty(2) if event_bracket is None else event_bracket
        scale, gap = self.error_scale, self.constraint_tolerance
        return integrate_projected_dop853(
            system, workspace, input_cubics, span, output_times, state, scale, tolerance, step, max_step, gap, max_steps, output_states,
            counters, bracket,
        )  # fmt: skip


@jit_internal
def _steer_step_over_singularity(angle: float, previous_angle: float, h: float, step: float) -> float:
    """Return the next step size that places the change point in the gap between stages, from its angles one step h apart."""
    time_to_singularity = angle * h / (previous_angle - angle)
    time_to_step_start = time_to_singularity - STAGE_GAP_FRACTION * step
    if time_to_step_start > step:  # at least two steps away
        return step
    if time_to_step_start > 0.0:  # end this step where the next one has the singularity in its gap
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
    """Evaluate the state derivative, near a change point after a projection, and return the pivot ratio of the constraint rows."""
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
    """Project poses and velocities of a state vector onto the constraints."""
    n_bodies = system.bodies.size
    poses, velocities = (state[: 3 * n_bodies].reshape(n_bodies, 3), state[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3))
    project_state_inline(system, workspace, input_cubics, local_time, poses, velocities, constraint_tolerance)


@jit_internal
def _combine_stages(
    state: FloatArray, stage_derivatives: FloatArray, weights: FloatArray, n_stages: int, h: float, result: FloatArray
) -> None:
    """Fill `result` with the state plus h times a weighted sum of the stage derivatives."""
    for i in range(state.size):
        total = 0.0
        for k in range(n_stages):
            total += weights[k] * stage_derivatives[k, i]
        result[i] = state[i] + h * total


@jit_internal
def _compute_error_norm(
    system: System, workspace: SystemWorkspace, stage_derivatives: FloatArray, error_scale: FloatArray, h: float, near_singular: bool
) -> float:
    """Return the error of one step, from Hairer's combination of the estimates of order 5 and 3.

    Near a change point the part that violates the constraints is removed first, because the projection removes it after the step.
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
    """Remove from an error of poses and velocities what violates the constraints, at the poses of the last evaluation."""
    n_bodies = system.bodies.size
    for block in range(2):
        error_block = error[3 * n_bodies * block : 3 * n_bodies * (block + 1)].reshape(n_bodies, 3)
        apply_jacobian(system.constraint_rows.row_bodies, workspace.jacobian, error_block, workspace.multipliers)
        solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
        subtract_minv_jt(system.constraint_rows.row_bodies, workspace.jacobian, workspace.inverse_mass, workspace.multipliers, error_block)


@jit_internal
def _estimate_dominant_eigenvalue(
    stage_derivatives: FloatArray, state_end: FloatArray, last_stage_state: FloatArray, error_scale: FloatArray
) -> float:
    """Return Hairer's estimate of the largest eigenvalue (1/s) from the last two stages."""
    derivative_difference = state_difference = 0.0
    for i in range(error_scale.size):
        derivative_difference += ((stage_derivatives[12, i] - stage_derivatives[11, i]) / error_scale[i]) ** 2
        state_difference += ((state_end[i] - last_stage_state[i]) / error_scale[i]) ** 2
    return math.sqrt(derivative_difference / state_difference) if state_difference > 0.0 else 0.0


@jit_internal
def _prepare_dense_output(
    state: FloatArray, state_end: FloatArray, stage_derivatives: FloatArray, h: float, dense_coefficients: FloatArray
) -> None:
    """Fill in the coefficients (7, states) of the interpolant of order 7."""
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
    """Evaluate the interpolant at a fraction theta of the step."""
    for i in range(state.size):
        total = 0.0
        for r in range(6, -1, -1):
            total = (total + dense_coefficients[r, i]) * (theta if r % 2 == 0 else 1.0 - theta)
        result[i] = state[i] + total
