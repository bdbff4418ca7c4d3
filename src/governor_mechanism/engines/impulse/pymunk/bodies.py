"""pymunk bodies that represent the bodies of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Body, Mechanism

if TYPE_CHECKING:
    import pymunk

QUASI_INFINITE_MASS = 1e30
"""Mass (kg) whose inverse vanishes next to any other; pymunk accepts no infinite mass for a body that rotates."""

PlanarVector = tuple[float, float]
"""Coordinates x, y (m)."""

Poses = Sequence[Sequence[float]]
"""Poses (x, y, angle) of all bodies and, behind them, the ground, as Python numbers, which are faster one by one than arrays."""


@dataclass(frozen=True)
class BodyProxy:
    """The pymunk body of a mechanism's body; a body pinned to the ground is reduced to rotation about its pin.

    `origin` (m) is the centre of the pymunk body in the axes of the mechanism's body.
    """

    body: pymunk.Body
    origin: PlanarVector = (0.0, 0.0)
    is_pinned: bool = False


@dataclass(frozen=True)
class AttachedPoint:
    """A point fixed to a pymunk body, in its axes (m); `index` is that of the body, or of the ground."""

    body: pymunk.Body
    index: int
    x: float
    y: float

    def locate(self, poses: Poses) -> tuple[float, float, float]:
        """Return the position x, y (m) and the angle of its body (rad)."""
        x, y, angle = poses[self.index]
        cosine, sine = math.cos(angle), math.sin(angle)
        return x + (cosine * self.x - sine * self.y), y + (sine * self.x + cosine * self.y), angle


def to_body_axes(poses: Poses, index: int, point: PlanarVector) -> PlanarVector:
    """Return a point (m) in the axes of a body."""
    x, y, angle = poses[index]
    dx, dy, cosine, sine = point[0] - x, point[1] - y, math.cos(angle), math.sin(angle)
    return cosine * dx + sine * dy, cosine * dy - sine * dx


def cannot_rotate_in_pymunk(mechanism: Mechanism, body: Body) -> bool:
    """Return whether a body that must rotate has no inertia for it: a point mass without a pin to the ground."""
    return body.can_rotate and body.planar_inertia <= 0.0 and _find_ground_pin(mechanism, body) is None


def _find_ground_pin(mechanism: Mechanism, body: Body) -> tuple[Point, Point] | None:
    """Return the points of the body and the ground that a pin joins; None without such a pin."""
    for joint in mechanism.joints:
        points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(points) == {GROUND, body.name}:
            return points[body.name], points[GROUND]
    return None


def make_body_proxy(mechanism: Mechanism, body: Body) -> BodyProxy:
    """Create the pymunk body of a mechanism's body."""
    import pymunk  # slow to import

    if not body.can_rotate:
        return BodyProxy(pymunk.Body(body.mass, math.inf))
    if points := _find_ground_pin(mechanism, body):
        pin, ground = points
        # The mass is so large that the body does not translate: the pin carries every force, only rotation is left.
        pinned_body = pymunk.Body(QUASI_INFINITE_MASS, body.planar_inertia + body.mass * (pin.x**2 + pin.y**2))
        pinned_body.position = (ground.x, ground.y)
        return BodyProxy(pinned_body, (pin.x, pin.y), is_pinned=True)
    return BodyProxy(pymunk.Body(body.mass, body.planar_inertia))
