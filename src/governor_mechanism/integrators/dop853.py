"""DOP853 with error control, dense output and event location for an equation y' = f(t, y) given by compiled functions; compiled."""

import math
from collections.abc import Callable
from typing import NamedTuple

from governor_mechanism.integrators import stages as runge_kutta
from governor_mechanism.integrators.equation import EquationFunctions, StepBuffers
from governor_mechanism.integrators.event_location import LAST_SAMPLE
from governor_mechanism.integrators.kink_approach import KINK_TIME_ROUNDING
from governor_mechanism.integrators.stage_quality import STEERING_QUALITY, domain_status, steer_step_over_singularity
from governor_mechanism.integrators.stages import Equation, StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.step_attempt import make_attempt, make_output
from governor_mechanism.integrators.step_ends import make_plain_step_ends, make_step_ends
from governor_mechanism.integrators.step_record import NO_STEPS, StepRecord, find_step, limit_to_half_steps, record_step
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

MAX_STEP_FACTOR = 6.0
"""Largest ratio of a step size to the one before."""

STALL_WINDOW_STEPS, MIN_PROGRESS_RATIO = 2000, 1e-6
"""An integration stalls when this many accepted steps advance less than this fraction of the interval."""

STABILITY_LIMIT = 6.1
"""Limit of step size times dominant eigenvalue (Hairer's estimate) up to which DOP853 is stable."""

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
    coarser_steps
        Steps of another run: at most half of each is taken.
    steps
        Record of the steps.
    """

    tolerance: float
    step: float
    max_step: float
    max_steps: int
    min_stiff_steps: float
    coarser_steps: StepRecord = NO_STEPS
    steps: StepRecord = NO_STEPS


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
    evaluate, check_step = functions.evaluate, functions.check_step
    attempt_step = jit_in_place(make_attempt(functions))
    ends = make_step_ends(functions) if has_event_functions else make_plain_step_ends(functions)
    evaluate_events, choose_length, finish_and_sample = ends.evaluate_events, ends.choose_length, ends.finish_and_sample
    correct_length, cut_at_event = ends.correct_length, ends.cut_at_event
    write_outputs = jit_in_place(make_output(functions))

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
        """Integrate a state in place up to the end of a span or to the first event.

        Parameters
        ----------
        equation
            The equation.
        buffers
            Buffers of the steps.
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
        states
            Result: states at the times reached; shape (n, components).

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
        stages, (t, end), step = buffers.stages, span, limits.step
        counts, n_integrated, has_events = stages.counts, buffers.error_scale.size, buffers.event_tolerances.size > 0
        quality = evaluate(equation, t - time_origin, state, stages.derivatives, 0)
        if quality < 0.0:
            return domain_status(quality), step, 0, t
        if has_events:
            evaluate_events(equation, t - time_origin, state, buffers.event_values[0])
            copy_array(buffers.arming_tolerances, buffers.event_tolerances)
            arm_events(buffers)
        is_regular, quality = quality > 0.0, 1.0
        n_reached = n_retries = n_kink_retries = n_stiff = n_calm = 0
        progress_time, progress_steps = t, counts[StepCounter.ACCEPTED]
        reach = min(end - t, limits.max_step * limits.max_steps)  # a later end cannot be reached
        # A step below the rounding of the time would not advance it, as in an interval that is hardly longer than that.
        min_step, full_step = max(1e-13 * reach, 2.0**-52 * abs(end)), step
        coarser_step = find_step(limits.coarser_steps, t)
        while t < end:
            if counts[StepCounter.ACCEPTED] - progress_steps >= STALL_WINDOW_STEPS:
                if t - progress_time < MIN_PROGRESS_RATIO * reach:
                    return IntegrationStatus.STALLED, step, n_reached, t
                progress_time, progress_steps = t, counts[StepCounter.ACCEPTED]
            if counts[StepCounter.ACCEPTED] + counts[StepCounter.REJECTED] >= limits.max_steps:
                return IntegrationStatus.STEP_LIMIT, step, n_reached, t
            if not min(min_step, end - t) <= step < math.inf:
                return IntegrationStatus.STALLED, step, n_reached, t
            if n_kink_retries == 0:
                full_step = min(step, limits.max_step)
                step, coarser_step = limit_to_half_steps(limits.coarser_steps, coarser_step, t, full_step)
                step = max(choose_length(equation, buffers, t - time_origin, step, state), min_step)
            is_last = t + step >= end
            h, t_next = (end - t, end) if is_last else (step, t + step)
            lowest_quality, error, retry_factor = attempt_step(
                equation, buffers, t - time_origin, h, state, quality, is_regular, n_retries, limits.tolerance
            )
            is_rejected, next_quality, is_at_kink = retry_factor > 0.0, lowest_quality, False
            if lowest_quality < 0.0 and not is_rejected:
                return domain_status(lowest_quality), step, n_reached, t
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
            next_quality = check_step(equation, t - time_origin, h, state, stages, next_quality)
            n_reached, output_quality = write_outputs(equation, stages, time_origin, t, h, t_next, state, times, states, n_reached)
            if output_quality < 0.0:
                return domain_status(output_quality), step, n_reached, t
            copy_array(state[:n_integrated], stages.next_state[:n_integrated])
            copy_array(stages.derivatives[:, 0], stages.next_derivative[:, 0])
            t = t_next
            record_step(limits.steps, t, h, lowest_quality)
            if next_quality < 0.0:
                return domain_status(next_quality), step, n_reached, t
            if fraction <= 1.0:
                return IntegrationStatus.EVENT, full_step, n_reached, t
            if has_events:
                copy_array(buffers.event_values[0], buffers.event_values[LAST_SAMPLE])
                arm_events(buffers)
            step_factor = min(MAX_STEP_FACTOR, max(0.3, 0.9 * max(error, 1e-30) ** -0.125))
            # The last step, one up to a kink, or half of another run's step may be much shorter than its error allows.
            is_cut = is_last or (h < full_step and step_factor == MAX_STEP_FACTOR)
            step = max(full_step, h * step_factor) if is_cut else h * step_factor
            if is_at_kink:
                return IntegrationStatus.EVENT, step, n_reached, t
            n_stiff, n_calm = (n_stiff + 1, 0) if is_stiff else (0 if n_calm + 1 >= N_NONSTIFF_STEPS else n_stiff, n_calm + 1)
            if is_regular and next_quality < min(quality, STEERING_QUALITY):
                step, coarser_step = limit_to_half_steps(limits.coarser_steps, coarser_step, t, min(step, limits.max_step))
                step = steer_step_over_singularity(math.sqrt(next_quality), math.sqrt(quality), h, step)
            n_retries, n_kink_retries, quality = 0, 0, next_quality
            if n_stiff >= N_STIFF_STEPS and end - t > limits.min_stiff_steps * h:
                return IntegrationStatus.STIFF, step, n_reached, t
        return IntegrationStatus.DONE, step, n_reached, t

    # Kernels from the cache share machine code of the same name: both variants of one equation in one process need names of their own.
    integrate.__qualname__ += "_to_event" if has_event_functions else "_without_events"
    return integrate
