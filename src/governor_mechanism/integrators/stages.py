"""Stages of one DOP853 step: their states, the error estimate and the dense output; compiled."""

import math
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple, TypeVar

import numpy as np

from governor_mechanism.integrators.tableau import DENSE_WEIGHTS, ERROR_3, ERROR_5, FIRST_NONZERO_STAGE, NODES, STAGES
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray

END_STAGE = 12
"""Index of the stage at the end of the step."""

N_STAGES = 16
"""Number of stages, those of the dense output included."""


class StepCounter(IntEnum):
    """Indices of the counters of an integration."""

    ACCEPTED = 0
    REJECTED = 1
    EVALUATIONS = 2
    """Evaluations of the derivative."""
    MOVING_EVALUATIONS = 3
    """Those in the steps of a mechanism that no contact holds; only engine `reduced` counts them."""


class Stages(NamedTuple):
    """Stage values and buffers of one step."""

    derivatives: FloatArray  # derivative of each component at the stages; shape (components, 16)
    stage_state: FloatArray  # state at a stage before stage 11, and buffer; shape (components,)
    last_stage_state: FloatArray  # state at stage 11; shape (components,)
    # state at the end of the step, as the method gives it, or at the stage that left the domain; shape
    # (components,)
    end: FloatArray
    next_state: FloatArray  # state from which the next step starts; shape (components,)
    next_derivative: FloatArray  # its derivative; shape (components, 1)
    errors: FloatArray  # errors per second of order 5 and of order 3; shape (2, integrated components)
    dense: FloatArray  # coefficients of the dense output; shape (components, 7)
    counts: IntArray  # counters, indexed by `StepCounter`
    n_coupled: int  # number of leading components on which the derivative depends


def make_stages(
    n_components: int,
    n_integrated: int,  # number of leading components that are integrated; the others stay constant
    n_coupled: int,
    counts: IntArray,
) -> Stages:
    """Allocate the stages of a step, filled with zeros."""
    return Stages(
        derivatives=np.zeros((n_components, N_STAGES)),
        stage_state=np.zeros(n_components),
        last_stage_state=np.zeros(n_components),
        end=np.zeros(n_components),
        next_state=np.zeros(n_components),
        next_derivative=np.zeros((n_components, 1)),
        errors=np.zeros((2, n_integrated)),
        dense=np.zeros((n_components, 7)),
        counts=counts,
        n_coupled=n_coupled,
    )


@jit_in_place
def combine_stages(stages: Stages, state: FloatArray, stage: int, h: float, n_components: int, result: FloatArray) -> None:
    """Fill the leading components of `result` with the state at a stage, from the derivatives at the stages before it."""
    for i in range(n_components):
        total = STAGES[stage, 0] * stages.derivatives[i, 0]
        for k in range(FIRST_NONZERO_STAGE[stage], stage):
            total += STAGES[stage, k] * stages.derivatives[i, k]
        result[i] = state[i] + h * total


Equation = TypeVar("Equation")
"""Whatever the functions of an equation take as their first argument."""


def make_take_step(
    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float],
) -> Callable[[Equation, float, float, FloatArray, Stages], float]:
    """Return the function that takes a step of an equation; the functions are those of `EquationFunctions`."""

    def take_step(
        equation: Equation,
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        state: FloatArray,  # state at the start; shape (components,)
        # stages, with the derivative at the start in the first column; the state at the end follows in `end`
        stages: Stages,
    ) -> float:
        """Fill the stages of a step; return their lowest quality, negative where one, whose state is in `end` then, leaves the domain."""
        quality = 1.0
        for stage in range(1, END_STAGE + 1):
            result = stages.end if stage == END_STAGE else stages.last_stage_state if stage == END_STAGE - 1 else stages.stage_state
            n_components = stages.errors.shape[1] if stage == END_STAGE else stages.n_coupled
            combine_stages(stages, state, stage, h, n_components, result)
            quality = min(quality, evaluate(equation, local_time + NODES[stage] * h, result, stages.derivatives, stage))
            if quality < 0.0:
                copy_array(stages.end, result)
                break
        return quality

    return take_step


@jit_in_place
def estimate_errors(stages: Stages) -> None:
    """Fill the errors of a step."""
    derivatives = stages.derivatives
    for i in range(stages.errors.shape[1]):
        error_5 = error_3 = 0.0
        for k in range(END_STAGE + 1):
            error_5 += ERROR_5[k] * derivatives[i, k]
            error_3 += ERROR_3[k] * derivatives[i, k]
        stages.errors[0, i], stages.errors[1, i] = error_5, error_3


@jit_in_place
def evaluate_error_norm(stages: Stages, error_scale: FloatArray, h: float) -> float:
    """Return the error of a step relative to the scales, from Hairer's combination of the estimates of order 5 and 3."""
    sum_5 = sum_3 = 0.0
    for i in range(error_scale.size):
        sum_5 += (stages.errors[0, i] / error_scale[i]) ** 2
        sum_3 += (stages.errors[1, i] / error_scale[i]) ** 2
    if sum_5 == 0.0 and sum_3 == 0.0:
        return 0.0
    return h * sum_5 / math.sqrt((sum_5 + 0.01 * sum_3) * error_scale.size)


@jit_in_place
def estimate_dominant_eigenvalue(stages: Stages, error_scale: FloatArray) -> float:
    """Return Hairer's estimate of the largest eigenvalue (1/s) from the last two stages."""
    derivative_difference = state_difference = 0.0
    for i in range(stages.n_coupled):
        derivative_change = stages.derivatives[i, END_STAGE] - stages.derivatives[i, END_STAGE - 1]
        derivative_difference += (derivative_change / error_scale[i]) ** 2
        state_difference += ((stages.end[i] - stages.last_stage_state[i]) / error_scale[i]) ** 2
    return math.sqrt(derivative_difference / state_difference) if state_difference > 0.0 else 0.0


@jit_in_place
def prepare_dense_output(stages: Stages, state: FloatArray, h: float) -> None:
    """Fill the coefficients of the interpolant of order 7 from all 16 stages."""
    derivatives, dense = stages.derivatives, stages.dense
    for i in range(stages.errors.shape[1]):
        increment = stages.end[i] - state[i]
        dense[i, 0] = increment
        dense[i, 1] = h * derivatives[i, 0] - increment
        dense[i, 2] = 2.0 * increment - h * (derivatives[i, END_STAGE] + derivatives[i, 0])
        for r in range(4):
            total = 0.0
            for k in range(N_STAGES):
                total += DENSE_WEIGHTS[r, k] * derivatives[i, k]
            dense[i, 3 + r] = h * total


@jit_in_place
def evaluate_dense_output(stages: Stages, state: FloatArray, fraction: float, result: FloatArray) -> None:
    """Evaluate the interpolant at a fraction of the step that starts from `state`."""
    for i in range(stages.errors.shape[1]):
        total = 0.0
        for r in range(6, -1, -1):
            total = (total + stages.dense[i, r]) * (fraction if r % 2 == 0 else 1.0 - fraction)
        result[i] = state[i] + total
