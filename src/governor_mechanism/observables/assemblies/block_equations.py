"""The constraint rows of a block as equations in complex numbers.

The position of a body is p = x + i y, its direction z = exp(i angle). With their conjugates as unknowns of their own, a pin gives an
equation in the first and one in the second group, and every other row one that is bilinear in both.
"""

import cmath
import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints.constraint_row import RowKind
from governor_mechanism.observables.assemblies.bilinear_systems import MAX_UNKNOWNS, ComplexArray, count_paths, solve_bilinear_system
from governor_mechanism.observables.assemblies.blocks import Block
from governor_mechanism.types import FloatArray, RecordArray

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
        self.solver, self.block, self.poses = solver, block, poses
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
        record = self._record(row)
        pairs = ((record["first"], record["first_angle_factor"]), (record["second"], record["second_angle_factor"]))
        return any(factor != 0.0 and int(body) in self.turned for body, factor in pairs)

    def _follow_angles(self) -> dict[int, tuple[int, float]]:
        """Return for each body whose angle follows from another unknown or known one (-1 for the ground) this body and the difference."""
        followers: dict[int, tuple[int, float]] = {}
        for row in self.angle_rows:
            record = self._record(row)
            first, second = int(record["first"]), int(record["second"])
            factors = float(record["first_angle_factor"]), float(record["second_angle_factor"])
            if record["direction_x"] or record["direction_y"]:
                raise UnsuitableBlockError
            is_unknown = first in self.turned, second in self.turned
            if all(is_unknown):
                if not math.isclose(factors[0], -factors[1]):
                    raise UnsuitableBlockError
                one, other, difference = first, second, float(self.constants[row]) / factors[1]
                (one, shift), (other, other_shift) = _root(followers, one), _root(followers, other)
                if one == other:
                    raise UnsuitableBlockError
                followers[other] = one, difference + shift - other_shift
            else:
                body, factor, known, known_factor = (
                    (second, factors[1], first, factors[0]) if is_unknown[1] else (first, factors[0], second, factors[1])
                )
                known_angle = 0.0 if known < 0 else float(self.poses[known, 2])
                value = (float(self.constants[row]) - known_factor * known_angle) / factor
                body, shift = _root(followers, body)
                if body < 0:
                    raise UnsuitableBlockError
                followers[body] = -1, value - shift
        return followers

    def _position(self, body: int, x: float, y: float) -> ComplexArray:
        """Return the coefficients of the position of a point in [1, unknowns of the first group]."""
        form = np.zeros(1 + len(self.columns), complex)
        if body < 0:
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
        if root < 0:
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
                normal = 1j * cmath.exp(1j * record["angle"]) * (one if first < 0 else self._direction(first))
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
        record = self._record(row)
        value = float(self.constants[row])
        for body, factor in ((record["first"], record["first_angle_factor"]), (record["second"], record["second_angle_factor"])):
            if factor and body >= 0:
                value -= float(factor) * float(self.poses[body, 2])
        return value / self.scale

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
            poses[body, 2] = shift + (0.0 if root < 0 else float(poses[root, 2]))
        return poses


def _root(followers: dict[int, tuple[int, float]], body: int) -> tuple[int, float]:
    """Return the body whose angle determines that of another, and the difference; -1 if it is known."""
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
