"""What a motion that is already known implies at its times: accelerations and joint forces, compiled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.dynamics.contacts import Mode
from governor_mechanism.mechanics.dynamics.equations_of_motion import accelerations
from governor_mechanism.mechanics.dynamics.lowering import (
    System,
    Workspace,
    from_centres,
    make_system,
    make_workspace,
    rows_in_order,
)
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import compiled
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class Dynamics:
    """At n times: accelerations of mass centres (n, bodies, 3); forces (n, rows, 3) of each joint row (as
    `constraints.joint_table` lists them) on its second body, as force (N) and moment about that body's point (N m);
    how independent the rows are (n,), 0 where they depend; power (n,) W of drives, of loads without a potential, and of
    the torque on a free spindle.
    """

    accelerations: FloatArray
    forces: FloatArray
    independence: FloatArray
    power: FloatArray


def dynamics(
    scene: Scene,
    times: FloatArray,
    poses: FloatArray,
    velocities: FloatArray,
    speeds: FloatArray,
    modes: Sequence[Mode] = (),
) -> Dynamics:
    """From times (n,) s, poses and velocities of mass centres (n, bodies, 3), and spindle speeds (n,) rad/s.

    modes (n,) say what sticks and rests at each time; left out, nothing does.
    """
    if not modes:
        return _dynamics(scene, None, times, poses, velocities, speeds)
    parts = {}
    for mode in dict.fromkeys(modes):
        at = np.flatnonzero([other == mode for other in modes])
        parts[mode] = at, _dynamics(scene, mode, times[at], poses[at], velocities[at], speeds[at])
    names = ("accelerations", "forces", "independence", "power")
    whole = {name: np.zeros((len(times), *getattr(parts[modes[0]][1], name).shape[1:])) for name in names}
    for at, part in parts.values():
        for name in names:
            whole[name][at] = getattr(part, name)
    return Dynamics(**whole)


def _dynamics(
    scene: Scene, mode: Mode | None, times: FloatArray, poses: FloatArray, velocities: FloatArray, speeds: FloatArray
) -> Dynamics:
    system, curves = make_system(scene, mode)
    cubics = np.stack([curve.cubics_from(times) for curve in curves], axis=1)
    there, moving = from_centres(system, poses, velocities)
    bends, forces = np.empty_like(poses), np.empty((len(times), len(system.rows.table), 3))
    apart, power = np.empty(len(times)), np.empty(len(times))
    _follow(system, make_workspace(system), cubics, there, moving, speeds**2, bends, forces, apart, power)
    if system.free:
        power += cubics[:, 0, 3] * speeds
    order = rows_in_order(scene, mode)
    joints = len(order) - sum(value is not None for value in mode.held) if mode else len(order)
    in_order = np.empty_like(forces)
    in_order[:, order] = forces
    return Dynamics(_of_centres(system, there, moving, bends), in_order[:, :joints], apart, power)


@compiled
def _follow(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    poses: FloatArray,
    velocities: FloatArray,
    squares: FloatArray,
    bends: FloatArray,
    forces: FloatArray,
    apart: FloatArray,
    power: FloatArray,
) -> None:
    rows = system.rows
    for t in range(poses.shape[0]):
        apart[t], power[t], _ = accelerations(
            system, room, poses[t], velocities[t], cubics[t], 0.0, squares[t], bends[t]
        )
        for i in range(room.vector.size):
            force_x = -room.vector[i] * room.gradient[i, 1, 0]
            force_y = -room.vector[i] * room.gradient[i, 1, 1]
            moment, row = -room.vector[i] * room.gradient[i, 1, 2], rows.table[i]
            if row.second >= 0:
                cosine, sine = np.cos(poses[t, row.second, 2]), np.sin(poses[t, row.second, 2])
                arm_x, arm_y = cosine * row.x2 - sine * row.y2, sine * row.x2 + cosine * row.y2
                moment -= arm_x * force_y - arm_y * force_x
            forces[t, i, 0], forces[t, i, 1], forces[t, i, 2] = force_x, force_y, moment


def _of_centres(system: System, poses: FloatArray, velocities: FloatArray, bends: FloatArray) -> FloatArray:
    """Accelerations of mass centres from those of origins."""
    cosine, sine = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = system.bodies["x"], system.bodies["y"]
    arm_x, arm_y = cosine * x - sine * y, sine * x + cosine * y
    found: NDArray[np.float64] = bends.copy()
    found[..., 0] -= arm_y * bends[..., 2] + arm_x * velocities[..., 2] ** 2
    found[..., 1] += arm_x * bends[..., 2] - arm_y * velocities[..., 2] ** 2
    return found
