"""The constraint rows of a block as equations in complex numbers, and all their solutions.

The position of a body is p = x + i y, its direction z = exp(i angle). With their conjugates as unknowns of their own, a pin gives an
equation in the first and one in the second group, and every other row one that is bilinear in both.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.observables.constraint_blocks import Block
from governor_mechanism.types import GROUND_INDEX, FloatArray, RecordArray

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


REALITY_TOLERANCE = 1e-6
"""Difference of both groups from conjugates, relative to the unknowns, below which a solution is real; double ones leave 1e-8."""

CLOSED_FORM = "closed form"
"""How the solutions of a block with two equations are found."""

RANK_TOLERANCE = 1e-11
"""Singular value, relative to the largest, below which linear equations of a block depend on one another."""


class UnsuitableBlockError(Exception):
    """A block that is not bilinear, as one with a gear between unknown angles or a guide curve, or that is too large."""


@dataclass(frozen=True, eq=False)
class BlockSolutions:
    """Poses of all bodies for each solution of a block, in words how they were found, and whether there are certainly no others."""

    poses: list[FloatArray]
    method: str
    complete: bool


class BlockEquations:
    """Equations of one block at known poses of the bodies before it; lengths in length scales."""

    def __init__(self, solver: PositionSolver, block: Block, poses: FloatArray) -> None:
        self.solver = solver
        self.block = block
        self.poses = poses
        self.scale = solver.mechanism.length_scale
        self.constants = solver.equations.rows.table["constant"] + solver.equations.prescribed_motion(np.array(solver.time))[:, 0]
        unknown = set(block.coordinates)
        self.moved = sorted({k // 3 for k in unknown if k % 3 < 2})
        self.turned = sorted({k // 3 for k in unknown if k % 3 == 2})
        if any(len({3 * body, 3 * body + 1} & unknown) == 1 for body in self.moved):
            raise UnsuitableBlockError
        self.angle_rows = [row for row in block.rows if self._has_unknown_angle_factor(row)]
        self.followers = self._follow_angles()
        free_turns = [body for body in self.turned if body not in self.followers]
        self.columns = {("p", body): 1 + k for k, body in enumerate(self.moved)}
        self.columns |= {("z", body): 1 + len(self.moved) + k for k, body in enumerate(free_turns)}
        self.free_turns = free_turns

    def solve(self) -> BlockSolutions:
        """Return all solutions."""
        if not self.columns:
            return BlockSolutions([self._poses_of(np.ones(1, complex))], "in turn", complete=True)
        linear, bilinear = self._equations()
        basis = _solution_space(linear, 1 + len(self.columns))
        if basis is None:
            return BlockSolutions([], "in turn", complete=True)
        n = basis.shape[1] - 1
        if n == 0:
            return BlockSolutions([self._poses_of(basis[:, 0])], "in turn", complete=True)
        if n > MAX_UNKNOWNS or len(bilinear) != 2 * n:
            raise UnsuitableBlockError
        matrices = np.array([basis.T @ matrix @ basis.conj() for matrix in bilinear])
        found = solve_bilinear_system(matrices)
        poses = []
        for first, second in zip(found.first, found.second, strict=True):
            if np.max(np.abs(first - second.conj())) < REALITY_TOLERANCE * (1.0 + np.max(np.abs(first))):
                poses.append(self._poses_of(basis @ np.append(1.0, 0.5 * (first + second.conj()))))
        method = CLOSED_FORM if n == 1 else f"homotopy of {count_paths(n)} paths"
        return BlockSolutions(poses, method, found.complete)

    def _record(self, row: int) -> RecordArray:
        record: RecordArray = self.solver.equations.rows.table[row]
        return record

    def _has_unknown_angle_factor(self, row: int) -> bool:
        """Return whether the row contains an unknown angle itself; known ones are part of its constant."""
        return any(body in self.turned for body, _ in self._angle_factors(row))

    def _angle_factors(self, row: int) -> list[tuple[int, float]]:
        """Return the bodies whose own angles a row contains, and their factors."""
        record = self._record(row)
        pairs = ((int(record[side]), float(record[f"{side}_angle_factor"])) for side in ("first", "second", "third"))
        return [(body, factor) for body, factor in pairs if body != GROUND_INDEX and factor != 0.0]

    def _follow_angles(self) -> dict[int, tuple[int, float]]:
        """Return for each body whose angle follows from another one this body, or GROUND_INDEX if that is known, and the difference."""
        followers: dict[int, tuple[int, float]] = {}
        for row in self.angle_rows:
            record = self._record(row)
            if record["direction_x"] or record["direction_y"]:
                raise UnsuitableBlockError
            factors = self._angle_factors(row)
            unknown = [(body, factor) for body, factor in factors if body in self.turned]
            known = sum(factor * float(self.poses[body, 2]) for body, factor in factors if body not in self.turned)
            value = (float(self.constants[row]) - known) / unknown[-1][1]
            if len(unknown) > 2:
                raise UnsuitableBlockError
            if len(unknown) == 2:
                if not math.isclose(unknown[0][1], -unknown[1][1]):
                    raise UnsuitableBlockError
                (one, shift), (other, other_shift) = (_root(followers, body) for body, _ in unknown)
                if one == other:
                    raise UnsuitableBlockError
                followers[other] = one, value + shift - other_shift
            else:
                body, shift = _root(followers, unknown[0][0])
                if body == GROUND_INDEX:
                    raise UnsuitableBlockError
                followers[body] = GROUND_INDEX, value - shift
        return followers

    def _position(self, body: int, x: float, y: float) -> ComplexArray:
        """Return the coefficients of the position of a point in [1, unknowns of the first group]."""
        form = np.zeros(1 + len(self.columns), complex)
        if body == GROUND_INDEX:
            form[0] = complex(x, y) / self.scale
            return form
        if ("p", body) in self.columns:
            form[self.columns["p", body]] = 1.0
        else:
            form[0] = complex(*self.poses[body, :2]) / self.scale
        return form + complex(x, y) / self.scale * self._direction(body)

    def _direction(self, body: int) -> ComplexArray:
        """Return the coefficients of the direction of a body in [1, unknowns of the first group]."""
        form = np.zeros(1 + len(self.columns), complex)
        root, shift = _root(self.followers, body)
        if root == GROUND_INDEX:
            form[0] = cmath.exp(1j * shift)
        elif root in self.turned:
            form[self.columns["z", root]] = cmath.exp(1j * shift)
        else:
            form[0] = cmath.exp(1j * float(self.poses[root, 2]))
        return form

    def _equations(self) -> tuple[list[ComplexArray], list[ComplexArray]]:
        """Return linear equations of the first group, and matrices of bilinear ones."""
        one = np.eye(1 + len(self.columns), dtype=complex)[0]
        bilinear = [np.outer(form, form.conj()) - np.outer(one, one) for form in map(self._direction, self.free_turns)]
        linear: list[ComplexArray] = []
        rows = [row for row in self.block.rows if row not in self.angle_rows]
        while rows:
            row = rows.pop(0)
            record = self._record(row)
            joint = self.solver.equations.joint_indices[row]
            gap = self._position(int(record["second"]), record["x2"], record["y2"])
            gap = gap - self._position(int(record["first"]), record["x1"], record["y1"])
            constant = self._constant(row)
            if record["kind"] == RowKind.DISTANCE:
                bilinear.append(np.outer(gap, gap.conj()) - constant**2 * np.outer(one, one))
            elif record["kind"] == RowKind.BODY_NORMAL and not record["n_segments"]:
                first = int(record["first"])
                normal = 1j * cmath.exp(1j * record["angle"]) * (one if first == GROUND_INDEX else self._direction(first))
                bilinear.append(_real_part(np.outer(gap, normal.conj())) - constant * np.outer(one, one))
            elif record["kind"] == RowKind.FIXED_DIRECTION:
                if rows and self.solver.equations.joint_indices[rows[0]] == joint and self._is_coincidence(row, rows[0]):
                    linear.append(gap - complex(constant, self._constant(rows.pop(0))) * one)
                else:
                    normal = complex(record["direction_x"], record["direction_y"]) * one
                    bilinear.append(_real_part(np.outer(gap, normal.conj())) - constant * np.outer(one, one))
            else:
                raise UnsuitableBlockError
        return linear, bilinear

    def _constant(self, row: int) -> float:
        """Return what is subtracted from a row, less its known angles, in length scales."""
        known = sum(factor * float(self.poses[body, 2]) for body, factor in self._angle_factors(row))
        return (float(self.constants[row]) - known) / self.scale

    def _is_coincidence(self, row: int, other: int) -> bool:
        """Return whether two rows are the components x and y of one gap."""
        one, two = self._record(row), self._record(other)
        return (one["direction_x"], one["direction_y"], two["direction_x"], two["direction_y"]) == (1.0, 0.0, 0.0, 1.0)

    def _poses_of(self, unknowns: ComplexArray) -> FloatArray:
        """Return the poses of all bodies at values of [1, unknowns of the first group]."""
        poses = self.poses.copy()
        for body in self.moved:
            position = unknowns[self.columns["p", body]] * self.scale
            poses[body, :2] = position.real, position.imag
        for body in self.free_turns:
            poses[body, 2] = cmath.phase(complex(unknowns[self.columns["z", body]]))
        for body in self.followers:
            root, shift = _root(self.followers, body)
            poses[body, 2] = shift + (0.0 if root == GROUND_INDEX else float(poses[root, 2]))
        return poses


def _root(followers: dict[int, tuple[int, float]], body: int) -> tuple[int, float]:
    """Return the body whose angle determines that of another, and the difference; GROUND_INDEX if it is known."""
    shift = 0.0
    while body in followers:
        body, difference = followers[body]
        shift += difference
    return body, shift


def _real_part(matrix: ComplexArray) -> ComplexArray:
    """Return the matrix of the real part of a bilinear form."""
    return 0.5 * (matrix + matrix.conj().T)


def _solution_space(linear: list[ComplexArray], size: int) -> ComplexArray | None:
    """Return the solution with the least unknowns, and a basis of the homogeneous ones, as columns of [1, unknowns]; None without any."""
    if not linear:
        return np.eye(size, dtype=complex)
    equations = np.array(linear)
    matrix, rhs = equations[:, 1:], -equations[:, 0]
    u, values, vh = np.linalg.svd(matrix)
    rank = int(np.sum(values > RANK_TOLERANCE * max(1.0, float(values[0]))))
    solution = vh[:rank].conj().T @ ((u.conj().T @ rhs)[:rank] / values[:rank])
    if np.max(np.abs(matrix @ solution - rhs)) > 1e-9:
        return None
    null = vh[rank:].conj().T
    basis = np.zeros((size, 1 + null.shape[1]), complex)
    basis[0, 0] = 1.0
    basis[1:, 0], basis[1:, 1:] = solution, null
    return basis
