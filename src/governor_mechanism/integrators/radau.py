"""Radau IIA methods with error control and dense output for a stiff equation y' = f(t, y) given by compiled functions; compiled."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple

from governor_mechanism.integrators import radau_stages
from governor_mechanism.integrators.radau_stages import EPSILON
from governor_mechanism.integrators.radau_systems import RadauBuffers, factorise_matrices
from governor_mechanism.integrators.stages import Equation, StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.step_record import (
    INSIDE_STEP_TOLERANCE,
    NO_STEPS,
    StepRecord,
    find_step,
    limit_to_half_steps,
    record_step,
)
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

MAX_KEPT_RATE = 0.03
"""Rate of convergence of Newton's method up to which the next step keeps the Jacobian: another iteration costs more than its columns."""

MIN_STEPS_PER_JACOBIAN = 10
"""Steps in which a Jacobian serves, and one more for each of its columns, before it is evaluated in any case.

An equation that watches how its coordinates depend on each other sees it there. It costs one evaluation per step at most.
"""

MAX_KEPT_STEP_RATIO = 1.2
"""Factor up to which a step is not lengthened: its matrices serve again."""

MAX_PREDICTED_RATE = 0.3
"""Rate of convergence of Newton's method to which a step may be lengthened: the rate grows with the step at least in proportion."""

MIN_STEP_FACTOR, MAX_STEP_FACTOR, STEP_SAFETY_FACTOR = 0.2, 8.0, 0.9
"""Bounds of the factor from one step size to the next, and the factor on what the error allows."""

MIN_STEP_RATIO = 1e-13
"""Step size as a fraction of the interval below which an integration stalls: rounding of the time."""


class RadauLimits(NamedTuple):
    """Limits of one integration.

    Attributes
    ----------
    tolerance
        Error of one step, relative to the error scale.
    step
        First step size, s.
    max_steps
        Largest number of accepted and rejected steps together.
    coarser_steps
        Steps of another run: at most half of each is taken.
    steps
        Record of the steps.
    """

    tolerance: float
    step: float
    max_steps: int
    coarser_steps: StepRecord = NO_STEPS
    steps: StepRecord = NO_STEPS


@dataclass(frozen=True)
class StiffEquationFunctions(Generic[Equation]):
    """Compiled functions of a stiff equation; times are local, as those of its inputs.

    Qualities are negative where a state is outside the domain of the equation.

    Attributes
    ----------
    start_step
        Prepare the evaluations of a step from the present state.
    evaluate
        Fill the derivative at a time and state, count the evaluation, and return the quality; the last argument is the stage.
    evaluate_jacobian
        Fill the Jacobian (components, coupled components) at a time and state with a given derivative, and return the quality.
    finish_step
        Make a state at a time the present one, fill its derivative, and return how the integration goes on: DONE if nothing ends it.
    write_output
        Fill a row of outputs at a time from an interpolated state.
    """

    start_step: Callable[[Equation], None]
    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float]
    evaluate_jacobian: Callable[[Equation, float, FloatArray, FloatArray, FloatArray], float]
    finish_step: Callable[[Equation, float, FloatArray, FloatArray], IntegrationStatus]
    write_output: Callable[[Equation, float, FloatArray, FloatArray], None]


ImplicitIntegration = Callable[
    [Equation, RadauBuffers, tuple[float, float], float, FloatArray, RadauLimits, FloatArray, FloatArray],
    tuple[IntegrationStatus, float, int, float],
]
"""Integration of a state in place over a span (s).

Its arguments are the equation, buffers, the span, the time (s) from which local times count, the state, limits, and times (s) in
(start, end] with the rows of outputs to fill in there. It returns how it ended, the next step size (s), the number of times reached, and
the time of the state (s).

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd edition 1996, section IV.8.
"""


def make_radau(functions: StiffEquationFunctions[Equation]) -> ImplicitIntegration[Equation]:
    """Return the integration of an equation, to be called by a compiled function; the buffers choose the method.

    Parameters
    ----------
    functions
        Functions of the equation.

    Returns
    -------
    ImplicitIntegration[Equation]
        The integration.
    """
    start_step, evaluate_jacobian, finish_step = functions.start_step, functions.evaluate_jacobian, functions.finish_step
    iterate = jit_in_place(radau_stages.make_newton_iteration(functions.evaluate))
    estimate_error = jit_in_place(radau_stages.make_error_estimate(functions.evaluate))
    write_outputs = jit_in_place(_make_output(functions))

    def integrate(
        equation: Equation,
        buffers: RadauBuffers,
        span: tuple[float, float],
        time_origin: float,
        state: FloatArray,
        limits: RadauLimits,
        times: FloatArray,
        outputs: FloatArray,
    ) -> tuple[IntegrationStatus, float, int, float]:
        """Integrate a state in place over a span.

        Parameters
        ----------
        equation
            The equation.
        buffers
            Buffers of the steps, which choose the method.
        span
            Start and end, s.
        time_origin
            Time from which local times count, s.
        state
            State at the start; changed in place; shape (components,).
        limits
            Tolerance and limits of the steps.
        times
            Reported times in (start, end], s; shape (n,).
        outputs
            Result: outputs at the times reached; shape (n, outputs).

        Returns
        -------
        status : IntegrationStatus
            How the integration ended.
        step : float
            Next step size, s.
        n_reached : int
            Number of times reached.
        time : float
            Time of the state, s.
        """
        (t, end), step, counts, n_stages = span, limits.step, buffers.counts, buffers.increments.shape[0]
        duration, max_total = end - t, limits.max_steps + counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED]
        status = finish_step(equation, t - time_origin, state, buffers.start_derivative)
        has_jacobian, is_jacobian_current, factorised_h, previous_h, previous_error, rate = False, False, 0.0, 0.0, 1.0, 1.0
        is_doubtful, n_reached, jacobian_age, max_jacobian_age = True, 0, 0, MIN_STEPS_PER_JACOBIAN + buffers.jacobian.shape[1]
        coarser_step = find_step(limits.coarser_steps, t)
        while t < end:
            if status != IntegrationStatus.DONE:
                return status, step, n_reached, t
            if counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED] >= max_total:
                return IntegrationStatus.STEP_LIMIT, step, n_reached, t
            if not MIN_STEP_RATIO * duration <= step < math.inf:
                return IntegrationStatus.STALLED, step, n_reached, t
            longest, coarser_step = limit_to_half_steps(limits.coarser_steps, coarser_step, t, step)
            if longest < step and abs(longest - factorised_h) <= INSIDE_STEP_TOLERANCE * longest:
                longest = factorised_h  # the same but for rounding of the time: the matrices serve again
            is_last, is_cut = t + longest >= end, longest < step
            h, t_next = (end - t, end) if is_last else (longest, t + longest)
            start_step(equation)
            if not has_jacobian:
                if evaluate_jacobian(equation, t - time_origin, state, buffers.start_derivative, buffers.jacobian) < 0.0:
                    return IntegrationStatus.STALLED, step, n_reached, t
                has_jacobian, is_jacobian_current, factorised_h, jacobian_age = True, True, 0.0, 0
            n_iterations = 0
            if h != factorised_h:
                factorised_h = h if factorise_matrices(buffers, h) else 0.0
            if factorised_h > 0.0:
                if previous_h > 0.0:
                    radau_stages.predict_increments(buffers, previous_h, h)
                else:
                    buffers.increments[:] = 0.0
                n_iterations, rate = iterate(equation, buffers, t - time_origin, h, state, limits.tolerance, rate)
            if n_iterations == 0:
                counts[StepCounter.REJECTED] += 1
                step, is_doubtful = 0.5 * h if is_jacobian_current else h, True
                has_jacobian, previous_h = is_jacobian_current, 0.0 if is_jacobian_current else previous_h
                continue
            error = estimate_error(equation, buffers, t - time_origin, h, state, limits.tolerance, is_doubtful)
            error = max(error, 1e-10) if error < math.inf else math.inf
            safety = STEP_SAFETY_FACTOR * (4 * n_stages + 1) / (4 * n_stages + n_iterations)
            if not error <= 1.0:
                counts[StepCounter.REJECTED] += 1
                step, is_doubtful = h * max(MIN_STEP_FACTOR, safety * error ** (-1.0 / (n_stages + 1))), True
                continue
            counts[StepCounter.ACCEPTED] += 1
            n_reached = write_outputs(equation, buffers, time_origin, t, h, t_next, state, times, outputs, n_reached)
            radau_stages.finish_increments(buffers, state)
            max_factor = 1.0 if is_doubtful else min(MAX_STEP_FACTOR, max(1.0, MAX_PREDICTED_RATE / max(rate, EPSILON)))
            factor = min(max_factor, max(MIN_STEP_FACTOR, safety * _predict_factor(error, previous_error, h, previous_h, n_stages)))
            t, previous_h, previous_error, is_doubtful = t_next, h, max(error, 1e-2), False
            record_step(limits.steps, t, h, 1.0)
            status = finish_step(equation, t - time_origin, state, buffers.start_derivative)
            jacobian_age += 1
            has_jacobian, is_jacobian_current = rate <= MAX_KEPT_RATE and jacobian_age < max_jacobian_age, False
            if has_jacobian and 1.0 <= factor <= MAX_KEPT_STEP_RATIO:
                factor = 1.0
            # The last step, or half of another run's step, may be much shorter than its error allows.
            step = max(step, h * factor) if is_last or (is_cut and factor >= 1.0) else h * factor
        return status, step, n_reached, t

    return integrate


@jit_in_place
def _predict_factor(error: float, previous_error: float, h: float, previous_h: float, n_stages: int) -> float:
    """Return the factor on a step size h that its error allows, relative to the tolerance; previous_h is 0 in a first step.

    The error of the next step is expected to change as it has changed since the previous one (Gustafsson).
    """
    exponent = 1.0 / (n_stages + 1)
    factor: float = error**-exponent
    return min(factor, h / previous_h * (previous_error / error**2) ** exponent) if previous_h > 0.0 else factor


def _make_output(functions: StiffEquationFunctions[Equation]) -> Callable[..., int]:
    """Return the function that fills the outputs at the times within a step."""
    write_output = functions.write_output

    def write_outputs(
        equation: Equation,
        buffers: RadauBuffers,
        time_origin: float,
        t: float,
        h: float,
        t_next: float,
        state: FloatArray,
        times: FloatArray,
        outputs: FloatArray,
        n_reached: int,
    ) -> int:
        """Fill in the outputs at the times within an accepted step.

        Parameters
        ----------
        equation
            The equation.
        buffers
            Buffers with the increments of the step.
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
        outputs
            Result: outputs at the times; shape (n, outputs).
        n_reached
            Number of times that are filled in already.

        Returns
        -------
        int
            Number of times that are filled in now.
        """
        while n_reached < times.size and times[n_reached] <= t_next:
            radau_stages.interpolate_state(buffers, state, (times[n_reached] - t) / h, buffers.stage_state)
            write_output(equation, times[n_reached] - time_origin, buffers.stage_state, outputs[n_reached])
            n_reached += 1
        return n_reached

    return write_outputs
