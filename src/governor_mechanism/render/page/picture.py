"""The picture of a page: coordinates with x to the right and y down, in 1/10 000 of its larger side."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.render.geometry.primitives import BoundingBox, Vec2
from governor_mechanism.types import FloatArray

PICTURE_SIZE = 10_000
"""Length of the larger side of a picture: all positions are rounded to one unit, less than a tenth of a pixel on most screens."""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """Map from the plane of a drawing (m) to a picture that shows a box (m)."""

    box: BoundingBox

    @property
    def scale(self) -> float:
        """Units of the picture per metre."""
        left, right, bottom, top = self.box
        return PICTURE_SIZE / max(right - left, top - bottom)

    @property
    def size(self) -> Vec2:
        """Width and height of the picture."""
        left, right, bottom, top = self.box
        return (right - left) * self.scale, (top - bottom) * self.scale

    def place(self, points: FloatArray) -> FloatArray:
        """Return the positions in the picture of points (..., 2) m."""
        left, _, _, top = self.box
        return np.stack([(points[..., 0] - left) * self.scale, (top - points[..., 1]) * self.scale], axis=-1)

    def place_poses(self, poses: FloatArray) -> FloatArray:
        """Return poses (..., 3) m and rad in the picture; angles become clockwise, as y points down."""
        return np.concatenate([self.place(poses[..., :2]), -poses[..., 2:]], axis=-1)

    def enlarge(self, points: FloatArray) -> FloatArray:
        """Return points (..., 2) m of axes of their own in such axes of the picture."""
        return points * (self.scale, -self.scale)
