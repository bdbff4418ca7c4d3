"""The straight line along which a reading of a mechanism measures the position of a point."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import PointCoordinate, PointDistance
from governor_mechanism.render.geometry.points import point_path
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray

_STRAIGHTNESS_TOLERANCE = 1e-5
"""Largest distance of a point from its line, relative to its travel: a loose assembly leaves 1e-6, what is not straight shows far more."""


@dataclass(frozen=True, kw_only=True)
class StraightMotion:
    """A point that moves along a line, and the reading that measures it.

    Attributes
    ----------
    point
        The point.
    start, start_value
        A place on the line, m, and the reading there, m.
    direction
        Unit vector along the line, in which the reading grows.
    """

    point: Point
    start: Vec2
    start_value: float
    direction: Vec2

    def place_at(self, value: float) -> Vec2:
        """Return the place (m) of the point where the reading has a value (m)."""
        along = value - self.start_value
        return self.start[0] + along * self.direction[0], self.start[1] + along * self.direction[1]


def find_straight_motion(mechanism: Mechanism, name: str, values: FloatArray, poses: FloatArray) -> StraightMotion | None:
    """Return the line of a reading with values (n,) m at poses (n, bodies, 3); None if its point stands still, or leaves a line."""
    match mechanism.reading(name):
        case PointCoordinate(point=point):
            pass
        case PointDistance(first=first, second=second) if GROUND in (first.body, second.body):
            point = second if first.body == GROUND else first
        case _:
            return None
    path = point_path(mechanism, poses, point)
    low, high = int(np.argmin(values)), int(np.argmax(values))
    travel = float(values[high] - values[low])
    if not travel > 0.0:
        return None
    direction = (path[high] - path[low]) / travel
    deviation = path - path[low] - np.multiply.outer(values - values[low], direction)
    # A direction whose length is not 1 is that of a reading that measures only a component of the motion.
    if max(float(np.abs(deviation).max()) / travel, abs(float(np.hypot(*direction)) - 1.0)) > _STRAIGHTNESS_TOLERANCE:
        return None
    (x, y), (dx, dy) = path[low].tolist(), direction.tolist()
    return StraightMotion(point=point, start=(x, y), start_value=float(values[low]), direction=(dx, dy))
