"""Accelerations of a mechanism under its joints and loads, and the projection of its state, compiled."""

from __future__ import annotations

import math

from governor_mechanism.equations import forces
from governor_mechanism.equations.compiled import compiled
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.rows import evaluate
from governor_mechanism.equations.schur import along, assemble, give_back, solve
from governor_mechanism.equations.system import System, Workspace

centrifugal_force = compiled(forces.centrifugal_force)
centrifugal_moment = compiled(forces.centrifugal_moment)
spindle_inertia = compiled(forces.spindle_inertia)
weight = compiled(forces.weight)


@compiled
def accelerations(
    system: System, room: Workspace, poses: Array, velocities: Array, speed_squared: float, result: Array
) -> bool:
    """Fill result (bodies, 3); room.vector then holds the joint forces (N), row by row. False at dependent rows."""
    evaluate(
        system.kind,
        system.body,
        system.anchor,
        system.parameter,
        poses,
        velocities,
        room.opening,
        room.gradient,
        room.bend,
    )
    _free_accelerations(system, poses, velocities, speed_squared, result)
    assemble(system.body, system.pairs, room.gradient, system.inverse_mass, room.band)
    along(system.body, room.gradient, result, room.vector)
    for i in range(room.vector.size):
        room.vector[i] -= room.bend[i]
    independent = solve(room.band, room.factor, room.vector)
    give_back(system.body, room.gradient, system.inverse_mass, room.vector, result)
    return independent


@compiled
def _free_accelerations(system: System, poses: Array, velocities: Array, speed_squared: float, result: Array) -> None:
    """M^-1 times the loads: what the bodies would do without joints."""
    for k in range(system.mass.size):
        mass, angle = system.mass[k], poses[k, 2]
        cosine, sine = math.cos(angle), math.sin(angle)
        arm_x = cosine * system.centre[k, 0] - sine * system.centre[k, 1]
        arm_y = sine * system.centre[k, 0] + cosine * system.centre[k, 1]
        force_x, force_y, moment = 0.0, weight(mass, system.gravity), 0.0
        if system.centrifugal:
            xx, yy, xy = system.moments[k, 0], system.moments[k, 1], system.moments[k, 2]
            force_x = centrifugal_force(mass, poses[k, 0] + arm_x, speed_squared)
            moment = centrifugal_moment(xx, yy, xy, angle, speed_squared)
        moment += arm_x * force_y - arm_y * force_x
        result[k, 0] = system.inverse_mass[k, 0] * force_x
        result[k, 1] = system.inverse_mass[k, 1] * force_y
        result[k, 2] = system.inverse_mass[k, 2] * moment


@compiled
def inertia_about_spindle(system: System, poses: Array) -> float:
    """J (kg m2) of all bodies."""
    total = 0.0
    for k in range(system.mass.size):
        angle = poses[k, 2]
        x = poses[k, 0] + math.cos(angle) * system.centre[k, 0] - math.sin(angle) * system.centre[k, 1]
        xx, yy, xy, zz = system.moments[k, 0], system.moments[k, 1], system.moments[k, 2], system.moments[k, 3]
        total += spindle_inertia(system.mass[k], xx, yy, xy, zz, x, angle)
    return total


@compiled
def project(system: System, room: Workspace, poses: Array, velocities: Array, closed: float) -> float:
    """Close all joints to `closed` (m), take from the velocities what opens them, in place; the gap that was left."""
    gap = 0.0
    for _ in range(8):
        evaluate(
            system.kind,
            system.body,
            system.anchor,
            system.parameter,
            poses,
            velocities,
            room.opening,
            room.gradient,
            room.bend,
        )
        assemble(system.body, system.pairs, room.gradient, system.inverse_mass, room.band)
        gap = 0.0
        for i in range(room.opening.size):
            gap = max(gap, abs(room.opening[i]))
        if not gap > closed:
            break
        room.vector[:] = room.opening
        solve(room.band, room.factor, room.vector)
        give_back(system.body, room.gradient, system.inverse_mass, room.vector, poses)
    along(system.body, room.gradient, velocities, room.vector)
    solve(room.band, room.factor, room.vector)
    give_back(system.body, room.gradient, system.inverse_mass, room.vector, velocities)
    return gap


@compiled
def slope(system: System, room: Workspace, speed: Array, since: float, state: Array, result: Array) -> bool:
    """Time derivative of a state: poses, velocities, and the work of the spindle's changes of speed (J).

    speed (4,): the spindle's speed as a cubic of the time `since` the start of its piece, highest power first.
    """
    count = system.mass.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    omega = ((speed[0] * since + speed[1]) * since + speed[2]) * since + speed[3]
    growth = (3.0 * speed[0] * since + 2.0 * speed[1]) * since + speed[2]
    result[: 3 * count] = state[3 * count : 6 * count]
    result[6 * count] = 0.0
    if growth != 0.0 and system.centrifugal:
        result[6 * count] = inertia_about_spindle(system, poses) * omega * growth
    bends = result[3 * count : 6 * count].reshape(count, 3)
    return accelerations(system, room, poses, velocities, omega * omega, bends)
