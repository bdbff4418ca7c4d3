"""Points fixed in bodies: positions, gradients, velocities and accelerations."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

Origins = Mapping[str, tuple[float, float]]
"""Origin of each body by name, in body axes (m); the mass centre if left out."""


def rotate_vector(angle: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the components of the vector (x, y), floats or arrays, rotated by an angle (rad)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


@dataclass(frozen=True)
class BodyPoint:
    """A point fixed in a body.

    Attributes
    ----------
    body
        Index of the body in the pose array; -1 for the ground.
    x
        Coordinate in body axes, m.
    y
        Coordinate in body axes, m.
    """

    body: int
    x: float
    y: float

    def position(self, poses: FloatArray) -> FloatArray:
        """Return the position (m), shape (..., 2), for poses of shape (..., bodies, 3)."""
        if self.body < 0:
            return np.broadcast_to(np.array([self.x, self.y]), (*poses.shape[:-2], 2))
        pose = poses[..., self.body, :]
        return pose[..., :2] + self._global_arm(pose)

    def gradient_along(self, poses: FloatArray, direction: FloatArray) -> FloatArray:
        """Return the gradient of direction * position for a constant direction (..., 2); shape (..., bodies, 3)."""
        gradient = np.zeros((*direction.shape[:-1], *poses.shape[-2:]))
        if self.body >= 0:
            arm = self._global_arm(poses[..., self.body, :])
            gradient[..., self.body, :2] = direction
            gradient[..., self.body, 2] = direction[..., 1] * arm[..., 0] - direction[..., 0] * arm[..., 1]
        return gradient

    def velocity(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the velocity (m/s), shape (..., 2), for poses and velocities of shape (..., bodies, 3)."""
        if self.body < 0:
            return np.zeros((*poses.shape[:-2], 2))
        arm, body_velocity = self._global_arm(poses[..., self.body, :]), velocities[..., self.body, :]
        perpendicular_arm = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        return body_velocity[..., :2] + body_velocity[..., 2:] * perpendicular_arm

    def centripetal_acceleration(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the centripetal part of the acceleration (m/s2), which the rotation of the body causes; shape (..., 2)."""
        if self.body < 0:
            return np.zeros((*poses.shape[:-2], 2))
        return -(velocities[..., self.body, 2:] ** 2) * self._global_arm(poses[..., self.body, :])

    def rotate_to_global(self, poses: FloatArray, direction: FloatArray) -> FloatArray:
        """Return a direction (2,) given in body axes in global axes; shape (..., 2)."""
        if self.body < 0:
            return np.broadcast_to(direction, (*poses.shape[:-2], 2))
        return BodyPoint(self.body, float(direction[0]), float(direction[1]))._global_arm(poses[..., self.body, :])

    def _global_arm(self, pose: FloatArray) -> FloatArray:
        """Return the vector (m) from the body origin to the point in global axes; shape (..., 2)."""
        return np.stack(rotate_vector(pose[..., 2], self.x, self.y), axis=-1)


def attachment_fields(mechanism: Mechanism, first: Point, second: Point, origins: Origins) -> tuple[float, ...]:
    """Return the fields of two points in a record: both bodies, then x and y (m) of each relative to its body's origin."""
    bodies = [mechanism.body_index(point.body) for point in (first, second)]
    coordinates = []
    for point in (first, second):
        x, y = origins.get(point.body, (0.0, 0.0))
        coordinates += [point.x - x, point.y - y]
    return (*bodies, *coordinates)


def body_point(mechanism: Mechanism, point: Point) -> BodyPoint:
    """Return a point with the index of its body.

    Parameters
    ----------
    mechanism
        Mechanism with its bodies.
    point
        Point given by the name of its body and coordinates in body axes.

    Returns
    -------
    BodyPoint
        The point.
    """
    return BodyPoint(mechanism.body_index(point.body), point.x, point.y)
