"""One step of a Radau IIA method: tableau, buffers, linear systems, Newton iteration, error estimate and dense output; compiled."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.integrators.stages import Equation
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place, record_dtype
from governor_mechanism.types import ComplexArray, FloatArray, IntArray, RecordArray


@jit_in_place
def factorise_lu(
    matrix: NDArray[Any],  # matrix; becomes the unit lower and the upper triangle; shape (n, n)
    pivots: IntArray,  # result: the row with which each row was exchanged; shape (n,)
) -> bool:
    """Replace a square matrix by its factors, and return whether it is regular: no pivot is 0 or not a number."""
    n = pivots.size
    for k in range(n):
        pivots[k] = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivots[k], k]):
                pivots[k] = i
        if not abs(matrix[pivots[k], k]) > 0.0:
            return False
        if pivots[k] != k:
            for j in range(n):
                matrix[k, j], matrix[pivots[k], j] = matrix[pivots[k], j], matrix[k, j]
        inverse_pivot = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            if matrix[i, k] != 0.0:
                factor = matrix[i, k] * inverse_pivot
                matrix[i, k] = factor
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@jit_in_place
def solve_lu(factors: NDArray[Any], pivots: IntArray, vector: NDArray[Any]) -> None:
    """Solve in place with the factors and pivots of `factorise_lu`, for the leading components of a vector."""
    n = pivots.size
    for k in range(n):
        vector[k], vector[pivots[k]] = vector[pivots[k]], vector[k]
    for k in range(n):
        for i in range(k + 1, n):
            vector[i] -= factors[i, k] * vector[k]
    for k in range(n - 1, -1, -1):
        total = vector[k]
        for j in range(k + 1, n):
            total -= factors[k, j] * vector[j]
        vector[k] = total / factors[k, k]


class RadauTableau(NamedTuple):
    """Coefficients of the method with s stages, of order 2 s - 1.

    With the matrix A of the method, A^-1 = V diag(eigenvalues) V^-1. Of each pair of complex eigenvalues only one is listed.
    """

    nodes: FloatArray  # start and stages as fractions of the step; shape (s + 1,)
    inverse_matrix: FloatArray  # a^-1; shape (s, s)
    real_eigenvalue: float  # real eigenvalue of A^-1
    complex_eigenvalues: ComplexArray  # its complex eigenvalues with a positive imaginary part; shape (pairs,)
    to_real: FloatArray  # row of V^-1 of the real eigenvalue; shape (s,)
    to_complex: ComplexArray  # rows of V^-1 of the complex eigenvalues; shape (pairs, s)
    from_real: FloatArray  # column of V of the real eigenvalue; shape (s,)
    # columns of V of the complex eigenvalues, twice as large: the real part of the product counts the
    # conjugate pair; shape (s, pairs)
    from_complex: ComplexArray
    error_weights: FloatArray  # weights of the stage increments in the error estimate of order s; shape (s,)


@cache
def make_radau_tableau(
    n_stages: int,  # number of stages, odd: of an even number no eigenvalue is real
) -> RadauTableau:
    """Compute the coefficients of a method."""
    from numpy.polynomial import legendre  # only stiff motion needs it

    # The nodes on (-1, 1] are the zeros of P_s - P_(s-1), Legendre's polynomials.
    difference = np.zeros(n_stages + 1)
    difference[-2:] = -1.0, 1.0
    zeros = legendre.legroots(difference)
    zeros[-1] = 1.0
    for _ in range(2):  # Newton's method: to rounding
        zeros[:-1] -= legendre.legval(zeros[:-1], difference) / legendre.legval(zeros[:-1], legendre.legder(difference))
    # Collocation: A integrates Legendre's polynomials of degree below s from -1 to the nodes.
    basis = legendre.legvander(zeros, n_stages - 1)
    integrals = np.stack([legendre.legval(zeros, legendre.legint(row, lbnd=-1.0)) for row in np.eye(n_stages)], axis=1)
    inverse_matrix = np.asarray(2.0 * np.linalg.solve(integrals.T, basis.T).T, dtype=np.float64)
    eigenvalues, vectors = np.linalg.eig(inverse_matrix)
    real = int(np.argmin(np.abs(eigenvalues.imag)))
    is_above = eigenvalues.imag > 1e-9
    inverse_vectors = np.linalg.inv(vectors)
    real_eigenvalue = float(eigenvalues[real].real)
    # The embedded method has the same nodes and the weight 1 / real eigenvalue at the start; its conditions of order in Legendre's basis:
    # it integrates each polynomial of degree below s as the method does, of which the value at the start is (-1)^degree.
    weight_differences = np.linalg.solve(basis.T, -((-1.0) ** np.arange(n_stages)) / real_eigenvalue)
    return RadauTableau(
        nodes=np.append(0.0, 0.5 * (1.0 + zeros)),
        inverse_matrix=inverse_matrix,
        real_eigenvalue=real_eigenvalue,
        complex_eigenvalues=np.ascontiguousarray(eigenvalues[is_above]),
        to_real=np.ascontiguousarray((inverse_vectors[real] * vectors[-1, real]).real),
        to_complex=np.ascontiguousarray(inverse_vectors[is_above]),
        from_real=np.ascontiguousarray((vectors[:, real] / vectors[-1, real]).real),
        from_complex=np.ascontiguousarray(2.0 * vectors[:, is_above]),
        error_weights=weight_differences @ inverse_matrix,
    )


RADAU_PROGRESS_DTYPE = record_dtype(
    ("status", "i8"),  # an IntegrationStatus; DONE while nothing ends the integration
    ("t", "f8"),  # time of the state, s
    ("step", "f8"),  # length of the next step, s
    ("h", "f8"),  # length of the present step, s
    ("t_next", "f8"),  # its end, s
    ("is_last", "i8"),  # whether it ends the span
    ("is_cut", "i8"),  # whether a step of another run shortens it
    ("previous_h", "f8"),  # length of the step before, s; 0 if its increments predict nothing
    ("factorised_h", "f8"),  # length for which the matrices are factorised, s; 0 if they are not
    ("has_jacobian", "i8"),
    ("is_jacobian_current", "i8"),  # whether it is that of the present state
    ("jacobian_age", "i8"),  # steps since its evaluation
    ("n_iterations", "i8"),  # of Newton's method; 0 if they do not converge
    ("rate", "f8"),  # rate of their convergence
    ("error", "f8"),  # error of the step relative to the tolerance
    ("previous_error", "f8"),  # that of the step before
    ("is_doubtful", "i8"),  # whether a large estimate is filtered a second time: in a first step, and after a rejected one
    ("n_reached", "i8"),  # number of reported times that are reached
    ("coarser_step", "i8"),  # index of the step of another run at t
)
"""Progress of an integration, and its present step."""


class RadauBuffers(NamedTuple):
    """Method and buffers of one integration.

    A state begins with the components on which the derivative depends (n_coupled); those after them are quadratures.
    """

    tableau: RadauTableau  # coefficients of the method, with s stages
    error_scale: FloatArray  # scale of every component; shape (components,)
    jacobian: FloatArray  # derivatives of the state derivative by the coupled components; shape (components, n_coupled)
    real_factors: FloatArray  # LU factors of the matrix of the real eigenvalue; shape (n_coupled, n_coupled)
    complex_factors: ComplexArray  # those of the complex eigenvalues; shape (pairs, n_coupled, n_coupled)
    pivots: IntArray  # their row exchanges, of the real matrix last; shape (pairs + 1, n_coupled)
    increments: FloatArray  # differences of the states at the stages from the start; shape (s, components)
    previous_increments: FloatArray  # those of the step before; shape (s, components)
    residuals: FloatArray  # derivatives at the stages, then residuals of the collocation equations; shape (s, components)
    real_update: FloatArray  # update of the iteration along the real eigenvector; shape (components,)
    complex_updates: ComplexArray  # those along the complex eigenvectors; shape (pairs, components)
    stage_state: FloatArray  # state at a stage or at an output time; shape (components,)
    start_derivative: FloatArray  # derivative at the start of the step; shape (components,)
    errors: FloatArray  # errors of the step; shape (components,)
    weights: FloatArray  # weights of start and stages in an interpolated state; shape (s + 1,)
    progress: RecordArray  # progress of the integration, a record of `RADAU_PROGRESS_DTYPE`; shape (1,)
    counts: IntArray  # counters, indexed by `StepCounter`


def make_radau_buffers(
    n_stages: int,
    n_coupled: int,
    error_scale: FloatArray,  # scale of every component; shape (components,)
    counts: IntArray,
) -> RadauBuffers:
    """Allocate the buffers of an integration."""
    n, n_pairs = error_scale.size, n_stages // 2
    increments, previous_increments, residuals = (np.zeros((n_stages, n)) for _ in range(3))
    real_update, stage_state, start_derivative, errors = (np.zeros(n) for _ in range(4))
    return RadauBuffers(
        tableau=make_radau_tableau(n_stages),
        error_scale=error_scale,
        jacobian=np.zeros((n, n_coupled)),
        real_factors=np.zeros((n_coupled, n_coupled)),
        complex_factors=np.zeros((n_pairs, n_coupled, n_coupled), dtype=np.complex128),
        pivots=np.zeros((n_pairs + 1, n_coupled), dtype=np.int64),
        increments=increments,
        previous_increments=previous_increments,
        residuals=residuals,
        real_update=real_update,
        complex_updates=np.zeros((n_pairs, n), dtype=np.complex128),
        stage_state=stage_state,
        start_derivative=start_derivative,
        errors=errors,
        weights=np.zeros(n_stages + 1),
        progress=np.zeros(1, dtype=RADAU_PROGRESS_DTYPE),
        counts=counts,
    )


@jit_in_place
def _fill_matrix(jacobian: FloatArray, diagonal: Any, matrix: NDArray[Any]) -> None:
    """Fill the coupled part of diagonal * identity - jacobian."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[0]):
            matrix[i, j] = -jacobian[i, j]
        matrix[i, i] += diagonal


@jit_in_place
def factorise_matrices(buffers: RadauBuffers, h: float) -> bool:
    """Factorise the matrices of the iteration for a step size, and return whether all are regular."""
    tableau, n_pairs = buffers.tableau, buffers.complex_factors.shape[0]
    _fill_matrix(buffers.jacobian, tableau.real_eigenvalue / h, buffers.real_factors)
    is_regular = factorise_lu(buffers.real_factors, buffers.pivots[n_pairs])
    for k in range(n_pairs):
        _fill_matrix(buffers.jacobian, tableau.complex_eigenvalues[k] / h, buffers.complex_factors[k])
        is_regular = factorise_lu(buffers.complex_factors[k], buffers.pivots[k]) and is_regular
    return is_regular


@jit_in_place
def solve_shifted(jacobian: FloatArray, diagonal: Any, factors: NDArray[Any], pivots: IntArray, vector: NDArray[Any]) -> None:
    """Solve (diagonal * identity - jacobian) x = vector in place; the quadratures follow from the coupled components."""
    solve_lu(factors, pivots, vector)
    for i in range(pivots.size, vector.size):
        total = vector[i]
        for j in range(pivots.size):
            total += jacobian[i, j] * vector[j]
        vector[i] = total / diagonal


@jit_in_place
def solve_real(buffers: RadauBuffers, h: float, vector: FloatArray) -> None:
    """Solve with the matrix of the real eigenvalue in place."""
    n_pairs = buffers.complex_factors.shape[0]
    solve_shifted(buffers.jacobian, buffers.tableau.real_eigenvalue / h, buffers.real_factors, buffers.pivots[n_pairs], vector)


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
    nodes = buffers.tableau.nodes
    weights = buffers.weights
    previous = buffers.previous_increments
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
    inverse_matrix = buffers.tableau.inverse_matrix
    increments = buffers.increments
    residuals = buffers.residuals
    n_stages, n = increments.shape
    for stage in range(n_stages):
        for k in range(n_stages):
            factor = inverse_matrix[stage, k] / h
            for i in range(n):
                residuals[stage, i] -= factor * increments[k, i]


@jit_in_place
def _update_increments(buffers: RadauBuffers, h: float) -> float:
    """Add the solution of the linear systems for the residuals to the increments; return its mean size relative to the scales."""
    tableau = buffers.tableau
    residuals = buffers.residuals
    increments = buffers.increments
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
        nodes = buffers.tableau.nodes
        increments = buffers.increments
        residuals = buffers.residuals
        n_stages, n = increments.shape
        max_iterations = 5 + n_stages
        newton_tolerance = NEWTON_TOLERANCE_RATIO * tolerance
        rounding = NEWTON_ROUNDINGS * _rounding_of(state, buffers.error_scale)
        iteration = 0
        last_size = 0.0
        rate = max(last_rate, EPSILON) ** 0.8
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
    weights = buffers.tableau.error_weights
    errors = buffers.errors
    n_stages = buffers.increments.shape[0]
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
