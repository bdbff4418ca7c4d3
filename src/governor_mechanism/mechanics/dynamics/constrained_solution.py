"""Accelerations and Lagrange multipliers under given forces, also of bodies without mass, and projection of states onto the joints.

Rows that share a body are coupled. Ordered well, a long chain has a narrow band and costs no more per link than a short
one. `linear_equations` solves the equations. They are singular where joints are redundant or a mechanism is at a change
point. Kernels are compiled.
"""

import math

import numpy as np

from governor_mechanism.mechanics.dynamics.arrays import System, SystemWorkspace, from_mass_centres, make_system_workspace, to_mass_centres
from governor_mechanism.mechanics.dynamics.body_forces import evaluate_plane_motion
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_drives, evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import RowColumn
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit_in_place, jit_inlined
from governor_mechanism.numerics.linear_equations import factorise_band, solve_band_system, solve_factorised_band
from governor_mechanism.types import GROUND_INDEX, FloatArray, IntArray


@jit_in_place
def assemble_schur_band(
    row_bodies: IntArray, row_pairs: IntArray, jacobian: FloatArray, inverse_mass: FloatArray, band: FloatArray
) -> None:
    """Fill band (rows, bandwidth + 1) with J M^-1 J^T: entry (j + k, j) is at [j, k]."""
    band[:] = 0.0
    for p in range(row_pairs.shape[0]):
        i = row_pairs[p, 0]
        j = row_pairs[p, 1]
        side = row_pairs[p, 2]
        other_side = row_pairs[p, 3]
        k = row_bodies[i, side]
        total = 0.0
        for c in range(3):
            total += jacobian[i, side, c] * inverse_mass[k, c] * jacobian[j, other_side, c]
        band[j, i - j] += total


@jit_in_place
def subtract_minv_jt(
    row_bodies: IntArray,  # bodies of each row; shape (rows, sides)
    jacobian: FloatArray,  # Jacobian of each row with respect to their poses; shape (rows, sides, 3)
    inverse_mass: FloatArray,  # inverse masses and moments of inertia; shape (bodies, 3)
    vector: FloatArray,  # multipliers of the rows; shape (rows,)
    target: FloatArray,  # accelerations, velocities or poses; shape (bodies, 3)
) -> None:
    """Subtract M^-1 J^T vector from target, in place."""
    for i in range(vector.size):
        for side in range(row_bodies.shape[1]):
            k = row_bodies[i, side]
            if k != GROUND_INDEX:
                for c in range(3):
                    target[k, c] -= inverse_mass[k, c] * jacobian[i, side, c] * vector[i]


@jit_in_place
def apply_jacobian(
    row_bodies: IntArray,  # bodies of each row; shape (rows, sides)
    jacobian: FloatArray,  # Jacobian of each row with respect to their poses; shape (rows, sides, 3)
    body_vectors: FloatArray,  # accelerations or velocities of the body origins; shape (bodies, 3)
    result: FloatArray,  # result: the product; shape (rows,)
) -> None:
    """Evaluate the product of the Jacobian and a vector."""
    for i in range(result.size):
        total = 0.0
        for side in range(row_bodies.shape[1]):
            k = row_bodies[i, side]
            if k != GROUND_INDEX:
                for c in range(3):
                    total += jacobian[i, side, c] * body_vectors[k, c]
        result[i] = total


CLEAR_PIVOT_RATIO = 0.1
"""Pivot ratio of the constraint rows above which they are independent in any metric: no integrator steers around a change point there, and
rounding costs the multipliers a single digit."""

MAX_STAND_IN_ITERATIONS = 60
"""Maximum number of solutions that remove the stand-in inertia; five suffice unless hardly any mass moves with a massless body."""

STAND_IN_TOLERANCE = 1e-15
"""Change of the inertia forces of stand-ins, relative to the forces of the system, at which they are removed."""

STAND_IN_ROUNDING_RATIO = 1e-11
"""The same change below which it may stop falling: rounding in an ill-conditioned position."""


@jit_in_place
def equal_mass_pivot_ratio(system: System, workspace: SystemWorkspace) -> float:
    """Return the smallest pivot ratio of the rows in the workspace as if all bodies had the same mass."""
    # Where a light body carries a heavy one, the pivot ratio in the metric of the masses is as small as
    # the ratio of the masses, though nothing is singular. At a change point it vanishes in every
    # metric.
    band, metric = workspace.equal_mass_band, system.equal_mass_metric
    assemble_schur_band(system.constraint_rows.row_bodies, system.row_pairs, workspace.jacobian, metric, band)
    return factorise_band(band, workspace.factor)


@jit_inlined
def solve_constrained_system(
    system: System,
    # work arrays with J, gamma, the band of J M^-1 J^T and the inverse masses; the multipliers remain in them
    workspace: SystemWorkspace,
    forces: FloatArray,  # applied forces, N and N m; may be changed; shape (bodies, 3)
    gamma_factor: float,  # 1 for accelerations under forces; 0 for changes of velocities under impulses
    result: FloatArray,  # result: accelerations, m/s2 and rad/s2; shape (bodies, 3)
) -> float:
    """Solve M result + J^T multipliers = forces, J result = gamma_factor * gamma; return the smallest pivot ratio of J M^-1 J^T."""
    pivot_ratio = _solve_with_stand_ins(system, workspace, forces, gamma_factor, result)
    if system.has_stand_in_inertia:
        _remove_stand_in_inertia(system, workspace, forces, gamma_factor, result)
    return pivot_ratio


@jit_inlined
def _solve_with_stand_ins(system: System, workspace: SystemWorkspace, forces: FloatArray, gamma_factor: float, result: FloatArray) -> float:
    """Solve as `solve_constrained_system`, with a mass matrix that includes the stand-in inertia."""
    for k in range(system.bodies.size):
        for c in range(3):
            result[k, c] = workspace.inverse_mass[k, c] * forces[k, c]
    _evaluate_row_residuals(system, workspace, gamma_factor, result, workspace.multipliers)
    pivot_ratio = solve_band_system(workspace.band, workspace.factor, workspace.eigen, workspace.multipliers)
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
    """Refine multipliers and accelerations by what the accelerations leave of the rows (iterative refinement)."""
    # Rounding of the force in a joint that a light body passes on to a heavy one accelerates the light
    # body by 1 / its mass. The rows tell that from motion: without this, step control takes it for
    # motion and shortens the steps without end.
    corrections = workspace.multiplier_corrections
    _evaluate_row_residuals(system, workspace, gamma_factor, accelerations, corrections)
    solve_factorised_band(workspace.factor, corrections)
    _subtract_row_forces(system, workspace, corrections, accelerations)
    for i in range(corrections.size):
        workspace.multipliers[i] += corrections[i]


@jit_in_place
def _remove_stand_in_inertia(
    system: System, workspace: SystemWorkspace, forces: FloatArray, gamma_factor: float, result: FloatArray
) -> None:
    """Solve again with the inertia forces of the stand-ins added, until they have no effect; the result is NaN if that never comes."""
    # The error falls by the share of the stand-ins in the inertia of the motion. An integrator rejects
    # NaN.
    added_forces, last_change = workspace.stand_in_forces, math.inf
    added_forces[:] = 0.0
    for _ in range(MAX_STAND_IN_ITERATIONS):
        change = magnitude = 0.0
        for k in range(system.bodies.size):
            for c in range(3):
                stand_in = system.stand_in_inertia[k, c]
                inverse_mass = workspace.inverse_mass[k, c]
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


MAX_PROJECTION_ITERATIONS = 8
"""Maximum number of Newton iterations of a projection; they converge quadratically from a state near the manifold."""

CLOSURE_TOLERANCE_RATIO = 1e-14
"""Gap of a closed joint, in length scales: rounding."""


@jit_in_place
def project_state(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,  # local cubics of all inputs; shape (inputs, 5)
    local_time: float,  # time since the start of these cubics, s
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
    closure_tolerance: float,  # residual below which a joint is closed, m
) -> float:
    """Project a state to the constraint manifold in place, weighted by inverse masses (0 keeps a value); return the last residual (m)."""
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
        solve_band_system(workspace.band, workspace.factor, workspace.eigen, workspace.multipliers)
        subtract_minv_jt(rows.row_bodies, workspace.jacobian, workspace.inverse_mass, workspace.multipliers, poses)
    apply_jacobian(rows.row_bodies, workspace.jacobian, velocities, workspace.multipliers)
    for i in range(workspace.multipliers.size):
        workspace.multipliers[i] -= workspace.row_values[i, RowColumn.DRIVE_RATE]
    solve_band_system(workspace.band, workspace.factor, workspace.eigen, workspace.multipliers)
    subtract_minv_jt(rows.row_bodies, workspace.jacobian, workspace.inverse_mass, workspace.multipliers, velocities)
    return max_residual


class StateProjector:
    """Projection of states onto joints and drives, in the metric of the mass matrix.

    Parameters
    ----------
    scene
        The scene.
    """

    def __init__(self, scene: Scene) -> None:
        system, self._input_functions = make_system(scene)
        self._model = system, make_system_workspace(system)
        self._closure_tolerance = CLOSURE_TOLERANCE_RATIO * scene.mechanism.length_scale

    def project(
        self,
        times: FloatArray,  # times at which the drives are evaluated, s; shape (n,)
        # poses of the mass centres, m and rad, with those of free shafts or without; shape (n, bodies, 3)
        poses: FloatArray,
        velocities: FloatArray,  # their time derivatives; shape (n, bodies, 3)
        *,
        closes_joints: bool = True,  # whether poses are projected as well; else they are kept
        model: tuple[System, SystemWorkspace] | None = None,  # one in which outputs are held as well
    ) -> tuple[FloatArray, FloatArray]:
        """Return the nearest poses (n, bodies, 3) with closed joints, and the velocities that impulses of the joints bring about."""
        system, workspace = model or self._model
        n_bodies = poses.shape[1]
        without_shafts = ((0, 0), (0, len(system.bodies) - n_bodies), (0, 0))
        origins, origin_velocities = from_mass_centres(system, np.pad(poses, without_shafts), np.pad(velocities, without_shafts))
        cubics = stack_local_cubics(self._input_functions, times)
        tolerance = self._closure_tolerance if closes_joints else np.inf
        for k in range(len(times)):
            project_state(system, workspace, cubics[k], 0.0, origins[k], origin_velocities[k], tolerance)
        projected_poses, projected_velocities = to_mass_centres(system, origins, origin_velocities)
        return projected_poses[:, :n_bodies], projected_velocities[:, :n_bodies]
