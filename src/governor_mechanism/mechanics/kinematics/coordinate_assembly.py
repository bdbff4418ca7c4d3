"""Assembly of a mechanism with one degree of freedom at values of its leading coordinate, and derivatives of the poses by it; compiled.

Dense elimination with row pivoting selects independent rows; redundant rows of joints are consistent with them.
"""

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, constraint_equations_of
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import N_ROW_COLUMNS, ConstraintRows, RowColumn
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value, make_output_rows
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import GROUND_INDEX, BoolArray, FloatArray, IntArray

MAX_NEWTON_STEPS = 16
"""Largest number of Newton steps."""

DIVERGENCE_STEP = 0.3
"""Newton step, in length scales and rad, from which the iteration counts as diverged: no solution is near."""

ROUNDING_STEP, CONVERGENCE_STEP = 2e-15, 1e-8
"""Newton steps, in length scales and rad: one of the first size ends the iteration; one below the second ends it if it does not
halve the step before it, because only rounding is left.
"""

CONTINUATION_STEP = 0.1
"""Continuation step with which a start is reached, in coordinate scales."""

MAX_BRANCH_DISTANCE = 0.05
"""Distance from the guess, in length scales and rad, beyond which a solution may belong to another branch."""

SINGULAR_PIVOT_RATIO = 1e-11
"""Pivot of the scaled Jacobian below which it is singular."""


class AssemblyArrays(NamedTuple):
    """The joints of a mechanism with one degree of freedom, and its leading coordinate, as arrays."""

    rows: ConstraintRows  # rows of the joints, and last the row of the leading coordinate
    coordinate_wraps: bool  # whether the coordinate is the angle of a line, which is known up to whole turns
    free_indices: IntArray  # indices of the coordinates of poses.ravel() that may change
    pose_scales: FloatArray  # scales of all coordinates; shape (3 bodies,)
    row_scales: FloatArray  # factors that make the residuals of the rows dimensionless; shape (rows,)
    coordinate_scale: float  # scale of the coordinate, m or rad


class AssemblyWorkspace(NamedTuple):
    """Buffers of the assembly; min_pivot (1,) is the smallest pivot of the last solved position."""

    row_values: FloatArray
    jacobian: FloatArray
    matrix: FloatArray
    row_order: IntArray
    rhs: FloatArray
    pose_change: FloatArray
    solution: FloatArray
    dense_row: FloatArray
    min_pivot: FloatArray
    zero_velocities: FloatArray


def lower_assembly(mechanism: Mechanism) -> AssemblyArrays:
    """Return the joints of a mechanism and its leading coordinate as arrays."""
    joint_rows = constraint_equations_of(mechanism).rows
    output_rows = make_output_rows(mechanism, [mechanism.coordinate], {})
    table = np.empty(len(joint_rows.table) + 1, dtype=joint_rows.table.dtype)
    table[:-1], table[-1:] = joint_rows.table, output_rows.table
    coordinate_scale = mechanism.output_scale(mechanism.coordinate)
    return AssemblyArrays(
        rows=ConstraintRows(table, bodies_of_rows(table), joint_rows.curve_segments),
        coordinate_wraps=isinstance(mechanism.reading(mechanism.coordinate), LineAngle),
        free_indices=np.flatnonzero(np.array([body.moves for body in mechanism.bodies]).ravel()),
        pose_scales=np.array([mechanism.length_scale, mechanism.length_scale, 1.0] * len(mechanism.bodies)),
        row_scales=np.array([*(1 / mechanism.length_scale,) * len(joint_rows.table), 1 / coordinate_scale]),
        coordinate_scale=coordinate_scale,
    )


def make_assembly_workspace(arrays: AssemblyArrays) -> AssemblyWorkspace:
    """Allocate the buffers of the assembly."""
    n_rows, n_coordinates = len(arrays.rows.table), len(arrays.pose_scales)
    return AssemblyWorkspace(
        row_values=np.zeros((n_rows, N_ROW_COLUMNS)),
        jacobian=np.zeros((*arrays.rows.row_bodies.shape, 3)),
        matrix=np.zeros((n_rows, len(arrays.free_indices))),
        row_order=np.zeros(n_rows, dtype=np.int64),
        rhs=np.zeros(n_rows),
        pose_change=np.zeros(n_coordinates),
        solution=np.zeros(len(arrays.free_indices)),
        dense_row=np.zeros(n_coordinates),
        min_pivot=np.zeros(1),
        zero_velocities=np.zeros((n_coordinates // 3, 3)),
    )


@jit_in_place
def _factorise(workspace: AssemblyWorkspace) -> bool:
    """Factorise the matrix in place with row pivoting and store its smallest pivot; return whether it is regular."""
    matrix = workspace.matrix
    row_order = workspace.row_order
    min_pivot = math.inf
    n_rows, n_columns = matrix.shape
    if n_rows < n_columns:
        return False
    for i in range(n_rows):
        row_order[i] = i
    for c in range(n_columns):
        best = c
        for i in range(c + 1, n_rows):
            if abs(matrix[i, c]) > abs(matrix[best, c]):
                best = i
        if best != c:
            row_order[c], row_order[best] = row_order[best], row_order[c]
            for k in range(n_columns):
                matrix[c, k], matrix[best, k] = matrix[best, k], matrix[c, k]
        pivot = matrix[c, c]
        min_pivot = min(min_pivot, abs(pivot))
        if not min_pivot > SINGULAR_PIVOT_RATIO:
            workspace.min_pivot[0] = 0.0
            return False
        for i in range(c + 1, n_rows):
            factor = matrix[i, c]
            if factor != 0.0:
                factor /= pivot
                matrix[i, c] = factor
                for k in range(c + 1, n_columns):
                    matrix[i, k] -= factor * matrix[c, k]
    workspace.min_pivot[0] = min_pivot
    return True


@jit_in_place
def _solve_factorised(arrays: AssemblyArrays, workspace: AssemblyWorkspace, pose_change: FloatArray) -> float:
    """Fill pose_change (3 bodies,) with the solution of the factorised system; return its largest component in pose scales."""
    matrix = workspace.matrix
    row_order = workspace.row_order
    rhs = workspace.rhs
    solution = workspace.solution
    n_columns, step_size = arrays.free_indices.size, 0.0
    for i in range(n_columns):
        total = rhs[row_order[i]]
        for k in range(i):
            total -= matrix[i, k] * solution[k]
        solution[i] = total
    for i in range(n_columns - 1, -1, -1):
        total = solution[i]
        for k in range(i + 1, n_columns):
            total -= matrix[i, k] * solution[k]
        solution[i] = total / matrix[i, i]
        pose_change[arrays.free_indices[i]] = arrays.pose_scales[arrays.free_indices[i]] * solution[i]
        step_size = max(step_size, abs(solution[i]))
    return step_size


@jit_in_place
def _fill_scaled_jacobian(arrays: AssemblyArrays, workspace: AssemblyWorkspace) -> None:
    """Fill the dimensionless Jacobian (rows, free coordinates); dense_row (3 bodies,) is a buffer of zeros before and after."""
    row_bodies = arrays.rows.row_bodies
    pose_scales = arrays.pose_scales
    dense_row = workspace.dense_row
    for i in range(row_bodies.shape[0]):
        for side in range(row_bodies.shape[1]):
            body = row_bodies[i, side]
            if body != GROUND_INDEX:
                for c in range(3):
                    dense_row[3 * body + c] += arrays.row_scales[i] * workspace.jacobian[i, side, c] * pose_scales[3 * body + c]
        for k in range(arrays.free_indices.size):
            workspace.matrix[i, k] = dense_row[arrays.free_indices[k]]
        for side in range(row_bodies.shape[1]):
            body = row_bodies[i, side]
            if body != GROUND_INDEX:
                dense_row[3 * body : 3 * body + 3] = 0.0


@jit_in_place
def solve_position(arrays: AssemblyArrays, workspace: AssemblyWorkspace, q: float, node: FloatArray) -> bool:
    """Solve for the poses node[0] at a value of the coordinate from a guess; fill in their two derivatives."""
    rows, row_scales = arrays.rows, arrays.row_scales
    row_values = workspace.row_values
    jacobian = workspace.jacobian
    rhs = workspace.rhs
    poses, tangents = node[0].reshape(-1, 3), node[1].reshape(-1, 3)
    last, previous_step = rhs.size - 1, math.inf
    for _ in range(MAX_NEWTON_STEPS):
        for i in range(rhs.size):
            row_values[i, RowColumn.DRIVE_VALUE] = 0.0
        evaluate_rows(rows, poses, workspace.zero_velocities, row_values, jacobian)
        row_values[last, RowColumn.RESIDUAL] -= q
        if arrays.coordinate_wraps:
            residual = row_values[last, RowColumn.RESIDUAL]
            row_values[last, RowColumn.RESIDUAL] -= 2.0 * math.pi * math.floor(residual / (2.0 * math.pi) + 0.5)
        for i in range(rhs.size):
            rhs[i] = -row_values[i, RowColumn.RESIDUAL] * row_scales[i]
        _fill_scaled_jacobian(arrays, workspace)
        if not _factorise(workspace):
            return False
        step = _solve_factorised(arrays, workspace, workspace.pose_change)
        if not step < DIVERGENCE_STEP:
            return False
        for c in range(workspace.pose_change.size):
            node[0, c] += workspace.pose_change[c]
        if step <= ROUNDING_STEP or (step < CONVERGENCE_STEP and step >= 0.5 * previous_step):
            break
        previous_step = step
    else:
        return False
    rhs[:] = 0.0
    rhs[last] = row_scales[last]
    _solve_factorised(arrays, workspace, node[1])
    for i in range(rhs.size):
        row_values[i, RowColumn.DRIVE_ACCELERATION] = 0.0
    evaluate_rows(rows, poses, tangents, row_values, jacobian)
    for i in range(rhs.size):
        rhs[i] = row_values[i, RowColumn.GAMMA] * row_scales[i]
    _solve_factorised(arrays, workspace, node[2])
    return True


@jit_in_place
def is_on_branch(arrays: AssemblyArrays, poses: FloatArray, guess: FloatArray) -> bool:
    """Return whether solved poses (3 bodies,) are so near to their guess that they belong to the same branch."""
    is_near = True
    for c in range(poses.size):
        is_near = is_near and abs(poses[c] - guess[c]) < MAX_BRANCH_DISTANCE * arrays.pose_scales[c]
    return is_near


@jit
def continue_to_coordinate(
    arrays: AssemblyArrays,
    workspace: AssemblyWorkspace,
    q: float,  # requested coordinate, SI
    node: FloatArray,  # poses that nearly close the joints, and their two derivatives, which are overwritten; shape (3, 3 bodies)
) -> bool:
    """Move poses and fill in their derivatives by the coordinate, by continuation; return whether the same branch reaches the value."""
    predicted = np.empty(arrays.pose_scales.size)
    node[1] = 0.0
    workspace.row_values[:] = 0.0
    evaluate_rows(arrays.rows, node[0].reshape(-1, 3), workspace.zero_velocities, workspace.row_values, workspace.jacobian)
    start = workspace.row_values[arrays.rows.table.size - 1, RowColumn.RESIDUAL]
    n_steps = max(1, math.ceil(abs(q - start) / (CONTINUATION_STEP * arrays.coordinate_scale)))
    q_reached = start
    for k in range(n_steps + 1):
        q_next = start + (q - start) * k / n_steps if k < n_steps else q
        node[0] += (q_next - q_reached) * node[1]
        predicted[:] = node[0]
        if not (solve_position(arrays, workspace, q_next, node) and is_on_branch(arrays, node[0], predicted)):
            return False
        q_reached = q_next
    return True


@jit
def solve_positions(arrays: AssemblyArrays, workspace: AssemblyWorkspace, values: FloatArray, nodes: FloatArray) -> BoolArray:
    """Solve for the poses at values (n,) of the coordinate from guesses; return which were found on the branch of their guess (n,)."""
    # nodes (n, 3, 3 bodies) holds the guesses, and on return the poses and their two derivatives by the
    # coordinate.
    is_solved = np.zeros(values.size, dtype=np.bool_)
    guess = np.empty(arrays.pose_scales.size)
    for k in range(values.size):
        guess[:] = nodes[k, 0]
        is_solved[k] = solve_position(arrays, workspace, values[k], nodes[k]) and is_on_branch(arrays, nodes[k, 0], guess)
    return is_solved


@jit
def follow_coordinate(arrays: AssemblyArrays, workspace: AssemblyWorkspace, values: FloatArray, nodes: FloatArray) -> int:
    """Solve for the poses at values (n,) of the coordinate, each from those at the value before; return how many were found."""
    # nodes (n, 3, 3 bodies) holds closed poses in nodes[0, 0], and on return the poses and their two
    # derivatives by the coordinate.
    predicted = np.empty(arrays.pose_scales.size)
    for k in range(values.size):
        change = 0.0
        if k > 0:
            change = values[k] - values[k - 1]
            nodes[k] = nodes[k - 1]
        predicted[:] = nodes[k, 0] + change * (nodes[k, 1] + 0.5 * change * nodes[k, 2])
        start = nodes[k, 0].copy()
        nodes[k, 0] = predicted
        # Far from the value before, or from the start, the way is too long for one step.
        is_near = k > 0 and abs(change) < CONTINUATION_STEP * arrays.coordinate_scale
        if not (is_near and solve_position(arrays, workspace, values[k], nodes[k]) and is_on_branch(arrays, nodes[k, 0], predicted)):
            nodes[k, 0] = start
            if not continue_to_coordinate(arrays, workspace, values[k], nodes[k]):
                return k
    return values.size


class CoordinateSolver(PositionSolver):
    """Assemble one mechanism with one degree of freedom at many values of its leading coordinate."""

    def __init__(self, mechanism: Mechanism) -> None:
        super().__init__(mechanism)
        self._arrays = lower_assembly(mechanism)
        self._workspace = make_assembly_workspace(self._arrays)

    @property
    def initial_coordinate(self) -> float:
        """Value of the leading coordinate at the initial guess, SI."""
        return float(evaluate_output_value(self.mechanism, self.mechanism.coordinate, self.initial_guess))

    def follow(
        self,
        # poses that close the joints, from which the first value is reached; shape (bodies, 3)
        poses: FloatArray,
        values: FloatArray,  # values of the coordinate, SI; shape (n,)
    ) -> FloatArray:
        """Return poses and two derivatives by the coordinate, (n or less, 3, bodies, 3), each on the branch before it."""
        nodes = np.zeros((len(values), 3, *poses.shape))
        nodes[0, 0] = poses
        n_found = follow_coordinate(self._arrays, self._workspace, np.ascontiguousarray(values), nodes.reshape(len(values), 3, -1))
        return nodes[:n_found]

    def try_solve_nodes(self, guesses: FloatArray, values: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return nodes as `solve_nodes` does, and which of them (n,) were found on the branch of their guess."""
        nodes = np.zeros((len(values), 3, *guesses.shape[1:]))
        nodes[:, 0] = guesses
        # a column of an array would be another type of argument, for which the kernel is compiled again
        flat_nodes = nodes.reshape(len(values), 3, nodes.shape[2] * nodes.shape[3])
        is_solved = solve_positions(self._arrays, self._workspace, np.ascontiguousarray(values), flat_nodes)
        return nodes, is_solved

    def solve_nodes(
        self,
        guesses: FloatArray,  # poses near the solutions; shape (n, bodies, 3)
        values: FloatArray,  # values of the leading coordinate, SI; shape (n,)
    ) -> FloatArray:
        """Return poses and two derivatives (n, 3, bodies, 3) at values (n,), on branches of guesses (n, bodies, 3), or raise."""
        # It is raised where the mechanism cannot be assembled (it names the joint that stays open),
        # or where the coordinate is at a turning point and does not determine the poses.
        nodes, is_solved = self.try_solve_nodes(guesses, values)
        for k in np.flatnonzero(~is_solved):
            poses = self.solve_at_coordinate(float(values[k]), guesses[k])
            nodes[k : k + 1], is_regular = self.try_solve_nodes(poses[np.newaxis], values[k : k + 1])
            if not is_regular[0]:
                raise MechanismError(f"{self.mechanism.coordinate!r} is at a turning point there and does not determine the poses")
        return nodes
