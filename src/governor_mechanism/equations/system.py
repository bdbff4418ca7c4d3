"""A scene as arrays for the compiled kernels: bodies, rows, loads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from governor_mechanism.equations.applied import load_table
from governor_mechanism.equations.constraints import joint_table
from governor_mechanism.equations.points import Array, Records, Whole
from governor_mechanism.equations.rows import Rows
from governor_mechanism.equations.schur import narrow_order, neighbours
from governor_mechanism.equations.timing import TimeCurve
from governor_mechanism.errors import MechanismError
from governor_mechanism.joints import GROUND, Pin
from governor_mechanism.mechanism import Body, Mechanism
from governor_mechanism.programs import Motion, Program
from governor_mechanism.scene import TURNING, FreeSpindle, Scene

BODY = np.dtype([(name, "f8") for name in ("mass", "x", "y", "xx", "yy", "xy", "zz")])
"""One body: mass; where the mass centre is from the origin, in body axes; second moments about the mass centre."""


class System(NamedTuple):
    """Rows, loads and pairs as in `rows`, `applied` and `schur`; bodies (bodies,) of BODY, inverse_mass (bodies, 3).

    Coordinates are counted from a body's origin, its mass centre but for a lever. A free spindle has spindle_inertia
    (kg m2) of its own.
    """

    rows: Rows
    loads: Records
    pairs: Whole
    width: int
    bodies: Records
    inverse_mass: Array
    gravity: float
    centrifugal: bool
    free: bool
    spindle_inertia: float


class Workspace(NamedTuple):
    """Room for one evaluation, so that none is allocated in the loop."""

    line: Array
    gradient: Array
    band: Array
    factor: Array
    vector: Array
    load: Array


def make_system(scene: Scene) -> tuple[System, tuple[TimeCurve, ...]]:
    """The arrays of a scene of one part, and its programs: the spindle's speed or torque, the drives', the loads'.

    Raises MechanismError for a body that has no inertia of its own to turn.
    """
    mechanism, spindle = scene.part.mechanism, scene.spindle
    origins = {body.name: lever_origin(mechanism, body) for body in mechanism.bodies}
    table = joint_table(mechanism, origins)
    order = narrow_order(table.rows.ends)
    rows = Rows(table.rows.table[order], table.rows.ends[order], table.rows.pieces)
    rows.table["drive"] += rows.table["drive"] >= 0  # program 0 is the spindle's
    pairs = neighbours(rows.ends)
    loads, programs = load_table(mechanism, origins, 1 + len(table.motions))
    inertia = [_inertia(body, origins[body.name]) for body in mechanism.bodies]
    inverse = [
        [1 / body.mass, 1 / body.mass, 1 / moment if body.turns else 0.0]
        for body, moment in zip(mechanism.bodies, inertia, strict=True)
    ]
    free = spindle if isinstance(spindle, FreeSpindle) else None
    system = System(
        rows=rows,
        loads=loads,
        pairs=pairs,
        width=int(np.max(pairs[:, 0] - pairs[:, 1], initial=0)),
        bodies=np.array([_record(body, origins[body.name]) for body in mechanism.bodies], dtype=BODY),
        inverse_mass=np.array(inverse),
        gravity=scene.gravity,
        centrifugal=scene.centrifugal and scene.part.plane == TURNING,
        free=free is not None,
        spindle_inertia=free.inertia if free else 0.0,
    )
    timed: list[Program | Motion] = [spindle.torque if isinstance(spindle, FreeSpindle) else spindle.program]
    timed += [*table.motions, *programs]
    return system, tuple(map(TimeCurve, timed))


def row_owners(mechanism: Mechanism) -> Whole:
    """(rows,) the joint that each row of a scene's system belongs to."""
    table = joint_table(mechanism)
    return table.owner[narrow_order(table.rows.ends)]


def make_workspace(system: System) -> Workspace:
    """Room for evaluations of this system."""
    rows, bodies = len(system.rows.table), len(system.bodies)
    band = (rows, system.width + 1)
    return Workspace(
        line=np.zeros((rows, 5)),
        gradient=np.zeros((rows, 2, 3)),
        band=np.zeros(band),
        factor=np.zeros(band),
        vector=np.zeros(rows),
        load=np.zeros((bodies, 3)),
    )


def to_centres(system: System, poses: Array, velocities: Array) -> tuple[Array, Array]:
    """Poses and velocities (..., bodies, 3) of mass centres from those of the origins."""
    return _moved(_centre(system), poses, velocities)


def from_centres(system: System, poses: Array, velocities: Array) -> tuple[Array, Array]:
    """Poses and velocities (..., bodies, 3) of the origins from those of mass centres."""
    return _moved(-_centre(system), poses, velocities)


def _moved(by: Array, poses: Array, velocities: Array) -> tuple[Array, Array]:
    poses, velocities = poses.copy(), velocities.copy()
    cosine, sine = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    arm_x, arm_y = cosine * by[:, 0] - sine * by[:, 1], sine * by[:, 0] + cosine * by[:, 1]
    poses[..., 0] += arm_x
    poses[..., 1] += arm_y
    velocities[..., 0] -= arm_y * velocities[..., 2]
    velocities[..., 1] += arm_x * velocities[..., 2]
    return poses, velocities


def lever_origin(mechanism: Mechanism, body: Body) -> tuple[float, float]:
    """From where a body's coordinates are counted, in its own axes (m): the pin of a lever, else the mass centre."""
    pin = lever_pin(mechanism, body)
    if pin is None:
        return (0.0, 0.0)
    own = pin.first if pin.first.body == body.name else pin.second
    return own.x, own.y


def lever_pin(mechanism: Mechanism, body: Body) -> Pin | None:
    """The pin of a lever; None for other bodies. Raises MechanismError for a body that has no inertia to turn with.

    A lever is a body whose mass is in one point and that a pin holds to the ground: about that pin it has inertia. The
    pin stands still, so the mass's coupling between turning and moving never acts on the motion.
    """
    if not body.turns or body.moments.xx + body.moments.yy > 0:
        return None
    for joint in mechanism.joints:
        ends = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(ends) == {GROUND, body.name}:
            own = ends[body.name]
            if own.x != 0.0 or own.y != 0.0:
                return joint
    raise MechanismError(
        f"body {body.name!r} cannot turn: its mass is in one point, and no pin beside that point joins it to ground; "
        "give it second moments, or turns=False"
    )


def _centre(system: System) -> Array:
    """(bodies, 2) m: where mass centres are from the origins, in body axes."""
    return np.stack([system.bodies["x"], system.bodies["y"]], axis=-1)


def _record(body: Body, origin: tuple[float, float]) -> tuple[float, ...]:
    moments = body.moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz)


def _inertia(body: Body, origin: tuple[float, float]) -> float:
    return body.moments.xx + body.moments.yy + body.mass * (origin[0] ** 2 + origin[1] ** 2)
