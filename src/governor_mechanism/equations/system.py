"""A scene as arrays for the compiled kernels: bodies, rows, loads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from governor_mechanism.equations.constraints import joint_table
from governor_mechanism.equations.points import Array, Whole
from governor_mechanism.equations.schur import narrow_order, neighbours
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.joints import GROUND, Pin
from governor_mechanism.mechanism import Body, Mechanism
from governor_mechanism.scene import Scene


class System(NamedTuple):
    """Rows and pairs as in `rows` and `schur`; per body mass, inverse_mass (bodies, 3), centre (bodies, 2), moments.

    Coordinates are counted from a body's origin, its mass centre but for a lever: centre is where the mass centre is
    from there, in body axes. moments (bodies, 4): second moments xx, yy, xy, zz about the mass centre.
    """

    kind: Whole
    body: Whole
    anchor: Array
    parameter: Array
    pairs: Whole
    width: int
    mass: Array
    inverse_mass: Array
    centre: Array
    moments: Array
    gravity: float
    centrifugal: bool


class Workspace(NamedTuple):
    """Room for one evaluation, so that none is allocated in the loop."""

    opening: Array
    gradient: Array
    bend: Array
    band: Array
    factor: Array
    vector: Array


def make_system(scene: Scene) -> System:
    """The arrays of a scene of one part. Raises UnsupportedEffect for a body that has no inertia of its own to turn."""
    mechanism = scene.part.mechanism
    origins = {body.name: lever_origin(mechanism, body) for body in mechanism.bodies}
    table = joint_table(mechanism, origins)
    order = narrow_order(table.body)
    body = table.body[order]
    pairs = neighbours(body)
    width = int(np.max(pairs[:, 0] - pairs[:, 1], initial=0))
    inertia = [_inertia(body, origins[body.name]) for body in mechanism.bodies]
    inverse = [
        [1 / body.mass, 1 / body.mass, 1 / moment if body.turns else 0.0]
        for body, moment in zip(mechanism.bodies, inertia, strict=True)
    ]
    return System(
        kind=table.kind[order],
        body=body,
        anchor=table.anchor[order],
        parameter=table.parameter[order],
        pairs=pairs,
        width=width,
        mass=np.array([body.mass for body in mechanism.bodies]),
        inverse_mass=np.array(inverse),
        centre=-np.array([origins[body.name] for body in mechanism.bodies]),
        moments=np.array([[m.xx, m.yy, m.xy, m.zz] for m in (body.moments for body in mechanism.bodies)]),
        gravity=scene.gravity,
        centrifugal=scene.centrifugal,
    )


def make_workspace(system: System) -> Workspace:
    """Room for evaluations of this system."""
    rows = len(system.kind)
    band = (rows, system.width + 1)
    return Workspace(
        np.zeros(rows), np.zeros((rows, 2, 3)), np.zeros(rows), np.zeros(band), np.zeros(band), np.zeros(rows)
    )


def to_centres(system: System, poses: Array, velocities: Array) -> tuple[Array, Array]:
    """Poses and velocities (..., bodies, 3) of mass centres from those of the origins."""
    return _moved(system.centre, poses, velocities)


def from_centres(system: System, poses: Array, velocities: Array) -> tuple[Array, Array]:
    """Poses and velocities (..., bodies, 3) of the origins from those of mass centres."""
    return _moved(-system.centre, poses, velocities)


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
    """From where a body's coordinates are counted, in its own axes (m): the pin of a lever, else the mass centre.

    A lever is a body whose mass is in one point and that a pin holds to the ground: about that pin it has inertia. The
    pin stands still, so the mass's coupling between turning and moving never acts.
    """
    if not body.turns or body.moments.xx + body.moments.yy > 0:
        return (0.0, 0.0)
    for joint in mechanism.joints:
        ends = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(ends) == {GROUND, body.name}:
            return (ends[body.name].x, ends[body.name].y)
    raise UnsupportedEffect(
        f"body {body.name!r} cannot turn: its mass is in one point, and no pin joins it to ground; "
        "give it second moments, or turns=False"
    )


def _inertia(body: Body, origin: tuple[float, float]) -> float:
    return body.moments.xx + body.moments.yy + body.mass * (origin[0] ** 2 + origin[1] ** 2)
