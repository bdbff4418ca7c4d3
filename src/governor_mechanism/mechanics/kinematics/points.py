"""Where marked points are, and how they move with the poses of their bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class Placed:
    """A point with the index of its body in the pose array; -1 for the ground."""

    body: int
    x: float
    y: float

    def position(self, poses: FloatArray) -> FloatArray:
        """(..., 2) m, from poses (..., bodies, 3)."""
        if self.body < 0:
            return np.broadcast_to(np.array([self.x, self.y]), (*poses.shape[:-2], 2))
        pose = poses[..., self.body, :]
        return pose[..., :2] + self._arm(pose)

    def pull_back(self, poses: FloatArray, direction: FloatArray) -> FloatArray:
        """Gradient (..., bodies, 3) of direction . position, for a direction (..., 2) held fixed."""
        gradient = np.zeros((*direction.shape[:-1], *poses.shape[-2:]))
        if self.body >= 0:
            arm = self._arm(poses[..., self.body, :])
            gradient[..., self.body, :2] = direction
            gradient[..., self.body, 2] = direction[..., 1] * arm[..., 0] - direction[..., 0] * arm[..., 1]
        return gradient

    def velocity(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """(..., 2) m/s, from poses and velocities (..., bodies, 3)."""
        if self.body < 0:
            return np.zeros((*poses.shape[:-2], 2))
        arm, motion = self._arm(poses[..., self.body, :]), velocities[..., self.body, :]
        across = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        return motion[..., :2] + motion[..., 2:] * across

    def inward(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """(..., 2) m/s2: the part of the point's acceleration that the turning of its body alone makes."""
        if self.body < 0:
            return np.zeros((*poses.shape[:-2], 2))
        return -(velocities[..., self.body, 2:] ** 2) * self._arm(poses[..., self.body, :])

    def turned(self, poses: FloatArray, direction: FloatArray) -> FloatArray:
        """A direction (2,) in the body's axes as one (..., 2) of the plane."""
        if self.body < 0:
            return np.broadcast_to(direction, (*poses.shape[:-2], 2))
        return Placed(self.body, float(direction[0]), float(direction[1]))._arm(poses[..., self.body, :])

    def _arm(self, pose: FloatArray) -> FloatArray:
        cosine, sine = np.cos(pose[..., 2]), np.sin(pose[..., 2])
        return np.stack([cosine * self.x - sine * self.y, sine * self.x + cosine * self.y], axis=-1)


def place(mechanism: Mechanism, point: Point) -> Placed:
    """Look up the body of a point."""
    return Placed(mechanism.body_index(point.body), point.x, point.y)
