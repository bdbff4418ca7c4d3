"""Band systems, regular and singular, against dense linear algebra."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from governor_mechanism.numerics import linear_equations
from governor_mechanism.numerics.linear_equations import diagonalise, solve_band_system
from interpreted_kernels import interpret_kernels

kernels_as_python = interpret_kernels(linear_equations)


def band_of(matrix, bandwidth):
    """Return the lower band of a symmetric matrix by columns, the diagonal first."""
    band = np.zeros((len(matrix), bandwidth + 1))
    for k in range(bandwidth + 1):
        band[: len(matrix) - k, k] = np.diag(matrix, -k)
    return band


def solve(matrix, right_hand_side, bandwidth):
    """Return solution and pivot ratio."""
    band, solution, n_rows = band_of(matrix, bandwidth), right_hand_side.copy(), len(matrix)
    return solution, solve_band_system(band, np.zeros_like(band), np.zeros((2, n_rows, n_rows)), solution)


def coupled_rows(seed, n_rows, bandwidth, n_dependent):
    """Return J J^T of rows that are coupled with their neighbours, of which some are multiples of others."""
    generator, jacobian = np.random.default_rng(seed), np.zeros((n_rows, n_rows + bandwidth))
    for i in range(n_rows):
        jacobian[i, i : i + bandwidth] = generator.normal(size=bandwidth)
    for i in generator.choice(n_rows - 1, size=n_dependent, replace=False):
        jacobian[i + 1] = jacobian[i] * generator.uniform(0.5, 2.0)
    return jacobian @ jacobian.T


@given(st.integers(0, 10**6), st.integers(2, 12), st.integers(1, 4))
def test_a_regular_system_is_solved_as_by_dense_algebra(seed, n_rows, bandwidth):
    matrix = coupled_rows(seed, n_rows, bandwidth, 0) + np.eye(n_rows)
    right_hand_side = np.random.default_rng(seed).normal(size=n_rows)
    solution, ratio = solve(matrix, right_hand_side, min(bandwidth, n_rows - 1))
    assert 0.0 < ratio <= 1.0
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, right_hand_side), rtol=1e-9, atol=1e-9)


@given(st.integers(0, 10**6), st.integers(3, 12), st.integers(1, 2))
def test_redundant_rows_get_the_solution_of_least_norm(seed, n_rows, n_dependent):
    matrix = coupled_rows(seed, n_rows, 2, n_dependent)
    right_hand_side = matrix @ np.random.default_rng(seed).normal(size=n_rows)  # consistent
    solution, ratio = solve(matrix, right_hand_side, n_rows - 1)
    expected = np.linalg.pinv(matrix, rcond=1e-12, hermitian=True) @ right_hand_side
    values = np.linalg.eigvalsh(matrix)
    smallest = values[values > 1e-9 * values[-1]][0]  # rounding of the data is magnified by the condition
    assume(not np.any((values > 1e-14 * values[-1]) & (values <= 1e-9 * values[-1])))  # else the rank is a matter of rounding
    assert ratio == 0.0
    np.testing.assert_allclose(solution, expected, rtol=0, atol=1e-13 * values[-1] / smallest * (1 + np.abs(expected).max()))


@given(st.integers(0, 10**6), st.integers(1, 15))
def test_eigenvectors_are_orthogonal_and_diagonalise(seed, n_rows):
    generator = np.random.default_rng(seed)
    factor = generator.normal(size=(n_rows, n_rows)) * 10.0 ** generator.uniform(-3, 3, size=n_rows)
    matrix = factor.T @ factor
    values, vectors = matrix.copy(), np.zeros((n_rows, n_rows))
    diagonalise(values, vectors)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(n_rows), atol=1e-13 * n_rows)
    np.testing.assert_allclose(vectors @ np.diag(np.diag(values)) @ vectors.T, matrix, atol=1e-13 * n_rows * np.abs(matrix).max())
    expected = np.linalg.eigvalsh(matrix)
    np.testing.assert_allclose(np.sort(np.diag(values)), expected, atol=1e-13 * n_rows * expected[-1])


@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_what_is_not_finite_gives_nan(value):
    solution, ratio = solve(np.array([[1.0, 1.0], [1.0, 1.0]]) * value, np.ones(2), 1)
    assert ratio == 0.0
    assert np.isnan(solution).all()
