"""Inverse dynamics: accelerations and joint forces of a known motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.equations.equations_of_motion import evaluate_accelerations
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.system.arrays import System, SystemWorkspace, make_system_workspace
from governor_mechanism.mechanics.dynamics.system.holding_rows import constraint_row_order
from governor_mechanism.mechanics.dynamics.system.lowering import make_system
from governor_mechanism.mechanics.dynamics.system.reference_points import from_mass_centres
from governor_mechanism.mechanics.kinematics.constraint_kernels import rotate_vector_jit
from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit
from governor_mechanism.types import GROUND_INDEX, FloatArray


@dataclass(frozen=True)
class InverseDynamics:
    """Accelerations, joint forces and power of a known motion at n times.

    Attributes
    ----------
    accelerations
        Accelerations of the mass centres, m/s2 and rad/s2; shape (n, bodies, 3).
    joint_forces
        Force (N) and moment about the joint's point on the second body (N m) that each joint row exerts on that body, in
        the order of `make_constraint_table`; shape (n, rows, 3).
    pivot_ratios
        Smallest pivot ratio of J M^-1 J^T; 0 where rows are linearly dependent; shape (n,).
    power
        Power of drives and of forces without a potential, W; shape (n,).
    """

    accelerations: FloatArray
    joint_forces: FloatArray
    pivot_ratios: FloatArray
    power: FloatArray


def compute_inverse_dynamics(
    scene: Scene,
    times: FloatArray,  # times, s; shape (n,)
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (n, bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (n, bodies, 3)
    lags: FloatArray,  # states of first-order lags; shape (n, lags)
    # contact mode at each time; if empty, no output is held and no friction acts
    modes: Sequence[ContactMode] = (),
) -> InverseDynamics:
    """Return the accelerations and joint forces of a known motion.

    Result: accelerations, joint forces, pivot ratios and power.
    """
    if not modes:
        return _compute_in_mode(scene, None, times, poses, velocities, lags)
    indices = {mode: np.flatnonzero([other == mode for other in modes]) for mode in dict.fromkeys(modes)}
    parts = [_compute_in_mode(scene, mode, times[i], poses[i], velocities[i], lags[i]) for mode, i in indices.items()]
    time_order = np.argsort(np.concatenate(list(indices.values())))
    return InverseDynamics(*(np.concatenate(values)[time_order] for values in zip(*(vars(part).values() for part in parts), strict=True)))


def _compute_in_mode(
    scene: Scene, mode: ContactMode | None, times: FloatArray, poses: FloatArray, velocities: FloatArray, lags: FloatArray
) -> InverseDynamics:
    """Return the inverse dynamics at times that share one contact mode."""
    system, time_functions = make_system(scene, mode)
    input_cubics = stack_local_cubics(time_functions, times)
    origin_poses, origin_velocities = from_mass_centres(system, poses, velocities)
    origin_accelerations, row_forces, pivot_ratios, power = _evaluate_along_motion(
        system, make_system_workspace(system), input_cubics, origin_poses, origin_velocities, np.ascontiguousarray(lags)
    )
    row_order = constraint_row_order(scene, mode)
    n_joint_rows = len(row_order) - sum(value is not None for value in mode.held_values) if mode else len(row_order)
    ordered_forces = np.empty_like(row_forces)
    ordered_forces[:, row_order] = row_forces
    accelerations = _mass_centre_accelerations(system, origin_poses, origin_velocities, origin_accelerations)
    return InverseDynamics(accelerations, ordered_forces[:, :n_joint_rows], pivot_ratios, power)


@jit
def _evaluate_along_motion(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, poses: FloatArray, velocities: FloatArray, lags: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return accelerations of the body origins, forces of the constraint rows, pivot ratios and power at all times."""
    rows, n_times = system.constraint_rows, poses.shape[0]
    body_accelerations, row_forces = np.empty(poses.shape), np.empty((n_times, rows.table.size, 3))
    pivot_ratios, power = np.empty(n_times), np.empty(n_times)
    for t in range(n_times):
        pivot_ratios[t], power[t], _ = evaluate_accelerations(
            system, workspace, poses[t], velocities[t], input_cubics[t], 0.0, lags[t], body_accelerations[t]
        )
        for i in range(workspace.multipliers.size):
            force_x = -workspace.multipliers[i] * workspace.jacobian[i, 1, 0]
            force_y = -workspace.multipliers[i] * workspace.jacobian[i, 1, 1]
            moment, row = -workspace.multipliers[i] * workspace.jacobian[i, 1, 2], rows.table[i]
            if row.second != GROUND_INDEX:
                arm_x, arm_y = rotate_vector_jit(poses[t, row.second, 2], row.x2, row.y2)
                moment -= arm_x * force_y - arm_y * force_x
            row_forces[t, i, 0], row_forces[t, i, 1], row_forces[t, i, 2] = force_x, force_y, moment
    return body_accelerations, row_forces, pivot_ratios, power


def _mass_centre_accelerations(system: System, poses: FloatArray, velocities: FloatArray, origin_accelerations: FloatArray) -> FloatArray:
    """Return the accelerations of the mass centres from those of the body origins."""
    arm_x, arm_y = rotate_vector(poses[..., 2], system.bodies["x"], system.bodies["y"])
    result: FloatArray = origin_accelerations.copy()
    result[..., 0] -= arm_y * origin_accelerations[..., 2] + arm_x * velocities[..., 2] ** 2
    result[..., 1] += arm_x * origin_accelerations[..., 2] - arm_y * velocities[..., 2] ** 2
    return result
