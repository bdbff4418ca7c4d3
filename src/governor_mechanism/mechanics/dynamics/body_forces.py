"""Gravity and centrifugal forces on bodies, and the motion and inertia of the planes that bodies turn with, as compiled kernels."""

import math

from governor_mechanism.mechanics.dynamics import force_laws
from governor_mechanism.mechanics.dynamics.arrays import PlaneColumn, System, SystemWorkspace
from governor_mechanism.mechanics.kinematics.constraint_kernels import rotate_vector_jit
from governor_mechanism.mechanics.kinematics.time_functions import evaluate_given_speed
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray

centrifugal_force_jit = jit_in_place(force_laws.centrifugal_force)
centrifugal_moment_jit = jit_in_place(force_laws.centrifugal_moment)
spindle_inertia_rate_jit = jit_in_place(force_laws.spindle_inertia_rate)
spindle_inertia_jit = jit_in_place(force_laws.spindle_inertia)
weight_jit = jit_in_place(force_laws.weight)


@jit_in_place
def evaluate_plane_motion(
    system: System,
    workspace: SystemWorkspace,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
    input_cubics: FloatArray,  # local cubics of all inputs; shape (inputs, 5)
    local_time: float,  # time since the start of these cubics, s
) -> None:
    """Evaluate speed, acceleration and inertia of the planes, and with them the inverse masses, into the workspace."""
    for p in range(system.planes.size):
        plane, motion = system.planes[p], workspace.plane_motion[p]
        if plane.shaft != NO_INDEX:
            motion[PlaneColumn.SPEED] = plane.ratio * velocities[plane.shaft, 2]
            motion[PlaneColumn.ACCELERATION] = 0.0
        else:
            speed, acceleration = evaluate_given_speed(input_cubics, plane.input_index, local_time, plane.amplitude, plane.cycles_per_turn)
            motion[PlaneColumn.SPEED], motion[PlaneColumn.ACCELERATION] = plane.ratio * speed, plane.ratio * acceleration
        if plane.shaft != NO_INDEX or motion[PlaneColumn.ACCELERATION] != 0.0:
            motion[PlaneColumn.INERTIA], motion[PlaneColumn.INERTIA_RATE] = inertia_of_plane(system.bodies, p, poses, velocities)
    update_inverse_mass(system, workspace)


@jit_in_place
def update_inverse_mass(system: System, workspace: SystemWorkspace) -> None:
    """Set the inverse masses of the workspace; a shaft gets the inertia of its plane, unless the system keeps its angle."""
    # A workspace also serves systems with other inverse masses, as for a projection that keeps some coordinates.
    copy_array(workspace.inverse_mass, system.inverse_mass)
    for p in range(system.planes.size):
        shaft = system.planes[p].shaft
        if system.planes[p].has_reaction and system.inverse_mass[shaft, 2] > 0.0:
            own_inertia = system.bodies[shaft].xx + system.bodies[shaft].yy
            workspace.inverse_mass[shaft, 2] = 1.0 / (own_inertia + workspace.plane_motion[p, PlaneColumn.INERTIA])


@jit_in_place
def evaluate_body_forces(
    bodies: RecordArray,  # records of `BODY_DTYPE`; shape (bodies,)
    plane_motion: FloatArray,  # motion of each plane, by `PlaneColumn`; shape (planes, 4)
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    result: FloatArray,  # result: forces along x and y, N, and moments, N m; shape (bodies, 3)
) -> None:
    """Evaluate gravity and centrifugal forces on the bodies, reduced to their origins."""
    for k in range(bodies.size):
        body, angle = bodies[k], poses[k, 2]
        arm_x = arm_y = 0.0
        if body.x != 0.0 or body.y != 0.0:
            arm_x, arm_y = rotate_vector_jit(angle, body.x, body.y)
        force_x = 0.0
        force_y = weight_jit(body.mass, body.gravity)
        moment = 0.0
        if body.plane != NO_INDEX:
            speed = plane_motion[body.plane, PlaneColumn.SPEED]
            speed_squared = speed * speed
            force_x = centrifugal_force_jit(body.mass, poses[k, 0] + arm_x, speed_squared)
            if body.xx != body.yy or body.xy != 0.0:
                moment = centrifugal_moment_jit(body.xx, body.yy, body.xy, angle, speed_squared)
        result[k, 0] = force_x
        result[k, 1] = force_y
        result[k, 2] = moment + arm_x * force_y - arm_y * force_x


@jit_in_place
def inertia_of_plane(
    bodies: RecordArray,  # records of `BODY_DTYPE`; shape (bodies,)
    plane: int,
    poses: FloatArray,  # poses of the body origins, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
) -> tuple[float, float]:
    """Return the moment of inertia (kg m2) of the bodies of a plane about its spindle, and its rate (kg m2/s)."""
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
