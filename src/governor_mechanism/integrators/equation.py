"""What an integration needs to know about an equation y' = f(t, y): compiled functions, scales and buffers."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple

import numpy as np

from governor_mechanism.integrators import stages as runge_kutta
from governor_mechanism.integrators.stages import Equation, Stages
from governor_mechanism.numerics.jit import jit_in_place, jit_inlined, record_dtype
from governor_mechanism.types import BoolArray, FloatArray, IntArray, RecordArray

EVENT_SAMPLE_FRACTIONS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Fractions of a step at which the event functions are sampled."""

LAST_SAMPLE = EVENT_SAMPLE_FRACTIONS.size - 1
"""Index of the sample at the end of the step."""

INACTIVE_EVENT_VALUE = -1.0
"""Value of an event function that is not monitored."""

PROGRESS_DTYPE = record_dtype(
    ("status", "i8"),  # how the integration ended, an IntegrationStatus, or RUNNING
    ("t", "f8"),  # time of the state, s
    ("step", "f8"),  # length of the next step, s
    ("is_far", "i8"),  # whether all events are far: steps may be longer, and not every one is sampled
    ("n_unsampled", "i8"),  # number of steps since the last that was sampled
    ("full_step", "f8"),  # that length before it was shortened for a kink or another run, s
    ("min_step", "f8"),  # length below which a step would not advance the time, s
    ("reach", "f8"),  # length of the span that the steps can reach, s
    ("h", "f8"),  # length of the present step, s
    ("t_next", "f8"),  # its end, s
    ("is_last", "i8"),  # whether it ends the span
    ("is_at_kink", "i8"),  # whether it ends at a kink
    ("quality", "f8"),  # quality of the state at its start
    ("lowest_quality", "f8"),  # lowest quality of its stages
    ("next_quality", "f8"),  # quality of the state at its end
    ("error", "f8"),  # its error relative to the tolerance; negative if it was not estimated
    ("retry_factor", "f8"),  # factor on its length with which to try again; 0 if it is accepted, or ends outside the domain
    ("is_regular", "i8"),  # whether the equation is not always singular
    ("n_reached", "i8"),  # number of reported times that are reached
    ("n_retries", "i8"),  # lengths tried beside a change point
    ("n_kink_retries", "i8"),  # lengths tried at a kink
    ("n_stiff", "i8"),  # steps at the stability limit
    ("n_calm", "i8"),  # steps since the last of them
    ("window_time", "f8"),  # start of the window in which an integration must advance, s
    ("window_steps", "i8"),  # accepted steps before that window
    ("coarser_step", "i8"),  # index of the step of another run at t
    ("near_step", "f8"),  # largest length of steps unless all events are far, s; infinity if none is ever taken as far
    ("far_time", "f8"),  # time within which no event is expected where all are far, s
)
"""Progress of an integration, and its present step."""


ROUNDING, ARMING = 0, 1
"""Rows of the tolerances of event functions: their rounding, and how far below zero each must have been before it can rise."""


class StepBuffers(NamedTuple):
    """Stages of a step and of trial steps, and what errors and event functions are relative to.

    They are few arrays, because each takes time in every call.
    """

    stages: Stages  # stages of a step
    trial_stages: Stages  # stages of the steps that locate events
    error_scale: FloatArray  # scale of every integrated component; shape (integrated components,)
    # tolerances of the event functions, ROUNDING and ARMING; the second are the rounding, and 0 once a function has been that far below
    # zero; shape (2, event functions)
    event_tolerances: FloatArray
    # event functions at the samples of a step; after an event the last row holds those at the event; shape
    # (samples, event functions)
    event_values: FloatArray
    trial_event_values: FloatArray  # buffer; shape (event functions,)
    is_rising: BoolArray  # buffer; shape (event functions,)
    progress: RecordArray  # progress of the integration, a record of `PROGRESS_DTYPE`; shape (1,)
    n_kinks: int  # number of event functions, the last ones, that are kinks of the derivative: steps end there, see `step_ends`
    # how fast each gap, through which a step may lead into a thin part and out of it again, rose at the end of the step before, per
    # second; NaN of other event functions; shape (event functions,), or (0,) without gaps
    gap_slopes: FloatArray


def make_step_buffers(
    n_components: int,
    n_coupled: int,
    error_scale: FloatArray,  # scale of every integrated component; shape (integrated components,)
    event_tolerances: FloatArray,  # rounding of the event functions; shape (event functions,)
    counts: IntArray,
    n_kinks: int = 0,  # number of event functions, the last ones, that are kinks
    near_step: float = math.inf,  # largest length of steps unless all events are far, s
    far_time: float = math.inf,  # time within which no event is expected where all are far, s
    is_gap: BoolArray | None = None,  # which event functions are gaps; none if left out
) -> StepBuffers:
    """Allocate the buffers of an integration."""
    stages, trial_stages = (runge_kutta.make_stages(n_components, error_scale.size, n_coupled, counts) for _ in range(2))
    event_values = np.full((EVENT_SAMPLE_FRACTIONS.size, event_tolerances.size), INACTIVE_EVENT_VALUE)
    trial_event_values = np.empty(event_tolerances.size)
    progress = np.zeros(1, dtype=PROGRESS_DTYPE)
    progress["near_step"] = near_step
    progress["far_time"] = far_time
    return StepBuffers(
        stages=stages,
        trial_stages=trial_stages,
        error_scale=error_scale,
        event_tolerances=np.stack([event_tolerances, event_tolerances]),
        event_values=event_values,
        trial_event_values=trial_event_values,
        is_rising=np.zeros(event_tolerances.size, dtype=np.bool_),
        progress=progress,
        n_kinks=n_kinks,
        gap_slopes=np.where(is_gap, 0.0, math.nan) if is_gap is not None and is_gap.any() else np.empty(0),
    )


@jit_in_place
def count_located(buffers: StepBuffers) -> int:
    """Return the number of event functions, the first ones, that are located by trial steps: all but the kinks."""
    return int(buffers.event_tolerances.shape[1]) - buffers.n_kinks


MAX_UNSAMPLED_STEPS = 8
"""Largest number of steps in a row that are not sampled, where all events are far."""


@jit_in_place
def are_events_far(buffers: StepBuffers, time: float) -> bool:
    """Return whether no located event function would rise to zero within a time (s), at the fastest change between samples of a step."""
    is_far, values = True, buffers.event_values
    for i in range(count_located(buffers)):
        highest, fastest = values[0, i], 0.0
        for j in range(1, values.shape[0]):
            highest = max(highest, values[j, i])
            fastest = max(fastest, abs(values[j, i] - values[j - 1, i]))
        is_far = is_far and highest < -LAST_SAMPLE * fastest * time / buffers.progress[0].h
    return is_far


@jit_inlined
def can_skip_samples(buffers: StepBuffers) -> bool:
    """Return whether a step needs no samples between its ends; those are interpolated then."""
    progress = buffers.progress[0]
    return bool(progress.is_far != 0 and progress.n_unsampled < MAX_UNSAMPLED_STEPS and _interpolates_samples(buffers))


@jit_in_place
def _interpolates_samples(buffers: StepBuffers) -> bool:
    """Interpolate the samples of a step, and return whether all events are far by these."""
    values = buffers.event_values
    for j in range(1, LAST_SAMPLE):
        for i in range(values.shape[1]):
            values[j, i] = values[0, i] + EVENT_SAMPLE_FRACTIONS[j] * (values[LAST_SAMPLE, i] - values[0, i])
    return are_events_far(buffers, buffers.progress[0].far_time)


LEAST_DIVIDED_STEP = 16.0
"""Smallest step, in those that rounding lets advance, that is divided to see whether a gap closes in it."""

FASTER_RATIO = 1.25
"""Speed at which a gap is taken to close and open between two samples, relative to that beside them."""


@jit_in_place
def leads_through_gap(buffers: StepBuffers) -> bool:
    """Return whether a gap may close between two samples of a step and open again, as behind a thin part.

    It comes nearer before the first of both and goes away behind the second one, so fast that the lines meet beyond zero. Behind the
    step it is taken to go away as fast as it came.
    """
    values, progress = buffers.event_values, buffers.progress[0]
    if progress.h <= LEAST_DIVIDED_STEP * progress.min_step:
        return False
    for i in range(count_located(buffers)):
        if math.isnan(buffers.gap_slopes[i]):
            continue
        rise = FASTER_RATIO * buffers.gap_slopes[i] * EVENT_SAMPLE_FRACTIONS[1] * progress.h
        tolerance = buffers.event_tolerances[ROUNDING, i]
        for j in range(LAST_SAMPLE):
            before, behind = values[j, i], values[j + 1, i]
            fall = FASTER_RATIO * (behind - values[j + 2, i]) if j + 2 <= LAST_SAMPLE else rise
            if rise > 0.0 and fall > 0.0 and before < -tolerance and behind < -tolerance:
                share = (behind + fall - before) / (rise + fall)
                if 0.0 < share < 1.0 and before + rise * share > tolerance:
                    return True
            rise = FASTER_RATIO * (behind - before)
    return False


@jit_inlined
def may_miss_events(buffers: StepBuffers) -> bool:
    """Return whether a step is too long for an event that is not far; else note whether all are far from the next step."""
    if buffers.gap_slopes.size > 0 and _divides_step_at_gap(buffers):
        return True
    return bool(buffers.progress[0].near_step < math.inf and _is_step_too_long(buffers))


@jit_in_place
def _divides_step_at_gap(buffers: StepBuffers) -> bool:
    """Return whether a step may lead through a gap that closes, and is divided; else note how fast the gaps change at its end."""
    progress, values = buffers.progress[0], buffers.event_values
    if leads_through_gap(buffers):
        progress.step = 0.5 * progress.h
        progress.n_kink_retries = 0
        return True
    for i in range(buffers.gap_slopes.size):
        if not math.isnan(buffers.gap_slopes[i]):
            buffers.gap_slopes[i] = (values[LAST_SAMPLE, i] - values[LAST_SAMPLE - 1, i]) / (EVENT_SAMPLE_FRACTIONS[1] * progress.h)
    return False


@jit_in_place
def forget_gap_slopes(buffers: StepBuffers) -> None:
    """Let all gaps start without a slope, as after a strike, which turns them back."""
    for i in range(buffers.gap_slopes.size):
        if not math.isnan(buffers.gap_slopes[i]):
            buffers.gap_slopes[i] = 0.0


@jit_in_place
def _is_step_too_long(buffers: StepBuffers) -> bool:
    """Return whether a step is too long for an event that is not far; else note whether all are far from the next step."""
    progress = buffers.progress[0]
    is_too_long = bool(progress.h > progress.near_step and not are_events_far(buffers, progress.h))
    progress.is_far = not is_too_long and are_events_far(buffers, progress.far_time)
    if is_too_long:
        progress.step = progress.near_step
        progress.n_kink_retries = 0
    return is_too_long


class EventStep(NamedTuple):
    """A step whose states are interpolated: local time (s) and state at its start, its length (s), and its stages and event functions."""

    local_time: float
    h: float
    state: FloatArray
    buffers: StepBuffers


@dataclass(frozen=True)
class EquationFunctions(Generic[Equation]):
    """Compiled functions of an equation; times are local, as those of its inputs.

    The quality of a stage is 1, less near a singular state, 0 where the equation is always singular, and negative outside its domain.
    """

    # fill a column of derivatives (components, stages) at a time and state, count the evaluation, and return
    # the quality
    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float]
    # fill the stages of a step from a time, of a length, from a state, and return the lowest quality; see
    # `make_take_step`
    take_step: Callable[[Equation, float, float, FloatArray, Stages], float]
    # fill the state and derivative with which the next step starts, at a time, from the end of a step of a
    # quality; return their quality
    finish_step: Callable[[Equation, float, float, Stages], float]
    # move a state at a fraction of a step, interpolated, into the domain
    finish_output: Callable[[Equation, EventStep, float, FloatArray], None]
    # remove from the errors of a step near a singular state what `finish_step` removes
    project_errors: Callable[[Equation, FloatArray], None]
    # fill the event functions at a time and state whose derivative was evaluated last
    evaluate_events: Callable[[Equation, float, FloatArray, FloatArray], None]
    # fill the event functions at a fraction of a step, interpolated
    sample_events: Callable[[Equation, EventStep, float, FloatArray], None]
    # return the quality of the end of an accepted step, cut at its event, from its start (local time, s),
    # length (s), state there, stages, and quality so far: a negative one if the motion ends within the step
    check_step: Callable[[Equation, float, float, FloatArray, Stages, float], float]
    # fill the last event functions, which are kinks, as `sample_events` does; that itself if it is left out
    sample_kinks: Callable[[Equation, EventStep, float, FloatArray], None] | None = None
