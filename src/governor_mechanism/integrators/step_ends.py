"""Ends of steps at kinks and events: lengths of steps, the samples of the event functions, and the part before an event; compiled."""

from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.integrators import event_location, kink_approach
from governor_mechanism.integrators.equation import EquationFunctions, StepBuffers
from governor_mechanism.integrators.event_location import EVENT_SAMPLE_FRACTIONS, LAST_SAMPLE, NO_EVENT, EventStep, is_any_positive
from governor_mechanism.integrators.stages import Equation
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class StepEnds:
    """Compiled functions for the ends of steps.

    Attributes
    ----------
    evaluate_events
        That of the equation.
    choose_length
        Return the length of the next step: that given, or a shorter one up to a kink.
    finish_and_sample
        Finish a step, sample its event functions, and return the quality of the state after it.
    correct_length
        Compare a finished step with the first kink: return whether it ends there, and the length with which to try again, or 0; its last
        arguments are those of `kink_approach.judge_length`.
    cut_at_event
        Cut a finished step at the first event, and return the fraction that precedes it, or NO_EVENT.
    """

    evaluate_events: Callable[..., None]
    choose_length: Callable[..., float]
    finish_and_sample: Callable[..., float]
    correct_length: Callable[..., tuple[bool, float]]
    cut_at_event: Callable[..., float]


def make_step_ends(functions: EquationFunctions[Equation]) -> StepEnds:
    """Return the functions for an equation with event functions.

    Result: functions that locate kinks and events.
    """
    return StepEnds(
        evaluate_events=functions.evaluate_events,
        choose_length=jit_in_place(_make_choice_of_length(functions)),
        finish_and_sample=jit_in_place(_make_finish_and_sample(functions)),
        correct_length=jit_in_place(_make_correction_of_length(functions)),
        cut_at_event=jit_in_place(_make_cut_at_event(functions)),
    )


@jit_in_place
def count_located(buffers: StepBuffers) -> int:
    """Return the number of event functions, the first ones, that are located by trial steps: all but the kinks."""
    return buffers.event_tolerances.size - buffers.n_kinks


def _make_choice_of_length(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that returns the length of the next step: that given, or a shorter one up to a kink."""
    aim_at_kink = jit_in_place(kink_approach.make_kink_aim(functions.evaluate_events))

    def choose_length(equation: Equation, buffers: StepBuffers, local_time: float, h: float, state: FloatArray) -> float:
        if buffers.n_kinks == 0:
            return h
        first_kink, buffer = buffers.event_tolerances.size - buffers.n_kinks, buffers.stages.stage_state
        return aim_at_kink(equation, local_time, h, state, buffers.stages.derivatives[:, 0], first_kink, buffers.event_values, buffer)

    return choose_length


def _make_finish_and_sample(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that finishes a step, samples its event functions, and returns the quality of the state after it."""
    finish_step, evaluate_events, sample_events = functions.finish_step, functions.evaluate_events, functions.sample_events

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
        """Finish a step and sample its event functions.

        Result: quality of the state after the step.
        """
        stages, event_values = buffers.stages, buffers.event_values
        quality = finish_step(equation, local_end, lowest_quality, stages)
        if buffers.event_tolerances.size > 0:
            evaluate_events(equation, local_end, stages.next_state, event_values[LAST_SAMPLE])
            step = EventStep(
                local_time, h, state, buffers.stages, buffers.trial_stages, buffers.arming_tolerances, buffers.trial_event_values,
                buffers.is_rising, count_located(buffers),
            )  # fmt: skip
            for j in range(1, LAST_SAMPLE):
                sample_events(equation, step, EVENT_SAMPLE_FRACTIONS[j], event_values[j])
        return quality

    return finish_and_sample


def _make_correction_of_length(functions: EquationFunctions[Equation]) -> Callable[..., tuple[bool, float]]:
    """Return the function that compares a finished step with the first kink; see `judge_length`."""
    predict_kink = jit_in_place(kink_approach.make_kink_prediction(functions.sample_events))

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
        """Compare a finished step with the first kink.

        Results: is_at_kink, whether the step ends at the kink; length, length of the step to the kink, s, or
        0 if this step is as good.
        """
        if buffers.n_kinks == 0:
            return False, 0.0
        event_values = buffers.event_values
        step = EventStep(
            local_time, h, state, buffers.stages, buffers.trial_stages, buffers.arming_tolerances, buffers.trial_event_values,
            buffers.is_rising, count_located(buffers),
        )  # fmt: skip
        fraction = predict_kink(equation, step, event_values, buffers.trial_event_values)
        is_reached = is_any_positive(event_values[LAST_SAMPLE, step.n_located :], buffers.n_kinks)
        return kink_approach.judge_length(h, fraction, is_reached, retry_factor, n_tried, min_length, time_rounding)

    return correct_length


def _make_cut_at_event(functions: EquationFunctions[Equation]) -> Callable[..., float]:
    """Return the function that cuts a finished step at the first event, and returns the fraction that precedes it, or NO_EVENT."""
    take_step, finish_step, evaluate_events = functions.take_step, functions.finish_step, functions.evaluate_events
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
        """Cut a finished step at the first event.

        Result: fraction of the step that precedes the event, or NO_EVENT.
        """
        stages = buffers.stages
        step = EventStep(
            local_time, h, state, buffers.stages, buffers.trial_stages, buffers.arming_tolerances, buffers.trial_event_values,
            buffers.is_rising, count_located(buffers),
        )  # fmt: skip
        if step.n_located == 0:
            return NO_EVENT
        fraction = locate_first_event(equation, step, buffers.event_values)
        if fraction <= 1.0:
            lowest_quality = take_step(equation, local_time, fraction * h, state, stages)
            finish_step(equation, local_time + fraction * h, lowest_quality, stages)
        return fraction

    return cut_at_event
