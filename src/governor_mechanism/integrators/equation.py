"""What an integration needs to know about an equation y' = f(t, y): compiled functions, scales and buffers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple

import numpy as np

from governor_mechanism.integrators import stages as runge_kutta
from governor_mechanism.integrators.event_location import EVENT_SAMPLE_FRACTIONS, INACTIVE_EVENT_VALUE, EventStep
from governor_mechanism.integrators.stages import Equation, Stages
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray


class StepBuffers(NamedTuple):
    """Stages of a step and of trial steps, and what errors and event functions are relative to.

    Attributes
    ----------
    stages
        Stages of a step.
    trial_stages
        Stages of the steps that locate events.
    error_scale
        Scale of every integrated component; shape (integrated components,).
    event_tolerances
        Rounding of the event functions; shape (event functions,).
    arming_tolerances
        How far below zero each event function must have been before it can rise: its rounding, and 0 once it has been; same shape.
    event_values
        Event functions at the samples of a step; after an event the last row holds those at the event; shape (samples, event functions).
    trial_event_values
        Buffer; shape (event functions,).
    n_kinks
        Number of event functions, the last ones, that are kinks of the derivative: steps end there, see `kink_approach`.
    """

    stages: Stages
    trial_stages: Stages
    error_scale: FloatArray
    event_tolerances: FloatArray
    arming_tolerances: FloatArray
    event_values: FloatArray
    trial_event_values: FloatArray
    n_kinks: int


def make_step_buffers(
    n_components: int, n_coupled: int, error_scale: FloatArray, event_tolerances: FloatArray, counts: IntArray, n_kinks: int = 0
) -> StepBuffers:
    """Allocate the buffers of an integration.

    Parameters
    ----------
    n_components
        Number of components of a state.
    n_coupled
        Number of leading components on which the derivative depends.
    error_scale
        Scale of every integrated component; shape (integrated components,).
    event_tolerances
        Rounding of the event functions; shape (event functions,).
    counts
        Counters, indexed by `StepCounter`, increased by the integration.
    n_kinks
        Number of event functions, the last ones, that are kinks.

    Returns
    -------
    StepBuffers
        The buffers.
    """
    stages, trial_stages = (runge_kutta.make_stages(n_components, error_scale.size, n_coupled, counts) for _ in range(2))
    event_values = np.full((EVENT_SAMPLE_FRACTIONS.size, event_tolerances.size), INACTIVE_EVENT_VALUE)
    arming_tolerances, trial_event_values = event_tolerances.copy(), np.empty(event_tolerances.size)
    return StepBuffers(stages, trial_stages, error_scale, event_tolerances, arming_tolerances, event_values, trial_event_values, n_kinks)


@jit_in_place
def _accept_step(equation: Equation, local_time: float, h: float, state: FloatArray, stages: Stages, quality: float) -> float:
    """Return the quality of a step as it is: nothing ends the motion."""
    return quality


@dataclass(frozen=True)
class EquationFunctions(Generic[Equation]):
    """Compiled functions of an equation; times are local, as those of its inputs.

    The quality of a stage is 1, less near a singular state, 0 where the equation is always singular, and negative outside its domain.

    Attributes
    ----------
    evaluate
        Fill a column of derivatives (components, stages) at a time and state, count the evaluation, and return the quality.
    take_step
        Fill the stages of a step from a time, of a length, from a state, and return the lowest quality; see `make_take_step`.
    finish_step
        Fill the state and derivative with which the next step starts, at a time, from the end of a step of a quality; return their quality.
    project
        Move a state at a time into the domain.
    project_errors
        Remove from the errors of a step near a singular state what `finish_step` removes.
    evaluate_events
        Fill the event functions at a time and state whose derivative was evaluated last.
    sample_events
        Fill the event functions at a fraction of a step, interpolated.
    check_step
        Return the quality of the end of an accepted step, cut at its event, from its start (local time, s), length (s), state there,
        stages, and quality so far: a negative one if the motion ends within the step.
    """

    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float]
    take_step: Callable[[Equation, float, float, FloatArray, Stages], float]
    finish_step: Callable[[Equation, float, float, Stages], float]
    project: Callable[[Equation, float, FloatArray], None]
    project_errors: Callable[[Equation, FloatArray], None]
    evaluate_events: Callable[[Equation, float, FloatArray, FloatArray], None]
    sample_events: Callable[[Equation, EventStep, float, FloatArray], None]
    check_step: Callable[[Equation, float, float, FloatArray, Stages, float], float] = _accept_step
