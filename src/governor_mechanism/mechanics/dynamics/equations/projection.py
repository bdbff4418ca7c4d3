"""Projection of the states of a scene onto its joints: a compiled kernel, and the projection of many states."""

import numpy as np

from governor_mechanism.mechanics.dynamics.equations.body_forces import evaluate_plane_motion
from governor_mechanism.mechanics.dynamics.equations.constrained_solution import apply_jacobian, assemble_schur_band, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.system.arrays import System, SystemWorkspace, make_system_workspace
from governor_mechanism.mechanics.dynamics.system.lowering import make_system
from governor_mechanism.mechanics.dynamics.system.reference_points import from_mass_centres, to_mass_centres
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn, evaluate_drives, evaluate_rows
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.banded_cholesky import solve_band_system
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

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
    """Project positions and velocities to the constraint manifold, in place.

    Corrections are weighted by the inverse masses: a coordinate whose inverse mass is 0 keeps its value.

    Result: largest residual at the last evaluation, m.
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
    ) -> tuple[FloatArray, FloatArray]:
        """Return the nearest admissible states; velocities are those that impulses of the joints bring about.

        Results: poses, poses with closed joints; shape (n, bodies, 3); velocities, velocities that satisfy
        joints and drives; shape (n, bodies, 3).
        """
        system = self._model[0]
        n_bodies = poses.shape[1]
        without_shafts = ((0, 0), (0, len(system.bodies) - n_bodies), (0, 0))
        origins, origin_velocities = from_mass_centres(system, np.pad(poses, without_shafts), np.pad(velocities, without_shafts))
        cubics = stack_local_cubics(self._input_functions, times)
        tolerance = self._closure_tolerance if closes_joints else np.inf
        for k in range(len(times)):
            project_state(*self._model, cubics[k], 0.0, origins[k], origin_velocities[k], tolerance)
        projected_poses, projected_velocities = to_mass_centres(system, origins, origin_velocities)
        return projected_poses[:, :n_bodies], projected_velocities[:, :n_bodies]
