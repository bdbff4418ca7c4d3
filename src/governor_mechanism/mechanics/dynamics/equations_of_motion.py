"""Equations of motion of a mechanism, and the projection of its state to the constraint manifold, as compiled kernels.

Inputs are evaluated as in `input_kernels`. Input 0 is the given speed of the spindle, or the torque on a free spindle.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.dynamics.constraint_solver import apply_jacobian, assemble_schur_band, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.force_elements import add_element_forces
from governor_mechanism.mechanics.dynamics.force_kernels import (
    centrifugal_force_jit,
    centrifugal_moment_jit,
    free_spindle_speed_jit,
    spindle_inertia_jit,
    weight_jit,
)
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.output_forces import EventFunctionKind, add_output_forces, output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn, evaluate_drives, evaluate_rows, rotate_vector_jit
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_given_speed, evaluate_input
from governor_mechanism.numerics.banded_cholesky import solve_band_system
from governor_mechanism.numerics.jit import jit, jit_inline, jit_internal
from governor_mechanism.types import FloatArray, RecordArray

N_AUXILIARY_STATES = 4
"""Number of states after poses and velocities.

They are the work term of the energy balance (J), the energy dissipated by dashpots and friction (J), the angle of the
spindle (rad) and its angular momentum (kg m2/s).
"""


MAX_PROJECTION_ITERATIONS = 8
"""Maximum number of Newton iterations of a projection; they converge quadratically from a state near the manifold."""


MAX_STAND_IN_ITERATIONS = 60
"""Maximum number of solutions that remove the stand-in inertia; five suffice unless hardly any mass moves with a massless body."""

STAND_IN_TOLERANCE = 1e-15
"""Change of the inertia forces of stand-ins, relative to the forces of the system, at which they are removed."""

STAND_IN_ROUNDING_RATIO = 1e-11
"""The same change below which it may stop falling: rounding in an ill-conditioned position."""


@jit_inline
def evaluate_accelerations(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    speed_squared: float,
    result: FloatArray,
) -> tuple[float, float, float]:
    """Evaluate the accelerations of the body origins into result (bodies, 3).

    The Lagrange multipliers remain in `workspace.multipliers`, with the Jacobian of the rows in `workspace.jacobian`.
    Returns the smallest pivot ratio (see `solve_band_system`), the power (W) of drives and of forces without a potential,
    dissipation subtracted, and the power (W) that dashpots and friction dissipate.
    """
    rows = system.constraint_rows
    evaluate_drives(rows, input_cubics, local_time, workspace.row_values)
    evaluate_rows(rows, poses, velocities, workspace.row_values, workspace.jacobian)
    forces = workspace.generalised_forces
    evaluate_body_forces(system.bodies, system.gravity, system.has_centrifugal_forces, poses, speed_squared, forces)
    power = add_element_forces(system.force_elements, poses, velocities, input_cubics, local_time, forces)
    dissipated_power = add_output_forces(
        system.output_rows,
        system.output_forces,
        poses,
        velocities,
        input_cubics,
        local_time,
        workspace.output_row_values,
        workspace.output_jacobian,
        forces,
    )
    power -= dissipated_power
    assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, system.inverse_mass, workspace.band)
    pivot_ratio = _solve_accelerations(system, workspace, result)
    if system.has_stand_in_inertia:
        _remove_stand_in_inertia(system, workspace, result)
    for i in range(workspace.multipliers.size):
        power -= workspace.multipliers[i] * workspace.row_values[i, RowColumn.DRIVE_RATE]
    return pivot_ratio, power, dissipated_power


@jit_inline
def _solve_accelerations(system: System, workspace: SystemWorkspace, result: FloatArray) -> float:
    """Solve for accelerations under `workspace.generalised_forces`, and for the multipliers; return the smallest pivot ratio."""
    rows, forces = system.constraint_rows, workspace.generalised_forces
    for k in range(system.bodies.size):
        for c in range(3):
            result[k, c] = system.inverse_mass[k, c] * forces[k, c]
    apply_jacobian(rows.row_bodies, workspace.jacobian, result, workspace.multipliers)
    for i in range(workspace.multipliers.size):
        workspace.multipliers[i] -= workspace.row_values[i, RowColumn.GAMMA]
    pivot_ratio = solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
    subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, result)
    return pivot_ratio


@jit_internal
def _remove_stand_in_inertia(system: System, workspace: SystemWorkspace, result: FloatArray) -> None:
    """Solve again with the inertia forces of the stand-ins returned, until the accelerations are those without stand-ins.

    The error falls by the share of the stand-ins in the inertia of the motion. If it does not vanish, the result is NaN, which
    an integrator rejects.
    """
    forces, returned, last_change = workspace.generalised_forces, np.zeros_like(result), math.inf
    for _ in range(MAX_STAND_IN_ITERATIONS):
        change = magnitude = 0.0
        for k in range(system.bodies.size):
            for c in range(3):
                stand_in, inverse_mass = system.stand_in_inertia[k, c], system.inverse_mass[k, c]
                if inverse_mass > 0.0:
                    magnitude += forces[k, c] * forces[k, c] * inverse_mass + result[k, c] * result[k, c] / inverse_mass
                if stand_in > 0.0:
                    force_change = stand_in * result[k, c] - returned[k, c]
                    forces[k, c] += force_change
                    returned[k, c] += force_change
                    change += force_change * force_change / stand_in
        is_rounding = change >= last_change and change <= STAND_IN_ROUNDING_RATIO**2 * magnitude
        if is_rounding or change <= STAND_IN_TOLERANCE**2 * magnitude:
            return
        last_change = change
        _solve_accelerations(system, workspace, result)
    result[:] = math.nan


@jit_internal
def evaluate_body_forces(
    bodies: RecordArray, gravity: float, has_centrifugal_forces: bool, poses: FloatArray, speed_squared: float, result: FloatArray
) -> None:
    """Fill result (bodies, 3) with gravity and centrifugal forces on the bodies, reduced to their origins."""
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        arm_x = arm_y = 0.0
        if body.x != 0.0 or body.y != 0.0:
            arm_x, arm_y = rotate_vector_jit(angle, body.x, body.y)
        force_x, force_y, moment = 0.0, weight_jit(body.mass, gravity), 0.0
        if has_centrifugal_forces:
            force_x = centrifugal_force_jit(body.mass, poses[k, 0] + arm_x, speed_squared)
            moment = centrifugal_moment_jit(body.xx, body.yy, body.xy, angle, speed_squared)
        result[k, 0] = force_x
        result[k, 1] = force_y
        result[k, 2] = moment + arm_x * force_y - arm_y * force_x


@jit
def inertia_about_spindle(bodies: RecordArray, poses: FloatArray) -> float:
    """Return the moment of inertia of all bodies about the spindle axis.

    Parameters
    ----------
    bodies
        Records of `BODY_DTYPE`; shape (bodies,).
    poses
        Poses of the body origins, m and rad; shape (bodies, 3).

    Returns
    -------
    float
        Moment of inertia, kg m2.
    """
    total = 0.0
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        x = poses[k, 0] + math.cos(angle) * body.x - math.sin(angle) * body.y
        total += spindle_inertia_jit(body.mass, body.xx, body.yy, body.xy, body.zz, x, angle)
    return total


def _project_state(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    local_time: float,
    poses: FloatArray,
    velocities: FloatArray,
    closure_tolerance: float,
) -> float:
    """Project positions and velocities to the constraint manifold, in place.

    Corrections are weighted by the inverse masses: a coordinate whose inverse mass is 0 keeps its value.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    workspace
        Work arrays.
    input_cubics
        Local cubics of all inputs; shape (inputs, 5).
    local_time
        Time since the start of these cubics, s.
    poses
        Poses of the body origins, m and rad; shape (bodies, 3).
    velocities
        Their time derivatives; shape (bodies, 3).
    closure_tolerance
        Residual below which a joint is closed, m.

    Returns
    -------
    float
        Largest residual at the last evaluation, m.
    """
    rows = system.constraint_rows
    evaluate_drives(rows, input_cubics, local_time, workspace.row_values)
    max_residual = 0.0
    for _ in range(MAX_PROJECTION_ITERATIONS):
        evaluate_rows(rows, poses, velocities, workspace.row_values, workspace.jacobian)
        assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, system.inverse_mass, workspace.band)
        max_residual = 0.0
        for i in range(workspace.multipliers.size):
            workspace.multipliers[i] = workspace.row_values[i, RowColumn.RESIDUAL]
            max_residual = max(max_residual, abs(workspace.multipliers[i]))
        if not max_residual > closure_tolerance:
            break
        solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
        subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, poses)
    apply_jacobian(rows.row_bodies, workspace.jacobian, velocities, workspace.multipliers)
    for i in range(workspace.multipliers.size):
        workspace.multipliers[i] -= workspace.row_values[i, RowColumn.DRIVE_RATE]
    solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
    subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, velocities)
    return max_residual


project_state = jit(_project_state)
project_state_inline = jit_inline(_project_state)
"""`project_state` inlined in its callers."""


@jit_inline
def split_state(system: System, state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return views of the poses and velocities (bodies, 3) in a state."""
    n_bodies = system.bodies.size
    return state[: 3 * n_bodies].reshape(n_bodies, 3), state[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3)


@jit_internal
def evaluate_spindle_speed(
    system: System, poses: FloatArray, input_cubics: FloatArray, local_time: float, momentum: float
) -> tuple[float, float, float]:
    """Return the speed (rad/s) of the spindle, its prescribed acceleration (rad/s2), and the torque (N m) on a free spindle."""
    if system.has_free_spindle:
        inertia = system.spindle_inertia + inertia_about_spindle(system.bodies, poses)
        return free_spindle_speed_jit(momentum, inertia), 0.0, evaluate_input(input_cubics, 0, local_time)
    speed, acceleration = evaluate_given_speed(input_cubics, local_time, system.fluctuation_amplitude, system.cycles_per_turn)
    return speed, acceleration, 0.0


@jit_inline
def evaluate_state_derivative_inline(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray, result: FloatArray
) -> float:
    """Evaluate the time derivative of a state; inlined in its callers.

    The work state is the work put in by changes of a given spindle speed, less the work of drives, of forces without a
    potential and of the torque on a free spindle.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    workspace
        Work arrays.
    input_cubics
        Local cubics of all inputs; shape (inputs, 5).
    local_time
        Time since the start of these cubics, s.
    state
        Poses and velocities of the body origins, then the auxiliary states; shape (6 * bodies + N_AUXILIARY_STATES,).
    result
        Result: the time derivative, with the shape of `state`.

    Returns
    -------
    float
        Smallest pivot ratio of J M^-1 J^T; 0 where rows are linearly dependent.
    """
    n_bodies = system.bodies.size
    poses, velocities = split_state(system, state)
    spindle_velocity, spindle_acceleration, torque = evaluate_spindle_speed(
        system, poses, input_cubics, local_time, state[6 * n_bodies + 3]
    )
    for i in range(3 * n_bodies):
        result[i] = state[3 * n_bodies + i]
    body_accelerations = result[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3)
    pivot_ratio, power, dissipated_power = evaluate_accelerations(
        system, workspace, poses, velocities, input_cubics, local_time, spindle_velocity * spindle_velocity, body_accelerations
    )
    result[6 * n_bodies] = -power - torque * spindle_velocity
    if spindle_acceleration != 0.0 and system.has_centrifugal_forces:
        result[6 * n_bodies] += inertia_about_spindle(system.bodies, poses) * spindle_velocity * spindle_acceleration
    result[6 * n_bodies + 1] = dissipated_power
    result[6 * n_bodies + 2] = spindle_velocity
    result[6 * n_bodies + 3] = torque
    return pivot_ratio


@jit
def evaluate_state_derivative(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray
) -> FloatArray:
    """Return the time derivative of a state; callable from Python.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    workspace
        Work arrays.
    input_cubics
        Local cubics of all inputs; shape (inputs, 5).
    local_time
        Time since the start of these cubics, s.
    state
        Poses and velocities of the body origins, then the auxiliary states; shape (6 * bodies + N_AUXILIARY_STATES,).

    Returns
    -------
    FloatArray
        Time derivative, with the shape of `state`.
    """
    result = np.empty(state.size)
    evaluate_state_derivative_inline(system, workspace, input_cubics, local_time, state, result)
    return result


@jit_internal
def evaluate_event_functions(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray, event_values: FloatArray
) -> None:
    """Evaluate the event functions at the state whose derivative was evaluated last.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    workspace
        Work arrays, with the Lagrange multipliers that `evaluate_accelerations` leaves in them.
    input_cubics
        Local cubics of all inputs; shape (inputs, 5).
    local_time
        Time since the start of these cubics, s.
    state
        Poses and velocities of the body origins, then the auxiliary states; shape (6 * bodies + N_AUXILIARY_STATES,).
    event_values
        Result: values of the event functions; shape (event functions,).
    """
    poses, velocities = split_state(system, state)
    row_values, jacobian = workspace.output_row_values, workspace.output_jacobian
    evaluate_rows(system.output_rows, poses, velocities, row_values, jacobian)
    for i in range(system.event_functions.size):
        event_function = system.event_functions[i]
        if event_function.kind == EventFunctionKind.VALUE:
            value = row_values[event_function.source_index, RowColumn.RESIDUAL]
        elif event_function.kind == EventFunctionKind.RATE:
            value = output_rate(system.output_rows, jacobian, event_function.source_index, velocities)
        else:
            value = -workspace.multipliers[event_function.source_index]
        event_values[i] = (
            event_function.sign * value - event_function.threshold - evaluate_input(input_cubics, event_function.input_index, local_time)
        )


@jit
def evaluate_events_and_derivative(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the event functions at a state and its time derivative; callable from Python.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    workspace
        Work arrays.
    input_cubics
        Local cubics of all inputs; shape (inputs, 5).
    local_time
        Time since the start of these cubics, s.
    state
        Poses and velocities of the body origins, then the auxiliary states; shape (6 * bodies + N_AUXILIARY_STATES,).

    Returns
    -------
    event_values : FloatArray
        Values of the event functions; an event is an upward zero crossing; shape (event functions,).
    derivative : FloatArray
        Time derivative of the state, with the shape of `state`.
    """
    derivative, event_values = np.empty(state.size), np.empty(system.event_functions.size)
    evaluate_state_derivative_inline(system, workspace, input_cubics, local_time, state, derivative)
    evaluate_event_functions(system, workspace, input_cubics, local_time, state, event_values)
    return event_values, derivative
