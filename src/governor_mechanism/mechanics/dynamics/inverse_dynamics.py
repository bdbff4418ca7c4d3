"""What a motion that is already known implies at its times: accelerations and joint forces, compiled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_accelerations
from governor_mechanism.mechanics.dynamics.lowering import (
    System,
    SystemWorkspace,
    constraint_row_order,
    from_mass_centres,
    make_system,
    make_system_workspace,
)
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class InverseDynamics:
    """At n times: accelerations of mass centres (n, bodies, 3); forces (n, rows, 3) of each joint row (as
    `constraints.joint_table` lists them) on its second body, as force (N) and moment about that body's point (N m);
    how independent the rows are (n,), 0 where they depend; power (n,) W of drives, of loads without a potential, and of
    the torque on a free spindle.
    """

    accelerations: FloatArray
    joint_forces: FloatArray
    pivot_ratios: FloatArray
    power: FloatArray


def compute_inverse_dynamics(
    scene: Scene, times: FloatArray, poses: FloatArray, velocities: FloatArray, speeds: FloatArray, modes: Sequence[ContactMode] = ()
) -> InverseDynamics:
    """From times (n,) s, poses and velocities of mass centres (n, bodies, 3), and spindle speeds (n,) rad/s.

    modes (n,) say what sticks and rests at each time; left out, nothing does.
    """
    if not modes:
        return _compute_in_mode(scene, None, times, poses, velocities, speeds)
    results = {}
    for mode in dict.fromkeys(modes):
        indices = np.flatnonzero([other == mode for other in modes])
        results[mode] = (indices, _compute_in_mode(scene, mode, times[indices], poses[indices], velocities[indices], speeds[indices]))
    names = ("accelerations", "joint_forces", "pivot_ratios", "power")
    merged = {name: np.zeros((len(times), *getattr(results[modes[0]][1], name).shape[1:])) for name in names}
    for indices, result in results.values():
        for name in names:
            merged[name][indices] = getattr(result, name)
    return InverseDynamics(**merged)


def _compute_in_mode(
    scene: Scene, mode: ContactMode | None, times: FloatArray, poses: FloatArray, velocities: FloatArray, speeds: FloatArray
) -> InverseDynamics:
    system, time_functions = make_system(scene, mode)
    input_cubics = np.stack([time_function.local_cubics(times) for time_function in time_functions], axis=1)
    origin_poses, origin_velocities = from_mass_centres(system, poses, velocities)
    origin_accelerations, row_forces = (np.empty_like(poses), np.empty((len(times), len(system.constraint_rows.table), 3)))
    pivot_ratios, power = np.empty(len(times)), np.empty(len(times))
    _evaluate_along_motion(
        system,
        make_system_workspace(system),
        input_cubics,
        origin_poses,
        origin_velocities,
        speeds**2,
        origin_accelerations,
        row_forces,
        pivot_ratios,
        power,
    )
    if system.has_free_spindle:
        power += input_cubics[:, 0, 3] * speeds
    row_order = constraint_row_order(scene, mode)
    n_joint_rows = len(row_order) - sum(value is not None for value in mode.held_values) if mode else len(row_order)
    ordered_forces = np.empty_like(row_forces)
    ordered_forces[:, row_order] = row_forces
    return InverseDynamics(
        _mass_centre_accelerations(system, origin_poses, origin_velocities, origin_accelerations),
        ordered_forces[:, :n_joint_rows],
        pivot_ratios,
        power,
    )


@jit
def _evaluate_along_motion(
    system: System,
    workspace: SystemWorkspace,
    input_cubics: FloatArray,
    poses: FloatArray,
    velocities: FloatArray,
    speeds_squared: FloatArray,
    body_accelerations: FloatArray,
    row_forces: FloatArray,
    pivot_ratios: FloatArray,
    power: FloatArray,
) -> None:
    rows = system.constraint_rows
    for t in range(poses.shape[0]):
        pivot_ratios[t], power[t], _ = evaluate_accelerations(
            system, workspace, poses[t], velocities[t], input_cubics[t], 0.0, speeds_squared[t], body_accelerations[t]
        )
        for i in range(workspace.multipliers.size):
            force_x = -workspace.multipliers[i] * workspace.jacobian[i, 1, 0]
            force_y = -workspace.multipliers[i] * workspace.jacobian[i, 1, 1]
            moment, row = -workspace.multipliers[i] * workspace.jacobian[i, 1, 2], rows.table[i]
            if row.second >= 0:
                cosine, sine = np.cos(poses[t, row.second, 2]), np.sin(poses[t, row.second, 2])
                arm_x, arm_y = cosine * row.x2 - sine * row.y2, sine * row.x2 + cosine * row.y2
                moment -= arm_x * force_y - arm_y * force_x
            row_forces[t, i, 0], row_forces[t, i, 1], row_forces[t, i, 2] = force_x, force_y, moment


def _mass_centre_accelerations(system: System, poses: FloatArray, velocities: FloatArray, origin_accelerations: FloatArray) -> FloatArray:
    """Accelerations of mass centres from those of origins."""
    cosine, sine = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = system.bodies["x"], system.bodies["y"]
    arm_x, arm_y = cosine * x - sine * y, sine * x + cosine * y
    result: NDArray[np.float64] = origin_accelerations.copy()
    result[..., 0] -= arm_y * origin_accelerations[..., 2] + arm_x * velocities[..., 2] ** 2
    result[..., 1] += arm_x * origin_accelerations[..., 2] - arm_y * velocities[..., 2] ** 2
    return result
