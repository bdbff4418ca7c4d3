"""The Radau IIA methods on stiff problems with known solutions.

Numba compiles them for these problems, which takes seconds; `test_stiff_scenes.py` guards the same laws where the engine uses them.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import radau

from governor_mechanism.integrators.radau import RadauLimits, StiffEquationFunctions, make_radau
from governor_mechanism.integrators.radau_stages import (
    RadauBuffers,
    factorise_matrices,
    finish_increments,
    interpolate_state,
    make_error_estimate,
    make_newton_iteration,
    make_radau_buffers,
    make_radau_tableau,
)
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.step_record import NO_STEPS, IntegrationStatus, make_step_record, record_step
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray

N_COUPLED, N_COMPONENTS = 2, 3


class StiffProblem(NamedTuple):
    """Van der Pol's oscillator, or Kaps' problem; the third component is the integral of the second one.

    Kaps' problem x' = -(rate + 2) x + rate y^2, y' = x - y - y^2 has the solution x = exp(-2 t), y = exp(-t) at any rate.
    """

    rate: float
    is_oscillator: bool
    last_time: float
    jacobian_factor: float
    counts: IntArray


def derivative_of(problem, time, state, result):
    x, y = state[0], state[1]
    if problem.is_oscillator:
        result[0], result[1] = y, problem.rate * ((1.0 - x * x) * y - x)
    else:
        result[0], result[1] = -(problem.rate + 2.0) * x + problem.rate * y * y, x - y - y * y
    result[2] = y


fill_derivative = jit_in_place(derivative_of)


@jit_in_place
def start_step(problem: StiffProblem) -> None:
    """There is nothing to prepare."""


@jit_in_place
def evaluate(problem: StiffProblem, time: float, state: FloatArray, derivative: FloatArray, stage: int) -> float:
    problem.counts[StepCounter.EVALUATIONS] += 1
    fill_derivative(problem, time, state, derivative)
    return 1.0 if time <= problem.last_time else -1.0


@jit_in_place
def evaluate_jacobian(problem: StiffProblem, time: float, state: FloatArray, derivative: FloatArray, jacobian: FloatArray) -> float:
    x, y = state[0], state[1]
    if problem.is_oscillator:
        jacobian[0, 0], jacobian[0, 1] = 0.0, 1.0
        jacobian[1, 0], jacobian[1, 1] = -problem.rate * (2.0 * x * y + 1.0), problem.rate * (1.0 - x * x)
    else:
        jacobian[0, 0], jacobian[0, 1] = -(problem.rate + 2.0), 2.0 * problem.rate * y
        jacobian[1, 0], jacobian[1, 1] = 1.0, -1.0 - 2.0 * y
    jacobian[2, 0], jacobian[2, 1] = 0.0, 1.0
    for i in range(N_COMPONENTS):
        jacobian[i, 0] *= problem.jacobian_factor
    return 1.0 if problem.jacobian_factor != 0.0 else -1.0


@jit_in_place
def finish_step(problem: StiffProblem, time: float, state: FloatArray, derivative: FloatArray) -> IntegrationStatus:
    evaluate(problem, time, state, derivative, 0)
    return IntegrationStatus.OUT_OF_RANGE if abs(state[0]) > 100.0 else IntegrationStatus.DONE


@jit_in_place
def write_output(problem: StiffProblem, time: float, state: FloatArray, output: FloatArray) -> None:
    for i in range(N_COMPONENTS):
        output[i] = state[i]


_integrate = jit_in_place(make_radau(StiffEquationFunctions(start_step, evaluate, evaluate_jacobian, finish_step, write_output)))
_iterate = jit_in_place(make_newton_iteration(evaluate))
_estimate = jit_in_place(make_error_estimate(evaluate))


@jit_in_place
def integrate_problem(
    problem: StiffProblem,
    buffers: RadauBuffers,
    span: tuple[float, float],
    state: FloatArray,
    limits: RadauLimits,
    times: FloatArray,
    outputs: FloatArray,
) -> tuple[IntegrationStatus, float, int, float]:
    return _integrate(problem, buffers, span, 0.0, state, limits, times, outputs)


@jit_in_place
def take_step(problem: StiffProblem, buffers: RadauBuffers, time: float, h: float, state: FloatArray) -> int:
    """Fill the increments of a step, to rounding, and return the number of iterations; 0 if they do not converge.

    An integration gives a long step up that needs more iterations than a shorter one. Here they go on.
    """
    evaluate_jacobian(problem, time, state, buffers.start_derivative, buffers.jacobian)
    factorise_matrices(buffers, h)
    buffers.increments[:] = 0.0
    n_iterations = 0
    for _ in range(5):
        if n_iterations == 0:
            n_iterations = _iterate(problem, buffers, time, h, state, 1e-12, 1.0)[0]
    return n_iterations


def make_problem(rate, n_stages, *, is_oscillator=False, last_time=math.inf, jacobian_factor=1.0):
    problem = StiffProblem(rate, is_oscillator, last_time, jacobian_factor, np.zeros(len(StepCounter), dtype=np.int64))
    return problem, make_radau_buffers(n_stages, N_COUPLED, np.ones(N_COMPONENTS), problem.counts)


def integrate(rate, tolerance, times, start=(1.0, 1.0, 0.0), *, n_stages=5, max_steps=10_000, step=1e-4, coarser_steps=NO_STEPS, **options):
    """Return status, states at the times, the time of the end, and the counters."""
    problem, buffers = make_problem(rate, n_stages, **options)
    state, outputs = np.array(start), np.full((len(times), N_COMPONENTS), np.nan)
    limits = RadauLimits(tolerance, step, max_steps, coarser_steps)
    status, _, _, time = integrate_problem(problem, buffers, (0.0, float(times[-1])), state, limits, np.asarray(times), outputs)
    return status, outputs, time, problem.counts


def solve_kaps(times):
    return np.stack([np.exp(-2 * times), np.exp(-times), -np.expm1(-times)], axis=-1)


def fixed_step_errors(rate, n_stages, n_steps):
    """Return the error at t = 1, and the largest one within the steps, of n steps of equal length."""
    problem, buffers = make_problem(rate, n_stages)
    state, h, largest, inside = np.array([1.0, 1.0, 0.0]), 1.0 / n_steps, 0.0, np.empty(N_COMPONENTS)
    for k in range(n_steps):
        assert take_step(problem, buffers, k * h, h, state) > 0
        for fraction in (0.15, 0.45, 0.75):
            interpolate_state(buffers, state, fraction, inside)
            largest = max(largest, np.max(np.abs(inside - solve_kaps(np.float64((k + fraction) * h)))))
        finish_increments(buffers, state)
    return np.max(np.abs(state - solve_kaps(np.float64(1.0)))), largest


def observed_order(errors, counts):
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def test_the_method_of_three_stages_is_that_of_scipy():
    tableau = make_radau_tableau(3)
    nodes = np.array([(4 - 6**0.5) / 10, (4 + 6**0.5) / 10, 1.0])
    np.testing.assert_allclose(tableau.nodes[1:], nodes, rtol=4e-16)
    # Derivatives at the nodes of the polynomials of degree up to 3 that vanish at the start.
    np.testing.assert_allclose(tableau.inverse_matrix @ np.vander(nodes, 4)[:, :3], np.vander(nodes, 3) * [3, 2, 1], atol=1e-14)
    assert tableau.real_eigenvalue == pytest.approx(radau.MU_REAL, rel=1e-14)
    assert tableau.complex_eigenvalues[0] == pytest.approx(np.conj(radau.MU_COMPLEX), rel=1e-14)
    np.testing.assert_allclose(tableau.real_eigenvalue * tableau.error_weights, radau.E, rtol=1e-13)


@pytest.mark.parametrize("n_stages", [3, 5, 7])
def test_the_coefficients_satisfy_the_conditions_of_order(n_stages):
    tableau = make_radau_tableau(n_stages)
    nodes, matrix = tableau.nodes[1:], np.linalg.inv(tableau.inverse_matrix)
    for k in range(1, 2 * n_stages):
        assert matrix[-1] @ nodes ** (k - 1) == pytest.approx(1 / k, rel=1e-14)
    identity = np.outer(tableau.from_real, tableau.to_real) + (tableau.from_complex @ tableau.to_complex).real
    np.testing.assert_allclose(
        identity, np.eye(n_stages), atol=1e3 * np.finfo(float).eps
    )  # condition number of the eigenvectors: below 1e3


@pytest.mark.long
@pytest.mark.parametrize(("n_stages", "counts"), [(3, [4, 8, 16]), (5, [1, 2, 3])])
def test_errors_fall_with_the_order_of_the_method_and_of_its_dense_output(n_stages, counts):
    errors = np.array([fixed_step_errors(1.0, n_stages, n) for n in counts])
    # 2 s - 1 at the end of the steps, s + 1 within; few steps, because five stages reach rounding with four.
    assert observed_order(errors[:, 0], counts) == pytest.approx(2 * n_stages - 1, abs=0.5)
    assert observed_order(errors[:, 1], counts) == pytest.approx(n_stages + 1, abs=0.5)


@pytest.mark.long
@pytest.mark.parametrize("n_stages", [3, 5])
def test_stiffness_reduces_the_order_to_no_less_than_the_number_of_stages(n_stages):
    counts = [1, 2, 4]
    errors = np.array([fixed_step_errors(1e6, n_stages, n) for n in counts])
    assert observed_order(errors[:, 1], counts) > n_stages - 0.2
    assert np.all(errors[:, 0] < errors[:, 1])


@pytest.mark.long
@pytest.mark.parametrize("rate", [0.0, 1e2, 1e4, 1e8])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_errors_follow_the_tolerance_at_any_stiffness(rate, tolerance):
    times = np.linspace(0.0, 5.0, 51)[1:]
    status, states, time, counts = integrate(rate, tolerance, times)
    assert status == IntegrationStatus.DONE
    assert time == 5.0
    # Errors of a decaying motion hardly add up; the error of the integral is that of a sum over the steps.
    np.testing.assert_allclose(states, solve_kaps(times), rtol=0, atol=10 * tolerance)
    assert counts[StepCounter.ACCEPTED] < 12 * tolerance ** (-1 / 6)  # as long as the order of the error estimate allows


@pytest.mark.long
def test_a_relaxation_oscillation_agrees_with_scipy():
    # Van der Pol's oscillator: slow for 0.8 s, then a jump at rates of 1e5.
    times, start, rate = [0.5, 1.0, 1.5, 2.0], (2.0, -0.66, 0.0), 1e3
    status, states, _, _ = integrate(rate, 1e-9, times, start, is_oscillator=True)
    assert status == IntegrationStatus.DONE
    problem = make_problem(rate, 5, is_oscillator=True)[0]

    def derivative(time, state):
        result = np.empty(N_COMPONENTS)
        derivative_of(problem, time, state, result)
        return result

    expected = solve_ivp(derivative, (0.0, 2.0), start, method="Radau", t_eval=times, rtol=1e-8, atol=1e-8).y.T
    np.testing.assert_allclose(states, expected, rtol=0, atol=1e-7)  # errors of 500 steps of scipy


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "status"),
    [
        ({"max_steps": 5}, IntegrationStatus.STEP_LIMIT),
        ({"last_time": 0.5}, IntegrationStatus.STALLED),
        ({"start": (101.0, 1.0, 0.0)}, IntegrationStatus.OUT_OF_RANGE),
        ({"start": (1.0, 1e160, 0.0)}, IntegrationStatus.STALLED),  # its square is not a number
        ({"jacobian_factor": 0.0}, IntegrationStatus.STALLED),  # outside its domain
        ({"jacobian_factor": math.nan}, IntegrationStatus.STALLED),
    ],
)
def test_an_integration_that_cannot_go_on_says_why(options, status):
    end, states, time, _ = integrate(10.0, 1e-6, np.array([0.25, 5.0]), **options)
    assert end == status
    assert 0.0 <= time <= 0.5
    assert np.isnan(states[1, 0])


@pytest.mark.long
def test_a_doubtful_estimate_is_filtered_again_where_the_equation_is_defined():
    estimates = {}
    for last_time in (math.inf, -1.0):
        problem, buffers = make_problem(1e6, 3, last_time=last_time)
        state, h = np.array([1.1, 1.0, 0.0]), 0.1  # not on the slow solution: what decays fast makes the estimate too large
        fill_derivative(problem, 0.0, state, buffers.start_derivative)
        evaluate_jacobian(problem, 0.0, state, buffers.start_derivative, buffers.jacobian)
        factorise_matrices(buffers, h)
        buffers.increments[:] = solve_kaps(h * buffers.tableau.nodes[1:]) - state
        estimates[last_time] = [float(_estimate(problem, buffers, 0.0, h, state, 1e-6, is_doubtful)) for is_doubtful in (False, True)]
    assert estimates[math.inf][1] < 0.1 * estimates[math.inf][0]
    assert estimates[-1.0][1] == estimates[-1.0][0] == estimates[math.inf][0]


@pytest.mark.long
def test_what_rests_goes_on_resting():
    status, states, _, counts = integrate(10.0, 1e-6, np.array([5.0]), start=(0.0, 0.0, 0.0))
    assert status == IntegrationStatus.DONE
    assert np.all(states == 0.0)
    assert counts[StepCounter.ACCEPTED] < 10  # each step is eight times as long as the one before, from 0.1 ms on


@pytest.mark.long
def test_steps_are_half_as_long_as_those_of_another_run_and_keep_their_matrices():
    steps = make_step_record(50)
    for k in range(50):
        record_step(steps, 0.1 * (k + 1), 0.1, 1.0)
    status, states, _, counts = integrate(1e4, 1e-3, np.array([5.0]), coarser_steps=steps, step=0.05)
    assert status == IntegrationStatus.DONE
    assert 100 <= counts[StepCounter.ACCEPTED] <= 101  # rounding of the times may leave a rest
    np.testing.assert_allclose(states, solve_kaps(np.array([5.0])), atol=1e-6)
