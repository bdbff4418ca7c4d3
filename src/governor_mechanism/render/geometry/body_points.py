"""Where the points marked on a mechanism's bodies stand, at one pose or over a run."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from governor_mechanism.model.joints import GROUND, Joint, Pin, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.render.geometry.primitives import Pair, Pose, place
from governor_mechanism.types import FloatArray

STILL: Pose = (0.0, 0.0, 0.0)


def poses_of(pose: FloatArray) -> list[Pose]:
    """The rows of an array (bodies, 3)."""
    return [(float(x), float(y), float(angle)) for x, y, angle in pose]


def pose_of(mechanism: Mechanism, poses: Sequence[Pose], body: str) -> Pose:
    """The pose of a body; the ground's is zero."""
    index = mechanism.body_index(body)
    return STILL if index < 0 else poses[index]


def where(mechanism: Mechanism, poses: Sequence[Pose], point: Point) -> Pair:
    """Where a point stands (m)."""
    return place(pose_of(mechanism, poses, point.body), point)


def axes_at(mechanism: Mechanism, poses: Sequence[Pose], origin: Point, angle: float) -> Pose:
    """Axes with their origin in a point, turned by `angle` (rad) from those of its body."""
    return *where(mechanism, poses, origin), pose_of(mechanism, poses, origin.body)[2] + angle


def put(axes: Pose, x: float, y: float) -> Pair:
    """Where (x, y) (m) of these axes stands in the plane."""
    c, s = math.cos(axes[2]), math.sin(axes[2])
    return axes[0] + c * x - s * y, axes[1] + s * x + c * y


def track(mechanism: Mechanism, poses: FloatArray, point: Point) -> FloatArray:
    """Where a point stands over a run with poses (n, bodies, 3): (n, 2) m."""
    x, y, turn = _columns(mechanism, poses, point.body)
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([x + c * point.x - s * point.y, y + s * point.x + c * point.y], axis=-1)


def seen_from(mechanism: Mechanism, poses: FloatArray, origin: Point, angle: float, point: Point) -> FloatArray:
    """A point's coordinates (n, 2) m in axes with their origin in another, turned by `angle` from its body's."""
    apart = track(mechanism, poses, point) - track(mechanism, poses, origin)
    turn = _columns(mechanism, poses, origin.body)[2] + angle
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([c * apart[:, 0] + s * apart[:, 1], c * apart[:, 1] - s * apart[:, 0]], axis=-1)


def _columns(mechanism: Mechanism, poses: FloatArray, body: str) -> FloatArray:
    index = mechanism.body_index(body)
    columns: FloatArray = np.zeros((3, len(poses))) if index < 0 else np.moveaxis(poses[:, index, :], -1, 0)
    return columns


def distinct(points: Iterable[Pair], apart: float) -> list[Pair]:
    """The points in their order, without those closer than `apart` (m) to one before."""
    found: list[Pair] = []
    for point in points:
        if all(math.dist(point, other) >= apart for other in found):
            found.append(point)
    return found


def hinge(mechanism: Mechanism, first: str, second: str, otherwise: Point | None = None) -> Point:
    """Where one body turns against another: their pin; else the point given, or the second body's mass centre."""
    pins: list[Joint] = [joint for joint in mechanism.joints if isinstance(joint, Pin)]
    for joint in pins:
        if {joint.first.body, joint.second.body} == {first, second}:
            return joint.second
    return otherwise or Point(body=first if second == GROUND else second)
