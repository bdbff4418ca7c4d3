"""DOP853 with error control, dense output and event location for an equation y' = f(t, y) given by compiled functions; compiled."""

import math
from collections.abc import Callable
from typing import NamedTuple

from governor_mechanism.integrators import stages as runge_kutta
from governor_mechanism.integrators.equation import (
    ARMING,
    LAST_SAMPLE,
    ROUNDING,
    EquationFunctions,
    EventStep,
    StepBuffers,
    may_miss_events,
)
from governor_mechanism.integrators.stages import END_STAGE, N_STAGES, Equation, StepCounter
from governor_mechanism.integrators.step_ends import KINK_TIME_ROUNDING, StepEnds, make_step_ends
from governor_mechanism.integrators.step_record import (
    CROSSING_QUALITY_RATIO,
    FAR_OUTSIDE_DOMAIN,
    MAX_SINGULAR_RETRIES,
    MIN_STAGE_QUALITY,
    NEAR_SINGULAR_QUALITY,
    NO_STEPS,
    STEERING_QUALITY,
    UNDETERMINED,
    IntegrationStatus,
    StepRecord,
    domain_status,
    find_step,
    limit_to_half_steps,
    record_step,
    steer_step_over_singularity,
)
from governor_mechanism.integrators.tableau import NODES
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray, RecordArray


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
            if lowest_quality in (FAR_OUTSIDE_DOMAIN, UNDETERMINED):
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
    """Return the function that fills in states within a step, and returns the quality of its stages, negative outside the domain."""
    evaluate, finish_output = functions.evaluate, functions.finish_output

    def write_outputs(
        equation: Equation,
        buffers: StepBuffers,
        time_origin: float,
        state: FloatArray,
        times: FloatArray,  # reported times, s; shape (n,)
        states: FloatArray,  # result: states at the times; shape (n, components)
    ) -> float:
        stages, progress = buffers.stages, buffers.progress[0]
        t = progress.t
        h = progress.h
        t_next = progress.t_next
        n_reached = progress.n_reached
        if n_reached >= times.size or times[n_reached] > t_next or not h > 0.0:
            return 1.0
        for stage in range(END_STAGE + 1, N_STAGES):
            runge_kutta.combine_stages(stages, state, stage, h, stages.n_coupled, stages.stage_state)
            quality = evaluate(equation, t - time_origin + NODES[stage] * h, stages.stage_state, stages.derivatives, stage)
            if quality < 0.0:
                return quality
        runge_kutta.prepare_dense_output(stages, state, h)
        step = EventStep(t - time_origin, h, state, buffers)
        while n_reached < times.size and times[n_reached] <= t_next:
            fraction = (times[n_reached] - t) / h
            runge_kutta.evaluate_dense_output(stages, state, fraction, states[n_reached])
            finish_output(equation, step, fraction, states[n_reached])
            n_reached += 1
        progress.n_reached = n_reached
        return 1.0

    return write_outputs


MAX_STEP_FACTOR = 6.0
"""Largest ratio of a step size to the one before."""

STALL_WINDOW_STEPS, MIN_PROGRESS_RATIO = 2000, 1e-6
"""An integration stalls when this many accepted steps advance less than this fraction of the interval."""

STABILITY_LIMIT = 6.1
"""Limit of step size times dominant eigenvalue (Hairer's estimate) up to which DOP853 is stable."""

N_STIFF_STEPS, N_NONSTIFF_STEPS = 15, 6
"""Number of steps at the stability limit that make a motion stiff, and number of other steps that resets the count."""


class StepLimits(NamedTuple):
    """Limits of one integration."""

    tolerance: float  # error of one step, relative to the error scale
    step: float  # first step size, s
    max_step: float  # largest step size, s
    max_steps: int  # largest number of accepted and rejected steps together
    min_stiff_steps: float  # fewest remaining steps with which a stiff equation ends the integration; infinity if it never does
    coarser_steps: StepRecord = NO_STEPS  # steps of another run: at most half of each is taken
    steps: StepRecord = NO_STEPS  # record of the steps


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


RUNNING = -1
"""Status of an integration that goes on."""


def make_dop853(functions: EquationFunctions[Equation]) -> Integration[Equation]:
    """Return the integration of an equation, to be called by a compiled function."""
    attempt_step = jit_in_place(make_attempt(functions))
    ends = make_step_ends(functions)
    start = jit_in_place(_make_start(functions))
    choose_step = jit_in_place(_make_choice_of_step(ends))
    tries_again_at_kink = jit_in_place(_make_retry_at_kink(ends))
    accept_step = jit_in_place(_make_acceptance(functions, ends))

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
        """Integrate a state in place up to the end of a span or to the first event; see `Integration`."""
        end = span[1]
        progress = buffers.progress[0]
        counts = buffers.stages.counts
        start(equation, buffers, span, time_origin, state, limits)
        while progress.status == RUNNING and progress.t < end:
            check_limits(progress, counts, limits, end)
            if progress.status != RUNNING:
                break
            local_time = progress.t - time_origin
            choose_step(equation, buffers, local_time, state, limits, end)
            attempt_step(equation, buffers, local_time, state, limits.tolerance)
            is_rejected = progress.retry_factor > 0.0
            if progress.lowest_quality < 0.0 and not is_rejected:
                progress.status = domain_status(progress.lowest_quality)
            elif tries_again_at_kink(equation, buffers, local_time, progress.t_next - time_origin, state, end):
                counts[StepCounter.REJECTED] += 1
            elif is_rejected:
                reject_step(progress)
                counts[StepCounter.REJECTED] += 1
            elif may_miss_events(buffers):
                counts[StepCounter.REJECTED] += 1
            else:
                accept_step(equation, buffers, time_origin, state, limits, end, times, states)
        status = IntegrationStatus.DONE if progress.status == RUNNING else progress.status
        return status, progress.step, progress.n_reached, progress.t

    return integrate


def _make_start(functions: EquationFunctions[Equation]) -> Callable[..., None]:
    """Return the function that evaluates the derivative and the event functions at the start, and sets the progress."""
    evaluate, evaluate_events = functions.evaluate, functions.evaluate_events

    def start(
        equation: Equation, buffers: StepBuffers, span: tuple[float, float], time_origin: float, state: FloatArray, limits: StepLimits
    ) -> None:
        (t, end), progress = span, buffers.progress[0]
        set_progress(progress, t, end, limits, buffers.stages.counts[StepCounter.ACCEPTED])
        quality = evaluate(equation, t - time_origin, state, buffers.stages.derivatives, 0)
        if quality < 0.0:
            progress.status = domain_status(quality)
            return
        progress.is_regular = quality > 0.0
        if buffers.event_tolerances.size > 0:
            evaluate_events(equation, t - time_origin, state, buffers.event_values[0])
            copy_array(buffers.event_tolerances[ARMING], buffers.event_tolerances[ROUNDING])
            arm_events(buffers)

    return start


@jit_in_place
def set_progress(progress: RecordArray, t: float, end: float, limits: StepLimits, n_accepted: int) -> None:
    """Set the progress at the start of a span."""
    progress.status = RUNNING
    progress.t = progress.window_time = t
    progress.step = progress.full_step = limits.step
    progress.reach = min(end - t, limits.max_step * limits.max_steps)  # a later end cannot be reached
    # A step below the rounding of the time would not advance it, as in an interval that is hardly longer than that.
    progress.min_step = max(1e-13 * progress.reach, 2.0**-52 * abs(end))
    progress.quality = progress.lowest_quality = 1.0
    progress.is_at_kink = progress.is_last = progress.is_far = 0
    progress.n_reached = progress.n_retries = progress.n_kink_retries = progress.n_stiff = progress.n_calm = 0
    progress.window_steps = n_accepted
    progress.coarser_step = find_step(limits.coarser_steps, t)


@jit_in_place
def arm_events(buffers: StepBuffers) -> None:
    """Arm the event functions that are below zero by more than rounding: their next zero is an event, however slowly they rise."""
    for i in range(buffers.event_tolerances.shape[1]):
        if buffers.event_values[0, i] < -buffers.event_tolerances[ROUNDING, i]:
            buffers.event_tolerances[ARMING, i] = 0.0


@jit_in_place
def check_limits(progress: RecordArray, counts: IntArray, limits: StepLimits, end: float) -> None:
    """End an integration that does not advance, or has used up its steps."""
    n_accepted = counts[StepCounter.ACCEPTED]
    if n_accepted - progress.window_steps >= STALL_WINDOW_STEPS:
        if progress.t - progress.window_time < MIN_PROGRESS_RATIO * progress.reach:
            progress.status = IntegrationStatus.STALLED
            return
        progress.window_time = progress.t
        progress.window_steps = n_accepted
    if n_accepted + counts[StepCounter.REJECTED] >= limits.max_steps:
        progress.status = IntegrationStatus.STEP_LIMIT
    elif not min(progress.min_step, end - progress.t) <= progress.step < math.inf:
        is_jammed = progress.lowest_quality == UNDETERMINED
        progress.status = IntegrationStatus.UNDETERMINED if is_jammed else IntegrationStatus.STALLED


def _make_choice_of_step(ends: StepEnds) -> Callable[..., None]:
    """Return the function that chooses length and end of the next step."""
    choose_length = ends.choose_length

    def choose_step(equation: Equation, buffers: StepBuffers, local_time: float, state: FloatArray, limits: StepLimits, end: float) -> None:
        progress = buffers.progress[0]
        if progress.n_kink_retries == 0:
            longest = limits.max_step if progress.is_far else min(limits.max_step, progress.near_step)
            progress.full_step = min(progress.step, longest)
            limit_to_coarser_steps(progress, limits.coarser_steps, progress.full_step)
            progress.step = max(choose_length(equation, buffers, local_time, progress.step, state), progress.min_step)
        progress.is_last = progress.t + progress.step >= end
        progress.h = progress.step
        progress.t_next = progress.t + progress.step
        if progress.is_last:
            progress.h = end - progress.t
            progress.t_next = end

    return choose_step


@jit_in_place
def limit_to_coarser_steps(progress: RecordArray, coarser_steps: StepRecord, step: float) -> None:
    """Set the length of the next step, at most half of each step of another run."""
    progress.step, progress.coarser_step = limit_to_half_steps(coarser_steps, progress.coarser_step, progress.t, step)


def _make_retry_at_kink(ends: StepEnds) -> Callable[..., bool]:
    """Return the function that finishes a step, and returns whether another length is tried to end it at a kink."""
    finish_and_sample, correct_length = ends.finish_and_sample, ends.correct_length

    def tries_again_at_kink(
        equation: Equation, buffers: StepBuffers, local_time: float, local_end: float, state: FloatArray, end: float
    ) -> bool:
        progress = buffers.progress[0]
        is_estimated = 0.0 <= progress.error < math.inf
        if progress.retry_factor > 0.0 and not (buffers.n_kinks > 0 and is_estimated):
            return False
        progress.next_quality = finish_and_sample(equation, buffers, local_time, progress.h, local_end, state, progress.lowest_quality)
        progress.is_at_kink, kink_step = correct_length(
            equation, buffers, local_time, progress.h, state, progress.retry_factor, progress.n_kink_retries, progress.min_step,
            KINK_TIME_ROUNDING * abs(progress.t),
        )  # fmt: skip
        if not 0.0 < kink_step < end - progress.t:
            return False
        progress.n_kink_retries += 1
        progress.step = max(kink_step, progress.min_step)
        return True

    return tries_again_at_kink


@jit_in_place
def reject_step(progress: RecordArray) -> None:
    """Try again with another length."""
    progress.n_retries += progress.error < 0.0
    progress.n_kink_retries = 0
    progress.step = progress.h * progress.retry_factor


def _make_acceptance(functions: EquationFunctions[Equation], ends: StepEnds) -> Callable[..., None]:
    """Return the function that accepts a step, up to the first event in it, and advances the state."""
    check_step = functions.check_step
    cut_at_event = ends.cut_at_event
    write_outputs = jit_in_place(make_output(functions))

    def accept_step(
        equation: Equation,
        buffers: StepBuffers,
        time_origin: float,
        state: FloatArray,
        limits: StepLimits,
        end: float,
        times: FloatArray,
        states: FloatArray,
    ) -> None:
        stages = buffers.stages
        progress = buffers.progress[0]
        n_integrated = buffers.error_scale.size
        local_time = progress.t - time_origin
        stages.counts[StepCounter.ACCEPTED] += 1
        is_stiff = is_at_stability_limit(buffers, limits)
        fraction = cut_at_event(equation, buffers, local_time, progress.h, state)
        if fraction < 1.0:
            progress.t_next = progress.t + fraction * progress.h
            progress.h = fraction * progress.h
        next_quality = check_step(equation, local_time, progress.h, state, stages, progress.next_quality)
        output_quality = write_outputs(equation, buffers, time_origin, state, times, states)
        if output_quality < 0.0:
            progress.status = domain_status(output_quality)
            return
        copy_array(state[:n_integrated], stages.next_state[:n_integrated])
        copy_array(stages.derivatives[:, 0], stages.next_derivative[:, 0])
        progress.t = progress.t_next
        progress.next_quality = next_quality
        record_step(limits.steps, progress.t, progress.h, progress.lowest_quality)
        if next_quality < 0.0:
            progress.status = domain_status(next_quality)
        elif fraction <= 1.0:
            progress.step = progress.full_step
            progress.status = IntegrationStatus.EVENT
        else:
            copy_array(buffers.event_values[0], buffers.event_values[LAST_SAMPLE])
            arm_events(buffers)
            prepare_next_step(progress, limits, end, is_stiff)

    return accept_step


@jit_in_place
def is_at_stability_limit(buffers: StepBuffers, limits: StepLimits) -> bool:
    """Return whether the stability of the method rather than its error limits the present step."""
    if limits.min_stiff_steps == math.inf:
        return False
    eigenvalue = runge_kutta.estimate_dominant_eigenvalue(buffers.stages, buffers.error_scale)
    return bool(buffers.progress[0].h * eigenvalue > STABILITY_LIMIT)


@jit_in_place
def prepare_next_step(progress: RecordArray, limits: StepLimits, end: float, is_stiff: bool) -> None:
    """Choose the length of the next step after an accepted one, or end the integration at a kink or where it is stiff."""
    h = progress.h
    step_factor = min(MAX_STEP_FACTOR, max(0.3, 0.9 * max(progress.error, 1e-30) ** -0.125))
    # The last step, one up to a kink, or half of another run's step may be much shorter than its error allows.
    is_cut = progress.is_last or (h < progress.full_step and step_factor == MAX_STEP_FACTOR)
    progress.step = max(progress.full_step, h * step_factor) if is_cut else h * step_factor
    if progress.is_at_kink:
        progress.status = IntegrationStatus.EVENT
        return
    progress.n_calm = 0 if is_stiff else progress.n_calm + 1
    if is_stiff:
        progress.n_stiff += 1
    elif progress.n_calm >= N_NONSTIFF_STEPS:
        progress.n_stiff = 0
    if progress.is_regular and progress.next_quality < min(progress.quality, STEERING_QUALITY):
        limit_to_coarser_steps(progress, limits.coarser_steps, min(progress.step, limits.max_step))
        progress.step = steer_step_over_singularity(math.sqrt(progress.next_quality), math.sqrt(progress.quality), h, progress.step)
    progress.n_retries = progress.n_kink_retries = 0
    progress.quality = progress.next_quality
    if progress.n_stiff >= N_STIFF_STEPS and end - progress.t > limits.min_stiff_steps * h:
        progress.status = IntegrationStatus.STIFF
