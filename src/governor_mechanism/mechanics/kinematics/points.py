"""Points of bodies at poses, and their paths."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import GROUND_INDEX, FloatArray

Origins = Mapping[str, tuple[float, float]]
"""Origin of each body by name, in body axes (m); the mass centre if left out."""


def rotate_vector(angle: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the components of the vector (x, y), floats or arrays, rotated by an angle (rad)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def attachment_fields(mechanism: Mechanism, first: Point, second: Point, origins: Origins) -> dict[str, float]:
    """Return the fields of two points in a record: both bodies, and x and y (m) of each relative to its body's origin."""
    fields: dict[str, float] = {"first": mechanism.body_index(first.body), "second": mechanism.body_index(second.body)}
    for number, point in enumerate((first, second), start=1):
        x, y = origins.get(point.body, (0.0, 0.0))
        fields |= {f"x{number}": point.x - x, f"y{number}": point.y - y}
    return fields


def point_path(mechanism: Mechanism, poses: FloatArray, point: Point) -> FloatArray:
    """Return the path (n, 2), m, of a point at poses (n, bodies, 3)."""
    index = mechanism.body_index(point.body)
    pose = poses[:, index] if index != GROUND_INDEX else np.zeros((len(poses), 3))
    path: FloatArray = pose[:, :2] + np.stack(rotate_vector(pose[:, 2], point.x, point.y), axis=-1)
    return path


def point_paths(mechanism: Mechanism, poses: FloatArray) -> dict[str, FloatArray]:
    """Return the path (n, 2), m, of each point that has a name, a moving pin or a mass centre, at poses (n, bodies, 3)."""
    return {name: point_path(mechanism, poses, point) for name, point in mechanism.path_points.items()}
