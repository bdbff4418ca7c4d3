"""A mechanism as pymunk bodies, joints and loads. The only module that imports pymunk.

A Chipmunk step moves positions with the old velocities, then applies forces, then solves the joints. So velocities live
at half steps: with joint errors removed completely in each step, and loads taken at the pose the step is about to
reach, that is a second-order SHAKE/Verlet scheme. Used in the plain way, with pymunk's defaults, it is first order.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from governor_mechanism.equations.forces import centrifugal_force, centrifugal_moment, spindle_inertia, weight
from governor_mechanism.equations.points import Array
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.scene import Scene

Load = Callable[[float, float, float], None]
"""Set a body's force for the kick that ends the next step: (time ahead s, spindle speed squared, scale of the kick)."""

POINT = SecondMoments()

IMMOVABLE = 1e30
"""kg: a mass whose inverse vanishes beside any other; pymunk takes no infinite one."""

GROOVE_REACH = 1e3
"""Half length of a groove in machine sizes: grooves end, a guide does not."""


@dataclass(frozen=True)
class Carrier:
    """The pymunk body that carries one of ours; a lever pinned to the ground is carried by its pin.

    origin: where the pymunk body's centre is on ours, in our body's axes (m).
    """

    body: Body
    carried_by: pymunk.Body
    origin: tuple[float, float] = (0.0, 0.0)
    lever: bool = False

    def put(self, pose: Array, velocity: Array, back: float) -> None:
        """Place the carrier for a pose (x, y, angle) of our body moved back by `back` seconds, with its velocity."""
        self.carried_by.angle = float(pose[2] - velocity[2] * back)
        self.carried_by.angular_velocity = float(velocity[2])
        if not self.lever:
            self.carried_by.position = (float(pose[0] - velocity[0] * back), float(pose[1] - velocity[1] * back))
            self.carried_by.velocity = (float(velocity[0]), float(velocity[1]))

    def anchor(self, point: Point) -> tuple[float, float]:
        """A point of our body in the axes of the pymunk body."""
        return (point.x - self.origin[0], point.y - self.origin[1])


class Assembly:
    """One scene's mechanism in a pymunk space. `plain` keeps pymunk's own joint correction, loads and start."""

    def __init__(self, scene: Scene, *, iterations: int, plain: bool = False) -> None:
        self.plain = plain
        self._mechanism: Mechanism = scene.part.mechanism
        self._space = pymunk.Space()
        self._space.iterations = iterations
        self._carriers = [_carry(self._mechanism, body) for body in self._mechanism.bodies]
        self._space.add(*(carrier.carried_by for carrier in self._carriers))
        for joint in self._mechanism.joints:
            self._add(joint)
        loads = [_load(scene, carrier) for carrier in self._carriers]
        self._loads = [load for load, _ in loads]
        self.laws = Counter(law for _, laws in loads for law in laws)
        """How often one step evaluates each force law."""

    def start(self, poses: Array, velocities: Array, h: float, speed_squared: float) -> None:
        """Stand at poses (bodies, 3) with velocities half a step ahead; in the plain way, as they are."""
        back = 0.0 if self.plain else 0.5 * h
        for carrier, pose, velocity in zip(self._carriers, poses, velocities, strict=True):
            carrier.put(pose, velocity, back)
        if not self.plain:
            self.step(back, speed_squared, 1.0)

    def step(self, h: float, speed_squared: float, scale: float) -> None:
        """One pymunk step of h seconds with all loads set; `scale` lengthens the kick where the next step differs."""
        ahead = 0.0 if self.plain else h
        for load in self._loads:
            load(ahead, speed_squared, scale)
        self._space.step(h)

    def rest(self) -> None:
        """Take all velocities away."""
        for carrier in self._carriers:
            carrier.carried_by.velocity = (0.0, 0.0)
            carrier.carried_by.angular_velocity = 0.0

    def kinetic_energy(self) -> float:
        """In the plane (J), half a step ahead of the poses."""
        return 0.5 * sum(carrier.carried_by.kinetic_energy for carrier in self._carriers)

    def poses(self) -> Array:
        """Poses (bodies, 3) of the pymunk bodies: see `of_mass_centres`."""
        return np.array([(*c.carried_by.position, c.carried_by.angle) for c in self._carriers])

    def velocities(self) -> Array:
        """Velocities (bodies, 3) of the pymunk bodies, half a step ahead of their poses."""
        return np.array([(*c.carried_by.velocity, c.carried_by.angular_velocity) for c in self._carriers])

    def levers(self) -> NDArray[np.bool_]:
        """(bodies,) which bodies are carried by a pin to the ground."""
        return np.array([carrier.lever for carrier in self._carriers])

    def of_mass_centres(self, poses: Array, velocities: Array) -> tuple[Array, Array]:
        """Poses and velocities (..., bodies, 3) of our bodies from those of the pymunk bodies."""
        poses, velocities = poses.copy(), velocities.copy()
        for index, carrier in enumerate(self._carriers):
            if carrier.lever:
                angle, rate = poses[..., index, 2], velocities[..., index, 2]
                x, y = -carrier.origin[0], -carrier.origin[1]
                arm_x, arm_y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
                poses[..., index, 0] += arm_x
                poses[..., index, 1] += arm_y
                velocities[..., index, 0] = -arm_y * rate
                velocities[..., index, 1] = arm_x * rate
        return poses, velocities

    def spindle_inertia(self, ahead: float) -> float:
        """Moment of inertia (kg m2) about the spindle at the pose predicted `ahead` seconds from now."""
        poses, velocities = self.poses(), self.velocities()
        poses, _ = self.of_mass_centres(poses + ahead * velocities, velocities)
        return float(
            sum(
                spindle_inertia(
                    carrier.body.mass, *carrier.body.moments.in_plane, carrier.body.moments.zz, pose[0], pose[2]
                )
                for carrier, pose in zip(self._carriers, poses, strict=True)
            )
        )

    def _add(self, joint: Joint) -> None:
        made = self._make(joint)
        if made is None:
            return
        made.collide_bodies = False
        if not self.plain:
            made.error_bias = 0.0
            made.max_bias = math.inf
        self._space.add(made)

    def _make(self, joint: Joint) -> pymunk.Constraint | None:
        first, second = self._on(joint.first), self._on(joint.second)
        if isinstance(joint, Distance):
            pin = pymunk.PinJoint(first[0], second[0], first[1], second[1])
            pin.distance = joint.length
            return pin
        if isinstance(joint, Pin):
            held = {point.body for point in (joint.first, joint.second)}
            if any(carrier.lever and held == {GROUND, carrier.body.name} for carrier in self._carriers):
                return None  # the lever turns about its carrier, which cannot move
            return pymunk.PivotJoint(first[0], second[0], first[1], second[1])
        if isinstance(joint, Slider):
            if first[0].moment != math.inf or second[0].moment != math.inf:
                raise UnsupportedEffect(
                    f"engine 'impulse' has sliders only between bodies that do not turn; joint {joint.name!r} does"
                )
            reach = GROOVE_REACH * self._mechanism.size
            dx, dy = reach * math.cos(joint.angle), reach * math.sin(joint.angle)
            (x, y), body = first[1], first[0]
            return pymunk.GrooveJoint(body, second[0], (x - dx, y - dy), (x + dx, y + dy), second[1])
        raise UnsupportedEffect(f"engine 'impulse' has no joint of type {type(joint).__name__}")

    def _on(self, point: Point) -> tuple[pymunk.Body, tuple[float, float]]:
        if point.body == GROUND:
            return self._space.static_body, (point.x, point.y)
        carrier = self._carriers[self._mechanism.body_index(point.body)]
        return carrier.carried_by, carrier.anchor(point)


def _carry(mechanism: Mechanism, body: Body) -> Carrier:
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


def _load(scene: Scene, carrier: Carrier) -> tuple[Load, tuple[str, ...]]:
    """The function that sets one body's loads, and the laws it evaluates. What the scene leaves out is not in it."""
    body, carried_by, mass = carrier.body, carrier.carried_by, carrier.body.mass
    down = weight(mass, scene.gravity) if scene.gravity else 0.0
    turning = scene.centrifugal and not _on_axis(scene.part.mechanism, body)
    laws = ("gravity",) * bool(scene.gravity) + ("centrifugal",) * turning
    if carrier.lever:
        return _lever_load(carrier, down, turning), laws

    def fixed(ahead: float, speed_squared: float, scale: float) -> None:
        carried_by.force = (0.0, down * scale)

    def point(ahead: float, speed_squared: float, scale: float) -> None:
        x = carried_by.position.x + carried_by.velocity.x * ahead
        carried_by.force = (centrifugal_force(mass, x, speed_squared) * scale, down * scale)

    def rigid(ahead: float, speed_squared: float, scale: float) -> None:
        point(ahead, speed_squared, scale)
        angle = carried_by.angle + carried_by.angular_velocity * ahead
        carried_by.torque = float(centrifugal_moment(*body.moments.in_plane, angle, speed_squared)) * scale

    if not turning:
        return fixed, laws
    return (point if body.moments == POINT else rigid), laws


def _lever_load(carrier: Carrier, down: float, turning: bool) -> Load:
    """Loads of a lever as a moment about its pin."""
    body, carried_by = carrier.body, carrier.carried_by
    x, y, pin_x = -carrier.origin[0], -carrier.origin[1], carried_by.position.x

    def lever(ahead: float, speed_squared: float, scale: float) -> None:
        angle = carried_by.angle + carried_by.angular_velocity * ahead
        sine, cosine = math.sin(angle), math.cos(angle)
        arm_x, arm_y = x * cosine - y * sine, x * sine + y * cosine
        moment = arm_x * down
        if turning:
            moment -= arm_y * centrifugal_force(body.mass, pin_x + arm_x, speed_squared)
            if body.moments != POINT:
                moment += float(centrifugal_moment(*body.moments.in_plane, angle, speed_squared))
        carried_by.torque = moment * scale

    return lever


def _on_axis(mechanism: Mechanism, body: Body) -> bool:
    """A body guided along the spindle axis with its centre on it feels no centrifugal load."""
    return not body.turns and any(
        isinstance(joint, Slider)
        and joint.first.body == GROUND
        and joint.first.x == 0.0
        and math.isclose(abs(joint.angle), math.pi / 2)
        and joint.second == Point(body=body.name, y=joint.second.y)
        for joint in mechanism.joints
    )
