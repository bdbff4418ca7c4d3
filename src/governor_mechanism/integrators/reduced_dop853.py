"""One step of DOP853 for the reduced model: step, error estimate and dense output; compiled."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.integrators.tableau import DENSE_NODES, DENSE_STAGES, DENSE_WEIGHTS, ERROR_3, ERROR_5, NODES, STAGES, WEIGHTS
from governor_mechanism.mechanics.reduction.equation_of_motion import (
    N_FURTHER_STATES,
    N_STATES,
    ReducedModel,
    StateIndex,
    evaluate_equation_of_motion,
)
from governor_mechanism.mechanics.reduction.lowering import ForceParameter
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.table import find_piece
from governor_mechanism.numerics.chebyshev import evaluate_piece, evaluate_piece_inline
from governor_mechanism.numerics.jit import jit_inline, jit_internal
from governor_mechanism.types import FloatArray

FIRST_NONZERO_STAGE = np.array([1, 1, 1, 2, 2, 3, 3, 3, 3, 3, 3, 3, 5])
"""First stage after stage 0 with a nonzero coefficient, for each stage and (last) for the step itself."""


class StepCounter(IntEnum):
    """Indices of the counters of an integration."""

    ACCEPTED = 0
    REJECTED = 1
    EVALUATIONS = 2
    """Evaluations of the equation of motion."""
    MOVING_EVALUATIONS = 3
    """Those while the mechanism is not held."""


class Stages(NamedTuple):
    """Stage values and buffers of one step.

    Attributes
    ----------
    rates
        Rate of the coordinate at the stages; shape (16,).
    accelerations
        Acceleration at the stages; shape (16,).
    further_rates
        Rates of the further states at the stages; shape (N_FURTHER_STATES, 16).
    dense
        Coefficients of the dense output; shape (N_STATES, 7).
    states
        States at stage 11, the last one before the end of the step, and at the end, without the energies; shape (2, N_STATES).
    """

    rates: FloatArray
    accelerations: FloatArray
    further_rates: FloatArray
    dense: FloatArray
    states: FloatArray


def make_stages() -> Stages:
    """Allocate the stages of a step.

    Returns
    -------
    Stages
        Buffers filled with zeros.
    """
    return Stages(np.zeros(16), np.zeros(16), np.zeros((N_FURTHER_STATES, 16)), np.zeros((N_STATES, 7)), np.zeros((2, N_STATES)))


make_stages_jit = jit_internal(make_stages)


@jit_inline
def _stage_increments(stage: int, rates: FloatArray, accelerations: FloatArray) -> tuple[float, float, float]:
    """Return the weighted means of rates and accelerations before a stage, and its node c_i; stage 12 is the end of the step."""
    if stage < 12:
        node, mean_rate, mean_acceleration = (NODES[stage], STAGES[stage, 0] * rates[0], STAGES[stage, 0] * accelerations[0])
        for k in range(FIRST_NONZERO_STAGE[stage], stage):
            mean_rate += STAGES[stage, k] * rates[k]
            mean_acceleration += STAGES[stage, k] * accelerations[k]
    else:
        node, mean_rate, mean_acceleration = 1.0, WEIGHTS[0] * rates[0], WEIGHTS[0] * accelerations[0]
        for k in range(5, 12):
            mean_rate += WEIGHTS[k] * rates[k]
            mean_acceleration += WEIGHTS[k] * accelerations[k]
    return mean_rate, mean_acceleration, node


@jit_internal
def take_step(model: ReducedModel, local_time: float, h: float, state: FloatArray, piece_index: int, stages: Stages) -> tuple[int, int]:
    """Take one step from the derivatives in stage 0.

    Parameters
    ----------
    model
        The reduced model.
    local_time
        Time of the start since the inputs' cubics begin, s.
    h
        Length of the step, s.
    state
        State at the start; shape (N_STATES,).
    piece_index
        Index of the table piece at the start.
    stages
        Its stage 0 is read, all others are filled, and the states.

    Returns
    -------
    piece_index : int
        Index of the table piece at the end.
    side : int
        -1, or the side on which a stage leaves the table: 0 below, 1 above.
    """
    if model.parameters[ForceParameter.IS_CONSERVATIVE] != 0.0:
        return _take_conservative_step(model, h, state, piece_index, stages)
    q, v, angle, speed = state[0], state[1], state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED]
    has_shaft, side = model.parameters[ForceParameter.HAS_SHAFT] != 0.0, -1
    angle_rates, speed_rates = stages.further_rates[2], stages.further_rates[3]
    for stage in range(1, 13):
        mean_rate, mean_acceleration, node = _stage_increments(stage, stages.rates, stages.accelerations)
        q_stage, v_stage, angle_stage, speed_stage = q + h * mean_rate, v + h * mean_acceleration, angle, speed
        if has_shaft:
            mean_rate, mean_acceleration, node = _stage_increments(stage, angle_rates, speed_rates)
            angle_stage, speed_stage = angle + h * mean_rate, speed + h * mean_acceleration
        _set_motion(stages.states[0 if stage == 11 else 1], q_stage, v_stage, angle_stage, speed_stage)
        piece_index, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, q_stage, piece_index)
        if side >= 0:
            break
        stages.rates[stage] = v_stage
        stages.accelerations[stage] = evaluate_equation_of_motion(
            model, piece_index, t, v_stage, angle_stage, speed_stage, local_time + node * h, stages.further_rates, stage
        )
    return piece_index, side


@jit_internal
def _set_motion(state: FloatArray, q: float, v: float, shaft_angle: float, shaft_speed: float) -> None:
    state[0], state[1], state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED] = q, v, shaft_angle, shaft_speed


@jit_internal
def _take_conservative_step(model: ReducedModel, h: float, state: FloatArray, piece_index: int, stages: Stages) -> tuple[int, int]:
    """Take a step of a conservative model, in one loop without calls: five times as fast."""
    rates, accelerations, coefficients = stages.rates, stages.accelerations, model.coefficients
    q, v, side, is_periodic = state[0], state[1], -1, model.periodicity[0] > 0.0
    q_end, v_end = q, v
    for stage in range(1, 13):
        mean_rate, mean_acceleration, _ = _stage_increments(stage, rates, accelerations)
        q_end, v_end = q + h * mean_rate, v + h * mean_acceleration
        t = (q_end - model.intervals[piece_index, 2]) * model.intervals[piece_index, 3]
        if is_periodic or abs(t) > 1.0:
            piece_index, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, q_end, piece_index)
            if side >= 0:
                break
        rates[stage] = v_end
        quadratic = evaluate_piece_inline(coefficients, piece_index, TableColumn.QUADRATIC, t)
        accelerations[stage] = quadratic * v_end * v_end + evaluate_piece_inline(coefficients, piece_index, TableColumn.POTENTIAL, t)
    stages.states[1, 0], stages.states[1, 1] = q_end, v_end
    return piece_index, side


@jit_internal
def error_norm(stages: Stages, parameters: FloatArray, h: float) -> float:
    """Return the error norm of a step, as DOP853 combines its estimates of order 5 and 3.

    Parameters
    ----------
    stages
        Stage values of the step.
    parameters
        Scales of the model, indexed by `ForceParameter`.
    h
        Length of the step, s.

    Returns
    -------
    float
        Root mean square of the errors relative to their scales.

    References
    ----------
    Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, section II.10.
    """
    coordinate_scale, time_scale = parameters[ForceParameter.COORDINATE_SCALE], parameters[ForceParameter.TIME_SCALE]
    fifth, third = _squared_errors(stages.rates, stages.accelerations, 1.0 / coordinate_scale, time_scale / coordinate_scale)
    n_components = 2.0
    if parameters[ForceParameter.IS_CONSERVATIVE] == 0.0:
        energy_factor = 1.0 / parameters[ForceParameter.ENERGY_SCALE]
        five, three = _squared_errors(stages.further_rates[0], stages.further_rates[1], energy_factor, energy_factor)
        fifth, third, n_components = fifth + five, third + three, 4.0
    if parameters[ForceParameter.HAS_SHAFT] != 0.0:
        five, three = _squared_errors(stages.further_rates[2], stages.further_rates[3], 1.0, time_scale)
        fifth, third, n_components = fifth + five, third + three, 6.0
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * n_components)


@jit_internal
def _squared_errors(first: FloatArray, second: FloatArray, first_scale: float, second_scale: float) -> tuple[float, float]:
    """Return the sums of the squared errors of order 5 and of order 3, per second, of two components."""
    first_five = first_three = second_five = second_three = 0.0
    for k in range(12):
        first_five += ERROR_5[k] * first[k]
        first_three += ERROR_3[k] * first[k]
        second_five += ERROR_5[k] * second[k]
        second_three += ERROR_3[k] * second[k]
    fifth = (first_five * first_scale) ** 2 + (second_five * second_scale) ** 2
    return fifth, (first_three * first_scale) ** 2 + (second_three * second_scale) ** 2


@jit_internal
def estimate_stiffness(stages: Stages) -> float:
    """Estimate the dominant eigenvalue of the Jacobian from the last two stages.

    Parameters
    ----------
    stages
        Stage values of the step.

    Returns
    -------
    float
        Its magnitude, 1/s.

    References
    ----------
    Hairer, Wanner: Solving Ordinary Differential Equations II, section IV.2.
    """
    rates, accelerations, state_change = stages.rates, stages.accelerations, 0.0
    derivative_change = (rates[12] - rates[11]) ** 2 + (accelerations[12] - accelerations[11]) ** 2
    for c in range(2, N_FURTHER_STATES):
        derivative_change += (stages.further_rates[c, 12] - stages.further_rates[c, 11]) ** 2
    for c in range(N_STATES):
        state_change += (stages.states[1, c] - stages.states[0, c]) ** 2
    return math.sqrt(derivative_change / state_change) if state_change > 0.0 else 0.0


@jit_internal
def prepare_dense_output(model: ReducedModel, local_time: float, h: float, state: FloatArray, piece_index: int, stages: Stages) -> int:
    """Fill the coefficients of the dense output of a step, with three more evaluations.

    Parameters
    ----------
    model
        The reduced model.
    local_time
        Time of the start since the inputs' cubics begin, s.
    h
        Length of the step, s.
    state
        State at the start; shape (N_STATES,).
    piece_index
        Index of the table piece at the start.
    stages
        The stages of the step; `dense` is filled.

    Returns
    -------
    int
        -1, or the side on which a stage leaves the table: 0 below, 1 above.
    """
    rates, accelerations, further_rates, dense = stages.rates, stages.accelerations, stages.further_rates, stages.dense
    q, v = state[0], state[1]
    coefficients, is_conservative = model.coefficients, model.parameters[ForceParameter.IS_CONSERVATIVE] != 0.0
    for extra in range(3):
        mean_rate = mean_acceleration = mean_speed = mean_shaft_acceleration = 0.0
        for k in range(13 + extra):
            mean_rate += DENSE_STAGES[extra, k] * rates[k]
            mean_acceleration += DENSE_STAGES[extra, k] * accelerations[k]
            mean_speed += DENSE_STAGES[extra, k] * further_rates[2, k]
            mean_shaft_acceleration += DENSE_STAGES[extra, k] * further_rates[3, k]
        piece_index, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, q + h * mean_rate, piece_index)
        if side >= 0:
            return side
        v_stage = v + h * mean_acceleration
        rates[13 + extra] = v_stage
        if is_conservative:
            accelerations[13 + extra] = evaluate_piece(
                coefficients, piece_index, TableColumn.QUADRATIC, t
            ) * v_stage * v_stage + evaluate_piece(coefficients, piece_index, TableColumn.POTENTIAL, t)
        else:
            stage_time = local_time + DENSE_NODES[extra] * h
            angle = state[StateIndex.SHAFT_ANGLE] + h * mean_speed
            speed = state[StateIndex.SHAFT_SPEED] + h * mean_shaft_acceleration
            accelerations[13 + extra] = evaluate_equation_of_motion(
                model, piece_index, t, v_stage, angle, speed, stage_time, further_rates, 13 + extra
            )
    _fill_dense_coefficients(rates, stages.states[1, 0] - q, h, dense, 0)
    _fill_dense_coefficients(accelerations, stages.states[1, 1] - v, h, dense, 1)
    for c in range(0 if is_conservative else N_FURTHER_STATES):
        _fill_dense_coefficients(further_rates[c], h * mean_stage_derivative(further_rates[c]), h, dense, 2 + c)
    return -1


@jit_internal
def mean_stage_derivative(derivatives: FloatArray) -> float:
    """Return the weighted mean of a derivative over the stages, which times the step is the increment.

    Parameters
    ----------
    derivatives
        Derivative at the stages; shape (16,).

    Returns
    -------
    float
        Mean derivative over the step.
    """
    total = WEIGHTS[0] * derivatives[0]
    for k in range(5, 12):
        total += WEIGHTS[k] * derivatives[k]
    return float(total)


@jit_internal
def _fill_dense_coefficients(derivatives: FloatArray, change: float, h: float, dense: FloatArray, component: int) -> None:
    dense[component, 0] = change
    dense[component, 1] = h * derivatives[0] - change
    dense[component, 2] = 2.0 * change - h * (derivatives[12] + derivatives[0])
    for r in range(4):
        total = 0.0
        for k in range(16):
            total += DENSE_WEIGHTS[r, k] * derivatives[k]
        dense[component, 3 + r] = h * total


@jit_internal
def evaluate_dense_output(dense: FloatArray, component: int, fraction: float) -> float:
    """Evaluate the increment of a component from the start of the step to a fraction of it.

    Parameters
    ----------
    dense
        Coefficients filled by `prepare_dense_output`; shape (N_STATES, 7).
    component
        Index of the state, see `StateIndex`.
    fraction
        Fraction of the step, 0 to 1.

    Returns
    -------
    float
        Increment of the component.
    """
    p, remainder = fraction, 1.0 - fraction
    total = (dense[component, 6] * p + dense[component, 5]) * remainder + dense[component, 4]
    return float(
        (
            (((total * p + dense[component, 3]) * remainder + dense[component, 2]) * p + dense[component, 1]) * remainder
            + dense[component, 0]
        )
        * p
    )
