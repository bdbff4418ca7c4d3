"""A few linear equations without symmetry: against LAPACK, and what is not determined."""

import numpy as np
import pytest

from governor_mechanism.numerics import linear_equations
from governor_mechanism.numerics.linear_equations import solve_dense
from interpreted_kernels import interpret_kernels

kernels_as_python = interpret_kernels(linear_equations)


@pytest.mark.parametrize("n", [0, 1, 2, 5])
def test_solution_and_determinant_are_those_of_lapack(n):
    rng = np.random.default_rng(n)
    for _ in range(10):
        matrix, vector = rng.normal(size=(n, n)), rng.normal(size=n)
        found = vector.copy()
        determinant = solve_dense(matrix.copy(), found)
        assert determinant == pytest.approx(np.linalg.det(matrix), rel=1e-10)
        np.testing.assert_allclose(found, np.linalg.solve(matrix, vector), rtol=1e-9)


def test_unknowns_that_are_not_determined_are_zero():
    matrix, vector = np.array([[1.0, 2, 3], [2, 4, 6], [0, 0, 1]]), np.array([6.0, 12, 1])
    found = vector.copy()
    assert solve_dense(matrix.copy(), found) == 0.0
    assert found[1] == 0.0
    np.testing.assert_allclose(matrix @ found, vector, rtol=1e-14)
