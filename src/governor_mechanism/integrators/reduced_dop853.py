"""One step of DOP853 for one coordinate and its rate, its error, and what lies within it; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.integrators.tableau import DENSE_NODES, DENSE_STAGES, DENSE_WEIGHTS, ERROR_3, ERROR_5, NODES, STAGES, WEIGHTS
from governor_mechanism.mechanics.reduction.equation_of_motion import N_QUADRATURES, ReducedModel, evaluate_equation_of_motion
from governor_mechanism.mechanics.reduction.lowering import IS_CONSERVATIVE
from governor_mechanism.mechanics.reduction.node_evaluation import POTENTIAL_COLUMN, QUADRATIC_COLUMN
from governor_mechanism.mechanics.reduction.table import find_piece
from governor_mechanism.numerics.chebyshev import evaluate_piece, evaluate_piece_inline
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, IntArray

FIRST_NONZERO_STAGE = np.array([1, 1, 1, 2, 2, 3, 3, 3, 3, 3, 3, 3, 5])
"""The first stage after stage 0 that counts in each, and in the step itself: those between have no weight."""


class Stages(NamedTuple):
    """Rates (16,) and accelerations (16,) at the stages of a step, and what flows (16, FLOWS); room for the inside of
    a step (2 + FLOWS, 7); last (1,), the coordinate at the stage before its end."""

    rates: FloatArray
    accelerations: FloatArray
    quadrature_rates: FloatArray
    dense: FloatArray
    q_last_stage: FloatArray


def make_stages() -> Stages:
    """Room for a step."""
    return Stages(np.zeros(16), np.zeros(16), np.zeros((16, N_QUADRATURES)), np.zeros((2 + N_QUADRATURES, 7)), np.zeros(1))


@jit_internal
def take_step(
    model: ReducedModel, local_time: float, h: float, q: float, v: float, piece_index: int, stages: Stages
) -> tuple[float, float, int, int]:
    """Coordinate and rate a step h later, from stages[0]; the piece they are on, and -1.

    Where none is laid, the side to lay one on stands in place of that.
    """
    if model.parameters[IS_CONSERVATIVE] != 0.0:
        return _take_conservative_step(
            model.coefficients,
            model.intervals,
            model.neighbours,
            model.periodicity,
            h,
            q,
            v,
            piece_index,
            stages.rates,
            stages.accelerations,
        )
    q_end, v_end, side = q, v, -1
    for stage in range(1, 13):
        mean_rate, mean_acceleration, node = _stage_increments(stage, stages.rates, stages.accelerations)
        q_end, v_end = q + h * mean_rate, v + h * mean_acceleration
        piece_index, t, side = find_piece(model.intervals, model.neighbours, model.periodicity, q_end, piece_index)
        if side >= 0:
            break
        if stage == 11:
            stages.q_last_stage[0] = q_end
        stages.rates[stage] = v_end
        stages.accelerations[stage] = evaluate_equation_of_motion(
            model, piece_index, t, v_end, local_time + node * h, stages.quadrature_rates, stage
        )
    return q_end, v_end, piece_index, side


@jit_internal
def _take_conservative_step(
    coefficients: FloatArray,
    intervals: FloatArray,
    neighbours: IntArray,
    periodicity: FloatArray,
    h: float,
    q: float,
    v: float,
    piece_index: int,
    rates: FloatArray,
    accelerations: FloatArray,
) -> tuple[float, float, int, int]:
    """The same where the first two columns are all that acts, in one loop without calls: five times as fast."""
    q_end, v_end, side, is_periodic = q, v, -1, periodicity[0] > 0.0
    for stage in range(1, 13):
        if stage < 12:
            mean_rate, mean_acceleration = STAGES[stage, 0] * rates[0], STAGES[stage, 0] * accelerations[0]
            for k in range(FIRST_NONZERO_STAGE[stage], stage):
                mean_rate += STAGES[stage, k] * rates[k]
                mean_acceleration += STAGES[stage, k] * accelerations[k]
        else:
            mean_rate, mean_acceleration = WEIGHTS[0] * rates[0], WEIGHTS[0] * accelerations[0]
            for k in range(5, 12):
                mean_rate += WEIGHTS[k] * rates[k]
                mean_acceleration += WEIGHTS[k] * accelerations[k]
        q_end, v_end = q + h * mean_rate, v + h * mean_acceleration
        t = (q_end - intervals[piece_index, 2]) * intervals[piece_index, 3]
        if is_periodic or abs(t) > 1.0:
            piece_index, t, side = find_piece(intervals, neighbours, periodicity, q_end, piece_index)
            if side >= 0:
                break
        rates[stage] = v_end
        accelerations[stage] = evaluate_piece_inline(
            coefficients, piece_index, QUADRATIC_COLUMN, t
        ) * v_end * v_end + evaluate_piece_inline(coefficients, piece_index, POTENTIAL_COLUMN, t)
    return q_end, v_end, piece_index, side


@jit_internal
def _stage_increments(stage: int, rates: FloatArray, accelerations: FloatArray) -> tuple[float, float, float]:
    """The weighed means of rates and accelerations up to a stage, and its part of the step; stage 12 is its end."""
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
def error_norm(
    quadrature_rates: FloatArray,
    rates: FloatArray,
    accelerations: FloatArray,
    coordinate_scale: float,
    time_scale: float,
    energy_scale: float,
    h: float,
) -> float:
    """The error of a step, each number relative to its scale, as Hairer combines those of order 5 and 3."""
    fifth, third = _squared_errors(rates, accelerations, 1.0 / coordinate_scale, time_scale / coordinate_scale)
    for c in range(N_QUADRATURES):
        column, scale = quadrature_rates[:, c], 1.0 if c == N_QUADRATURES - 1 else 1.0 / energy_scale
        five, three = _squared_errors(column, column, scale, 0.0)
        fifth, third = fifth + five, third + three
    return _combine_error_orders(fifth, third, h, 2.0 + N_QUADRATURES)


@jit_internal
def conservative_error_norm(rates: FloatArray, accelerations: FloatArray, coordinate_scale: float, time_scale: float, h: float) -> float:
    """The same where nothing flows."""
    fifth, third = _squared_errors(rates, accelerations, 1.0 / coordinate_scale, time_scale / coordinate_scale)
    return _combine_error_orders(fifth, third, h, 2.0)


@jit_internal
def _squared_errors(first: FloatArray, second: FloatArray, first_scale: float, second_scale: float) -> tuple[float, float]:
    """The squares of the errors of order 5 and 3 of two numbers, per second, summed."""
    first_five = first_three = second_five = second_three = 0.0
    for k in range(12):
        first_five += ERROR_5[k] * first[k]
        first_three += ERROR_3[k] * first[k]
        second_five += ERROR_5[k] * second[k]
        second_three += ERROR_3[k] * second[k]
    fifth = (first_five * first_scale) ** 2 + (second_five * second_scale) ** 2
    return fifth, (first_three * first_scale) ** 2 + (second_three * second_scale) ** 2


@jit_internal
def _combine_error_orders(fifth: float, third: float, h: float, n_components: float) -> float:
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * n_components)


@jit_internal
def estimate_stiffness(rates: FloatArray, accelerations: FloatArray, q_last_stage: FloatArray, q_end: float, v_end: float) -> float:
    """The fastest rate (1/s) at which neighbouring motions come together, as the last two stages tell it."""
    derivative_change = (rates[12] - rates[11]) ** 2 + (accelerations[12] - accelerations[11]) ** 2
    state_change = (q_end - q_last_stage[0]) ** 2 + (v_end - rates[11]) ** 2
    return math.sqrt(derivative_change / state_change) if state_change > 0.0 else 0.0


@jit_internal
def prepare_dense_output(
    model: ReducedModel, local_time: float, h: float, q: float, v: float, q_end: float, v_end: float, piece_index: int, stages: Stages
) -> int:
    """Prepare stages.dense for what lies within a step, of three more evaluations; -1, or the side to lay on."""
    rates, accelerations, quadrature_rates, dense = (stages.rates, stages.accelerations, stages.quadrature_rates, stages.dense)
    coefficients, intervals, neighbours, periodicity, is_conservative = (
        model.coefficients,
        model.intervals,
        model.neighbours,
        model.periodicity,
        model.parameters[IS_CONSERVATIVE] != 0.0,
    )
    for extra in range(3):
        mean_rate = mean_acceleration = 0.0
        for k in range(13 + extra):
            mean_rate += DENSE_STAGES[extra, k] * rates[k]
            mean_acceleration += DENSE_STAGES[extra, k] * accelerations[k]
        piece_index, t, side = find_piece(intervals, neighbours, periodicity, q + h * mean_rate, piece_index)
        if side >= 0:
            return side
        v_stage = v + h * mean_acceleration
        rates[13 + extra] = v_stage
        if is_conservative:
            accelerations[13 + extra] = evaluate_piece(coefficients, piece_index, QUADRATIC_COLUMN, t) * v_stage * v_stage + evaluate_piece(
                coefficients, piece_index, POTENTIAL_COLUMN, t
            )
        else:
            stage_time = local_time + DENSE_NODES[extra] * h
            accelerations[13 + extra] = evaluate_equation_of_motion(
                model, piece_index, t, v_stage, stage_time, quadrature_rates, 13 + extra
            )
    _fill_dense_coefficients(rates, q_end - q, h, dense, 0)
    _fill_dense_coefficients(accelerations, v_end - v, h, dense, 1)
    for c in range(0 if is_conservative else N_QUADRATURES):
        column = quadrature_rates[:, c]
        _fill_dense_coefficients(column, h * mean_stage_derivative(column), h, dense, 2 + c)
    return -1


@jit_internal
def mean_stage_derivative(derivatives: FloatArray) -> float:
    """The step's mean of something whose slopes are known at its stages."""
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
    """The change from the step's beginning to a part of it."""
    p, remainder = fraction, 1.0 - fraction
    total = (dense[component, 6] * p + dense[component, 5]) * remainder + dense[component, 4]
    return float(
        (
            (((total * p + dense[component, 3]) * remainder + dense[component, 2]) * p + dense[component, 1]) * remainder
            + dense[component, 0]
        )
        * p
    )
