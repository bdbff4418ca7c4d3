"""The pymunk bodies that carry ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pymunk

from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.types import FloatArray

IMMOVABLE = 1e30
"""kg: a mass whose inverse vanishes beside any other; pymunk takes no infinite one."""

Pair = tuple[float, float]


@dataclass(frozen=True)
class Carrier:
    """The pymunk body that carries one of ours; a lever pinned to the ground is carried by its pin.

    origin: where the pymunk body's centre is on ours, in our body's axes (m).
    """

    body: Body
    carried_by: pymunk.Body
    origin: Pair = (0.0, 0.0)
    lever: bool = False

    def put(self, pose: FloatArray, velocity: FloatArray, back: float) -> None:
        """Place the carrier for a pose (x, y, angle) of our body moved back by `back` seconds, with its velocity."""
        self.carried_by.angle = float(pose[2] - velocity[2] * back)
        self.carried_by.angular_velocity = float(velocity[2])
        if not self.lever:
            self.carried_by.position = (float(pose[0] - velocity[0] * back), float(pose[1] - velocity[1] * back))
            self.carried_by.velocity = (float(velocity[0]), float(velocity[1]))

    def anchor(self, point: Point) -> Pair:
        """A point of our body in the axes of the pymunk body."""
        return (point.x - self.origin[0], point.y - self.origin[1])


@dataclass(frozen=True)
class Marked:
    """A point marked on a pymunk body, in its axes (m)."""

    body: pymunk.Body
    x: float
    y: float

    def place(self, ahead: float) -> tuple[float, float, float, float, float]:
        """Position (m) of the point `ahead` seconds from now, its arm from the body's centre, and the body's angle."""
        body = self.body
        if body.body_type == pymunk.Body.STATIC:
            return self.x, self.y, self.x, self.y, 0.0
        position, velocity = body.position, body.velocity
        angle = body.angle + body.angular_velocity * ahead
        c, s = math.cos(angle), math.sin(angle)
        arm_x, arm_y = c * self.x - s * self.y, s * self.x + c * self.y
        return position.x + velocity.x * ahead + arm_x, position.y + velocity.y * ahead + arm_y, arm_x, arm_y, angle


def carry(mechanism: Mechanism, body: Body) -> Carrier:
    """A carrier for a body; refuses one that cannot turn for want of inertia."""
    if not body.turns:
        return Carrier(body, pymunk.Body(body.mass, math.inf))
    inertia = body.moments.xx + body.moments.yy
    for joint in mechanism.joints:
        ends = {joint.first.body: joint.first, joint.second.body: joint.second}
        if isinstance(joint, Pin) and set(ends) == {GROUND, body.name}:
            pin, ground = ends[body.name], ends[GROUND]
            # So heavy that it takes no part in the solve: the pin carries every force, only turning is left.
            lever = pymunk.Body(IMMOVABLE, inertia + body.mass * (pin.x**2 + pin.y**2))
            lever.position = (ground.x, ground.y)
            return Carrier(body, lever, (pin.x, pin.y), lever=True)
    if inertia <= 0.0:
        raise UnsupportedEffect(
            f"engine 'impulse' cannot turn body {body.name!r}: its mass is in one point, and no pin joins it to ground"
        )
    return Carrier(body, pymunk.Body(body.mass, inertia))
