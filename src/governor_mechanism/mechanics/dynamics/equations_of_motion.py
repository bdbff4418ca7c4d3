"""Accelerations of a mechanism under its joints and loads, and the projection of its state, compiled.

Time enters as cubics (programs, 5) of the time `since` the start of a piece, highest power first, and what the program
has integrated to before: program 0 is the speed of a given spindle, or the torque on a free one.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.dynamics import force_laws as forces
from governor_mechanism.mechanics.dynamics.constraint_solver import apply_jacobian, assemble_schur_band, solve_schur_band, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.force_elements import add_element_forces
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.output_forces import add_output_forces, evaluate_multibody_event_functions
from governor_mechanism.mechanics.kinematics import time_functions
from governor_mechanism.mechanics.kinematics.constraint_kernels import DRIVE_RATE, GAMMA, RESIDUAL, evaluate_drives, evaluate_rows
from governor_mechanism.numerics.jit import jit, jit_inline, jit_internal
from governor_mechanism.types import FloatArray, RecordArray

centrifugal_force_jit = jit_internal(forces.centrifugal_force)
centrifugal_moment_jit = jit_internal(forces.centrifugal_moment)
free_spindle_speed_jit = jit_internal(forces.free_spindle_speed)
spindle_inertia_jit = jit_internal(forces.spindle_inertia)
fluctuating_speed_kernel = jit_internal(time_functions.fluctuating_speed)
weight_jit = jit_internal(forces.weight)

N_AUXILIARY_STATES = 4
"""Numbers of a state beside poses and velocities: work (J), what brakes and friction took of it (J), angle of the
spindle (rad), its momentum (kg m2/s)."""


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
    """Fill result (bodies, 3); room.vector then holds the joint forces (N), row by row, against its gradient.

    How independent the rows are (see `schur.solve`), the power (W) of drives and of loads that have no potential, and
    what brakes and friction take (W), which that power is less by.
    """
    rows = system.constraint_rows
    evaluate_drives(rows, input_cubics, local_time, workspace.row_values)
    evaluate_rows(rows, poses, velocities, workspace.row_values, workspace.jacobian)
    power, dissipated_power = evaluate_generalised_forces(
        system, workspace, poses, velocities, input_cubics, local_time, speed_squared, workspace.generalised_forces
    )
    for k in range(system.bodies.size):
        for c in range(3):
            result[k, c] = system.inverse_mass[k, c] * workspace.generalised_forces[k, c]
    assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, system.inverse_mass, workspace.band)
    apply_jacobian(rows.row_bodies, workspace.jacobian, result, workspace.multipliers)
    for i in range(workspace.multipliers.size):
        workspace.multipliers[i] -= workspace.row_values[i, GAMMA]
    pivot_ratio = solve_schur_band(workspace.band, workspace.factor, workspace.multipliers)
    subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, result)
    for i in range(workspace.multipliers.size):
        power -= workspace.multipliers[i] * workspace.row_values[i, DRIVE_RATE]
    return pivot_ratio, power, dissipated_power


@jit_internal
def evaluate_body_forces(
    bodies: RecordArray, gravity: float, centrifugal: bool, poses: FloatArray, speed_squared: float, result: FloatArray
) -> None:
    """Fill result (bodies, 3) with what gravity and the spindle's turning do to the bodies' origins."""
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        arm_x = arm_y = 0.0
        if body.x != 0.0 or body.y != 0.0:
            cosine, sine = math.cos(angle), math.sin(angle)
            arm_x, arm_y = cosine * body.x - sine * body.y, sine * body.x + cosine * body.y
        force_x, force_y, moment = 0.0, weight_jit(body.mass, gravity), 0.0
        if centrifugal:
            force_x = centrifugal_force_jit(body.mass, poses[k, 0] + arm_x, speed_squared)
            moment = centrifugal_moment_jit(body.xx, body.yy, body.xy, angle, speed_squared)
        result[k, 0] = force_x
        result[k, 1] = force_y
        result[k, 2] = moment + arm_x * force_y - arm_y * force_x


@jit
def evaluate_generalised_forces(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    speed_squared: float,
    result: FloatArray,
) -> tuple[float, float]:
    """Fill result (bodies, 3) with all loads on the bodies' origins.

    The power (W) of those without a potential, and what brakes and friction take, which it is less by.
    """
    evaluate_body_forces(system.bodies, system.gravity, system.has_centrifugal_forces, poses, speed_squared, result)
    power = add_element_forces(system.force_elements, poses, velocities, input_cubics, local_time, result)
    dissipated_power = add_output_forces(
        system.output_rows,
        system.output_forces,
        poses,
        velocities,
        input_cubics,
        local_time,
        workspace.output_row_values,
        workspace.output_jacobian,
        result,
    )
    return power - dissipated_power, dissipated_power


@jit
def inertia_about_spindle(system: System, poses: FloatArray) -> float:
    """J (kg m2) of all bodies."""
    return bodies_inertia_about_spindle(system.bodies, poses)


@jit_internal
def bodies_inertia_about_spindle(bodies: RecordArray, poses: FloatArray) -> float:
    """J (kg m2) of these bodies."""
    total = 0.0
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        x = poses[k, 0] + math.cos(angle) * body.x - math.sin(angle) * body.y
        total += spindle_inertia_jit(body.mass, body.xx, body.yy, body.xy, body.zz, x, angle)
    return total


@jit_inline
def project_state_inline(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    local_time: float,
    poses: FloatArray,
    velocities: FloatArray,
    closure_tolerance: float,
) -> float:
    """Close all joints to `closed` (m), take from the velocities what opens them, in place; the gap that was left.

    Where inverse_mass is zero, coordinates stay as they are.
    """
    rows = system.constraint_rows
    evaluate_drives(rows, input_cubics, local_time, workspace.row_values)
    max_residual = 0.0
    for _ in range(8):
        evaluate_rows(rows, poses, velocities, workspace.row_values, workspace.jacobian)
        assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, system.inverse_mass, workspace.band)
        max_residual = 0.0
        for i in range(workspace.multipliers.size):
            workspace.multipliers[i] = workspace.row_values[i, RESIDUAL]
            max_residual = max(max_residual, abs(workspace.multipliers[i]))
        if not max_residual > closure_tolerance:
            break
        solve_schur_band(workspace.band, workspace.factor, workspace.multipliers)
        subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, poses)
    apply_jacobian(rows.row_bodies, workspace.jacobian, velocities, workspace.multipliers)
    for i in range(workspace.multipliers.size):
        workspace.multipliers[i] -= workspace.row_values[i, DRIVE_RATE]
    solve_schur_band(workspace.band, workspace.factor, workspace.multipliers)
    subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, velocities)
    return max_residual


@jit
def project_state(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    local_time: float,
    poses: FloatArray,
    velocities: FloatArray,
    closure_tolerance: float,
) -> float:
    """That projection, for Python to call."""
    return project_state_inline(system, workspace, input_cubics, local_time, poses, velocities, closure_tolerance)


@jit_internal
def evaluate_spindle_speed(
    system: System, poses: FloatArray, input_cubics: FloatArray, local_time: float, momentum: float
) -> tuple[float, float, float]:
    """Speed (rad/s) of the spindle, its given slope (rad/s2), and the torque (N m) on a free one."""
    a, b, c, d = input_cubics[0, 0], input_cubics[0, 1], input_cubics[0, 2], input_cubics[0, 3]
    value = ((a * local_time + b) * local_time + c) * local_time + d
    if system.has_free_spindle:
        return (free_spindle_speed_jit(momentum, system.spindle_inertia + inertia_about_spindle(system, poses)), 0.0, value)
    mean_acceleration = (3.0 * a * local_time + 2.0 * b) * local_time + c
    if system.fluctuation_amplitude == 0.0:
        return value, mean_acceleration, 0.0
    mean_angle = input_cubics[0, 4] + (((0.25 * a * local_time + b / 3.0) * local_time + 0.5 * c) * local_time + d) * local_time
    speed, acceleration = fluctuating_speed_kernel(
        system.fluctuation_amplitude, system.cycles_per_turn, mean_angle, value, mean_acceleration
    )
    return speed, acceleration, 0.0


@jit_inline
def evaluate_state_derivative_inline(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray, result: FloatArray
) -> float:
    """Time derivative of a state: poses, velocities and what EXTRA names; how independent the rows are.

    Work (J) is what the changes of a given speed have put in, less what drives, loads and a free spindle's torque have.
    """
    n_bodies = system.bodies.size
    poses, velocities = (state[: 3 * n_bodies].reshape(n_bodies, 3), state[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3))
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
        result[6 * n_bodies] += inertia_about_spindle(system, poses) * spindle_velocity * spindle_acceleration
    result[6 * n_bodies + 1] = dissipated_power
    result[6 * n_bodies + 2] = spindle_velocity
    result[6 * n_bodies + 3] = torque
    return pivot_ratio


@jit
def evaluate_state_derivative(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray
) -> FloatArray:
    """That derivative, for Python to call."""
    result = np.empty(state.size)
    evaluate_state_derivative_inline(system, workspace, input_cubics, local_time, state, result)
    return result


@jit
def evaluate_events_and_derivative(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What is watched at a state, and the state's slope, for Python to call."""
    derivative, event_values = np.empty(state.size), np.empty(system.event_functions.size)
    evaluate_state_derivative_inline(system, workspace, input_cubics, local_time, state, derivative)
    n_bodies = system.bodies.size
    poses, velocities = (state[: 3 * n_bodies].reshape(n_bodies, 3), state[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3))
    evaluate_multibody_event_functions(
        system.output_rows,
        system.event_functions,
        poses,
        velocities,
        input_cubics,
        local_time,
        workspace.multipliers,
        workspace.output_row_values,
        workspace.output_jacobian,
        event_values,
    )
    return event_values, derivative
