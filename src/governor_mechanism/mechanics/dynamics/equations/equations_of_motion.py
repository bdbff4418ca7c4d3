"""Equations of motion of a mechanism as compiled kernels.

Inputs are evaluated as in `time_functions`.
"""

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT
from governor_mechanism.mechanics.dynamics.equations.body_forces import evaluate_body_forces, evaluate_plane_motion
from governor_mechanism.mechanics.dynamics.equations.constrained_solution import (
    CLEAR_PIVOT_RATIO,
    assemble_schur_band,
    equal_mass_pivot_ratio,
    solve_constrained_system,
)
from governor_mechanism.mechanics.dynamics.forces.inputs import evaluate_inputs
from governor_mechanism.mechanics.dynamics.forces.output_forces import add_output_forces
from governor_mechanism.mechanics.dynamics.system.arrays import PlaneColumn, System, SystemWorkspace
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn, evaluate_drives, evaluate_rows
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray


@jit_in_place
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
    equal masses; power, power of drives and of forces without a potential, dissipation subtracted, W;
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
    output_rows, values, jacobian = system.output_rows, workspace.output_row_values, workspace.output_jacobian
    dissipated_power = -add_output_forces(output_rows, system.output_forces, velocities, workspace.inputs, values, jacobian, forces)
    force_elements = workspace.force_elements
    for i in range(force_elements.size):
        if force_elements[i].switch_input != NO_INDEX:
            force_elements[i].coefficients[SWITCH_COEFFICIENT] = workspace.inputs[force_elements[i].switch_input]
    power = add_output_forces(output_rows, force_elements, velocities, workspace.inputs, values, jacobian, forces) - dissipated_power
    assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, workspace.inverse_mass, workspace.band)
    pivot_ratio = solve_constrained_system(system, workspace, forces, 1.0, result)
    for i in range(workspace.multipliers.size):
        power -= workspace.multipliers[i] * workspace.row_values[i, RowColumn.DRIVE_RATE]
    if 0.0 < pivot_ratio < CLEAR_PIVOT_RATIO:
        pivot_ratio = max(pivot_ratio, equal_mass_pivot_ratio(system, workspace))
    return pivot_ratio, power, dissipated_power


@jit_in_place
def evaluate_inputs_at(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
    input_cubics: FloatArray,  # local cubics of all inputs; shape (inputs, 5)
    local_time: float,  # time since the start of these cubics, s
    lag_states: FloatArray,  # states of the lags; shape (lags,)
) -> None:
    """Evaluate the output rows and then the inputs into the workspace."""
    row_values, jacobian = workspace.output_row_values, workspace.output_jacobian
    if system.output_rows.table.size > 0:
        evaluate_rows(system.output_rows, poses, velocities, row_values, jacobian)
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
    """Evaluate the time derivative of a state.

    The work state is the work put in by changes of given spindle speeds, less the work of drives and of forces without a potential.

    Result: smallest pivot ratio of J M^-1 J^T; 0 where rows are linearly dependent.
    """
    layout = system.state_layout
    poses, velocities = state[: layout.velocities].reshape(-1, 3), state[layout.velocities : layout.work].reshape(-1, 3)
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
