"""DOP853 with error control, dense output and event location for an equation y' = f(t, y) given by compiled functions; compiled."""

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from governor_mechanism.integrators import stages as runge_kutta
from governor_mechanism.integrators.equation import EquationFunctions, StepBuffers
from governor_mechanism.integrators.event_location import LAST_SAMPLE
from governor_mechanism.integrators.kink_approach import KINK_TIME_ROUNDING
from governor_mechanism.integrators.stages import END_STAGE, N_STAGES, Stages, StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.step_ends import make_plain_step_ends, make_step_ends
from governor_mechanism.integrators.tableau import NODES
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

MAX_STEP_FACTOR = 6.0
"""Largest ratio of a step size to the one before."""

STALL_WINDOW_STEPS, MIN_PROGRESS_RATIO = 2000, 1e-6
"""An integration stalls when this many accepted steps advance less than this fraction of the interval."""

STABILITY_LIMIT = 6.1
"""Limit of step size times dominant eigenvalue (Hairer's estimate) up to which DOP853 is stable."""

NEAR_SINGULAR_QUALITY, MIN_STAGE_QUALITY = 1e-3, 1e-6
"""Quality of a stage below which it is near a singular state, and below which a step is retried.

At an angle e from a change point, a constraint violation d causes an acceleration error of order d / e^3. The step is
therefore placed so that the change point falls into the widest gap between stages. A step with a stage too close to
the change point is repeated with another length, unless it starts so close that no step does better.
"""

CROSSING_QUALITY_RATIO = 0.04
"""Quality of the stages nearest to a change point relative to that of the start, in a step that has the change point in its widest gap.

The gap reaches from 0.333 to 0.6 of the step. With the change point in its middle, the nearest stages are 0.134 / 0.466 of the angle of
the start away, and the quality is the square of an angle: 0.08. Half of it is required, because the angle is extrapolated.
"""

BELOW_DOMAIN, ABOVE_DOMAIN, FAR_OUTSIDE_DOMAIN, OUT_OF_RANGE, TURNED_BACK = -1.0, -2.0, -3.0, -4.0, -5.0
"""Qualities of a stage that leaves the domain of the equation, of one so far outside that a shorter step may stay inside, and of ends of
a step at which the integration ends.
"""

STAGE_GAP_FRACTION = 0.466
"""Middle of the widest gap between the stage nodes, as a fraction of the step."""

STEERING_QUALITY = 0.1
"""Quality below which step sizes are steered so that the change point falls into the gap between stages."""

MAX_SINGULAR_RETRIES = 60
"""Largest number of other step lengths tried at one change point."""

N_STIFF_STEPS, N_NONSTIFF_STEPS = 15, 6
"""Number of steps at the stability limit that make a motion stiff, and number of other steps that resets the count."""


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
    min_stiff_steps
        Fewest remaining steps with which a stiff equation ends the integration; infinity if it never does.
    """

    tolerance: float
    step: float
    max_step: float
    max_steps: int
    min_stiff_steps: float


Equation = TypeVar("Equation")


Integration = Callable[
    [Equation, StepBuffers, tuple[float, float], float, FloatArray, StepLimits, FloatArray, FloatArray],
    tuple[IntegrationStatus, float, int, float],
]
"""Integration of a state in place over a span (s) up to its end or to the first event.

Its arguments are the equation, buffers, the span, the time (s) from which local times count, the state, limits, and times (s) in
(start, end] with the states to fill in there. It returns how it ended, the next step size (s), the number of times reached, and the
time of the state (s).

E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd edition 1993, section II.10.
"""


@jit_in_place
def arm_events(buffers: StepBuffers) -> None:
    """Arm the event functions that are below zero by more than rounding: their next zero is an event, however slowly they rise."""
    for i in range(buffers.event_tolerances.size):
        if buffers.event_values[0, i] < -buffers.event_tolerances[i]:
            buffers.arming_tolerances[i] = 0.0


def make_dop853(functions: EquationFunctions[Equation], *, has_event_functions: bool) -> Integration[Equation]:
    """Return the integration of an equation, to be called by a compiled function.

    Parameters
    ----------
    functions
        Functions of the equation.
    has_event_functions
        Whether the integration locates events; otherwise there must be no event functions. It is then compiled in half the time.

    Returns
    -------
    Integration[Equation]
        The integration.
    """
    evaluate = functions.evaluate
    attempt_step = jit_in_place(_make_attempt(functions))
    ends = make_step_ends(functions) if has_event_functions else make_plain_step_ends(functions)
    evaluate_events, choose_length, finish_and_sample = ends.evaluate_events, ends.choose_length, ends.finish_and_sample
    correct_length, cut_at_event = ends.correct_length, ends.cut_at_event
    write_outputs = jit_in_place(_make_output(functions))

    def integrate(
        equation: Equation,
        buffers: StepBuffers,
        span: tuple[float, float],
        time_origin: float,
        state: FloatArray,
        limits: StepLimits,
        times: FloatArray,
        states: FloatArray,
    ) -> tuple[IntegrationStatus, float, int, float]:
        stages, (t, end), step = buffers.stages, span, limits.step
        counts, n_integrated, has_events = stages.counts, buffers.error_scale.size, buffers.event_tolerances.size > 0
        quality = evaluate(equation, t - time_origin, state, stages.derivatives, 0)
        if quality < 0.0:
            return _domain_status(quality), step, 0, t
        if has_events:
            evaluate_events(equation, t - time_origin, state, buffers.event_values[0])
            copy_array(buffers.arming_tolerances, buffers.event_tolerances)
            arm_events(buffers)
        is_regular, quality = quality > 0.0, 1.0
        n_reached = n_retries = n_kink_retries = n_stiff = n_calm = 0
        progress_time, progress_steps = t, counts[StepCounter.ACCEPTED]
        reach = min(end - t, limits.max_step * limits.max_steps)  # a later end cannot be reached
        min_step, full_step = 1e-13 * reach, step
        while t < end:
            if counts[StepCounter.ACCEPTED] - progress_steps >= STALL_WINDOW_STEPS:
                if t - progress_time < MIN_PROGRESS_RATIO * reach:
                    return IntegrationStatus.STALLED, step, n_reached, t
                progress_time, progress_steps = t, counts[StepCounter.ACCEPTED]
            if counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED] >= limits.max_steps:
                return IntegrationStatus.STEP_LIMIT, step, n_reached, t
            if not min_step <= step < math.inf:
                return IntegrationStatus.STALLED, step, n_reached, t
            if n_kink_retries == 0:
                full_step = min(step, limits.max_step)
                step = max(choose_length(equation, buffers, t - time_origin, full_step, state), min_step)
            is_last = t + step >= end
            h, t_next = (end - t, end) if is_last else (step, t + step)
            lowest_quality, error, retry_factor = attempt_step(
                equation, buffers, t - time_origin, h, state, quality, is_regular, n_retries, limits.tolerance
            )
            is_rejected, next_quality, is_at_kink = retry_factor > 0.0, lowest_quality, False
            if lowest_quality < 0.0 and not is_rejected:
                return _domain_status(lowest_quality), step, n_reached, t
            if not is_rejected or (buffers.n_kinks > 0 and 0.0 <= error < math.inf):
                next_quality = finish_and_sample(equation, buffers, t - time_origin, h, t_next - time_origin, state, lowest_quality)
                rounding = KINK_TIME_ROUNDING * abs(t)
                is_at_kink, kink_step = correct_length(
                    equation, buffers, t - time_origin, h, state, retry_factor, n_kink_retries, min_step, rounding
                )
                if 0.0 < kink_step < end - t:
                    counts[StepCounter.REJECTED] += 1
                    n_kink_retries += 1
                    step = max(kink_step, min_step)
                    continue
            if is_rejected:
                counts[StepCounter.REJECTED] += 1
                n_retries += error < 0.0
                n_kink_retries, step = 0, h * retry_factor
                continue
            counts[StepCounter.ACCEPTED] += 1
            is_stiff = (
                limits.min_stiff_steps < math.inf
                and h * runge_kutta.estimate_dominant_eigenvalue(stages, buffers.error_scale) > STABILITY_LIMIT
            )
            fraction = cut_at_event(equation, buffers, t - time_origin, h, state)
            if fraction <= 1.0:
                h, t_next = fraction * h, t + fraction * h if fraction < 1.0 else t_next
            n_reached, output_quality = write_outputs(equation, stages, time_origin, t, h, t_next, state, times, states, n_reached)
            if output_quality < 0.0:
                return _domain_status(output_quality), step, n_reached, t
            copy_array(state[:n_integrated], stages.next_state[:n_integrated])
            copy_array(stages.derivatives[:, 0], stages.next_derivative[:, 0])
            t = t_next
            if next_quality < 0.0:
                return _domain_status(next_quality), step, n_reached, t
            if fraction <= 1.0:
                return IntegrationStatus.EVENT, full_step, n_reached, t
            if has_events:
                copy_array(buffers.event_values[0], buffers.event_values[LAST_SAMPLE])
                arm_events(buffers)
            step_factor = min(MAX_STEP_FACTOR, max(0.3, 0.9 * max(error, 1e-30) ** -0.125))
            # The last step, or one up to a kink, may be cut very short.
            is_cut = is_last or (h < full_step and step_factor == MAX_STEP_FACTOR)
            step = max(full_step, h * step_factor) if is_cut else h * step_factor
            if is_at_kink:
                return IntegrationStatus.EVENT, step, n_reached, t
            n_stiff, n_calm = (n_stiff + 1, 0) if is_stiff else (0 if n_calm + 1 >= N_NONSTIFF_STEPS else n_stiff, n_calm + 1)
            if is_regular and next_quality < min(quality, STEERING_QUALITY):
                step = _steer_step_over_singularity(math.sqrt(next_quality), math.sqrt(quality), h, step)
            n_retries, n_kink_retries, quality = 0, 0, next_quality
            if n_stiff >= N_STIFF_STEPS and end - t > limits.min_stiff_steps * h:
                return IntegrationStatus.STIFF, step, n_reached, t
        return IntegrationStatus.DONE, step, n_reached, t

    # Kernels from the cache share machine code of the same name: both variants of one equation in one process need names of their own.
    integrate.__qualname__ += "_to_event" if has_event_functions else "_without_events"
    return integrate


@jit_in_place
def _domain_status(quality: float) -> IntegrationStatus:
    """Return how an integration ends at a stage outside the domain."""
    if quality == OUT_OF_RANGE:
        return IntegrationStatus.OUT_OF_RANGE
    if quality == TURNED_BACK:
        return IntegrationStatus.TURNED_BACK
    return IntegrationStatus.BELOW_TABLE if quality == BELOW_DOMAIN else IntegrationStatus.ABOVE_TABLE


@jit_in_place
def _steer_step_over_singularity(angle: float, previous_angle: float, h: float, step: float) -> float:
    """Return the next step size that places the change point in the gap between stages, from its angles one step h apart."""
    time_to_singularity = angle * h / (previous_angle - angle)
    time_to_step_start = time_to_singularity - STAGE_GAP_FRACTION * step
    if time_to_step_start > step:  # at least two steps away
        return step
    if time_to_step_start > 0.0:  # end this step where the next one has the singularity in its gap
        return max(time_to_step_start, 0.02 * step)
    return time_to_singularity / STAGE_GAP_FRACTION if time_to_singularity > 0.1 * step else step


def _make_attempt(functions: EquationFunctions[Equation]) -> Callable[..., tuple[float, float, float]]:
    """Return the function that tries a step of a length h.

    It returns the lowest quality of its stages (that of the first one, and whether it is not always singular, are given), the error
    relative to the tolerance (negative without one), and the factor on the length with which to try again, or 0.
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


def _make_output(functions: EquationFunctions[Equation]) -> Callable[..., tuple[int, float]]:
    """Return the function that fills in the states at the times within a step, from t to t_next, and returns how many are filled.

    It also returns the quality of the additional stages, which is negative if one leaves the domain.
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
