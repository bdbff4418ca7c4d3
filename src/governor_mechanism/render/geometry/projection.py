"""A plane that turns with a spindle, seen from the side: slight perspective, outlines of plates and depth. Lengths in m."""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.render.geometry.points import convex_hull
from governor_mechanism.types import FloatArray

EYE_DISTANCE_RATIO = 12.0
"""Distance of the eye from the axis, relative to the reach of the machine: far, for a slight perspective."""


@dataclass(frozen=True, kw_only=True)
class TurnedPlane:
    """A plane through the axis x = 0, turned by an angle and seen by an eye in front of the axis.

    Attributes
    ----------
    angle
        Rotation of the plane, anticlockwise seen from above, rad: what was at the right passes behind the axis first.
    reach
        Largest distance of the machine from the axis, m.
    middle
        Height of the eye, m.
    """

    angle: float
    reach: float
    middle: float

    def depths(self, points: FloatArray, offset: float = 0.0) -> FloatArray:
        """Return how far points (n, 2) are in front of the axis (n,), m; they are `offset` (m) before the plane."""
        depths: FloatArray = -points[:, 0] * math.sin(self.angle) + offset * math.cos(self.angle)
        return depths

    def sizes(self, depths: FloatArray) -> FloatArray:
        """Return how much larger than at the axis things at depths (n,) m appear."""
        sizes: FloatArray = 1.0 / (1.0 - depths / (EYE_DISTANCE_RATIO * self.reach))
        return sizes

    def project(self, points: FloatArray, offset: float = 0.0) -> FloatArray:
        """Return where points (n, 2) at an offset (m) from the plane are seen; shape (n, 2)."""
        size = self.sizes(self.depths(points, offset))
        across = points[:, 0] * math.cos(self.angle) + offset * math.sin(self.angle)
        return np.column_stack([across * size, self.middle + (points[:, 1] - self.middle) * size])

    def project_plate(self, outline: FloatArray, half_thickness: float) -> FloatArray:
        """Return the seen outline (m, 2) of a plate without dents, from its outline (n, 2) and half its thickness."""
        return hull_of(np.concatenate([self.project(outline, -half_thickness), self.project(outline, half_thickness)]))


def hull_of(points: FloatArray) -> FloatArray:
    """Return the corners (m, 2) of the convex hull of points (n, 2), anticlockwise."""
    return np.array(convex_hull([(x, y) for x, y in points.tolist()])).reshape(-1, 2)


def area_of(outline: FloatArray) -> float:
    """Return the area within a closed outline (n, 2), m2."""
    following = np.roll(outline, -1, axis=0)
    return 0.5 * abs(float(np.sum(outline[:, 0] * following[:, 1] - following[:, 0] * outline[:, 1])))
