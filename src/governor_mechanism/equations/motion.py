"""Accelerations of a mechanism under its joints and loads, and the projection of its state, compiled.

Time enters as cubics (programs, 4) of the time `since` the start of a piece, highest power first: program 0 is the
speed of a given spindle, or the torque on a free one.
"""

from __future__ import annotations

import math

from governor_mechanism.equations import forces
from governor_mechanism.equations.applied import add_loads
from governor_mechanism.equations.compiled import compiled
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.rows import ask, evaluate
from governor_mechanism.equations.schur import along, assemble, give_back, solve
from governor_mechanism.equations.system import System, Workspace

centrifugal_force = compiled(forces.centrifugal_force)
centrifugal_moment = compiled(forces.centrifugal_moment)
free_spindle_speed = compiled(forces.free_spindle_speed)
spindle_inertia = compiled(forces.spindle_inertia)
weight = compiled(forces.weight)

EXTRA = 3
"""Numbers of a state beside poses and velocities: work (J), angle of the spindle (rad), its momentum (kg m2/s)."""


@compiled
def accelerations(
    system: System,
    room: Workspace,
    poses: Array,
    velocities: Array,
    cubics: Array,
    since: float,
    speed_squared: float,
    result: Array,
) -> tuple[float, float]:
    """Fill result (bodies, 3); room.vector then holds the joint forces (N), row by row, against its gradient.

    How independent the rows are (see `schur.solve`), and the power (W) of drives and of loads that have no potential.
    """
    rows = system.rows
    ask(rows, cubics, since, room.asked)
    evaluate(rows, poses, velocities, room.asked, room.opening, room.gradient, room.bend)
    power = generalised_forces(system, poses, velocities, cubics, since, speed_squared, room.load)
    for k in range(system.mass.size):
        for c in range(3):
            result[k, c] = system.inverse_mass[k, c] * room.load[k, c]
    assemble(rows.body, system.pairs, room.gradient, system.inverse_mass, room.band)
    along(rows.body, room.gradient, result, room.vector)
    for i in range(room.vector.size):
        room.vector[i] -= room.bend[i]
    independent = solve(room.band, room.factor, room.vector)
    give_back(rows.body, room.gradient, system.inverse_mass, room.vector, result)
    for i in range(room.vector.size):
        power -= room.vector[i] * room.asked[i, 1]
    return independent, power


@compiled
def generalised_forces(
    system: System,
    poses: Array,
    velocities: Array,
    cubics: Array,
    since: float,
    speed_squared: float,
    result: Array,
) -> float:
    """Fill result (bodies, 3) with all loads on the bodies' origins; the power (W) of those without a potential."""
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
        result[k, 0] = force_x
        result[k, 1] = force_y
        result[k, 2] = moment + arm_x * force_y - arm_y * force_x
    return add_loads(system.loads, poses, velocities, cubics, since, result)


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
def project(
    system: System, room: Workspace, cubics: Array, since: float, poses: Array, velocities: Array, closed: float
) -> float:
    """Close all joints to `closed` (m), take from the velocities what opens them, in place; the gap that was left.

    Where inverse_mass is zero, coordinates stay as they are.
    """
    rows = system.rows
    ask(rows, cubics, since, room.asked)
    gap = 0.0
    for _ in range(8):
        evaluate(rows, poses, velocities, room.asked, room.opening, room.gradient, room.bend)
        assemble(rows.body, system.pairs, room.gradient, system.inverse_mass, room.band)
        gap = 0.0
        for i in range(room.opening.size):
            gap = max(gap, abs(room.opening[i]))
        if not gap > closed:
            break
        room.vector[:] = room.opening
        solve(room.band, room.factor, room.vector)
        give_back(rows.body, room.gradient, system.inverse_mass, room.vector, poses)
    along(rows.body, room.gradient, velocities, room.vector)
    for i in range(room.vector.size):
        room.vector[i] -= room.asked[i, 1]
    solve(room.band, room.factor, room.vector)
    give_back(rows.body, room.gradient, system.inverse_mass, room.vector, velocities)
    return gap


@compiled
def spindle_speed(
    system: System, poses: Array, cubics: Array, since: float, momentum: float
) -> tuple[float, float, float]:
    """Speed (rad/s) of the spindle, its given slope (rad/s2), and the torque (N m) on a free one."""
    a, b, c, d = cubics[0, 0], cubics[0, 1], cubics[0, 2], cubics[0, 3]
    value = ((a * since + b) * since + c) * since + d
    if system.free:
        return free_spindle_speed(momentum, system.spindle_inertia + inertia_about_spindle(system, poses)), 0.0, value
    return value, (3.0 * a * since + 2.0 * b) * since + c, 0.0


@compiled
def slope(system: System, room: Workspace, cubics: Array, since: float, state: Array, result: Array) -> float:
    """Time derivative of a state: poses, velocities, work, spindle's angle and momentum; how independent the rows are.

    Work (J) is what the changes of a given speed have put in, less what drives, loads and a free spindle's torque have.
    """
    count = system.mass.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    omega, growth, torque = spindle_speed(system, poses, cubics, since, state[6 * count + 2])
    result[: 3 * count] = state[3 * count : 6 * count]
    bends = result[3 * count : 6 * count].reshape(count, 3)
    independent, power = accelerations(system, room, poses, velocities, cubics, since, omega * omega, bends)
    result[6 * count] = -power - torque * omega
    if growth != 0.0 and system.centrifugal:
        result[6 * count] += inertia_about_spindle(system, poses) * omega * growth
    result[6 * count + 1] = omega
    result[6 * count + 2] = torque
    return independent
