"""Equations of motion of a mechanism as compiled kernels, and inverse dynamics: accelerations and joint forces of a known motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT
from governor_mechanism.mechanics.dynamics.arrays import PlaneColumn, System, SystemWorkspace, from_mass_centres, make_system_workspace
from governor_mechanism.mechanics.dynamics.body_forces import evaluate_body_forces, evaluate_plane_motion
from governor_mechanism.mechanics.dynamics.constrained_solution import (
    CLEAR_PIVOT_RATIO,
    assemble_schur_band,
    equal_mass_pivot_ratio,
    solve_constrained_system,
)
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.inputs import evaluate_inputs, output_rate
from governor_mechanism.mechanics.dynamics.lowering import constraint_row_order, make_system
from governor_mechanism.mechanics.dynamics.output_forces import add_output_forces
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_drives, evaluate_rows, evaluate_rows_for, rotate_vector_jit
from governor_mechanism.mechanics.kinematics.constraint_rows import FOR_FORCES, RowColumn, rotate_vector
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit, jit_in_place, jit_inlined
from governor_mechanism.numerics.linear_equations import solve_dense
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, IntArray

JAMMED = -1.0
"""In place of a pivot ratio: friction of what slides raises the forces that press it more than any of them can bear (Painleve)."""


@jit_inlined
def evaluate_accelerations(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
    input_cubics: FloatArray,  # local cubics of all inputs; shape (inputs, 5)
    local_time: float,  # time since the start of these cubics, s
    lag_states: FloatArray,  # states of the lags; shape (lags,)
    result: FloatArray,  # result: accelerations, m/s2 and rad/s2; shape (bodies, 3)
) -> tuple[float, float, float]:
    """Evaluate the accelerations of the body origins.

    The Lagrange multipliers remain in `workspace.multipliers`, with the Jacobian of the rows in `workspace.jacobian`.

    Results: pivot_ratio, smallest pivot ratio (see `solve_band_system`), in the metric of the masses or of
    equal masses, or JAMMED; power, power of drives and of forces without a potential, dissipation subtracted, W;
    dissipated_power, power that dashpots and friction dissipate, W.
    """
    rows, forces = system.constraint_rows, workspace.generalised_forces
    evaluate_drives(rows, input_cubics, local_time, workspace.row_values)
    evaluate_rows(rows, poses, velocities, workspace.row_values, workspace.jacobian)
    evaluate_inputs_at(system, workspace, poses, velocities, input_cubics, local_time, lag_states)
    evaluate_plane_motion(system, workspace, poses, velocities, input_cubics, local_time)
    evaluate_body_forces(system.bodies, workspace.plane_motion, poses, forces)
    for p in range(system.planes.size):
        if system.planes[p].has_reaction:
            motion = workspace.plane_motion[p]
            forces[system.planes[p].shaft, 2] -= motion[PlaneColumn.INERTIA_RATE] * motion[PlaneColumn.SPEED]
    output_rows = system.output_rows
    values = workspace.output_row_values
    jacobian = workspace.output_jacobian
    dissipated_power = -add_output_forces(output_rows, system.output_forces, velocities, workspace.inputs, values, jacobian, forces)
    force_elements = workspace.force_elements
    for i in range(force_elements.size):
        if force_elements[i].switch_input != NO_INDEX:
            force_elements[i].coefficients[SWITCH_COEFFICIENT] = workspace.inputs[force_elements[i].switch_input]
    power = add_output_forces(output_rows, force_elements, velocities, workspace.inputs, values, jacobian, forces) - dissipated_power
    assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, workspace.inverse_mass, workspace.band)
    pivot_ratio = solve_constrained_system(system, workspace, forces, 1.0, result)
    if system.rubbing.size > 0:
        determinant, friction_power = _add_rubbing(system, workspace, velocities, result)
        power += friction_power
        dissipated_power -= friction_power
        if determinant <= 0.0:
            return JAMMED, power, dissipated_power
    for i in range(workspace.multipliers.size):
        power -= workspace.multipliers[i] * workspace.row_values[i, RowColumn.DRIVE_RATE]
    if 0.0 < pivot_ratio < CLEAR_PIVOT_RATIO:
        pivot_ratio = max(pivot_ratio, equal_mass_pivot_ratio(system, workspace))
    return pivot_ratio, power, dissipated_power


@jit_in_place
def _add_rubbing(system: System, workspace: SystemWorkspace, velocities: FloatArray, accelerations: FloatArray) -> tuple[float, float]:
    """Add the friction under normal forces, which it changes itself; return the determinant of their equations, and the power (W)."""
    # Rigid bodies determine the normal forces where the determinant is positive.
    rubbing, n_rubbing = system.rubbing, system.rubbing.size
    multipliers = workspace.rubbing_multipliers
    matrix = workspace.rubbing_matrix
    friction = workspace.rubbing_forces
    copy_array(multipliers[n_rubbing], workspace.multipliers)
    for k in range(n_rubbing):
        output = rubbing[k].output_index
        workspace.generalised_forces[:] = 0.0
        for side in range(2):
            body = system.output_rows.row_bodies[output, side]
            if body != GROUND_INDEX:
                for c in range(3):
                    workspace.generalised_forces[body, c] += workspace.output_jacobian[output, side, c]
        solve_constrained_system(system, workspace, workspace.generalised_forces, 0.0, workspace.rubbing_accelerations[k])
        copy_array(multipliers[k], workspace.multipliers)
    copy_array(workspace.multipliers, multipliers[n_rubbing])
    for j in range(n_rubbing):
        row = rubbing[j].row_index
        friction[j] = -multipliers[n_rubbing, row]  # the normal force without friction, and then with it
        for k in range(n_rubbing):
            matrix[j, k] = (1.0 if j == k else 0.0) - multipliers[k, row] * rubbing[k].coefficient
    determinant, power = solve_dense(matrix, friction), 0.0
    for k in range(n_rubbing):
        friction[k] *= -rubbing[k].coefficient
        power += friction[k] * output_rate(system.output_rows, workspace.output_jacobian, rubbing[k].output_index, velocities)
        for i in range(workspace.multipliers.size):
            workspace.multipliers[i] += friction[k] * multipliers[k, i]
        for b in range(accelerations.shape[0]):
            for c in range(3):
                accelerations[b, c] += friction[k] * workspace.rubbing_accelerations[k, b, c]
    return determinant, power


@jit_inlined
def evaluate_inputs_at(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
    input_cubics: FloatArray,  # local cubics of all inputs; shape (inputs, 5)
    local_time: float,  # time since the start of these cubics, s
    lag_states: FloatArray,  # states of the lags; shape (lags,)
) -> None:
    """Evaluate the output rows of forces and then the inputs into the workspace."""
    row_values, jacobian = workspace.output_row_values, workspace.output_jacobian
    if system.output_rows.table.size > 0:
        evaluate_rows_for(FOR_FORCES, system.output_rows, poses, velocities, row_values, jacobian)
    evaluate_inputs(
        system.input_terms, system.output_rows, row_values, jacobian, velocities, input_cubics, local_time, lag_states, workspace.inputs
    )


@jit_in_place
def evaluate_state_derivative(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,  # local cubics of all inputs; shape (inputs, 5)
    local_time: float,  # time since the start of these cubics, s
    # poses and velocities of the body origins, the energy states and the lags; shape (6 * bodies +
    # N_ENERGY_STATES + lags,)
    state: FloatArray,
    result: FloatArray,  # result: the time derivative, with the shape of `state`
) -> float:
    """Evaluate the rate of a state; return the smallest pivot ratio of J M^-1 J^T, 0 for dependent rows, or JAMMED where friction jams."""
    # The work state is the work put in by changes of given spindle speeds, less the work of drives and
    # of forces without a potential.
    layout = system.state_layout
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    for i in range(layout.velocities):
        result[i] = state[layout.velocities + i]
    body_accelerations = result[layout.velocities : layout.work].reshape(-1, 3)
    pivot_ratio, power, dissipated_power = evaluate_accelerations(
        system, workspace, poses, velocities, input_cubics, local_time, state[layout.lags :], body_accelerations
    )
    result[layout.work] = -power
    result[layout.dissipated_energy] = dissipated_power
    for p in range(system.planes.size):
        plane, motion = system.planes[p], workspace.plane_motion[p]
        acceleration = motion[PlaneColumn.ACCELERATION] if plane.shaft == NO_INDEX else plane.ratio * body_accelerations[plane.shaft, 2]
        if not plane.has_reaction and acceleration != 0.0:
            result[layout.work] += motion[PlaneColumn.INERTIA] * motion[PlaneColumn.SPEED] * acceleration
    for k in range(system.lags.size):
        lag = system.lags[k]
        lag_index = layout.lags + k
        result[lag_index] = (workspace.inputs[lag.input_index] - state[lag_index]) / lag.time_constant
    return pivot_ratio


@dataclass(frozen=True)
class InverseDynamics:
    """Accelerations, joint forces and power of a known motion at n times."""

    accelerations: FloatArray  # accelerations of the mass centres, m/s2 and rad/s2; shape (n, bodies, 3)
    # force (N) and moment about the joint's point on the second body (N m) that each joint row exerts on that
    # body, in the order of `make_constraint_table`; shape (n, rows, 3)
    joint_forces: FloatArray
    pivot_ratios: FloatArray  # smallest pivot ratio of J M^-1 J^T; 0 where rows are linearly dependent; shape (n,)
    power: FloatArray  # power of drives and of forces without a potential, W; shape (n,)
    # force along the output of each contact that holds it or slides under a normal force, N or N m; shape (n,
    # contacts)
    contact_forces: FloatArray


def compute_inverse_dynamics(
    scene: Scene,
    times: FloatArray,  # times, s; shape (n,)
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (n, bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (n, bodies, 3)
    lags: FloatArray,  # states of first-order lags; shape (n, lags)
    # contact mode at each time; if empty, no output is held and no friction acts
    modes: Sequence[ContactMode] = (),
) -> InverseDynamics:
    """Return the accelerations, joint forces, pivot ratios and power of a known motion."""
    if not modes:
        return _compute_in_mode(scene, None, times, poses, velocities, lags)
    numbers, number_at = _number_modes(modes)
    indices = [np.flatnonzero(number_at == number) for number in numbers.values()]
    parts = [_compute_in_mode(scene, mode, times[i], poses[i], velocities[i], lags[i]) for mode, i in zip(numbers, indices, strict=True)]
    time_order = np.argsort(np.concatenate(indices))
    return InverseDynamics(*(np.concatenate(values)[time_order] for values in zip(*(vars(part).values() for part in parts), strict=True)))


def _number_modes(modes: Sequence[ContactMode]) -> tuple[dict[ContactMode, int], IntArray]:
    """Return the number of each mode, and the number at each time; neighbours are mostly the same object."""
    numbers = dict[ContactMode, int]()
    number_at = np.empty(len(modes), dtype=np.int64)
    last, number = None, 0
    for k, mode in enumerate(modes):
        if mode is not last:
            last, number = mode, numbers.setdefault(mode, len(numbers))
        number_at[k] = number
    return numbers, number_at


def _compute_in_mode(
    scene: Scene, mode: ContactMode | None, times: FloatArray, poses: FloatArray, velocities: FloatArray, lags: FloatArray
) -> InverseDynamics:
    """Return the inverse dynamics at times that share one contact mode."""
    system, time_functions = make_system(scene, mode)
    input_cubics = stack_local_cubics(time_functions, times)
    origin_poses, origin_velocities = from_mass_centres(system, poses, velocities)
    origin_accelerations, row_forces, multipliers, pivot_ratios, power = _evaluate_along_motion(
        system, make_system_workspace(system), input_cubics, origin_poses, origin_velocities, np.ascontiguousarray(lags)
    )
    row_order = constraint_row_order(scene, mode)
    n_joint_rows = len(row_order) - sum(value is not None for value in mode.held_values) if mode else len(row_order)
    ordered_forces = np.empty_like(row_forces)
    ordered_forces[:, row_order] = row_forces
    accelerations = _mass_centre_accelerations(system, origin_poses, origin_velocities, origin_accelerations)
    held_forces = -multipliers[:, np.argsort(row_order)[n_joint_rows:]]
    contact_forces = _contact_forces(scene, mode, held_forces) if mode else np.zeros((len(times), 0))
    return InverseDynamics(accelerations, ordered_forces[:, :n_joint_rows], pivot_ratios, power, contact_forces)


def _contact_forces(scene: Scene, mode: ContactMode, held_forces: FloatArray) -> FloatArray:
    """Return the forces (n, contacts) along the outputs of contacts from those of the held ones (n, held)."""
    contacts = contacts_of(scene)
    names = [contact.output_name for contact in contacts_of(scene)]
    forces = np.zeros((len(held_forces), len(contacts)))
    forces[:, [held is not None for held in mode.held_values]] = held_forces
    for k, contact in enumerate(contacts):
        if contact.normal is not None and mode.sliding_signs[k]:
            forces[:, k] = -mode.sliding_signs[k] * contact.friction_coefficient * forces[:, names.index(contact.normal)]
    return forces


@jit
def _evaluate_along_motion(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, poses: FloatArray, velocities: FloatArray, lags: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return accelerations of the body origins, forces and multipliers of the constraint rows, pivot ratios and power at all times."""
    rows, n_times = system.constraint_rows, poses.shape[0]
    body_accelerations = np.empty(poses.shape)
    row_forces = np.empty((n_times, rows.table.size, 3))
    multipliers = np.empty((n_times, rows.table.size))
    pivot_ratios = np.empty(n_times)
    power = np.empty(n_times)
    for t in range(n_times):
        pivot_ratios[t], power[t], _ = evaluate_accelerations(
            system, workspace, poses[t], velocities[t], input_cubics[t], 0.0, lags[t], body_accelerations[t]
        )
        for i in range(workspace.multipliers.size):
            multipliers[t, i] = workspace.multipliers[i]
            force_x = -workspace.multipliers[i] * workspace.jacobian[i, 1, 0]
            force_y = -workspace.multipliers[i] * workspace.jacobian[i, 1, 1]
            moment = -workspace.multipliers[i] * workspace.jacobian[i, 1, 2]
            row = rows.table[i]
            if row.second != GROUND_INDEX:
                arm_x, arm_y = rotate_vector_jit(poses[t, row.second, 2], row.x2, row.y2)
                moment -= arm_x * force_y - arm_y * force_x
            row_forces[t, i, 0] = force_x
            row_forces[t, i, 1] = force_y
            row_forces[t, i, 2] = moment
    return body_accelerations, row_forces, multipliers, pivot_ratios, power


def _mass_centre_accelerations(system: System, poses: FloatArray, velocities: FloatArray, origin_accelerations: FloatArray) -> FloatArray:
    """Return the accelerations of the mass centres from those of the body origins."""
    arm_x, arm_y = rotate_vector(poses[..., 2], system.bodies["x"], system.bodies["y"])
    result: FloatArray = origin_accelerations.copy()
    result[..., 0] -= arm_y * origin_accelerations[..., 2] + arm_x * velocities[..., 2] ** 2
    result[..., 1] += arm_x * origin_accelerations[..., 2] - arm_y * velocities[..., 2] ** 2
    return result
