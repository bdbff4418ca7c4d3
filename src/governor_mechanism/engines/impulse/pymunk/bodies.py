"""pymunk bodies that represent the bodies of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pymunk

from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.types import FloatArray

QUASI_INFINITE_MASS = 1e30
"""Mass (kg) whose inverse vanishes next to any other; pymunk accepts no infinite mass for a body that rotates."""

PlanarVector = tuple[float, float]
"""Coordinates x, y (m)."""


@dataclass(frozen=True)
class BodyProxy:
    """The pymunk body of a mechanism's body; a body pinned to the ground is reduced to rotation about its pin.

    `origin` (m) is the centre of the pymunk body in the axes of the mechanism's body.
    """

    body: Body
    pymunk_body: pymunk.Body
    origin: PlanarVector = (0.0, 0.0)
    is_pinned: bool = False

    def set_state(self, pose: FloatArray, velocity: FloatArray, lag: float) -> None:
        """Set the pymunk body to a pose (x, y, angle), moved back by `lag` seconds, with a velocity."""
        self.pymunk_body.angle = float(pose[2] - velocity[2] * lag)
        self.pymunk_body.angular_velocity = float(velocity[2])
        if not self.is_pinned:
            self.pymunk_body.position = (float(pose[0] - velocity[0] * lag), float(pose[1] - velocity[1] * lag))
            self.pymunk_body.velocity = (float(velocity[0]), float(velocity[1]))

    def anchor(self, point: Point) -> PlanarVector:
        """Return a point of the mechanism's body in the axes of the pymunk body (m)."""
        return (point.x - self.origin[0], point.y - self.origin[1])


@dataclass(frozen=True)
class AttachedPoint:
    """A point fixed to a pymunk body, in its axes (m)."""

    body: pymunk.Body
    x: float
    y: float

    def predict(self, lead: float) -> tuple[float, float, float, float, float]:
        """Return position x, y (m) `lead` seconds ahead, the arm x, y (m) from the body's centre, and the body's angle (rad)."""
        body = self.body
        if body.body_type == pymunk.Body.STATIC:
            return self.x, self.y, self.x, self.y, 0.0
        position, velocity = body.position, body.velocity
        angle = body.angle + body.angular_velocity * lead
        c, s = math.cos(angle), math.sin(angle)
        arm_x, arm_y = c * self.x - s * self.y, s * self.x + c * self.y
        return position.x + velocity.x * lead + arm_x, position.y + velocity.y * lead + arm_y, arm_x, arm_y, angle


def to_body_axes(pose: Sequence[float] | FloatArray, point: PlanarVector) -> PlanarVector:
    """Return a point (m) in the axes of a body at a pose (x, y, angle)."""
    dx, dy = point[0] - float(pose[0]), point[1] - float(pose[1])
    cosine, sine = math.cos(float(pose[2])), math.sin(float(pose[2]))
    return cosine * dx + sine * dy, cosine * dy - sine * dx


def make_body_proxy(mechanism: Mechanism, body: Body) -> BodyProxy:
    """Create the pymunk body of a mechanism's body; raise UnsupportedEffect if it must rotate and has no inertia."""
    if not body.can_rotate:
        return BodyProxy(body, pymunk.Body(body.mass, math.inf))
    inertia = body.second_moments.xx + body.second_moments.yy
    for joint in mechanism.joints:
        joint_points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(joint_points) == {GROUND, body.name}:
            pin, ground = joint_points[body.name], joint_points[GROUND]
            # The mass is so large that the body does not translate: the pin carries every force, only rotation is left.
            pinned_body = pymunk.Body(QUASI_INFINITE_MASS, inertia + body.mass * (pin.x**2 + pin.y**2))
            pinned_body.position = (ground.x, ground.y)
            return BodyProxy(body, pinned_body, (pin.x, pin.y), is_pinned=True)
    if inertia <= 0.0:
        raise UnsupportedEffect(
            f"engine 'impulse' cannot rotate body {body.name!r}: it is a point mass without a pin to the ground; use engine 'multibody'"
        )
    return BodyProxy(body, pymunk.Body(body.mass, inertia))
