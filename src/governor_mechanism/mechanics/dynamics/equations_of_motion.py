"""Equations of motion of a mechanism, and the projection of its state to the constraint manifold, as compiled kernels.

Inputs are evaluated as in `input_kernels`.
"""

import math

import numpy as np

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT
from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.mechanics.dynamics.constraint_solver import apply_jacobian, assemble_schur_band, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.inputs import evaluate_inputs, output_rate
from governor_mechanism.mechanics.dynamics.lowering import PlaneColumn, System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.output_forces import EventFunctionKind, add_output_forces, evaluate_event_function
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn, evaluate_drives, evaluate_rows, rotate_vector_jit
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_given_speed
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.banded_cholesky import factorise_band, solve_band_system, solve_factorised_band
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import FloatArray, RecordArray

centrifugal_force_jit = jit_in_place(force_laws.centrifugal_force)
centrifugal_moment_jit = jit_in_place(force_laws.centrifugal_moment)
spindle_inertia_rate_jit = jit_in_place(force_laws.spindle_inertia_rate)
spindle_inertia_jit = jit_in_place(force_laws.spindle_inertia)
weight_jit = jit_in_place(force_laws.weight)

N_ENERGY_STATES = 2
"""Number of states after poses and velocities: the work term of the energy balance (J) and the energy dissipated by dashpots and friction
(J). The states of the lags follow them."""

CLEAR_PIVOT_RATIO = 0.1
"""Pivot ratio of the constraint rows above which they are independent in any metric: no integrator steers around a change point there, and
rounding costs the multipliers a single digit."""

MAX_PROJECTION_ITERATIONS = 8
"""Maximum number of Newton iterations of a projection; they converge quadratically from a state near the manifold."""


MAX_STAND_IN_ITERATIONS = 60
"""Maximum number of solutions that remove the stand-in inertia; five suffice unless hardly any mass moves with a massless body."""

STAND_IN_TOLERANCE = 1e-15
"""Change of the inertia forces of stand-ins, relative to the forces of the system, at which they are removed."""

STAND_IN_ROUNDING_RATIO = 1e-11
"""The same change below which it may stop falling: rounding in an ill-conditioned position."""


@jit_in_place
def evaluate_accelerations(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    lag_states: FloatArray,
    result: FloatArray,
) -> tuple[float, float, float]:
    """Evaluate the accelerations of the body origins into result (bodies, 3).

    The Lagrange multipliers remain in `workspace.multipliers`, with the Jacobian of the rows in `workspace.jacobian`.
    Returns the smallest pivot ratio (see `solve_band_system`), in the metric of the masses or of equal masses; the power (W) of drives and
    of forces without a potential, dissipation subtracted; and the power (W) that dashpots and friction dissipate.
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
        if force_elements[i].switch_input >= 0:
            force_elements[i].coefficients[SWITCH_COEFFICIENT] = workspace.inputs[force_elements[i].switch_input]
    power = add_output_forces(output_rows, force_elements, velocities, workspace.inputs, values, jacobian, forces) - dissipated_power
    assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, workspace.inverse_mass, workspace.band)
    pivot_ratio = solve_constrained_system(system, workspace, forces, 1.0, result)
    for i in range(workspace.multipliers.size):
        power -= workspace.multipliers[i] * workspace.row_values[i, RowColumn.DRIVE_RATE]
    if 0.0 < pivot_ratio < CLEAR_PIVOT_RATIO:
        pivot_ratio = max(pivot_ratio, _equal_mass_pivot_ratio(system, workspace))
    return pivot_ratio, power, dissipated_power


@jit_in_place
def _equal_mass_pivot_ratio(system: System, workspace: SystemWorkspace) -> float:
    """Return the smallest pivot ratio of the rows in the workspace as if all bodies had the same mass.

    Where a light body carries a heavy one, the pivot ratio in the metric of the masses is as small as the ratio of the masses, though
    nothing is singular. At a change point it vanishes in every metric.
    """
    band, metric = workspace.equal_mass_band, system.equal_mass_metric
    assemble_schur_band(system.constraint_rows.row_bodies, system.row_pairs, workspace.jacobian, metric, band)
    return factorise_band(band, workspace.factor)


@jit_in_place
def solve_constrained_system(
    system: System, workspace: SystemWorkspace, forces: FloatArray, gamma_factor: float, result: FloatArray
) -> float:
    """Solve M result + J^T multipliers = forces, J result = gamma_factor * gamma; return the smallest pivot ratio.

    `workspace` holds J, gamma, the band of J M^-1 J^T and the inverse masses. `forces` may be changed.
    """
    pivot_ratio = _solve_with_stand_ins(system, workspace, forces, gamma_factor, result)
    if system.has_stand_in_inertia:
        _remove_stand_in_inertia(system, workspace, forces, gamma_factor, result)
    return pivot_ratio


@jit_in_place
def _solve_with_stand_ins(system: System, workspace: SystemWorkspace, forces: FloatArray, gamma_factor: float, result: FloatArray) -> float:
    """Solve as `solve_constrained_system`, with a mass matrix that includes the stand-in inertia."""
    for k in range(system.bodies.size):
        for c in range(3):
            result[k, c] = workspace.inverse_mass[k, c] * forces[k, c]
    _evaluate_row_residuals(system, workspace, gamma_factor, result, workspace.multipliers)
    pivot_ratio = solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
    _subtract_row_forces(system, workspace, workspace.multipliers, result)
    if 0.0 < pivot_ratio < CLEAR_PIVOT_RATIO:
        _refine_multipliers(system, workspace, gamma_factor, result)
    return pivot_ratio


@jit_in_place
def _evaluate_row_residuals(
    system: System, workspace: SystemWorkspace, gamma_factor: float, accelerations: FloatArray, residuals: FloatArray
) -> None:
    """Fill the residuals J accelerations - gamma_factor * gamma of the rows."""
    apply_jacobian(system.constraint_rows.row_bodies, workspace.jacobian, accelerations, residuals)
    for i in range(residuals.size):
        residuals[i] -= gamma_factor * workspace.row_values[i, RowColumn.GAMMA]


@jit_in_place
def _subtract_row_forces(system: System, workspace: SystemWorkspace, multipliers: FloatArray, accelerations: FloatArray) -> None:
    """Subtract the accelerations by forces of the rows, in place."""
    subtract_minv_jt(system.constraint_rows.row_bodies, workspace.jacobian, workspace.inverse_mass, multipliers, accelerations)


@jit_in_place
def _refine_multipliers(system: System, workspace: SystemWorkspace, gamma_factor: float, accelerations: FloatArray) -> None:
    """Refine multipliers and accelerations by what the accelerations leave of the rows (iterative refinement).

    Rounding of the force in a joint that a light body passes on to a heavy one accelerates the light body by 1 / its mass. The rows
    tell that from motion: without this, step control takes it for motion and shortens the steps without end.
    """
    corrections = workspace.multiplier_corrections
    _evaluate_row_residuals(system, workspace, gamma_factor, accelerations, corrections)
    solve_factorised_band(workspace.factor, corrections)
    _subtract_row_forces(system, workspace, corrections, accelerations)
    for i in range(corrections.size):
        workspace.multipliers[i] += corrections[i]


@jit
def _remove_stand_in_inertia(
    system: System, workspace: SystemWorkspace, forces: FloatArray, gamma_factor: float, result: FloatArray
) -> None:
    """Solve again with the inertia forces of the stand-ins added to the forces, until the result is that without stand-ins.

    The error falls by the share of the stand-ins in the inertia of the motion. If it does not vanish, the result is NaN, which
    an integrator rejects.
    """
    added_forces, last_change = np.zeros_like(result), math.inf
    for _ in range(MAX_STAND_IN_ITERATIONS):
        change = magnitude = 0.0
        for k in range(system.bodies.size):
            for c in range(3):
                stand_in, inverse_mass = system.stand_in_inertia[k, c], workspace.inverse_mass[k, c]
                if inverse_mass > 0.0:
                    magnitude += forces[k, c] * forces[k, c] * inverse_mass + result[k, c] * result[k, c] / inverse_mass
                if stand_in > 0.0:
                    force_change = stand_in * result[k, c] - added_forces[k, c]
                    forces[k, c] += force_change
                    added_forces[k, c] += force_change
                    change += force_change * force_change / stand_in
        is_rounding = change >= last_change and change <= STAND_IN_ROUNDING_RATIO**2 * magnitude
        if is_rounding or change <= STAND_IN_TOLERANCE**2 * magnitude:
            return
        last_change = change
        _solve_with_stand_ins(system, workspace, forces, gamma_factor, result)
    result[:] = math.nan


@jit_in_place
def evaluate_inputs_at(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    lag_states: FloatArray,
) -> None:
    """Evaluate the output rows and then the inputs into the workspace."""
    row_values, jacobian = workspace.output_row_values, workspace.output_jacobian
    if system.output_rows.table.size > 0:
        evaluate_rows(system.output_rows, poses, velocities, row_values, jacobian)
    evaluate_inputs(
        system.input_terms, system.output_rows, row_values, jacobian, velocities, input_cubics, local_time, lag_states, workspace.inputs
    )


@jit_in_place
def evaluate_plane_motion(
    system: System, workspace: SystemWorkspace, poses: FloatArray, velocities: FloatArray, input_cubics: FloatArray, local_time: float
) -> None:
    """Evaluate speed, acceleration and inertia of the planes, and with them the inverse masses, into the workspace."""
    for p in range(system.planes.size):
        plane, motion = system.planes[p], workspace.plane_motion[p]
        if plane.shaft >= 0:
            motion[PlaneColumn.SPEED], motion[PlaneColumn.ACCELERATION] = plane.ratio * velocities[plane.shaft, 2], 0.0
        else:
            speed, acceleration = evaluate_given_speed(input_cubics, plane.input_index, local_time, plane.amplitude, plane.cycles_per_turn)
            motion[PlaneColumn.SPEED], motion[PlaneColumn.ACCELERATION] = plane.ratio * speed, plane.ratio * acceleration
        if plane.shaft >= 0 or motion[PlaneColumn.ACCELERATION] != 0.0:
            motion[PlaneColumn.INERTIA], motion[PlaneColumn.INERTIA_RATE] = inertia_of_plane(system.bodies, p, poses, velocities)
    update_inverse_mass(system, workspace)


@jit_in_place
def update_inverse_mass(system: System, workspace: SystemWorkspace) -> None:
    """Set the inverse masses of the workspace; a shaft gets the inertia of its plane, unless the system keeps its angle."""
    copy_array(workspace.inverse_mass, system.inverse_mass)
    for p in range(system.planes.size):
        shaft = system.planes[p].shaft
        if system.planes[p].has_reaction and system.inverse_mass[shaft, 2] > 0.0:
            own_inertia = system.bodies[shaft].xx + system.bodies[shaft].yy
            workspace.inverse_mass[shaft, 2] = 1.0 / (own_inertia + workspace.plane_motion[p, PlaneColumn.INERTIA])


@jit_in_place
def evaluate_body_forces(bodies: RecordArray, plane_motion: FloatArray, poses: FloatArray, result: FloatArray) -> None:
    """Fill result (bodies, 3) with gravity and centrifugal forces on the bodies, reduced to their origins."""
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        arm_x = arm_y = 0.0
        if body.x != 0.0 or body.y != 0.0:
            arm_x, arm_y = rotate_vector_jit(angle, body.x, body.y)
        force_x, force_y, moment = 0.0, weight_jit(body.mass, body.gravity), 0.0
        if body.plane >= 0:
            speed = plane_motion[body.plane, PlaneColumn.SPEED]
            speed_squared = speed * speed
            force_x = centrifugal_force_jit(body.mass, poses[k, 0] + arm_x, speed_squared)
            moment = centrifugal_moment_jit(body.xx, body.yy, body.xy, angle, speed_squared)
        result[k, 0] = force_x
        result[k, 1] = force_y
        result[k, 2] = moment + arm_x * force_y - arm_y * force_x


@jit
def inertia_of_plane(bodies: RecordArray, plane: int, poses: FloatArray, velocities: FloatArray) -> tuple[float, float]:
    """Return the moment of inertia of the bodies of a plane about its spindle, and its rate.

    Parameters
    ----------
    bodies
        Records of `BODY_DTYPE`; shape (bodies,).
    plane
        Index of the plane.
    poses
        Poses of the body origins, m and rad; shape (bodies, 3).
    velocities
        Their time derivatives; shape (bodies, 3).

    Returns
    -------
    inertia : float
        Moment of inertia, kg m2.
    rate : float
        Its time derivative, kg m2/s.
    """
    total = rate = 0.0
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        if body.plane != plane:
            continue
        arm_x = math.cos(angle) * body.x - math.sin(angle) * body.y
        arm_y = math.sin(angle) * body.x + math.cos(angle) * body.y
        x, x_rate = poses[k, 0] + arm_x, velocities[k, 0] - arm_y * velocities[k, 2]
        total += spindle_inertia_jit(body.mass, body.xx, body.yy, body.xy, body.zz, x, angle)
        rate += spindle_inertia_rate_jit(body.mass, body.xx, body.yy, body.xy, x, angle, x_rate, velocities[k, 2])
    return total, rate


@jit_in_place
def project_state(
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
    evaluate_plane_motion(system, workspace, poses, velocities, input_cubics, local_time)
    max_residual = 0.0
    for _ in range(MAX_PROJECTION_ITERATIONS):
        evaluate_rows(rows, poses, velocities, workspace.row_values, workspace.jacobian)
        assemble_schur_band(rows.row_bodies, system.row_pairs, workspace.jacobian, workspace.inverse_mass, workspace.band)
        max_residual = 0.0
        for i in range(workspace.multipliers.size):
            workspace.multipliers[i] = workspace.row_values[i, RowColumn.RESIDUAL]
            max_residual = max(max_residual, abs(workspace.multipliers[i]))
        if not max_residual > closure_tolerance:
            break
        solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
        subtract_minv_jt(rows.row_bodies, workspace.jacobian, workspace.inverse_mass, workspace.multipliers, poses)
    apply_jacobian(rows.row_bodies, workspace.jacobian, velocities, workspace.multipliers)
    for i in range(workspace.multipliers.size):
        workspace.multipliers[i] -= workspace.row_values[i, RowColumn.DRIVE_RATE]
    solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
    subtract_minv_jt(rows.row_bodies, workspace.jacobian, workspace.inverse_mass, workspace.multipliers, velocities)
    return max_residual


@jit_in_place
def evaluate_state_derivative(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, local_time: float, state: FloatArray, result: FloatArray
) -> float:
    """Evaluate the time derivative of a state.

    The work state is the work put in by changes of given spindle speeds, less the work of drives and of forces without a potential.

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
        Poses and velocities of the body origins, the energy states and the lags; shape (6 * bodies + N_ENERGY_STATES + lags,).
    result
        Result: the time derivative, with the shape of `state`.

    Returns
    -------
    float
        Smallest pivot ratio of J M^-1 J^T; 0 where rows are linearly dependent.
    """
    n_bodies = system.bodies.size
    poses, velocities = state[: 3 * n_bodies].reshape(-1, 3), state[3 * n_bodies : 6 * n_bodies].reshape(-1, 3)
    first_lag = 6 * n_bodies + N_ENERGY_STATES
    for i in range(3 * n_bodies):
        result[i] = state[3 * n_bodies + i]
    body_accelerations = result[3 * n_bodies : 6 * n_bodies].reshape(n_bodies, 3)
    pivot_ratio, power, dissipated_power = evaluate_accelerations(
        system, workspace, poses, velocities, input_cubics, local_time, state[first_lag:], body_accelerations
    )
    result[6 * n_bodies], result[6 * n_bodies + 1] = -power, dissipated_power
    for p in range(system.planes.size):
        plane, motion = system.planes[p], workspace.plane_motion[p]
        acceleration = motion[PlaneColumn.ACCELERATION] if plane.shaft < 0 else plane.ratio * body_accelerations[plane.shaft, 2]
        if not plane.has_reaction and acceleration != 0.0:
            result[6 * n_bodies] += motion[PlaneColumn.INERTIA] * motion[PlaneColumn.SPEED] * acceleration
    for k in range(system.lags.size):
        lag = system.lags[k]
        result[first_lag + k] = (workspace.inputs[lag.input_index] - state[first_lag + k]) / lag.time_constant
    return pivot_ratio


@jit_in_place
def evaluate_event_functions(system: System, workspace: SystemWorkspace, state: FloatArray, event_values: FloatArray) -> None:
    """Evaluate the event functions at the state whose derivative was evaluated last.

    Parameters
    ----------
    system
        Arrays of the multibody model.
    workspace
        Work arrays, with the inputs and Lagrange multipliers that `evaluate_accelerations` leaves in them.
    state
        Poses and velocities of the body origins, the energy states and the lags; shape (6 * bodies + N_ENERGY_STATES + lags,).
    event_values
        Result: values of the event functions, -1 for one that is not armed; shape (event functions,).
    """
    n_coordinates = 3 * system.bodies.size
    poses, velocities = state[:n_coordinates].reshape(-1, 3), state[n_coordinates : 2 * n_coordinates].reshape(-1, 3)
    row_values, jacobian = workspace.output_row_values, workspace.output_jacobian
    evaluate_rows(system.output_rows, poses, velocities, row_values, jacobian)
    for i in range(system.event_functions.size):
        event_function = system.event_functions[i]
        if not workspace.is_armed[i]:
            event_values[i] = -1.0
            continue
        limit = workspace.inputs[event_function.input_index] if event_function.input_index >= 0 else 0.0
        argument = row_values[event_function.argument_index, RowColumn.RESIDUAL] if event_function.argument_index >= 0 else 0.0
        if event_function.kind == EventFunctionKind.RATE:
            value = output_rate(system.output_rows, jacobian, event_function.source_index, velocities)
        elif event_function.kind == EventFunctionKind.FORCE:
            value = -workspace.multipliers[event_function.source_index]
        else:
            value = row_values[event_function.source_index, RowColumn.RESIDUAL]
        event_values[i] = evaluate_event_function(system.event_functions, i, value, argument, limit)
