"""Bodies and the planes that they turn with as records of the compiled kernels, and the inertia of bodies."""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.mechanics.kinematics.points import Origins
from governor_mechanism.model.mechanism import Body, Mechanism, Shaft
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import record_dtype
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray

BODY_DTYPE = record_dtype(
    ("mass", "f8"),  # kg
    ("x", "f8"),  # mass centre from the origin, in body axes, m
    ("y", "f8"),
    ("xx", "f8"),  # second moments about the mass centre, kg m2
    ("yy", "f8"),
    ("xy", "f8"),
    ("zz", "f8"),
    ("gravity", "f8"),  # gravitational acceleration, m/s2
    ("plane", "i8"),  # plane whose centrifugal forces the body carries, or NO_INDEX
)
"""One body."""

PLANE_DTYPE = record_dtype(
    ("shaft", "i8"),  # body that the plane turns with, or NO_INDEX
    ("input_index", "i8"),  # input of its given speed, or NO_INDEX
    ("has_reaction", "i8"),  # whether its bodies act on the shaft
    ("ratio", "f8"),  # its speed relative to the shaft or the input
    ("amplitude", "f8"),  # relative amplitude of a fluctuation of the given speed
    ("cycles_per_turn", "f8"),
)
"""One plane with centrifugal forces."""

STAND_IN_INERTIA_RATIO = 1e-3
"""Stand-in inertia of massless coordinates, relative to the smallest mass and moment of inertia of the mechanism.

`constrained_solution` removes it again by an iteration that converges by about this ratio; a smaller ratio conditions the
joint equations worse.
"""


def make_body_record(
    body: Body,
    gravity: float,  # gravitational acceleration, m/s2
    plane: int,  # index of the plane whose centrifugal forces it carries, or NO_INDEX
    origin: tuple[float, float] = (0.0, 0.0),  # its origin in body axes from the mass centre, m
) -> tuple[float, ...]:
    """Return a body as a record of `BODY_DTYPE`."""
    moments = body.second_moments
    return (body.mass, -origin[0], -origin[1], moments.xx, moments.yy, moments.xy, moments.zz, gravity, plane)


def make_body_records(scene: Scene, origins: Origins) -> RecordArray:
    """Return the bodies as records of `BODY_DTYPE`."""
    loaded_planes = [plane for plane in scene.system.planes if plane.is_loaded]
    plane_of_body = {body: index for index, plane in enumerate(loaded_planes) for body in plane.bodies}
    records = [
        make_body_record(body, gravity, plane_of_body.get(index, NO_INDEX), origins[body.name])
        for index, (body, gravity) in enumerate(zip(scene.mechanism.bodies, scene.system.gravity, strict=True))
    ]
    return np.array(records, dtype=BODY_DTYPE)


def make_plane_records(scene: Scene, speeds: Sequence[Spindle]) -> RecordArray:
    """Return the planes with centrifugal forces as records of `PLANE_DTYPE`; `speeds` are the inputs of given speeds."""
    records = []
    for plane in scene.system.planes:
        if plane.is_loaded and plane.given_speed:
            given = plane.given_speed
            records.append((NO_INDEX, speeds.index(given), 0, plane.ratio, 0.5 * given.speed_fluctuation, given.cycles_per_turn))
        elif plane.is_loaded:
            records.append((scene.mechanism.body_index(plane.shaft), NO_INDEX, plane.has_reaction, plane.ratio, 0.0, 1.0))
    return np.array(records, dtype=PLANE_DTYPE)


def make_inertia(mechanism: Mechanism, origins: Origins) -> tuple[FloatArray, FloatArray]:
    """Return mass (twice) and moment of inertia about the origin of each body, and the stand-ins for those that are 0; (bodies, 3).

    Coordinates that cannot change have neither. The moment of inertia of a shaft follows with the poses.
    """
    rows = []
    for body in mechanism.bodies:
        moment = 1.0 if isinstance(body, Shaft) else body.planar_inertia + body.mass * math.hypot(*origins[body.name]) ** 2
        rows.append([body.mass, body.mass, moment])
    moves = np.array([body.moves for body in mechanism.bodies]).reshape(-1, 3)
    inertia = np.where(moves, np.array(rows).reshape(-1, 3), 0.0)
    masses, moments = inertia[:, 0][inertia[:, 0] > 0], inertia[:, 2][inertia[:, 2] > 0]
    mass = float(np.min(masses)) if masses.size else 1.0
    moment = float(np.min(moments, initial=mass * mechanism.length_scale**2))
    return inertia, np.where(moves & (inertia == 0), STAND_IN_INERTIA_RATIO * np.array([mass, mass, moment]), 0.0)
