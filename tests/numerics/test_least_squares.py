"""Many equations solved sparsely are solved as a few are, and where they depend on each other that is seen."""

from __future__ import annotations

import numpy as np
import pytest

from governor_mechanism.mechanics.dynamics.constraint_solver import find_coupled_rows
from governor_mechanism.numerics.least_squares import MIN_SPARSE_ROWS, least_norm_solution, mass_weighted_least_norm, numerical_rank

ROUNDING = 1e-11
"""Of solutions of order one: conditions of these matrices are below some thousands."""


def chained(count, seed):
    """Equations of neighbouring bodies, as a chain's joints make them; two for each of `count` bodies of three."""
    generator = np.random.default_rng(seed)
    rows = np.zeros((2 * count, 3 * count))
    for k in range(count):
        rows[2 * k : 2 * k + 2, max(0, 3 * k - 3) : 3 * k + 3] = generator.normal(size=(2, 6 if k else 3))
        rows[2 * k : 2 * k + 2, 3 * k : 3 * k + 2] += 3 * np.eye(2)
    return rows, generator.normal(size=2 * count), generator.uniform(0.5, 2.0, 3 * count)


@pytest.mark.parametrize("seed", range(5))
def test_the_smallest_change_is_that_of_singular_values(seed):
    rows, right, _ = chained(MIN_SPARSE_ROWS, seed)
    expected = np.linalg.pinv(rows) @ right
    assert least_norm_solution(rows, right) == pytest.approx(expected, abs=ROUNDING * np.max(np.abs(expected)))
    few = rows[: MIN_SPARSE_ROWS // 2]
    assert least_norm_solution(few, right[: MIN_SPARSE_ROWS // 2]) == pytest.approx(np.linalg.pinv(few) @ right[: MIN_SPARSE_ROWS // 2])


def test_equations_that_nearly_depend_on_each_other_are_met_to_rounding():
    """Two that differ by a ten-thousandth: products of rows lose eight digits, which are won back."""
    rows, right, _ = chained(MIN_SPARSE_ROWS, 3)
    rows[41] = rows[40] + 1e-4 * rows[41]
    found = least_norm_solution(rows, right)
    assert rows @ found == pytest.approx(right, abs=1e-11)
    assert found == pytest.approx(np.linalg.pinv(rows) @ right, rel=1e-8, abs=1e-8 * np.max(np.abs(found)))


@pytest.mark.parametrize("seed", range(5))
def test_the_lightest_change_is_that_of_lagrange(seed):
    rows, right, masses = chained(MIN_SPARSE_ROWS, seed)
    count = len(rows)
    system = np.block([[np.diag(masses), rows.T], [rows, np.zeros((count, count))]])
    expected = np.linalg.solve(system, np.append(np.zeros(len(masses)), right))[: len(masses)]
    assert mass_weighted_least_norm(rows, masses, right) == pytest.approx(expected, abs=ROUNDING * np.max(np.abs(expected)))


def test_what_has_no_mass_is_moved_by_the_equations():
    rows, right, masses = chained(MIN_SPARSE_ROWS, 1)
    masses[5] = 0.0
    found = mass_weighted_least_norm(rows, masses, right)
    assert rows @ found == pytest.approx(right, abs=ROUNDING * np.max(np.abs(found)))


def test_equations_that_depend_on_each_other_are_seen():
    rows, right, masses = chained(MIN_SPARSE_ROWS, 2)
    assert numerical_rank(rows) == len(rows)
    twice = np.concatenate([rows, rows[:3] + rows[3:6]])
    assert numerical_rank(twice) == len(rows)
    asked = np.append(right, right[:3] + right[3:6])
    expected = np.linalg.pinv(rows) @ right
    assert least_norm_solution(twice, asked) == pytest.approx(expected, abs=ROUNDING * np.max(np.abs(expected)))
    assert mass_weighted_least_norm(twice, masses, np.append(right, [1.0, 2.0, 3.0])) is None


def test_nothing_has_no_rank():
    assert numerical_rank(np.zeros((0, 6))) == 0


@pytest.mark.parametrize("seed", range(5))
def test_neighbours_are_all_pairs_of_rows_that_share_a_body(seed):
    ends = np.random.default_rng(seed).integers(-1, 5, (12, 2))
    expected = [
        (i, j, side, other)
        for i in range(12)
        for j in range(i + 1)
        for side in range(2)
        for other in range(2)
        if ends[i, side] >= 0 and ends[i, side] == ends[j, other]
    ]
    assert find_coupled_rows(ends).tolist() == [list(pair) for pair in expected]
