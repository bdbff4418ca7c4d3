"""Sparse solutions agree with dense ones, and linearly dependent equations are detected."""

import numpy as np
import pytest

from governor_mechanism.mechanics.dynamics.lowering import find_coupled_rows
from governor_mechanism.numerics.least_squares import (
    MIN_SPARSE_ROWS,
    MIN_SPARSE_SPECTRUM_ROWS,
    least_norm_solution,
    numerical_rank,
    singular_value_ratio,
)

ROUNDING = 1e-11
"""Error of solutions of order one; the condition numbers of these matrices are below a few thousand."""


def chain_equations(count, seed):
    """Return equations as of the joints of a chain (two for each of `count` bodies), and their right-hand side."""
    generator = np.random.default_rng(seed)
    rows = np.zeros((2 * count, 3 * count))
    for k in range(count):
        rows[2 * k : 2 * k + 2, max(0, 3 * k - 3) : 3 * k + 3] = generator.normal(size=(2, 6 if k else 3))
        rows[2 * k : 2 * k + 2, 3 * k : 3 * k + 2] += 3 * np.eye(2)
    return rows, generator.normal(size=2 * count)


@pytest.mark.parametrize("seed", range(5))
def test_least_norm_solution_matches_the_pseudoinverse(seed):
    rows, rhs = chain_equations(MIN_SPARSE_ROWS, seed)
    expected = np.linalg.pinv(rows) @ rhs
    assert least_norm_solution(rows, rhs) == pytest.approx(expected, abs=ROUNDING * np.max(np.abs(expected)))
    few = rows[: MIN_SPARSE_ROWS // 2]
    assert least_norm_solution(few, rhs[: MIN_SPARSE_ROWS // 2]) == pytest.approx(np.linalg.pinv(few) @ rhs[: MIN_SPARSE_ROWS // 2])


def test_nearly_dependent_equations_are_satisfied_to_rounding():
    """Two rows differ by 1e-4: rows * rows^T loses eight digits, which the refinement restores."""
    rows, rhs = chain_equations(MIN_SPARSE_ROWS, 3)
    rows[41] = rows[40] + 1e-4 * rows[41]
    solution = least_norm_solution(rows, rhs)
    assert rows @ solution == pytest.approx(rhs, abs=1e-11)
    assert solution == pytest.approx(np.linalg.pinv(rows) @ rhs, rel=1e-8, abs=1e-8 * np.max(np.abs(solution)))


def test_linearly_dependent_equations_are_detected():
    rows, rhs = chain_equations(MIN_SPARSE_ROWS, 2)
    assert numerical_rank(rows) == len(rows)
    dependent_rows = np.concatenate([rows, rows[:3] + rows[3:6]])
    assert numerical_rank(dependent_rows) == len(rows)
    dependent_rhs = np.append(rhs, rhs[:3] + rhs[3:6])
    expected = np.linalg.pinv(rows) @ rhs
    assert least_norm_solution(dependent_rows, dependent_rhs) == pytest.approx(expected, abs=ROUNDING * np.max(np.abs(expected)))


def test_no_equations_have_rank_zero():
    assert numerical_rank(np.zeros((0, 6))) == 0


@pytest.mark.parametrize("seed", range(5))
def test_coupled_rows_are_all_pairs_that_share_a_body(seed):
    row_bodies = np.random.default_rng(seed).integers(-1, 5, (12, 2))
    expected = [
        (i, j, side, other_side)
        for i in range(12)
        for j in range(i + 1)
        for side in range(2)
        for other_side in range(2)
        if row_bodies[i, side] >= 0 and row_bodies[i, side] == row_bodies[j, other_side]
    ]
    assert find_coupled_rows(row_bodies).tolist() == [list(pair) for pair in expected]


@pytest.mark.parametrize("smallest", [1e-2, 1e-5, 1e-9])
@pytest.mark.parametrize("n_rows", [20, MIN_SPARSE_SPECTRUM_ROWS])
def test_extreme_singular_values_are_those_that_the_equations_were_made_of(n_rows, smallest):
    """A small one keeps its digits but for rounding relative to the largest, and the same equations give the same bits."""
    generator, values = np.random.default_rng(n_rows), np.geomspace(7.0, 7.0 * smallest, n_rows)
    left, right = (np.linalg.qr(generator.normal(size=(n, n)))[0] for n in (n_rows, n_rows + 3))
    rows = left * values @ right[:n_rows]
    ratio = singular_value_ratio(rows)
    assert ratio == pytest.approx(smallest, rel=1e-6, abs=1e-14)  # the largest one is the scale, and less accurate
    assert ratio == singular_value_ratio(rows.copy())


def test_equations_without_a_smallest_singular_value_and_more_equations_than_unknowns_are_measured_too():
    rows = np.random.default_rng(1).normal(size=(MIN_SPARSE_SPECTRUM_ROWS, MIN_SPARSE_SPECTRUM_ROWS + 5))
    rows[7] = 0.0
    assert singular_value_ratio(rows) < 1e-15
    assert singular_value_ratio(rows.T) < 1e-15
