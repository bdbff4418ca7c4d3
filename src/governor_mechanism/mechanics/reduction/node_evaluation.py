"""Position solution and coefficients of the reduced model at one value of the coordinate; compiled.

Dense elimination with row pivoting selects independent rows; redundant rows of joints are consistent with them.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_body_forces, inertia_of_plane
from governor_mechanism.mechanics.dynamics.force_elements import add_element_forces
from governor_mechanism.mechanics.dynamics.inputs import output_rate
from governor_mechanism.mechanics.dynamics.lowering import N_PLANE_COLUMNS, PlaneColumn
from governor_mechanism.mechanics.dynamics.output_forces import add_output_forces
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows, RowColumn, evaluate_rows
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import FloatArray, IntArray, RecordArray

MAX_NODE_NEWTON_STEPS = 16
"""Largest number of Newton steps."""

NODE_DIVERGENCE_STEP = 0.3
"""Newton step, in length scales and rad, from which the iteration counts as diverged: no solution is near."""

NODE_ROUNDING_STEP, NODE_CONVERGENCE_STEP = 2e-15, 1e-8
"""Newton steps, in length scales and rad: one of the first size ends the iteration; one below the second ends it if it does not
halve the step before it, because only rounding is left.
"""

NODE_CONTINUATION_STEP = 0.1
"""Continuation step with which a start is reached, in coordinate scales."""

MAX_NODE_BRANCH_DISTANCE = 0.05
"""Distance from the guess, in length scales and rad, beyond which a solution may belong to another branch."""

SINGULAR_NODE_PIVOT_RATIO = 1e-11
"""Pivot of the scaled Jacobian below which it is singular."""


class TableColumn(IntEnum):
    """Columns of the motion table along the coordinate q.

    With T = I q'^2 / 2 the equation of motion is q'' = QUADRATIC q'^2 + POTENTIAL + CENTRIFUGAL w^2 + DAMPING q' + other forces.
    """

    QUADRATIC = 0
    """-I'/2I."""
    POTENTIAL = 1
    """-V'/I; at constant spindle speed it contains the centrifugal forces."""
    CENTRIFUGAL = 2
    """J'/2I."""
    INVERSE_INERTIA = 3
    """1/I."""
    SPINDLE_INERTIA = 4
    """J."""
    DAMPING = 5
    """Derivative of the dampers' force by q', over I."""
    FIRST_PROGRAM = 6
    """From here on the programmed forces at unit input over I, then value and derivative of each output."""


class ReductionArrays(NamedTuple):
    """A mechanism with one degree of freedom as arrays, from which the columns of its motion table are computed.

    Attributes
    ----------
    constraint_rows
        Rows of the joints, and last the row of the leading coordinate.
    coordinate_wraps
        Whether the coordinate is the angle of a line, which is known up to whole turns.
    free_indices
        Indices of the coordinates of poses.ravel() that may change.
    pose_scales
        Scales of all coordinates; shape (3 bodies,).
    row_scales
        Factors that make the residuals of the rows dimensionless; shape (rows,).
    mass
        Mass, mass and moment of inertia of each body; shape (3 bodies,).
    bodies
        Mass properties; shape (bodies,).
    has_centrifugal_forces
        Whether the plane rotates with the spindle and centrifugal forces act.
    springs
        Force elements with a potential.
    dampers
        Force elements that damp.
    programmed_force_elements
        Force elements with a time function.
    program_indices
        Indices of their time functions.
    output_rows
        Rows of the outputs with forces or limits.
    output_scales
        Their scales; shape (outputs,).
    output_springs
        Springs along outputs that both pull and push.
    limits
        Output index, low and high limit; shape (n, 3).
    steady_speed
        Magnitude of a constant spindle speed, rad/s; negative if the speed changes.
    coordinate_scale
        Scale of the coordinate, m or rad.
    time_scale
        Characteristic time, s.
    length_scale
        Characteristic length, m.
    low
        Lower bound of the coordinate.
    high
        Upper bound of the coordinate.
    full_turn
        Whole turn of a coordinate that is an angle, rad; else 0.
    is_conservative
        Whether the quadratic and the potential column hold all forces.
    """

    constraint_rows: ConstraintRows
    coordinate_wraps: bool
    free_indices: IntArray
    pose_scales: FloatArray
    row_scales: FloatArray
    mass: FloatArray
    bodies: RecordArray
    has_centrifugal_forces: bool
    springs: RecordArray
    dampers: RecordArray
    programmed_force_elements: RecordArray
    program_indices: IntArray
    output_rows: ConstraintRows
    output_scales: FloatArray
    output_springs: RecordArray
    limits: FloatArray
    steady_speed: float
    coordinate_scale: float
    time_scale: float
    length_scale: float
    low: float
    high: float
    full_turn: float
    is_conservative: bool


class NodeWorkspace(NamedTuple):
    """Buffers of the node evaluation; min_pivot (1,) is the smallest pivot of the last solved position."""

    row_values: FloatArray
    jacobian: FloatArray
    output_row_values: FloatArray
    output_jacobian: FloatArray
    matrix: FloatArray
    row_order: IntArray
    rhs: FloatArray
    pose_change: FloatArray
    solution: FloatArray
    dense_row: FloatArray
    min_pivot: FloatArray
    generalised_forces: FloatArray
    zero_velocities: FloatArray
    inputs: FloatArray
    plane_motion: FloatArray


def make_node_workspace(arrays: ReductionArrays) -> NodeWorkspace:
    """Allocate the buffers of the node evaluation.

    Parameters
    ----------
    arrays
        The lowered mechanism.

    Returns
    -------
    NodeWorkspace
        Buffers of matching sizes.
    """
    n_rows, n_bodies, n_outputs = len(arrays.constraint_rows.table), len(arrays.bodies), len(arrays.output_rows.table)
    return NodeWorkspace(
        row_values=np.zeros((n_rows, 5)),
        jacobian=np.zeros((n_rows, 2, 3)),
        output_row_values=np.zeros((n_outputs, 5)),
        output_jacobian=np.zeros((n_outputs, 2, 3)),
        matrix=np.zeros((n_rows, len(arrays.free_indices))),
        row_order=np.zeros(n_rows, dtype=np.int64),
        rhs=np.zeros(n_rows),
        pose_change=np.zeros(3 * n_bodies),
        solution=np.zeros(len(arrays.free_indices)),
        dense_row=np.zeros(3 * n_bodies),
        min_pivot=np.zeros(1),
        generalised_forces=np.zeros((n_bodies, 3)),
        zero_velocities=np.zeros((n_bodies, 3)),
        inputs=np.zeros(int(np.max(arrays.program_indices, initial=0)) + 1),
        plane_motion=np.zeros((1, N_PLANE_COLUMNS)),
    )


@jit_in_place
def _factorise(workspace: NodeWorkspace) -> bool:
    """Factorise the matrix in place with row pivoting and store its smallest pivot; return whether it is regular."""
    matrix, row_order, min_pivot = workspace.matrix, workspace.row_order, math.inf
    n_rows, n_columns = matrix.shape
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
        if not min_pivot > SINGULAR_NODE_PIVOT_RATIO:
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
def _solve_factorised(arrays: ReductionArrays, workspace: NodeWorkspace, pose_change: FloatArray) -> float:
    """Fill pose_change (3 bodies,) with the solution of the factorised system; return its largest component in pose scales."""
    matrix, row_order, rhs, solution = workspace.matrix, workspace.row_order, workspace.rhs, workspace.solution
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
def _fill_scaled_jacobian(arrays: ReductionArrays, workspace: NodeWorkspace) -> None:
    """Fill the dimensionless Jacobian (rows, free coordinates); dense_row (3 bodies,) is a buffer of zeros before and after."""
    row_bodies, pose_scales, dense_row = arrays.constraint_rows.row_bodies, arrays.pose_scales, workspace.dense_row
    for i in range(row_bodies.shape[0]):
        for side in range(2):
            body = row_bodies[i, side]
            if body >= 0:
                for c in range(3):
                    dense_row[3 * body + c] += arrays.row_scales[i] * workspace.jacobian[i, side, c] * pose_scales[3 * body + c]
        for k in range(arrays.free_indices.size):
            workspace.matrix[i, k] = dense_row[arrays.free_indices[k]]
        for side in range(2):
            body = row_bodies[i, side]
            if body >= 0:
                dense_row[3 * body : 3 * body + 3] = 0.0


@jit
def solve_position(arrays: ReductionArrays, workspace: NodeWorkspace, q: float, node: FloatArray) -> bool:
    """Solve for the poses node[0] at a value of the coordinate from a guess; fill in their two derivatives."""
    rows, row_scales = arrays.constraint_rows, arrays.row_scales
    row_values, jacobian, rhs = workspace.row_values, workspace.jacobian, workspace.rhs
    poses, tangents = node[0].reshape(-1, 3), node[1].reshape(-1, 3)
    last, previous_step = rhs.size - 1, math.inf
    for _ in range(MAX_NODE_NEWTON_STEPS):
        row_values[:, RowColumn.DRIVE_VALUE] = 0.0
        evaluate_rows(rows, poses, workspace.zero_velocities, row_values, jacobian)
        row_values[last, RowColumn.RESIDUAL] -= q
        if arrays.coordinate_wraps:
            residual = row_values[last, RowColumn.RESIDUAL]
            row_values[last, RowColumn.RESIDUAL] -= 2.0 * math.pi * math.floor(residual / (2.0 * math.pi) + 0.5)
        rhs[:] = -row_values[:, RowColumn.RESIDUAL] * row_scales
        _fill_scaled_jacobian(arrays, workspace)
        if not _factorise(workspace):
            return False
        step = _solve_factorised(arrays, workspace, workspace.pose_change)
        if not step < NODE_DIVERGENCE_STEP:
            return False
        node[0] += workspace.pose_change
        if step <= NODE_ROUNDING_STEP or (step < NODE_CONVERGENCE_STEP and step >= 0.5 * previous_step):
            break
        previous_step = step
    else:
        return False
    rhs[:] = 0.0
    rhs[last] = row_scales[last]
    _solve_factorised(arrays, workspace, node[1])
    row_values[:, RowColumn.DRIVE_ACCELERATION] = 0.0
    evaluate_rows(rows, poses, tangents, row_values, jacobian)
    rhs[:] = row_values[:, RowColumn.GAMMA] * row_scales
    _solve_factorised(arrays, workspace, node[2])
    return True


@jit
def is_on_branch(arrays: ReductionArrays, poses: FloatArray, guess: FloatArray) -> bool:
    """Return whether solved poses (3 bodies,) are so near to their guess that they belong to the same branch."""
    return bool(np.all(np.abs(poses - guess) < MAX_NODE_BRANCH_DISTANCE * arrays.pose_scales))


@jit
def continue_to_coordinate(arrays: ReductionArrays, workspace: NodeWorkspace, q: float, poses: FloatArray) -> bool:
    """Move poses by continuation to a value of the coordinate.

    Parameters
    ----------
    arrays
        The lowered mechanism.
    workspace
        Buffers of the node evaluation.
    q
        Requested coordinate, SI.
    poses
        Poses that nearly close the joints; changed in place; shape (bodies, 3).

    Returns
    -------
    bool
        Whether the value was reached on the same branch.
    """
    node, predicted = np.zeros((3, arrays.pose_scales.size)), np.zeros(arrays.pose_scales.size)
    node[0] = poses.ravel()
    workspace.row_values[:] = 0.0
    evaluate_rows(arrays.constraint_rows, poses, workspace.zero_velocities, workspace.row_values, workspace.jacobian)
    start = workspace.row_values[arrays.constraint_rows.table.size - 1, RowColumn.RESIDUAL]
    n_steps = max(1, math.ceil(abs(q - start) / (NODE_CONTINUATION_STEP * arrays.coordinate_scale)))
    q_reached = start
    for k in range(n_steps + 1):
        q_next = start + (q - start) * k / n_steps
        node[0] += (q_next - q_reached) * node[1]
        predicted[:] = node[0]
        if not (solve_position(arrays, workspace, q_next, node) and is_on_branch(arrays, node[0], predicted)):
            return False
        q_reached = q_next
    poses[:] = node[0].reshape(-1, 3)
    return True


@jit_in_place
def evaluate_columns(arrays: ReductionArrays, workspace: NodeWorkspace, node: FloatArray, columns: FloatArray) -> None:
    """Fill the columns of the table from a node (3, 3 bodies): poses, tangent and curvature."""
    poses, tangents, zero_velocities = node[0].reshape(-1, 3), node[1].reshape(-1, 3), workspace.zero_velocities
    inputs, plane_motion, forces = workspace.inputs, workspace.plane_motion, workspace.generalised_forces
    inertia = inertia_derivative = 0.0
    for k in range(arrays.mass.size):
        inertia += arrays.mass[k] * node[1, k] * node[1, k]
        inertia_derivative += 2.0 * arrays.mass[k] * node[1, k] * node[2, k]
    is_steady = arrays.has_centrifugal_forces and arrays.steady_speed >= 0.0
    plane_motion[0, PlaneColumn.SPEED] = arrays.steady_speed if is_steady else 0.0
    evaluate_body_forces(arrays.bodies, plane_motion, 1.0, poses, forces)
    add_element_forces(arrays.springs, poses, zero_velocities, inputs, forces)
    rows, springs = arrays.output_rows, arrays.output_springs
    evaluate_rows(rows, poses, zero_velocities, workspace.output_row_values, workspace.output_jacobian)
    add_output_forces(rows, springs, zero_velocities, inputs, workspace.output_row_values, workspace.output_jacobian, forces)
    columns[TableColumn.QUADRATIC] = -0.5 * inertia_derivative / inertia
    columns[TableColumn.POTENTIAL] = _project_on_tangent(forces, node[1]) / inertia
    columns[TableColumn.CENTRIFUGAL] = 0.0
    if columns.size == TableColumn.INVERSE_INERTIA:
        return
    if arrays.has_centrifugal_forces and not is_steady:
        plane_motion[0, PlaneColumn.SPEED] = 1.0
        evaluate_body_forces(arrays.bodies, plane_motion, 0.0, poses, forces)
        columns[TableColumn.CENTRIFUGAL] = _project_on_tangent(forces, node[1]) / inertia
    columns[TableColumn.INVERSE_INERTIA] = 1.0 / inertia
    columns[TableColumn.SPINDLE_INERTIA] = inertia_of_plane(arrays.bodies, 0, poses, zero_velocities)[0]
    forces[:] = 0.0
    add_element_forces(arrays.dampers, poses, tangents, inputs, forces)
    columns[TableColumn.DAMPING] = _project_on_tangent(forces, node[1]) / inertia
    column: int = TableColumn.FIRST_PROGRAM
    for program in arrays.program_indices:
        forces[:] = 0.0
        inputs[program] = 1.0
        add_element_forces(arrays.programmed_force_elements, poses, zero_velocities, inputs, forces)
        inputs[program] = 0.0
        columns[column] = _project_on_tangent(forces, node[1]) / inertia
        column += 1
    evaluate_rows(arrays.output_rows, poses, tangents, workspace.output_row_values, workspace.output_jacobian)
    for k in range(arrays.output_rows.table.size):
        columns[column] = workspace.output_row_values[k, RowColumn.RESIDUAL]
        columns[column + 1] = output_rate(arrays.output_rows, workspace.output_jacobian, k, tangents)
        column += 2


@jit_in_place
def _project_on_tangent(forces: FloatArray, tangent: FloatArray) -> float:
    total = 0.0
    for k in range(tangent.size):
        total += forces[k // 3, k % 3] * tangent[k]
    return total
