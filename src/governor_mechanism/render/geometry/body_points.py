"""Positions of body-fixed points at one pose or over a run."""

import math
from collections.abc import Iterable

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.render.geometry.primitives import PoseTuple, Vec2
from governor_mechanism.types import FloatArray


def as_pose_tuples(pose: FloatArray) -> list[PoseTuple]:
    """Return the rows of an array (bodies, 3) as tuples."""
    return [(float(x), float(y), float(angle)) for x, y, angle in pose]


def axes_to_plane(axes: PoseTuple, x: float, y: float) -> Vec2:
    """Return the position in the plane of a point (x, y) (m) given in axes."""
    c, s = math.cos(axes[2]), math.sin(axes[2])
    return axes[0] + c * x - s * y, axes[1] + s * x + c * y


def point_path(mechanism: Mechanism, poses: FloatArray, point: Point) -> FloatArray:
    """Return the path (n, 2) m of a point over a run with poses (n, bodies, 3)."""
    x, y, angles = _pose_columns(mechanism, poses, point.body)
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([x + c * point.x - s * point.y, y + s * point.x + c * point.y], axis=-1)


def separation_path(mechanism: Mechanism, poses: FloatArray, first: Point, second: Point) -> FloatArray:
    """Return the position (n, 2) m of a point relative to another one over a run."""
    return point_path(mechanism, poses, second) - point_path(mechanism, poses, first)


def value_range(values: FloatArray) -> Vec2:
    """Return the smallest and the largest value."""
    return float(values.min()), float(values.max())


def point_path_in_axes(mechanism: Mechanism, poses: FloatArray, origin: Point, axes_angle: float, point: Point) -> FloatArray:
    """Return the path (n, 2) m of a point in axes with their origin at another point, rotated by `axes_angle` (rad) from its body's."""
    x, y = separation_path(mechanism, poses, origin, point).T
    angles = _pose_columns(mechanism, poses, origin.body)[2] + axes_angle
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def _pose_columns(mechanism: Mechanism, poses: FloatArray, body: str) -> FloatArray:
    """Return x, y and angle of a body over a run, (3, n)."""
    index = mechanism.body_index(body)
    columns: FloatArray = np.zeros((3, len(poses))) if index < 0 else np.moveaxis(poses[:, index, :], -1, 0)
    return columns


def distinct_points(points: Iterable[Vec2], min_distance: float) -> list[Vec2]:
    """Return the points in order, without those closer than `min_distance` (m) to an earlier one."""
    kept: list[Vec2] = []
    for point in points:
        if all(math.dist(point, other) >= min_distance for other in kept):
            kept.append(point)
    return kept
