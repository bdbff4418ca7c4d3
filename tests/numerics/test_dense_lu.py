"""Dense LU factorisation."""

import numpy as np
import pytest

from governor_mechanism.integrators import radau_stages
from governor_mechanism.integrators.radau_stages import factorise_lu, solve_lu
from interpreted_kernels import interpret_kernels

kernels_as_python = interpret_kernels(radau_stages)


@pytest.mark.parametrize("kind", [np.float64, np.complex128])
@pytest.mark.parametrize("n", [0, 1, 2, 7, 30])
def test_the_factors_solve_the_equations(kind, n):
    rng = np.random.default_rng(n)
    matrix = rng.normal(size=(n, n)).astype(kind) + (1j * rng.normal(size=(n, n)) if kind is np.complex128 else 0.0)
    vector = rng.normal(size=n + 1).astype(kind)
    factors, pivots, solution = matrix.copy(), np.zeros(n, dtype=np.int64), vector.copy()
    assert factorise_lu(factors, pivots)
    solve_lu(factors, pivots, solution)
    # Condition numbers of these matrices are below 1e3.
    np.testing.assert_allclose(solution[:n], np.linalg.solve(matrix, vector[:n]) if n else [], rtol=0, atol=1e-11)
    assert solution[n] == vector[n]


@pytest.mark.parametrize("matrix", [[[1.0, 2.0], [2.0, 4.0]], [[0.0, 0.0], [0.0, 1.0]], [[np.nan, 1.0], [1.0, 1.0]]])
def test_a_matrix_without_an_inverse_is_reported(matrix):
    assert not factorise_lu(np.array(matrix), np.zeros(2, dtype=np.int64))
