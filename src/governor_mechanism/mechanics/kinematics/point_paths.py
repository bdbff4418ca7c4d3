"""Paths of the points of a mechanism."""

import numpy as np

from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import GROUND_INDEX, FloatArray


def point_path(mechanism: Mechanism, poses: FloatArray, point: Point) -> FloatArray:
    """Return the path (n, 2), m, of a point at poses (n, bodies, 3)."""
    index = mechanism.body_index(point.body)
    pose = poses[:, index] if index != GROUND_INDEX else np.zeros((len(poses), 3))
    path: FloatArray = pose[:, :2] + np.stack(rotate_vector(pose[:, 2], point.x, point.y), axis=-1)
    return path


def point_paths(mechanism: Mechanism, poses: FloatArray) -> dict[str, FloatArray]:
    """Return the path (n, 2), m, of each point that has a name, a moving pin or a mass centre, at poses (n, bodies, 3)."""
    return {name: point_path(mechanism, poses, point) for name, point in mechanism.path_points.items()}
