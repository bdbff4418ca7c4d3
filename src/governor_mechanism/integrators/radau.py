"""Radau IIA methods with error control and dense output for a stiff equation y' = f(t, y) given by compiled functions; compiled."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple

from governor_mechanism.integrators import radau_stages
from governor_mechanism.integrators.radau_stages import EPSILON, RadauBuffers, factorise_matrices
from governor_mechanism.integrators.stages import Equation, StepCounter
from governor_mechanism.integrators.step_record import (
    INSIDE_STEP_TOLERANCE,
    NO_STEPS,
    IntegrationStatus,
    StepRecord,
    find_step,
    limit_to_half_steps,
    record_step,
)
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray, RecordArray

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

MIN_STEP_FACTOR = 0.2
MAX_STEP_FACTOR = 8.0
STEP_SAFETY_FACTOR = 0.9
"""Bounds of the factor from one step size to the next, and the factor on what the error allows."""

MIN_STEP_RATIO = 1e-13
"""Step size as a fraction of the interval below which an integration stalls: rounding of the time."""


class RadauLimits(NamedTuple):
    """Limits of one integration."""

    tolerance: float  # error of one step, relative to the error scale
    step: float  # first step size, s
    max_steps: int  # largest number of accepted and rejected steps together
    coarser_steps: StepRecord = NO_STEPS  # steps of another run: at most half of each is taken
    steps: StepRecord = NO_STEPS  # record of the steps


@dataclass(frozen=True)
class StiffEquationFunctions(Generic[Equation]):
    """Compiled functions of a stiff equation, in local times, as its inputs; qualities are negative outside its domain."""

    start_step: Callable[[Equation], None]  # prepare the evaluations of a step from the present state
    # fill the derivative at a time and state, count the evaluation, and return the quality; the last argument
    # is the stage
    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float]
    # fill the Jacobian (components, coupled components) at a time and state with a given derivative, and
    # return the quality
    evaluate_jacobian: Callable[[Equation, float, FloatArray, FloatArray, FloatArray], float]
    # make a state at a time the present one, fill its derivative, and return how the integration goes on:
    # DONE if nothing ends it
    finish_step: Callable[[Equation, float, FloatArray, FloatArray], IntegrationStatus]
    # fill a row of outputs at a time from an interpolated state
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
    """Return the integration of an equation, to be called by a compiled function; the buffers choose the method."""
    start_step, finish_step = functions.start_step, functions.finish_step
    solve_step = jit_in_place(_make_solution(functions))
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
        """Integrate a state in place over a span; see `ImplicitIntegration`."""
        progress = buffers.progress[0]
        counts = buffers.counts
        end = span[1]
        set_radau_progress(progress, span[0], limits)
        max_total = limits.max_steps + count_steps(counts)
        min_step = MIN_STEP_RATIO * (end - span[0])
        progress.status = finish_step(equation, span[0] - time_origin, state, buffers.start_derivative)
        while progress.status == IntegrationStatus.DONE and progress.t < end:
            local_time = progress.t - time_origin
            if count_steps(counts) >= max_total:
                progress.status = IntegrationStatus.STEP_LIMIT
                break
            if not min_step <= progress.step < math.inf:
                progress.status = IntegrationStatus.STALLED
                break
            choose_radau_step(progress, limits, end)
            start_step(equation)
            solve_step(equation, buffers, local_time, state, limits.tolerance)
            if progress.status != IntegrationStatus.DONE:
                break
            if progress.n_iterations == 0:
                counts[StepCounter.REJECTED] += 1
                retry_unsolved_step(progress)
                continue
            is_doubtful = progress.is_doubtful != 0
            error = estimate_error(equation, buffers, local_time, progress.h, state, limits.tolerance, is_doubtful)
            progress.error = max(error, 1e-10) if error < math.inf else math.inf
            factor = choose_step_factor(progress, buffers.increments.shape[0])
            if not progress.error <= 1.0:
                counts[StepCounter.REJECTED] += 1
                progress.step = progress.h * factor
                progress.is_doubtful = 1
                continue
            counts[StepCounter.ACCEPTED] += 1
            write_outputs(equation, buffers, time_origin, state, times, outputs)
            radau_stages.finish_increments(buffers, state)
            advance(progress, limits, factor, MIN_STEPS_PER_JACOBIAN + buffers.jacobian.shape[1])
            progress.status = finish_step(equation, progress.t - time_origin, state, buffers.start_derivative)
        return progress.status, progress.step, progress.n_reached, progress.t

    return integrate


@jit_in_place
def count_steps(counts: IntArray) -> int:
    """Return the number of accepted and rejected steps."""
    return int(counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED])


@jit_in_place
def set_radau_progress(progress: RecordArray, t: float, limits: RadauLimits) -> None:
    """Set the progress at the start of a span."""
    progress.status = IntegrationStatus.DONE
    progress.t = t
    progress.step = limits.step
    progress.has_jacobian = progress.is_jacobian_current = progress.jacobian_age = progress.n_reached = 0
    progress.factorised_h = progress.previous_h = 0.0
    progress.previous_error = progress.rate = 1.0
    progress.is_doubtful = 1
    progress.coarser_step = find_step(limits.coarser_steps, t)


@jit_in_place
def choose_radau_step(progress: RecordArray, limits: RadauLimits, end: float) -> None:
    """Choose length and end of the next step: at most half of each step of another run."""
    longest, progress.coarser_step = limit_to_half_steps(limits.coarser_steps, progress.coarser_step, progress.t, progress.step)
    if longest < progress.step and abs(longest - progress.factorised_h) <= INSIDE_STEP_TOLERANCE * longest:
        longest = progress.factorised_h  # the same but for rounding of the time: the matrices serve again
    progress.is_cut = longest < progress.step
    progress.is_last = progress.t + longest >= end
    progress.h = end - progress.t if progress.is_last else longest
    progress.t_next = end if progress.is_last else progress.t + longest


def _make_solution(functions: StiffEquationFunctions[Equation]) -> Callable[..., None]:
    """Return the function that solves the equations of a step, with the Jacobian and the matrices that it keeps or makes."""
    evaluate_jacobian = functions.evaluate_jacobian
    iterate = jit_in_place(radau_stages.make_newton_iteration(functions.evaluate))

    def solve_step(equation: Equation, buffers: RadauBuffers, local_time: float, state: FloatArray, tolerance: float) -> None:
        progress = buffers.progress[0]
        progress.n_iterations = 0
        if not progress.has_jacobian:
            if evaluate_jacobian(equation, local_time, state, buffers.start_derivative, buffers.jacobian) < 0.0:
                progress.status = IntegrationStatus.STALLED
                return
            progress.has_jacobian = progress.is_jacobian_current = 1
            progress.factorised_h = 0.0
            progress.jacobian_age = 0
        if progress.h != progress.factorised_h:
            progress.factorised_h = progress.h if factorise_matrices(buffers, progress.h) else 0.0
        if progress.factorised_h > 0.0:
            if progress.previous_h > 0.0:
                radau_stages.predict_increments(buffers, progress.previous_h, progress.h)
            else:
                buffers.increments[:] = 0.0
            progress.n_iterations, progress.rate = iterate(equation, buffers, local_time, progress.h, state, tolerance, progress.rate)

    return solve_step


@jit_in_place
def retry_unsolved_step(progress: RecordArray) -> None:
    """Try again with a new Jacobian, or with half the step if the Jacobian is that of the present state."""
    progress.is_doubtful = 1
    progress.step = progress.h
    if progress.is_jacobian_current:
        progress.step = 0.5 * progress.h
        progress.previous_h = 0.0
    progress.has_jacobian = progress.is_jacobian_current


@jit_in_place
def choose_step_factor(progress: RecordArray, n_stages: int) -> float:
    """Return the factor on the step size that the error allows, for the next step or for the same one after a rejection."""
    error = progress.error
    safety = STEP_SAFETY_FACTOR * (4 * n_stages + 1) / (4 * n_stages + progress.n_iterations)
    if not error <= 1.0:
        return float(max(MIN_STEP_FACTOR, safety * error ** (-1.0 / (n_stages + 1))))
    max_factor = 1.0 if progress.is_doubtful else min(MAX_STEP_FACTOR, max(1.0, MAX_PREDICTED_RATE / max(progress.rate, EPSILON)))
    predicted = _predict_factor(error, progress.previous_error, progress.h, progress.previous_h, n_stages)
    return float(min(max_factor, max(MIN_STEP_FACTOR, safety * predicted)))


@jit_in_place
def advance(progress: RecordArray, limits: RadauLimits, factor: float, max_jacobian_age: int) -> None:
    """Go on behind an accepted step, with another step size."""
    h = progress.h
    progress.t = progress.t_next
    progress.previous_h = h
    progress.previous_error = max(progress.error, 1e-2)
    progress.is_doubtful = progress.is_jacobian_current = 0
    record_step(limits.steps, progress.t, h, 1.0)
    progress.jacobian_age += 1
    progress.has_jacobian = progress.rate <= MAX_KEPT_RATE and progress.jacobian_age < max_jacobian_age
    if progress.has_jacobian and 1.0 <= factor <= MAX_KEPT_STEP_RATIO:
        factor = 1.0
    # The last step, or half of another run's step, may be much shorter than its error allows.
    is_shortened = progress.is_last or (progress.is_cut and factor >= 1.0)
    progress.step = max(progress.step, h * factor) if is_shortened else h * factor


@jit_in_place
def _predict_factor(error: float, previous_error: float, h: float, previous_h: float, n_stages: int) -> float:
    """Return the factor on a step size h that its error allows, relative to the tolerance; previous_h is 0 in a first step."""
    # The error of the next step is expected to change as it has changed since the previous one
    # (Gustafsson).
    exponent = 1.0 / (n_stages + 1)
    factor: float = error**-exponent
    return min(factor, h / previous_h * (previous_error / error**2) ** exponent) if previous_h > 0.0 else factor


def _make_output(functions: StiffEquationFunctions[Equation]) -> Callable[..., None]:
    """Return the function that fills the outputs at the times within an accepted step."""
    write_output = functions.write_output

    def write_outputs(
        equation: Equation,
        buffers: RadauBuffers,
        time_origin: float,
        state: FloatArray,
        times: FloatArray,  # reported times, s; shape (n,)
        outputs: FloatArray,  # result: outputs at the times; shape (n, outputs)
    ) -> None:
        progress, n_reached = buffers.progress[0], buffers.progress[0].n_reached
        while n_reached < times.size and times[n_reached] <= progress.t_next:
            fraction = (times[n_reached] - progress.t) / progress.h
            radau_stages.interpolate_state(buffers, state, fraction, buffers.stage_state)
            write_output(equation, times[n_reached] - time_origin, buffers.stage_state, outputs[n_reached])
            n_reached += 1
        progress.n_reached = n_reached

    return write_outputs
