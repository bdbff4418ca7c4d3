"""The pymunk bodies that carry ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pymunk

from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.types import FloatArray

QUASI_INFINITE_MASS = 1e30
"""kg: a mass whose inverse vanishes beside any other; pymunk takes no infinite one."""

PlanarVector = tuple[float, float]


@dataclass(frozen=True)
class BodyProxy:
    """The pymunk body that carries one of ours; a lever pinned to the ground is carried by its pin.

    origin: where the pymunk body's centre is on ours, in our body's axes (m).
    """

    body: Body
    pymunk_body: pymunk.Body
    origin: PlanarVector = (0.0, 0.0)
    is_pinned: bool = False

    def set_state(self, pose: FloatArray, velocity: FloatArray, lag: float) -> None:
        """Place the carrier for a pose (x, y, angle) of our body moved back by `back` seconds, with its velocity."""
        self.pymunk_body.angle = float(pose[2] - velocity[2] * lag)
        self.pymunk_body.angular_velocity = float(velocity[2])
        if not self.is_pinned:
            self.pymunk_body.position = (float(pose[0] - velocity[0] * lag), float(pose[1] - velocity[1] * lag))
            self.pymunk_body.velocity = (float(velocity[0]), float(velocity[1]))

    def anchor(self, point: Point) -> PlanarVector:
        """A point of our body in the axes of the pymunk body."""
        return (point.x - self.origin[0], point.y - self.origin[1])


@dataclass(frozen=True)
class AttachedPoint:
    """A point marked on a pymunk body, in its axes (m)."""

    body: pymunk.Body
    x: float
    y: float

    def predict(self, lead: float) -> tuple[float, float, float, float, float]:
        """Position (m) of the point `ahead` seconds from now, its arm from the body's centre, and the body's angle."""
        body = self.body
        if body.body_type == pymunk.Body.STATIC:
            return self.x, self.y, self.x, self.y, 0.0
        position, velocity = body.position, body.velocity
        angle = body.angle + body.angular_velocity * lead
        c, s = math.cos(angle), math.sin(angle)
        arm_x, arm_y = c * self.x - s * self.y, s * self.x + c * self.y
        return position.x + velocity.x * lead + arm_x, position.y + velocity.y * lead + arm_y, arm_x, arm_y, angle


def make_body_proxy(mechanism: Mechanism, body: Body) -> BodyProxy:
    """A carrier for a body; refuses one that cannot turn for want of inertia."""
    if not body.can_rotate:
        return BodyProxy(body, pymunk.Body(body.mass, math.inf))
    inertia = body.second_moments.xx + body.second_moments.yy
    for joint in mechanism.joints:
        joint_points = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(joint_points) == {GROUND, body.name}:
            pin, ground = joint_points[body.name], joint_points[GROUND]
            # So heavy that it takes no part in the solve: the pin carries every force, only turning is left.
            pinned_body = pymunk.Body(QUASI_INFINITE_MASS, inertia + body.mass * (pin.x**2 + pin.y**2))
            pinned_body.position = (ground.x, ground.y)
            return BodyProxy(body, pinned_body, (pin.x, pin.y), is_pinned=True)
    if inertia <= 0.0:
        raise UnsupportedEffect(f"engine 'impulse' cannot turn body {body.name!r}: its mass is in one point, and no pin joins it to ground")
    return BodyProxy(body, pymunk.Body(body.mass, inertia))
