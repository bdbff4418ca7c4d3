"""Geometry of a link gear: points of the link, and the positions of the link at crank angles.

Coordinates are those of the valve line: x away from the shaft, y up; the crank turns clockwise in them. The link has axes with their
origin in the middle of its arc, x away from the shaft. The arc is concave to the shaft.
"""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.types import FloatArray, Vector2

MAX_NEWTON_STEPS = 40
"""Newton's method needs about five steps from the position of the link with both eccentrics at the shaft."""

CLOSURE_TOLERANCE = 1e-13
"""Largest error of the three rods of a closed link, relative to the length of the eccentric rods: a hundred times rounding."""

MAX_STEP_RATIO = 0.2
"""Largest displacement of the link in a Newton step, relative to the eccentric rods, and largest rotation, rad."""


@dataclass(frozen=True, kw_only=True)
class LinkGeometry:
    """The parts of a link gear that determine the position of the link, lengths in m.

    Attributes
    ----------
    eccentric
        Eccentricity.
    eccentric_rod
        Length of both eccentric rods.
    advance
        Angle of advance of both eccentrics, rad.
    link_radius
        Radius of the link's arc.
    half_link
        Half the distance of the rod pins.
    pin_setback
        Distance of the rod pins behind the arc, toward the shaft.
    suspension
        Point of the link from which it hangs, in the axes of the link.
    hanger
        Length of the hanger.
    crossed
        Whether the forward eccentric drives the lower pin.
    """

    eccentric: float
    eccentric_rod: float
    advance: float
    link_radius: float
    half_link: float
    pin_setback: float
    suspension: Vector2
    hanger: float
    crossed: bool

    @property
    def half_arc(self) -> float:
        """Half the length of the arc between the rod pins, or the points of the arc in front of them, m."""
        return self.link_radius * math.asin(self.half_link / self.link_radius)

    @property
    def pins(self) -> tuple[Vector2, Vector2]:
        """Upper and lower rod pin in the axes of the link, m."""
        x = -arc_depth(self.link_radius, self.half_link) - self.pin_setback
        return (x, self.half_link), (x, -self.half_link)

    @property
    def middle_distance(self) -> float:
        """Distance of the arc's middle from the shaft with both eccentrics at the shaft and the link upright, m."""
        return math.sqrt(self.eccentric_rod**2 - self.half_link**2) - self.pins[0][0]

    def nominal_offset(self, reverser: float) -> float:
        """Return the position of the die along the arc with both eccentrics at the shaft, m; in full forward gear at the forward pin."""
        return -reverser * self.half_arc if self.crossed else reverser * self.half_arc

    def hanger_top(self, reverser: float) -> Vector2:
        """Return the fixed end of the hanger at a position of the reversing lever, m."""
        x, y = self.suspension
        return self.middle_distance + x, y - self.nominal_offset(reverser) + self.hanger

    def eccentrics(self, crank_angles: FloatArray) -> FloatArray:
        """Return the centres of the eccentrics of the upper and the lower pin at crank angles (n,) rad; shape (n, 2, 2), m."""
        forward, backward = crank_angles + self.advance, crank_angles - self.advance + math.pi
        pair = [np.stack([np.sin(angle), np.cos(angle)], axis=-1) for angle in (forward, backward)]
        return self.eccentric * np.stack(pair[::-1] if self.crossed else pair, axis=1)

    def locate_die(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distance of the die from the shaft and its position along the arc from the middle, m, at poses (n, 3) of the link.

        They are nan where the arc's circle does not meet the valve line.
        """
        x, y, angle = poses.T
        centre_x, centre_y = x - self.link_radius * np.cos(angle), y - self.link_radius * np.sin(angle)
        with np.errstate(invalid="ignore"):
            extent = np.sqrt(self.link_radius**2 - centre_y**2)
        return centre_x + extent, self.link_radius * (np.arctan2(-centre_y, extent) - angle)

    def solve_poses(self, crank_angles: FloatArray, reverser: float) -> FloatArray:
        """Return the poses (n, 3) of the link (m, m, rad) at crank angles (n,) rad; nan where it cannot be assembled.

        Every pose continues that with both eccentrics at the shaft.
        """
        anchors = np.concatenate([self.eccentrics(crank_angles), np.tile(self.hanger_top(reverser), (len(crank_angles), 1, 1))], axis=1)
        points, lengths = np.array([*self.pins, self.suspension]), np.array([self.eccentric_rod, self.eccentric_rod, self.hanger])
        poses = np.tile([self.middle_distance, -self.nominal_offset(reverser), 0.0], (len(crank_angles), 1))
        max_steps = MAX_STEP_RATIO * np.array([self.eccentric_rod, self.eccentric_rod, 1.0])
        for _ in range(MAX_NEWTON_STEPS):
            residuals, jacobians = _evaluate_closure(poses, anchors, points, lengths)
            is_closed = np.max(np.abs(residuals), axis=1) < CLOSURE_TOLERANCE * self.eccentric_rod
            if is_closed.all():
                break
            # A singular position has no solution; the least change of the others is zero.
            steps = -(np.linalg.pinv(jacobians) @ residuals[..., np.newaxis])[..., 0]
            poses = poses + np.clip(steps, -max_steps, max_steps)
        return np.where(is_closed[:, np.newaxis], poses, math.nan)


def arc_depth(radius: float, half_chord: float) -> float:
    """Return the height of an arc over its chord, m."""
    return half_chord**2 / (radius + math.sqrt(radius**2 - half_chord**2))


def _evaluate_closure(poses: FloatArray, anchors: FloatArray, points: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the errors (n, 3) of the three rods, m, and their derivatives (n, 3, 3) by the poses (n, 3)."""
    cosine, sine = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    arm_x, arm_y = cosine * points[:, 0] - sine * points[:, 1], sine * points[:, 0] + cosine * points[:, 1]
    dx, dy = poses[:, :1] + arm_x - anchors[..., 0], poses[:, 1:2] + arm_y - anchors[..., 1]
    distances = np.hypot(dx, dy)
    jacobians = np.stack([dx, dy, arm_x * dy - arm_y * dx], axis=-1) / distances[..., np.newaxis]
    return distances - lengths, jacobians
