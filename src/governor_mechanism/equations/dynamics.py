"""What a motion that is already known implies at its times: accelerations and joint forces, compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.equations.compiled import compiled
from governor_mechanism.equations.motion import accelerations
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.system import System, Workspace, from_centres, make_system, make_workspace
from governor_mechanism.scene import Scene


@dataclass(frozen=True)
class Dynamics:
    """At n times: accelerations of mass centres (n, bodies, 3); forces (n, rows, 3) of each joint row on its second
    body, as force (N) and moment about that body's point (N m); how independent the rows are (n,), 0 where they depend;
    power (n,) W of drives, of loads without a potential, and of the torque on a free spindle.
    """

    accelerations: Array
    forces: Array
    independence: Array
    power: Array


def dynamics(scene: Scene, times: Array, poses: Array, velocities: Array, speeds: Array) -> Dynamics:
    """From times (n,) s, poses and velocities of mass centres (n, bodies, 3), and spindle speeds (n,) rad/s."""
    system, curves = make_system(scene)
    cubics = np.stack([curve.cubics_from(times) for curve in curves], axis=1)
    there, moving = from_centres(system, poses, velocities)
    bends, forces = np.empty_like(poses), np.empty((len(times), len(system.rows.table), 3))
    apart, power = np.empty(len(times)), np.empty(len(times))
    _follow(system, make_workspace(system), cubics, there, moving, speeds**2, bends, forces, apart, power)
    if system.free:
        power += cubics[:, 0, 3] * speeds
    return Dynamics(_of_centres(system, there, moving, bends), forces, apart, power)


@compiled
def _follow(
    system: System,
    room: Workspace,
    cubics: Array,
    poses: Array,
    velocities: Array,
    squares: Array,
    bends: Array,
    forces: Array,
    apart: Array,
    power: Array,
) -> None:
    rows = system.rows
    for t in range(poses.shape[0]):
        apart[t], power[t] = accelerations(system, room, poses[t], velocities[t], cubics[t], 0.0, squares[t], bends[t])
        for i in range(room.vector.size):
            force_x = -room.vector[i] * room.gradient[i, 1, 0]
            force_y = -room.vector[i] * room.gradient[i, 1, 1]
            moment, row = -room.vector[i] * room.gradient[i, 1, 2], rows.table[i]
            if row.second >= 0:
                cosine, sine = np.cos(poses[t, row.second, 2]), np.sin(poses[t, row.second, 2])
                arm_x, arm_y = cosine * row.x2 - sine * row.y2, sine * row.x2 + cosine * row.y2
                moment -= arm_x * force_y - arm_y * force_x
            forces[t, i, 0], forces[t, i, 1], forces[t, i, 2] = force_x, force_y, moment


def _of_centres(system: System, poses: Array, velocities: Array, bends: Array) -> Array:
    """Accelerations of mass centres from those of origins."""
    cosine, sine = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = system.bodies["x"], system.bodies["y"]
    arm_x, arm_y = cosine * x - sine * y, sine * x + cosine * y
    found: NDArray[np.float64] = bends.copy()
    found[..., 0] -= arm_y * bends[..., 2] + arm_x * velocities[..., 2] ** 2
    found[..., 1] += arm_x * bends[..., 2] - arm_y * velocities[..., 2] ** 2
    return found
