"""All solutions of 2n bilinear equations in two groups of n complex unknowns: in closed form for n = 1, else by homotopy."""

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

ComplexArray = NDArray[np.complex128]

MAX_UNKNOWNS: Final = 4
"""Largest n that is solved; there are binomial(2n, n) paths, 70 for n = 4 and 252 for n = 5."""

MAX_STEPS: Final = 2000
"""Number of steps after which a path is given up; a smooth one takes about thirty."""

FIRST_STEP: Final = 0.05
"""First step of a path, whose parameter goes from 0 to 1."""

CORRECTION_TOLERANCE: Final = 1e-3
"""First correction of a step, relative to the unknowns, above which the step is repeated with half its size."""

ENDGAME_DISTANCE: Final = 1e-8
"""Distance from the end of a path at which it is finished by Newton's iteration; multiple solutions cannot be followed closer."""

LOST_DISTANCE: Final = 1e-4
"""Distance from the end of a path above which it is lost if it cannot be followed farther; multiple solutions stop it nearer."""

INFINITY_TOLERANCE: Final = 1e-6
"""Homogeneous coordinate, relative to the others, below which a path has gone to infinity."""

RESIDUAL_TOLERANCE: Final = 1e-8
"""Residual, relative to the coefficients, above which the end of a path is no solution; double solutions leave about 1e-12."""

SAME_TOLERANCE: Final = 1e-6
"""Difference of the ends of two paths below which they are the same solution."""

N_ATTEMPTS: Final = 4
"""Number of start systems that are tried until no path is lost and no two paths have met."""


@dataclass(frozen=True, eq=False)
class BilinearSolutions:
    """Finite solutions: `first` and `second` group of unknowns, each (solutions, n), and whether there are certainly no others."""

    first: ComplexArray
    second: ComplexArray
    complete: bool


def count_paths(n_unknowns: int) -> int:
    """Return the largest number of isolated solutions, the coefficient in the product of 2n linear forms of both groups."""
    return math.comb(2 * n_unknowns, n_unknowns)


def solve_bilinear_system(
    # coefficients of [1, first]^T matrix [1, second] = 0; shape (2n, n + 1, n + 1)
    matrices: ComplexArray,
) -> BilinearSolutions:
    """Return all finite solutions of bilinear equations."""
    norms = np.linalg.norm(matrices, axis=(1, 2), keepdims=True)
    if np.any(norms == 0.0):  # an equation that is always satisfied leaves a motion
        n = matrices.shape[1] - 1
        return BilinearSolutions(np.zeros((0, n), complex), np.zeros((0, n), complex), complete=False)
    scaled = matrices / norms
    return _solve_pair(scaled) if len(matrices) == 2 else _follow_all_paths(scaled)


def _solve_pair(matrices: ComplexArray) -> BilinearSolutions:
    """Return the solutions of two equations a + b v + c u + d u v = 0: without v, a quadratic equation remains for u."""
    (a1, b1, c1, d1), (a2, b2, c2, d2) = matrices.reshape(2, 4).tolist()
    coefficients = np.array([c1 * d2 - c2 * d1, c1 * b2 - c2 * b1 + a1 * d2 - a2 * d1, a1 * b2 - a2 * b1])
    if np.max(np.abs(coefficients)) < 1e-14:  # the equations are the same, or have a common factor
        return BilinearSolutions(np.zeros((0, 1), complex), np.zeros((0, 1), complex), complete=False)
    first = np.roots(_without_small_leading(coefficients))
    denominators = np.stack([b1 + d1 * first, b2 + d2 * first])
    numerators = -np.stack([a1 + c1 * first, a2 + c2 * first])
    larger = np.argmax(np.abs(denominators), axis=0), np.arange(len(first))
    finite = np.abs(denominators[larger]) > 1e-12 * (1.0 + np.abs(first))
    second = numerators[larger][finite] / denominators[larger][finite]
    return BilinearSolutions(first[finite][:, np.newaxis], second[:, np.newaxis], complete=True)


def _without_small_leading(coefficients: ComplexArray) -> ComplexArray:
    """Return the coefficients of a polynomial, highest first, without leading ones that are rounding."""
    is_large = np.abs(coefficients) > 1e-13 * np.max(np.abs(coefficients))
    kept: ComplexArray = coefficients[int(np.argmax(is_large)) :]
    return kept


def _follow_all_paths(matrices: ComplexArray) -> BilinearSolutions:
    """Return the ends of the paths from the solutions of a start system of products of linear forms."""
    found: list[ComplexArray] = []
    n = matrices.shape[1] - 1
    complete = False
    for seed in range(N_ATTEMPTS):
        ends, complete = _PathTracker(matrices, np.random.default_rng(seed)).follow()
        found += [
            end for end in ends if not any(np.max(np.abs(end - other)) < SAME_TOLERANCE * (1 + np.max(np.abs(end))) for other in found)
        ]
        if complete:
            break
    solutions = np.array(found).reshape(len(found), 2 * n)
    return BilinearSolutions(solutions[:, :n], solutions[:, n:], complete)


class _PathTracker:
    """Paths of (1 - t) gamma start + t target = 0 in homogeneous coordinates of both groups, on random patches."""

    def __init__(self, target: ComplexArray, generator: np.random.Generator) -> None:
        def random(*shape: int) -> ComplexArray:
            values: ComplexArray = np.exp(2j * np.pi * generator.random(shape)) * generator.uniform(0.5, 1.5, shape)
            return values

        self.target = target
        self.size = target.shape[1]
        self.forms = random(2, 2 * self.size - 2, self.size)
        self.patches = random(2, self.size)
        self.start = np.einsum("ki,kj->kij", *self.forms) * np.exp(2j * np.pi * generator.random())

    def follow(self) -> tuple[list[ComplexArray], bool]:
        """Return the finite ends of the paths, without homogeneous coordinates, and whether none is lost or found twice."""
        points = self._start_points()
        n_paths = len(points)
        times = np.zeros(n_paths)
        steps = np.full(n_paths, FIRST_STEP)
        for _ in range(MAX_STEPS):
            active = np.flatnonzero((times < 1.0 - ENDGAME_DISTANCE) & (steps > 1e-14))
            if not active.size:
                break
            sizes = np.minimum(steps[active], 1.0 - times[active])
            with np.errstate(all="ignore"):
                predicted = self._predict(points[active], times[active], sizes)
                corrected, correction = self._correct(predicted, times[active] + sizes)
            accepted = correction < CORRECTION_TOLERANCE
            points[active[accepted]] = corrected[accepted]
            times[active[accepted]] += sizes[accepted]
            steps[active] = np.where(accepted, np.where(correction < 0.1 * CORRECTION_TOLERANCE, 2.0, 1.0), 0.5) * sizes
        return self._finish(points, times)

    def _start_points(self) -> ComplexArray:
        """Return the solutions of the start system: n forms of the first group and the other n of the second vanish."""
        n = self.size - 1
        points = []
        for chosen in combinations(range(2 * n), n):
            others = [k for k in range(2 * n) if k not in chosen]
            halves = []
            for group, rows in enumerate((list(chosen), others)):
                matrix = np.vstack([self.forms[group][rows], self.patches[group]])
                halves.append(np.linalg.solve(matrix, np.eye(self.size)[-1]))
            points.append(np.concatenate(halves))
        return np.array(points)

    def _system(self, points: ComplexArray, times: NDArray[np.float64]) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return values (paths, 2n + 2), derivatives by the unknowns, and by t."""
        a, b = points[:, : self.size], points[:, self.size :]
        t = times[:, np.newaxis, np.newaxis, np.newaxis]
        matrices = (1.0 - t) * self.start + t * self.target
        by_b = np.einsum("pi,pkij->pkj", a, matrices)
        by_a = np.einsum("pkij,pj->pki", matrices, b)
        change = np.einsum("pi,kij,pj->pk", a, self.target - self.start, b)
        n_paths = len(points)
        patch_rows = np.zeros((2, 2 * self.size), complex)
        patch_rows[0, : self.size], patch_rows[1, self.size :] = self.patches
        jacobian = np.concatenate([np.concatenate([by_a, by_b], axis=2), np.broadcast_to(patch_rows, (n_paths, 2, 2 * self.size))], axis=1)
        values = np.concatenate([np.einsum("pkj,pj->pk", by_b, b), points @ patch_rows.T - 1.0], axis=1)
        return values, jacobian, np.concatenate([change, np.zeros((n_paths, 2), complex)], axis=1)

    def _tangent(self, points: ComplexArray, times: NDArray[np.float64]) -> ComplexArray:
        _, jacobian, change = self._system(points, times)
        return _solve_each(jacobian, -change)

    def _predict(self, points: ComplexArray, times: NDArray[np.float64], sizes: NDArray[np.float64]) -> ComplexArray:
        """Return the points after a step by the classical Runge-Kutta method."""
        h = sizes[:, np.newaxis]
        k1 = self._tangent(points, times)
        k2 = self._tangent(points + 0.5 * h * k1, times + 0.5 * sizes)
        k3 = self._tangent(points + 0.5 * h * k2, times + 0.5 * sizes)
        k4 = self._tangent(points + h * k3, times + sizes)
        return points + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def _correct(self, points: ComplexArray, times: NDArray[np.float64]) -> tuple[ComplexArray, NDArray[np.float64]]:
        """Return the points after two Newton steps, and the size of the first, relative to the points; inf if it has none."""
        values, jacobian, _ = self._system(points, times)
        step = _solve_each(jacobian, -values)
        size = np.max(np.abs(step), axis=1) / np.max(np.abs(points), axis=1)
        moved = points + step
        values, jacobian, _ = self._system(moved, times)
        second = _solve_each(jacobian, -values)
        shrinks = np.max(np.abs(second), axis=1) <= 0.1 * np.max(np.abs(step), axis=1) + 1e-12 * np.max(np.abs(points), axis=1)
        return moved + second, np.where(np.isfinite(size) & shrinks, size, np.inf)

    def _finish(self, points: ComplexArray, times: NDArray[np.float64]) -> tuple[list[ComplexArray], bool]:
        """Return the finite ends of the paths, and whether every path has an end of its own."""
        ends: list[ComplexArray] = []
        is_complete = bool(np.all(times >= 1.0 - LOST_DISTANCE))
        for last in points[times >= 1.0 - LOST_DISTANCE]:
            point = last
            for _ in range(8):
                values, jacobian, _ = self._system(point[np.newaxis], np.ones(1))
                point = (point - _least_squares(jacobian[0], values[0])).astype(np.complex128)
            values, jacobian, _ = self._system(point[np.newaxis], np.ones(1))
            groups = point[: self.size], point[self.size :]
            if any(abs(group[0]) < INFINITY_TOLERANCE * np.max(np.abs(group)) for group in groups):
                continue
            if not np.max(np.abs(values)) < RESIDUAL_TOLERANCE:
                is_complete = False
                continue
            end = np.concatenate([group[1:] / group[0] for group in groups])
            is_regular = np.linalg.cond(jacobian[0]) < 1e8
            is_known = any(np.max(np.abs(end - other)) < SAME_TOLERANCE * (1 + np.max(np.abs(end))) for other in ends)
            is_complete = is_complete and not (is_regular and is_known)  # two paths never meet at a regular solution
            ends += [] if is_known else [end]
        return ends, is_complete


def _solve_each(matrices: ComplexArray, values: ComplexArray) -> ComplexArray:
    """Return the solutions of linear systems; nan for all if one of them is singular."""
    try:
        solutions: ComplexArray = np.linalg.solve(matrices, values[..., np.newaxis])[..., 0].astype(np.complex128, copy=False)
    except np.linalg.LinAlgError:
        solutions = np.full(values.shape, np.nan, complex)
    return solutions


def _least_squares(matrix: ComplexArray, values: ComplexArray) -> ComplexArray:
    """Return the shortest solution of linear equations, also where they are nearly singular."""
    solution: ComplexArray = np.linalg.lstsq(matrix, values, rcond=1e-14)[0].astype(np.complex128)
    return solution
