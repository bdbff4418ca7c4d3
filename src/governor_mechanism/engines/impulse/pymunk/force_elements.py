"""Gravity, the spindle's turning, springs, dampers, torques and forces, set on pymunk bodies before every step."""

from __future__ import annotations

import math
from collections.abc import Callable

import pymunk

from governor_mechanism.engines.impulse.pymunk.bodies import Carrier, Marked
from governor_mechanism.engines.impulse.pymunk.step_inputs import Moment
from governor_mechanism.mechanics.dynamics.force_laws import (
    centrifugal_force,
    centrifugal_moment,
    damper_force,
    spring_force,
    weight,
)
from governor_mechanism.model.force_elements import Damper, Force, Load, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.scene import TURNING, Scene

Push = Callable[[float, Moment], None]
"""Set or add a force for the kick that ends the next step, at the pose `ahead` seconds from now."""

POINT = SecondMoments()


def effects_on(scene: Scene, carrier: Carrier) -> tuple[Push, tuple[str, ...]]:
    """The function that sets one body's loads of the scene's effects, and the laws it evaluates.

    What the scene leaves out is not in it.
    """
    body, carried_by, mass = carrier.body, carrier.carried_by, carrier.body.mass
    down = weight(mass, scene.gravity) if scene.gravity else 0.0
    turning = scene.centrifugal and scene.part.plane == TURNING and not _on_axis(scene.part.mechanism, body)
    laws = ("gravity",) * bool(scene.gravity) + ("centrifugal",) * turning
    if carrier.lever:
        return _on_lever(carrier, down, turning), laws

    def fixed(ahead: float, now: Moment) -> None:
        carried_by.force = (0.0, down * now.scale)

    def point(ahead: float, now: Moment) -> None:
        x = carried_by.position.x + carried_by.velocity.x * ahead
        carried_by.force = (centrifugal_force(mass, x, now.square) * now.scale, down * now.scale)

    def rigid(ahead: float, now: Moment) -> None:
        point(ahead, now)
        angle = carried_by.angle + carried_by.angular_velocity * ahead
        carried_by.torque = float(centrifugal_moment(*body.moments.in_plane, angle, now.square)) * now.scale

    if not turning:
        return fixed, laws
    return (point if body.moments == POINT else rigid), laws


def _on_lever(carrier: Carrier, down: float, turning: bool) -> Push:
    """Loads of a lever as a moment about its pin."""
    body, carried_by = carrier.body, carrier.carried_by
    x, y, pin_x = -carrier.origin[0], -carrier.origin[1], carried_by.position.x

    def lever(ahead: float, now: Moment) -> None:
        angle = carried_by.angle + carried_by.angular_velocity * ahead
        sine, cosine = math.sin(angle), math.cos(angle)
        arm_x, arm_y = x * cosine - y * sine, x * sine + y * cosine
        moment = arm_x * down
        if turning:
            moment -= arm_y * centrifugal_force(body.mass, pin_x + arm_x, now.square)
            if body.moments != POINT:
                moment += float(centrifugal_moment(*body.moments.in_plane, angle, now.square))
        carried_by.torque = moment * now.scale

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


class Speeds:
    """Velocities of bodies at the end of the coming step, extrapolated from the last two half steps."""

    def __init__(self, bodies: list[pymunk.Body]) -> None:
        self._bodies = bodies
        self._older: dict[pymunk.Body, tuple[float, float, float]] = {}
        self._age = 0.0
        self.now: dict[pymunk.Body, tuple[float, float, float]] = {}

    def look(self, half: float) -> None:
        """Note the velocities before a step, `half` seconds before the kick that ends it."""
        last = {body: (body.velocity.x, body.velocity.y, body.angular_velocity) for body in self._bodies}
        part = half / self._age if self._age > 0.0 else 0.0
        for body, (u, v, w) in last.items():
            a, b, c = self._older.get(body, (u, v, w))
            self.now[body] = (u + part * (u - a), v + part * (v - b), w + part * (w - c))
        self._older = last

    def passed(self, between: float) -> None:
        """So many seconds will lie between the velocities before the step and those after it."""
        self._age = between


def load_on(load: Load, ends: tuple[Marked, Marked], speeds: Speeds, programs: tuple[int, ...]) -> Push:
    """The function that adds one load of the mechanism; programs are where its own stand among those of a Moment."""
    first, second = ends
    if isinstance(load, Spring | Damper):
        return _line_load(load, first, second, speeds)
    if isinstance(load, TorsionSpring | TorsionDamper | Torque):
        return _turning_load(load, first.body, second.body, speeds, programs)
    if isinstance(load, Force):
        along_x, along_y = programs

        def force(ahead: float, now: Moment) -> None:
            place = second.place(ahead)
            _add(second.body, place, now.programs[along_x] * now.scale, now.programs[along_y] * now.scale)

        return force
    raise TypeError(f"no law is written for loads of type {type(load).__name__}")


def _line_load(load: Spring | Damper, first: Marked, second: Marked, speeds: Speeds) -> Push:
    def pull(ahead: float, now: Moment) -> None:
        one, two = first.place(ahead), second.place(ahead)
        dx, dy = two[0] - one[0], two[1] - one[1]
        length = math.hypot(dx, dy)
        if length == 0.0:
            return  # no direction to pull in
        if isinstance(load, Spring):
            size = spring_force(load.stiffness, load.free_length, length)
        else:
            u1, v1 = _velocity(first.body, one, speeds)
            u2, v2 = _velocity(second.body, two, speeds)
            size = damper_force(load.damping, ((u2 - u1) * dx + (v2 - v1) * dy) / length)
        force_x, force_y = now.scale * size * dx / length, now.scale * size * dy / length
        _add(first.body, one, force_x, force_y)
        _add(second.body, two, -force_x, -force_y)

    return pull


def _turning_load(
    load: TorsionSpring | TorsionDamper | Torque,
    first: pymunk.Body,
    second: pymunk.Body,
    speeds: Speeds,
    programs: tuple[int, ...],
) -> Push:
    def turn(ahead: float, now: Moment) -> None:
        if isinstance(load, TorsionSpring):
            angles = [body.angle + body.angular_velocity * ahead for body in (first, second)]
            moment = -spring_force(load.stiffness, load.free_angle, angles[1] - angles[0])
        elif isinstance(load, TorsionDamper):
            rates = [speeds.now[body][2] if body in speeds.now else 0.0 for body in (first, second)]
            moment = -damper_force(load.damping, rates[1] - rates[0])
        else:
            moment = now.programs[programs[0]]
        for body, sign in ((second, 1.0), (first, -1.0)):
            if body.body_type != pymunk.Body.STATIC:
                body.torque += sign * moment * now.scale

    return turn


def _add(body: pymunk.Body, place: tuple[float, float, float, float, float], force_x: float, force_y: float) -> None:
    if body.body_type == pymunk.Body.STATIC:
        return
    before = body.force
    body.force = (before.x + force_x, before.y + force_y)
    body.torque += place[2] * force_y - place[3] * force_x


def _velocity(
    body: pymunk.Body, place: tuple[float, float, float, float, float], speeds: Speeds
) -> tuple[float, float]:
    u, v, w = speeds.now.get(body, (0.0, 0.0, 0.0))
    return u - place[3] * w, v + place[2] * w
