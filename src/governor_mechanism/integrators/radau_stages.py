"""One step of a Radau IIA method: its simplified Newton iteration, error estimate and dense output; compiled."""

import math
from collections.abc import Callable

import numpy as np

from governor_mechanism.integrators.radau_systems import RadauBuffers, solve_real, solve_shifted
from governor_mechanism.integrators.stages import Equation
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

EPSILON = float(np.finfo(np.float64).eps)

NEWTON_TOLERANCE_RATIO = 1e-4
"""Error of the iteration relative to that of the step: it adds up over the steps, and must not be seen in the error estimate.

Where the directions of the stiff forces turn within a step, errors along the others decay more slowly than the first updates show. A slider
crank with a stiff damper on its slider had 30 to 100 times larger errors with a ratio of 0.01.
"""

NEWTON_ROUNDINGS = 100.0
"""Size of an update, in roundings of the state, up to which an iteration that no longer converges is at its end."""


@jit_in_place
def set_weights(nodes: FloatArray, fraction: float, weights: FloatArray) -> None:
    """Set the weights of start and stages in the collocation polynomial at a fraction of the step (Lagrange)."""
    for j in range(nodes.size):
        weight = 1.0
        for k in range(nodes.size):
            if k != j:
                weight *= (fraction - nodes[k]) / (nodes[j] - nodes[k])
        weights[j] = weight


@jit_in_place
def predict_increments(buffers: RadauBuffers, previous_h: float, h: float) -> None:
    """Fill the increments of a step from the collocation polynomial of the step before."""
    nodes, weights, previous = buffers.tableau.nodes, buffers.weights, buffers.previous_increments
    n_stages, n = previous.shape
    for stage in range(n_stages):
        set_weights(nodes, 1.0 + nodes[stage + 1] * h / previous_h, weights)
        for i in range(n):
            total = -previous[n_stages - 1, i]
            for k in range(n_stages):
                total += weights[k + 1] * previous[k, i]
            buffers.increments[stage, i] = total


@jit_in_place
def interpolate_state(buffers: RadauBuffers, state: FloatArray, fraction: float, result: FloatArray) -> None:
    """Fill result with the collocation polynomial at a fraction of the step that starts from `state`."""
    set_weights(buffers.tableau.nodes, fraction, buffers.weights)
    for i in range(state.size):
        total = 0.0
        for k in range(buffers.increments.shape[0]):
            total += buffers.weights[k + 1] * buffers.increments[k, i]
        result[i] = state[i] + total


@jit_in_place
def _subtract_slopes(buffers: RadauBuffers, h: float) -> None:
    """Subtract the slopes of the collocation polynomial from the derivatives at the stages: the residuals."""
    inverse_matrix, increments, residuals = buffers.tableau.inverse_matrix, buffers.increments, buffers.residuals
    n_stages, n = increments.shape
    for stage in range(n_stages):
        for k in range(n_stages):
            factor = inverse_matrix[stage, k] / h
            for i in range(n):
                residuals[stage, i] -= factor * increments[k, i]


@jit_in_place
def _update_increments(buffers: RadauBuffers, h: float) -> float:
    """Add the solution of the linear systems for the residuals to the increments; return its mean size relative to the scales."""
    tableau, residuals, increments = buffers.tableau, buffers.residuals, buffers.increments
    real_update, complex_updates = buffers.real_update, buffers.complex_updates
    n_stages, n = increments.shape
    n_pairs = complex_updates.shape[0]
    for i in range(n):
        real_total = 0.0
        for stage in range(n_stages):
            real_total += tableau.to_real[stage] * residuals[stage, i]
        real_update[i] = real_total
        for k in range(n_pairs):
            total = 0.0j
            for stage in range(n_stages):
                total += tableau.to_complex[k, stage] * residuals[stage, i]
            complex_updates[k, i] = total
    solve_real(buffers, h, real_update)
    for k in range(n_pairs):
        diagonal = tableau.complex_eigenvalues[k] / h
        solve_shifted(buffers.jacobian, diagonal, buffers.complex_factors[k], buffers.pivots[k], complex_updates[k])
    square_sum = 0.0
    for i in range(n):
        inverse_scale = 1.0 / buffers.error_scale[i]
        for stage in range(n_stages):
            update = tableau.from_real[stage] * real_update[i]
            for k in range(n_pairs):
                update += (tableau.from_complex[stage, k] * complex_updates[k, i]).real
            increments[stage, i] += update
            square_sum += (update * inverse_scale) ** 2
    return math.sqrt(square_sum / (n * n_stages))


@jit_in_place
def _rounding_of(state: FloatArray, error_scale: FloatArray) -> float:
    """Return the largest rounding of a component relative to its scale."""
    largest = 0.0
    for i in range(state.size):
        largest = max(largest, abs(state[i]) / error_scale[i])
    return EPSILON * largest


def make_newton_iteration(
    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float],
) -> Callable[[Equation, RadauBuffers, float, float, FloatArray, float, float], tuple[int, float]]:
    """Return the function that solves the collocation equations of a step by Newton's method with a kept Jacobian."""

    def iterate(
        equation: Equation,
        # buffers with the predicted increments, shape (stages, components), and the factorised matrices
        buffers: RadauBuffers,
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        state: FloatArray,  # state at the start; shape (components,)
        tolerance: float,
        last_rate: float,
    ) -> tuple[int, float]:
        """Solve the collocation equations in place; return the number of iterations, 0 without convergence, and its rate."""
        nodes, increments, residuals = buffers.tableau.nodes, buffers.increments, buffers.residuals
        n_stages, n = increments.shape
        max_iterations, newton_tolerance = 5 + n_stages, NEWTON_TOLERANCE_RATIO * tolerance
        rounding = NEWTON_ROUNDINGS * _rounding_of(state, buffers.error_scale)
        iteration, last_size, rate = 0, 0.0, max(last_rate, EPSILON) ** 0.8
        while True:  # max_iterations at most: what does not pass the first test of the rate in the last one fails the second
            iteration += 1
            for stage in range(n_stages):
                for i in range(n):
                    buffers.stage_state[i] = state[i] + increments[stage, i]
                quality = evaluate(equation, local_time + nodes[stage + 1] * h, buffers.stage_state, residuals[stage], stage)
                if quality < 0.0:
                    return 0, 1.0
            _subtract_slopes(buffers, h)
            size = _update_increments(buffers, h)
            if not size < math.inf:
                return 0, 1.0
            if size == 0.0:
                return iteration, 0.0
            if iteration > 1:
                last_rate, rate = rate, size / last_size
                if rate < 1.0 and rate / (1.0 - rate) * size <= newton_tolerance:
                    return iteration, rate
                if rate >= 1.0 or rate ** (max_iterations - iteration) / (1.0 - rate) * size > newton_tolerance:
                    return (iteration, last_rate) if size <= rounding else (0, 1.0)
            last_size = size

    return iterate


@jit_in_place
def estimate_errors(buffers: RadauBuffers, h: float, derivative: FloatArray) -> float:
    """Fill the errors of a step from the derivative at its start, filtered by the real matrix; return their mean relative to the scales."""
    weights, errors, n_stages = buffers.tableau.error_weights, buffers.errors, buffers.increments.shape[0]
    for i in range(errors.size):
        total = 0.0
        for stage in range(n_stages):
            total += weights[stage] * buffers.increments[stage, i]
        errors[i] = derivative[i] + buffers.tableau.real_eigenvalue / h * total
    solve_real(buffers, h, errors)
    square_sum = 0.0
    for i in range(errors.size):
        square_sum += (errors[i] / buffers.error_scale[i]) ** 2
    return math.sqrt(square_sum / errors.size)


def make_error_estimate(
    evaluate: Callable[[Equation, float, FloatArray, FloatArray, int], float],
) -> Callable[[Equation, RadauBuffers, float, float, FloatArray, float, bool], float]:
    """Return the function that estimates the error of a step relative to the tolerance."""
    # Where that is doubtful, a large estimate is filtered a second time, with the derivative at the
    # start plus the errors: in a first step and after a rejected one, components that decay fast would
    # make it too large.

    def estimate_error(
        equation: Equation,
        buffers: RadauBuffers,  # buffers with the increments of the step and the derivative at its start
        local_time: float,  # local time at the start of the step, s
        h: float,  # length of the step, s
        state: FloatArray,  # state at the start; shape (components,)
        tolerance: float,
        # whether a large estimate is filtered a second time: in a first step, and after a rejected one
        is_doubtful: bool,
    ) -> float:
        """Return the error of a step relative to the tolerance."""
        error = estimate_errors(buffers, h, buffers.start_derivative) / tolerance
        if error >= 1.0 and is_doubtful:
            for i in range(state.size):
                buffers.stage_state[i] = state[i] + buffers.errors[i]
            if evaluate(equation, local_time, buffers.stage_state, buffers.residuals[0], 0) >= 0.0:
                error = estimate_errors(buffers, h, buffers.residuals[0]) / tolerance
        return error

    return estimate_error


@jit_in_place
def finish_increments(buffers: RadauBuffers, state: FloatArray) -> None:
    """Move the state to the end of the step, and keep the increments for the prediction of the next one."""
    last = buffers.increments.shape[0] - 1
    for i in range(state.size):
        state[i] += buffers.increments[last, i]
    copy_array(buffers.previous_increments, buffers.increments)
