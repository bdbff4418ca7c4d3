"""Guess of the poses of bodies that hang together: from the ground outwards, each body is put where its joint is."""

import math
from collections.abc import Collection, Mapping

import numpy as np

from governor_mechanism.machines.base import rotate_point
from governor_mechanism.machines.custom import MechanismSketch
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    Joint,
    Pin,
    Point,
    Prismatic,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.types import FloatArray

_Pose = tuple[float, float, float]


def chain_bodies(
    sketch: MechanismSketch,
    angles: Mapping[str, float],  # angles of the bodies that rotate, rad
    placed: Collection[str],
    # for each body, its position along a slot or its direction from the centre of an arc or link, from -1 to
    # 1; shape (bodies,)
    offsets: FloatArray,
) -> FloatArray:
    """Return guessed poses of the mass centres.

    Result: poses, m and rad; shape (bodies, 3). A loop of joints is open at one of them.
    """
    scale = sketch.length_scale
    poses: dict[str, _Pose] = {GROUND: (0.0, 0.0, 0.0)}
    offset_of = {body.name: float(offset) for body, offset in zip(sketch.bodies, offsets, strict=True)}
    for body in sketch.bodies:
        if body.name in placed:
            x, y = rotate_point(*body.shape.element.centre, angles.get(body.name, 0.0))
            poses[body.name] = body.origin[0] + x, body.origin[1] + y, angles.get(body.name, 0.0)
    while len(poses) <= len(sketch.bodies):
        joint = _next_joint(sketch, poses)
        if joint is None:  # nothing that is placed holds the others
            name = next(body.name for body in sketch.bodies if body.name not in poses)
            poses[name] = 0.0, 0.0, angles.get(name, 0.0)
            continue
        is_first = joint.first.body in poses
        known, own = (joint.first, joint.second) if is_first else (joint.second, joint.first)
        angle = _angle_of(joint, poses, angles, is_first)
        x, y = _position(poses[known.body], known)
        shift_x, shift_y = _shift(joint, poses[known.body][2] if is_first else angle, offset_of[own.body], scale)
        sign = 1.0 if is_first else -1.0
        point_x, point_y = rotate_point(own.x, own.y, angle)
        poses[own.body] = x + sign * shift_x - point_x, y + sign * shift_y - point_y, angle
    return np.array([poses[body.name] for body in sketch.bodies])


def _next_joint(sketch: MechanismSketch, poses: Mapping[str, _Pose]) -> Joint | None:
    """Return a joint of a placed body and one that is not; joints that leave no choice of the position come first."""
    borders = [joint for joint in sketch.joints if (joint.first.body in poses) != (joint.second.body in poses)]
    located = [joint for joint in borders if isinstance(joint, Pin | Weld | Slider | CurveSlot | ArcSlot | Distance | TranslationalDriver)]
    return min(located, key=lambda joint: not isinstance(joint, Pin | Weld), default=None)


def _angle_of(joint: Joint, poses: Mapping[str, _Pose], angles: Mapping[str, float], is_first: bool) -> float:
    """Return the angle of the body that a joint places: that of the other body if they do not rotate against each other."""
    name, other = (joint.second.body, joint.first.body) if is_first else (joint.first.body, joint.second.body)
    if not isinstance(joint, Weld | Prismatic) or name not in angles:
        return angles.get(name, 0.0)
    return poses[other][2] + (joint.relative_angle if is_first else -joint.relative_angle)


def _position(pose: _Pose, point: Point) -> tuple[float, float]:
    x, y = rotate_point(point.x, point.y, pose[2])
    return pose[0] + x, pose[1] + y


def _shift(joint: Joint, first_angle: float, offset: float, scale: float) -> tuple[float, float]:
    """Return the vector from the first to the second point of a joint, m."""
    if isinstance(joint, Pin | Weld):
        return 0.0, 0.0
    if isinstance(joint, Distance | ArcSlot):
        length = joint.length if isinstance(joint, Distance) else joint.radius
        return rotate_point(length, 0.0, math.pi * (offset - 0.5))
    direction = joint.angle if isinstance(joint, Slider | CurveSlot | TranslationalDriver) else 0.0
    return rotate_point(offset * scale, 0.0, first_angle + direction)
