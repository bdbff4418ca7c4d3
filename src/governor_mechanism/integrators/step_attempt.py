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
from governor_mechanism.integrators.stages import END_STAGE, N_STAGES, Equation, Stages
from governor_mechanism.integrators.tableau import NODES
from governor_mechanism.types import FloatArray


def make_attempt(functions: EquationFunctions[Equation]) -> Callable[..., tuple[float, float, float]]:
    """Return the function that tries a step.

    Parameters
    ----------
    functions
        Functions of the equation.

    Returns
    -------
    Callable
        The function, `attempt_step`.
    """
    take_step, project_errors = functions.take_step, functions.project_errors

    def attempt_step(
        equation: Equation,
        buffers: StepBuffers,
        local_time: float,
        h: float,
        state: FloatArray,
        quality: float,
        is_regular: bool,
        n_retries: int,
        tolerance: float,
    ) -> tuple[float, float, float]:
        """Try a step.

        Parameters
        ----------
        equation
            The equation.
        buffers
            Buffers of the steps; the stages hold the derivative at the start.
        local_time
            Local time at the start of the step, s.
        h
            Length of the step, s.
        state
            State at the start; shape (components,).
        quality
            Quality of the first stage.
        is_regular
            Whether the equation is not always singular.
        n_retries
            Number of lengths tried before beside a change point.
        tolerance
            Error of a step, relative to the error scale.

        Returns
        -------
        lowest_quality : float
            Lowest quality of the stages.
        error : float
            Error relative to the tolerance; negative if it was not estimated.
        retry_factor : float
            Factor on the length with which to try again; 0 if the step is accepted, or ends outside the domain.
        """
        stages = buffers.stages
        lowest_quality = min(quality, take_step(equation, local_time, h, state, stages))
        if lowest_quality < 0.0:
            return lowest_quality, -1.0, 0.25 if lowest_quality == FAR_OUTSIDE_DOMAIN else 0.0
        if is_regular and lowest_quality < min(MIN_STAGE_QUALITY, CROSSING_QUALITY_RATIO * quality) and n_retries < MAX_SINGULAR_RETRIES:
            return lowest_quality, -1.0, 0.83 if (n_retries + 1) % 8 else 3.1  # ever shorter, then longer once
        runge_kutta.estimate_errors(stages)
        if is_regular and lowest_quality < NEAR_SINGULAR_QUALITY:
            project_errors(equation, stages.errors)
        error = runge_kutta.evaluate_error_norm(stages, buffers.error_scale, h) / tolerance
        if error <= 1.0:
            return lowest_quality, error, 0.0
        return lowest_quality, error, max(0.2, 0.9 * error**-0.125) if math.isfinite(error) else 0.1

    return attempt_step


def make_output(functions: EquationFunctions[Equation]) -> Callable[..., tuple[int, float]]:
    """Return the function that fills in the states at the times within a step.

    Parameters
    ----------
    functions
        Functions of the equation.

    Returns
    -------
    Callable
        The function, `write_outputs`.
    """
    evaluate, project = functions.evaluate, functions.project

    def write_outputs(
        equation: Equation,
        stages: Stages,
        time_origin: float,
        t: float,
        h: float,
        t_next: float,
        state: FloatArray,
        times: FloatArray,
        states: FloatArray,
        n_reached: int,
    ) -> tuple[int, float]:
        """Fill in the states at the times within an accepted step.

        Parameters
        ----------
        equation
            The equation.
        stages
            Stages of the step.
        time_origin
            Time from which local times count, s.
        t
            Start of the step, s.
        h
            Length of the step, s.
        t_next
            End of the step, s.
        state
            State at the start of the step; shape (components,).
        times
            Reported times, s; shape (n,).
        states
            Result: states at the times; shape (n, components).
        n_reached
            Number of times that are filled in already.

        Returns
        -------
        n_reached : int
            Number of times that are filled in now.
        quality : float
            Quality of the additional stages; negative if one leaves the domain.
        """
        if n_reached >= times.size or times[n_reached] > t_next or not h > 0.0:
            return n_reached, 1.0
        for stage in range(END_STAGE + 1, N_STAGES):
            runge_kutta.combine_stages(stages, state, stage, h, stages.n_coupled, stages.stage_state)
            quality = evaluate(equation, t - time_origin + NODES[stage] * h, stages.stage_state, stages.derivatives, stage)
            if quality < 0.0:
                return n_reached, quality
        runge_kutta.prepare_dense_output(stages, state, h)
        while n_reached < times.size and times[n_reached] <= t_next:
            runge_kutta.evaluate_dense_output(stages, state, (times[n_reached] - t) / h, states[n_reached])
            project(equation, times[n_reached] - time_origin, states[n_reached])
            n_reached += 1
        return n_reached, 1.0

    return write_outputs
