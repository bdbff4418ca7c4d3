"""Accelerations of a mechanism under its joints and loads, and the projection of its state, compiled.

Time enters as cubics (programs, 5) of the time `since` the start of a piece, highest power first, and what the program
has integrated to before: program 0 is the speed of a given spindle, or the torque on a free one.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.dynamics import force_laws as forces
from governor_mechanism.mechanics.dynamics.constraint_solver import along, assemble, give_back, solve
from governor_mechanism.mechanics.dynamics.force_elements import add_loads
from governor_mechanism.mechanics.dynamics.lowering import System, Workspace
from governor_mechanism.mechanics.dynamics.output_forces import add_acts, observe
from governor_mechanism.mechanics.kinematics import time_functions
from governor_mechanism.mechanics.kinematics.constraint_kernels import BEND, OPENING, RATE, ask, evaluate
from governor_mechanism.numerics.jit import compiled, inlined, kernel
from governor_mechanism.types import FloatArray, RecordArray

centrifugal_force = kernel(forces.centrifugal_force)
centrifugal_moment = kernel(forces.centrifugal_moment)
free_spindle_speed = kernel(forces.free_spindle_speed)
spindle_inertia = kernel(forces.spindle_inertia)
uneven_speed = kernel(time_functions.uneven_speed)
weight = kernel(forces.weight)

EXTRA = 4
"""Numbers of a state beside poses and velocities: work (J), what brakes and friction took of it (J), angle of the
spindle (rad), its momentum (kg m2/s)."""


@inlined
def accelerations(
    system: System,
    room: Workspace,
    poses: FloatArray,
    velocities: FloatArray,
    cubics: FloatArray,
    since: float,
    speed_squared: float,
    result: FloatArray,
) -> tuple[float, float, float]:
    """Fill result (bodies, 3); room.vector then holds the joint forces (N), row by row, against its gradient.

    How independent the rows are (see `schur.solve`), the power (W) of drives and of loads that have no potential, and
    what brakes and friction take (W), which that power is less by.
    """
    rows = system.rows
    ask(rows, cubics, since, room.line)
    evaluate(rows, poses, velocities, room.line, room.gradient)
    power, lost = generalised_forces(system, room, poses, velocities, cubics, since, speed_squared, room.load)
    for k in range(system.bodies.size):
        for c in range(3):
            result[k, c] = system.inverse_mass[k, c] * room.load[k, c]
    assemble(rows.ends, system.pairs, room.gradient, system.inverse_mass, room.band)
    along(rows.ends, room.gradient, result, room.vector)
    for i in range(room.vector.size):
        room.vector[i] -= room.line[i, BEND]
    independent = solve(room.band, room.factor, room.vector)
    give_back(rows.ends, room.gradient, system.inverse_mass, room.vector, result)
    for i in range(room.vector.size):
        power -= room.vector[i] * room.line[i, RATE]
    return independent, power, lost


@kernel
def body_forces(
    bodies: RecordArray, gravity: float, centrifugal: bool, poses: FloatArray, speed_squared: float, result: FloatArray
) -> None:
    """Fill result (bodies, 3) with what gravity and the spindle's turning do to the bodies' origins."""
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        arm_x = arm_y = 0.0
        if body.x != 0.0 or body.y != 0.0:
            cosine, sine = math.cos(angle), math.sin(angle)
            arm_x, arm_y = cosine * body.x - sine * body.y, sine * body.x + cosine * body.y
        force_x, force_y, moment = 0.0, weight(body.mass, gravity), 0.0
        if centrifugal:
            force_x = centrifugal_force(body.mass, poses[k, 0] + arm_x, speed_squared)
            moment = centrifugal_moment(body.xx, body.yy, body.xy, angle, speed_squared)
        result[k, 0] = force_x
        result[k, 1] = force_y
        result[k, 2] = moment + arm_x * force_y - arm_y * force_x


@compiled
def generalised_forces(
    system: System,
    room: Workspace,
    poses: FloatArray,
    velocities: FloatArray,
    cubics: FloatArray,
    since: float,
    speed_squared: float,
    result: FloatArray,
) -> tuple[float, float]:
    """Fill result (bodies, 3) with all loads on the bodies' origins.

    The power (W) of those without a potential, and what brakes and friction take, which it is less by.
    """
    body_forces(system.bodies, system.gravity, system.centrifugal, poses, speed_squared, result)
    power = add_loads(system.loads, poses, velocities, cubics, since, result)
    lost = add_acts(system.gauges, system.acts, poses, velocities, cubics, since, room.seen, room.leaning, result)
    return power - lost, lost


@compiled
def inertia_about_spindle(system: System, poses: FloatArray) -> float:
    """J (kg m2) of all bodies."""
    return inertia_of(system.bodies, poses)


@kernel
def inertia_of(bodies: RecordArray, poses: FloatArray) -> float:
    """J (kg m2) of these bodies."""
    total = 0.0
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        x = poses[k, 0] + math.cos(angle) * body.x - math.sin(angle) * body.y
        total += spindle_inertia(body.mass, body.xx, body.yy, body.xy, body.zz, x, angle)
    return total


@inlined
def close_joints(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    since: float,
    poses: FloatArray,
    velocities: FloatArray,
    closed: float,
) -> float:
    """Close all joints to `closed` (m), take from the velocities what opens them, in place; the gap that was left.

    Where inverse_mass is zero, coordinates stay as they are.
    """
    rows = system.rows
    ask(rows, cubics, since, room.line)
    gap = 0.0
    for _ in range(8):
        evaluate(rows, poses, velocities, room.line, room.gradient)
        assemble(rows.ends, system.pairs, room.gradient, system.inverse_mass, room.band)
        gap = 0.0
        for i in range(room.vector.size):
            room.vector[i] = room.line[i, OPENING]
            gap = max(gap, abs(room.vector[i]))
        if not gap > closed:
            break
        solve(room.band, room.factor, room.vector)
        give_back(rows.ends, room.gradient, system.inverse_mass, room.vector, poses)
    along(rows.ends, room.gradient, velocities, room.vector)
    for i in range(room.vector.size):
        room.vector[i] -= room.line[i, RATE]
    solve(room.band, room.factor, room.vector)
    give_back(rows.ends, room.gradient, system.inverse_mass, room.vector, velocities)
    return gap


@compiled
def project(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    since: float,
    poses: FloatArray,
    velocities: FloatArray,
    closed: float,
) -> float:
    """That projection, for Python to call."""
    return close_joints(system, room, cubics, since, poses, velocities, closed)


@kernel
def spindle_speed(
    system: System, poses: FloatArray, cubics: FloatArray, since: float, momentum: float
) -> tuple[float, float, float]:
    """Speed (rad/s) of the spindle, its given slope (rad/s2), and the torque (N m) on a free one."""
    a, b, c, d = cubics[0, 0], cubics[0, 1], cubics[0, 2], cubics[0, 3]
    value = ((a * since + b) * since + c) * since + d
    if system.free:
        return free_spindle_speed(momentum, system.spindle_inertia + inertia_about_spindle(system, poses)), 0.0, value
    growth = (3.0 * a * since + 2.0 * b) * since + c
    if system.uneven == 0.0:
        return value, growth, 0.0
    turned = cubics[0, 4] + (((0.25 * a * since + b / 3.0) * since + 0.5 * c) * since + d) * since
    speed, slope = uneven_speed(system.uneven, system.waves, turned, value, growth)
    return speed, slope, 0.0


@inlined
def slope(
    system: System, room: Workspace, cubics: FloatArray, since: float, state: FloatArray, result: FloatArray
) -> float:
    """Time derivative of a state: poses, velocities and what EXTRA names; how independent the rows are.

    Work (J) is what the changes of a given speed have put in, less what drives, loads and a free spindle's torque have.
    """
    count = system.bodies.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    omega, growth, torque = spindle_speed(system, poses, cubics, since, state[6 * count + 3])
    for i in range(3 * count):
        result[i] = state[3 * count + i]
    bends = result[3 * count : 6 * count].reshape(count, 3)
    independent, power, lost = accelerations(system, room, poses, velocities, cubics, since, omega * omega, bends)
    result[6 * count] = -power - torque * omega
    if growth != 0.0 and system.centrifugal:
        result[6 * count] += inertia_about_spindle(system, poses) * omega * growth
    result[6 * count + 1] = lost
    result[6 * count + 2] = omega
    result[6 * count + 3] = torque
    return independent


@compiled
def slope_of(system: System, room: Workspace, cubics: FloatArray, since: float, state: FloatArray) -> FloatArray:
    """That derivative, for Python to call."""
    result = np.empty(state.size)
    slope(system, room, cubics, since, state, result)
    return result


@compiled
def marks_of(
    system: System, room: Workspace, cubics: FloatArray, since: float, state: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What is watched at a state, and the state's slope, for Python to call."""
    result, marks = np.empty(state.size), np.empty(system.watch.size)
    slope(system, room, cubics, since, state, result)
    count = system.bodies.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    observe(system.gauges, system.watch, poses, velocities, cubics, since, room.vector, room.seen, room.leaning, marks)
    return marks, result
