"""One step of DOP853 that is tried, and the outputs within it when it is accepted; compiled."""

import math
from collections.abc import Callable

from governor_mechanism.integrators import stages as runge_kutta
from governor_mechanism.integrators.equation import EquationFunctions, StepBuffers
from governor_mechanism.integrators.stage_quality import (
    CROSSING_QUALITY_RATIO,
    FAR_OUTSIDE_DOMAIN,
    MAX_SINGULAR_RETRIES,
    MIN_STAGE_QUALITY,
    NEAR_SINGULAR_QUALITY,
)
from governor_mechanism.integrators.stages import END_STAGE, N_STAGES, Equation
from governor_mechanism.integrators.tableau import NODES
from governor_mechanism.types import FloatArray


def make_attempt(functions: EquationFunctions[Equation]) -> Callable[..., None]:
    """Return the function that tries the step of a length, and notes in the progress how good it is."""
    take_step, project_errors = functions.take_step, functions.project_errors

    def attempt_step(equation: Equation, buffers: StepBuffers, local_time: float, state: FloatArray, tolerance: float) -> None:
        stages, progress = buffers.stages, buffers.progress[0]
        is_regular, quality = progress.is_regular != 0, progress.quality
        lowest_quality = min(quality, take_step(equation, local_time, progress.h, state, stages))
        progress.lowest_quality = lowest_quality
        progress.error = -1.0
        progress.retry_factor = 0.0
        if lowest_quality < 0.0:
            if lowest_quality == FAR_OUTSIDE_DOMAIN:
                progress.retry_factor = 0.25
            return
        is_too_near = lowest_quality < min(MIN_STAGE_QUALITY, CROSSING_QUALITY_RATIO * quality)
        if is_regular and is_too_near and progress.n_retries < MAX_SINGULAR_RETRIES:
            progress.retry_factor = 0.83 if (progress.n_retries + 1) % 8 else 3.1  # ever shorter, then longer once
            return
        runge_kutta.estimate_errors(stages)
        if is_regular and lowest_quality < NEAR_SINGULAR_QUALITY:
            project_errors(equation, stages.errors)
        error = runge_kutta.evaluate_error_norm(stages, buffers.error_scale, progress.h) / tolerance
        progress.error = error
        if not error <= 1.0:
            progress.retry_factor = max(0.2, 0.9 * error**-0.125) if math.isfinite(error) else 0.1

    return attempt_step


def make_output(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that fills in the states at the times within an accepted step.

    It returns the quality of the additional stages, negative if one leaves the domain.
    """
    evaluate, project = functions.evaluate, functions.project

    def write_outputs(
        equation: Equation,
        buffers: StepBuffers,
        time_origin: float,
        state: FloatArray,
        times: FloatArray,  # reported times, s; shape (n,)
        states: FloatArray,  # result: states at the times; shape (n, components)
    ) -> float:
        stages, progress = buffers.stages, buffers.progress[0]
        t, h, t_next, n_reached = progress.t, progress.h, progress.t_next, progress.n_reached
        if n_reached >= times.size or times[n_reached] > t_next or not h > 0.0:
            return 1.0
        for stage in range(END_STAGE + 1, N_STAGES):
            runge_kutta.combine_stages(stages, state, stage, h, stages.n_coupled, stages.stage_state)
            quality = evaluate(equation, t - time_origin + NODES[stage] * h, stages.stage_state, stages.derivatives, stage)
            if quality < 0.0:
                return quality
        runge_kutta.prepare_dense_output(stages, state, h)
        while n_reached < times.size and times[n_reached] <= t_next:
            runge_kutta.evaluate_dense_output(stages, state, (times[n_reached] - t) / h, states[n_reached])
            project(equation, times[n_reached] - time_origin, states[n_reached])
            n_reached += 1
        progress.n_reached = n_reached
        return 1.0

    return write_outputs
