"""Ends of steps at kinks and events: lengths of steps, the samples of the event functions, and the part before an event; compiled.

At a kink another smooth function takes over from the derivative: no step may lead over one, because its error would be that of a method
of low order. A kink is where the last event functions of an equation rise through zero; up to there the equation keeps the function that
held at the start, also in steps tried that lead too far. The first length follows from the tangent of the motion. The quintic
interpolant of each step tried gives the next length: where the step ends beside the kink, it is good to the cube of the distance, so that
two or three steps locate the kink to rounding.
"""

from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.integrators import event_location
from governor_mechanism.integrators.equation import (
    EVENT_SAMPLE_FRACTIONS,
    LAST_SAMPLE,
    EquationFunctions,
    EventStep,
    StepBuffers,
    can_skip_samples,
    count_located,
)
from governor_mechanism.integrators.event_location import NO_EVENT, is_any_positive
from governor_mechanism.integrators.stages import Equation
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray

KINK_TOLERANCE = 2e-13
"""Distance behind a kink, relative to the step, at which a step ends there: above rounding, and far below what an order of 8 notices."""

KINK_TIME_ROUNDING = 1e-15
"""The same relative to the time: angles that grow with the time are rounded like it."""

MAX_STRETCH = 0.05
"""Fraction of a step by which it is stretched to a kink behind it: less would be left for a step of its own. The error grows by half."""

MAX_KINK_RETRIES = 8
"""Largest number of lengths tried at one kink; three suffice unless rounding exceeds the tolerances above."""

AIM_CORRECTIONS = 3
"""Number of false-position steps along the tangent, which are good to the curvature of the motion then."""

MAX_SECANT_STEPS = 12
"""Largest number of secant steps on an interpolant, which take a fraction of the time of a step; five suffice."""

SECANT_TOLERANCE = 1e-15
"""Change of a fraction of the step at which secant steps end: rounding."""

SampleEvents = Callable[[Equation, EventStep, float, FloatArray], None]
"""Function that fills the event functions at a fraction of a step, interpolated or extrapolated."""


def make_kink_prediction(
    # function that fills the event functions at a fraction of the step
    sample_events: SampleEvents[Equation],
) -> Callable[[Equation, EventStep], float]:
    """Return the function that predicts the first kink in a step or a little behind it."""
    find_root = jit_in_place(_make_root_search(sample_events))

    def predict_kink(equation: Equation, step: EventStep) -> float:
        """Return the first kink in a step or a little behind it as a fraction of the step, up to 1 + MAX_STRETCH, or NO_EVENT."""
        prediction, event_values = NO_EVENT, step.buffers.event_values
        for i in range(count_located(step.buffers), event_values.shape[1]):
            if event_values[0, i] < 0.0:
                high = 1
                while high < LAST_SAMPLE and event_values[high, i] <= 0.0:
                    high += 1
                if EVENT_SAMPLE_FRACTIONS[high - 1] < prediction and event_values[high - 1, i] < event_values[high, i]:
                    root = find_root(equation, step, i, high)
                    if root <= 1.0 + MAX_STRETCH:
                        prediction = min(prediction, root)
        return prediction

    return predict_kink


def _make_root_search(sample_events: SampleEvents[Equation]) -> Callable[[Equation, EventStep, int, int], float]:
    """Return the function that finds the zero of event function i near a sample, in which it rises from the sample before it."""
    # The secant steps stay between both samples if the zero is there. A zero too far behind the step is
    # not located.

    def find_root(equation: Equation, step: EventStep, i: int, sample: int) -> float:
        """Return the zero of an event function by secant steps, as a fraction of the step, or NO_EVENT if it is too far behind."""
        event_values = step.buffers.event_values
        buffer = step.buffers.trial_event_values
        low = EVENT_SAMPLE_FRACTIONS[sample - 1]
        high = EVENT_SAMPLE_FRACTIONS[sample]
        is_bracketed = event_values[sample, i] > 0.0
        position = high
        previous = low
        previous_value = event_values[sample - 1, i]
        value = event_values[sample, i]
        for _ in range(MAX_SECANT_STEPS):
            if value == previous_value:
                break
            change = -value * (position - previous) / (value - previous_value)
            if is_bracketed and not low <= position + change <= high:  # an end of the bracket may be the zero itself
                change = 0.5 * (low + high) - position
            previous = position
            previous_value = value
            position = position + change
            if not position <= 1.0 + 2.0 * MAX_STRETCH:
                return NO_EVENT
            if abs(change) <= SECANT_TOLERANCE:
                break
            sample_events(equation, step, position, buffer)
            value = buffer[i]
            if value > 0.0:
                high = min(high, position)
            else:
                low = max(low, position)
        return float(position)

    return find_root


def make_kink_aim(
    # function that fills the event functions at a time and state
    evaluate_events: Callable[[Equation, float, FloatArray, FloatArray], None],
) -> Callable[[Equation, float, float, FloatArray, FloatArray, int, FloatArray, FloatArray], float]:
    """Return the function that aims a step at the first kink along the tangent of the motion."""

    def evaluate_on_tangent(
        equation: Equation,
        local_time: float,
        time: float,
        state: FloatArray,
        derivative: FloatArray,
        buffer: FloatArray,
        event_values: FloatArray,
    ) -> None:
        """Fill the event functions (event functions,) on the tangent of the motion, at a time (s) after the start of a step."""
        for i in range(state.size):
            buffer[i] = state[i] + time * derivative[i]
        evaluate_events(equation, local_time + time, buffer, event_values)

    evaluate_on_tangent = jit_in_place(evaluate_on_tangent)

    def aim_at_kink(
        equation: Equation,
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        state: FloatArray,  # state at the start; shape (components,)
        derivative: FloatArray,  # its time derivative; shape (components,)
        first_kink: int,  # index of the first event function that is a kink
        # event functions at the samples: the first row is given, the others are overwritten; shape (samples,
        # event functions)
        event_values: FloatArray,
        buffer: FloatArray,  # buffer; shape (components,)
    ) -> float:
        """Return the length (s) of a step, or a shorter one up to the first kink along the tangent of the motion."""
        aim = h
        kink = NO_INDEX
        low = 0.0
        high = h
        for j in range(1, EVENT_SAMPLE_FRACTIONS.size):
            low, high = EVENT_SAMPLE_FRACTIONS[j - 1] * h, EVENT_SAMPLE_FRACTIONS[j] * h
            evaluate_on_tangent(equation, local_time, high, state, derivative, buffer, event_values[j])
            for i in range(first_kink, event_values.shape[1]):
                low_value, high_value = event_values[j - 1, i], event_values[j, i]
                if low_value < 0.0 < high_value and low - (high - low) * low_value / (high_value - low_value) < aim:
                    aim, kink = low - (high - low) * low_value / (high_value - low_value), i
            if kink != NO_INDEX:
                low_value, high_value = event_values[j - 1, kink], event_values[j, kink]
                break
        for _ in range(AIM_CORRECTIONS if kink != NO_INDEX else 0):
            evaluate_on_tangent(equation, local_time, aim, state, derivative, buffer, event_values[LAST_SAMPLE])
            value = event_values[LAST_SAMPLE, kink]
            if value > 0.0:
                high, high_value = aim, value
            else:
                low, low_value = aim, value
            aim = low - (high - low) * low_value / (high_value - low_value)
        return aim

    return aim_at_kink


@jit_in_place
def judge_length(
    h: float,  # length of the step, s
    fraction: float,  # the kink as a fraction of the step, or NO_EVENT
    is_reached: bool,
    retry_factor: float,  # factor on the length with which its error would be small enough, or 0 if it is
    n_tried: int,
    min_length: float,  # length of the shortest step, s
    time_rounding: float,  # rounding of the time, s
) -> tuple[bool, float]:
    """Return whether a step ends at a kink, and the length (s) with which to try again, or 0."""
    # An accepted step ends at the kink but for rounding, or where it does not come nearer. The length
    # is 0 if this step is as good, or if its error does not let it lead there.
    overshoot, tolerance = (1.0 - fraction) * h, KINK_TOLERANCE * h + time_rounding
    is_close = is_reached and (overshoot <= tolerance or h <= min_length)
    is_futile = fraction == NO_EVENT or n_tried >= MAX_KINK_RETRIES or 0.0 < retry_factor < fraction
    if is_close or is_futile:
        return is_reached and retry_factor == 0.0, 0.0
    return False, h - overshoot + 0.5 * tolerance


@dataclass(frozen=True)
class StepEnds:
    """Compiled functions for the ends of steps."""

    choose_length: Callable[..., float]  # return the length of the next step: that given, or a shorter one up to a kink
    # finish a step, sample its event functions, and return the quality of the state after it
    finish_and_sample: Callable[..., float]
    # compare a finished step with the first kink: return whether it ends there, and the length with which to
    # try again, or 0; its last arguments are those of `judge_length`
    correct_length: Callable[..., tuple[bool, float]]
    # cut a finished step at the first event, and return the fraction that precedes it, or NO_EVENT
    cut_at_event: Callable[..., float]


def make_step_ends(functions: EquationFunctions[Equation]) -> StepEnds:
    """Return the functions that locate kinks and events of an equation."""
    return StepEnds(
        choose_length=jit_in_place(_make_choice_of_length(functions)),
        finish_and_sample=jit_in_place(_make_finish_and_sample(functions)),
        correct_length=jit_in_place(_make_correction_of_length(functions)),
        cut_at_event=jit_in_place(_make_cut_at_event(functions)),
    )


def _make_choice_of_length(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that returns the length of the next step: that given, or a shorter one up to a kink."""
    aim_at_kink = jit_in_place(make_kink_aim(functions.evaluate_events))

    def choose_length(equation: Equation, buffers: StepBuffers, local_time: float, h: float, state: FloatArray) -> float:
        if buffers.n_kinks == 0:
            return h
        first_kink, buffer = count_located(buffers), buffers.stages.stage_state
        return aim_at_kink(equation, local_time, h, state, buffers.stages.derivatives[:, 0], first_kink, buffers.event_values, buffer)

    return choose_length


def _make_finish_and_sample(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that finishes a step, samples its event functions, and returns the quality of the state after it."""
    finish_step = functions.finish_step
    evaluate_events = functions.evaluate_events
    sample_events = functions.sample_events

    def finish_and_sample(
        equation: Equation,
        # stages of the step; its event functions are filled in, shape (samples, event functions)
        buffers: StepBuffers,
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        local_end: float,  # local time at its end, s
        state: FloatArray,  # state at the start; shape (components,)
        lowest_quality: float,
    ) -> float:
        """Finish a step and sample its event functions; return the quality of the state after it."""
        stages, event_values = buffers.stages, buffers.event_values
        quality = finish_step(equation, local_end, lowest_quality, stages)
        if buffers.event_tolerances.size > 0:
            evaluate_events(equation, local_end, stages.next_state, event_values[LAST_SAMPLE])
            step, progress = EventStep(local_time, h, state, buffers), buffers.progress[0]
            progress.n_unsampled += 1
            if not can_skip_samples(buffers):
                progress.n_unsampled = 0
                for j in range(1, LAST_SAMPLE):
                    sample_events(equation, step, EVENT_SAMPLE_FRACTIONS[j], event_values[j])
        return quality

    return finish_and_sample


def _make_correction_of_length(functions: EquationFunctions[Equation]) -> Callable[..., tuple[bool, float]]:
    """Return the function that compares a finished step with the first kink; see `judge_length`."""
    predict_kink = jit_in_place(make_kink_prediction(functions.sample_kinks or functions.sample_events))

    def correct_length(
        equation: Equation,
        buffers: StepBuffers,  # stages of the step and samples of its event functions
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        state: FloatArray,  # state at the start; shape (components,)
        retry_factor: float,  # factor on the length with which its error would be small enough, or 0 if it is
        n_tried: int,
        min_length: float,  # length of the shortest step, s
        time_rounding: float,  # rounding of the time, s
    ) -> tuple[bool, float]:
        """Return whether a finished step ends at the first kink, and the length (s) to it, or 0 if this step is as good."""
        if buffers.n_kinks == 0:
            return False, 0.0
        fraction = predict_kink(equation, EventStep(local_time, h, state, buffers))
        is_reached = is_any_positive(buffers.event_values[LAST_SAMPLE, count_located(buffers) :], buffers.n_kinks)
        return judge_length(h, fraction, is_reached, retry_factor, n_tried, min_length, time_rounding)

    return correct_length


def _make_cut_at_event(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that cuts a finished step at the first event, and returns the fraction that precedes it, or NO_EVENT."""
    take_step = functions.take_step
    finish_step = functions.finish_step
    evaluate_events = functions.evaluate_events
    evaluate_after_fraction = jit_in_place(event_location.make_trial_evaluation(take_step, finish_step, evaluate_events))
    locate_first_event = jit_in_place(event_location.make_event_location(evaluate_after_fraction))

    def cut_at_event(
        equation: Equation,
        # stages of the step, which are filled again up to the event, and samples of its event functions
        buffers: StepBuffers,
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        state: FloatArray,  # state at the start; shape (components,)
    ) -> float:
        """Cut a finished step at the first event; return the fraction that precedes it, or NO_EVENT."""
        if count_located(buffers) == 0:
            return NO_EVENT
        fraction = locate_first_event(equation, EventStep(local_time, h, state, buffers))
        if fraction <= 1.0:
            lowest_quality = take_step(equation, local_time, fraction * h, state, buffers.stages)
            finish_step(equation, local_time + fraction * h, lowest_quality, buffers.stages)
        return fraction

    return cut_at_event
