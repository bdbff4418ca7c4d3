"""Gravity, centrifugal force, springs, dampers, torques and forces, applied to pymunk bodies before every step."""

from __future__ import annotations

import math
from collections.abc import Callable

import pymunk

from governor_mechanism.engines.impulse.pymunk.bodies import AttachedPoint, BodyProxy
from governor_mechanism.engines.impulse.pymunk.step_inputs import StepInputs
from governor_mechanism.mechanics.dynamics.force_laws import centrifugal_force, centrifugal_moment, damper_force, spring_force, weight
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.scene import Scene

ForceCallback = Callable[[float, StepInputs], None]
"""Set or add a force for the kick that ends the next step, at the pose `lead` seconds ahead."""

POINT_MASS_MOMENTS = SecondMoments()
"""Second moments of a point mass, all zero."""


def make_body_force(scene: Scene, proxy: BodyProxy) -> tuple[ForceCallback, tuple[str, ...]]:
    """Return the callback that sets gravity and centrifugal load on one body, and the names of the laws that it evaluates."""
    body, pymunk_body, mass = proxy.body, proxy.pymunk_body, proxy.body.mass
    weight_force = weight(mass, scene.gravity) if scene.gravity else 0.0
    is_centrifugal = scene.has_centrifugal and scene.part.plane == TURNING_PLANE and not _is_on_spindle_axis(scene.part.mechanism, body)
    law_names = ("gravity",) * bool(scene.gravity) + ("centrifugal",) * is_centrifugal
    if proxy.is_pinned:
        return _make_pinned_body_force(proxy, weight_force, is_centrifugal), law_names

    def apply_gravity(lead: float, inputs: StepInputs) -> None:
        """Set the weight."""
        pymunk_body.force = (0.0, weight_force * inputs.kick_scale)

    def apply_point_mass_loads(lead: float, inputs: StepInputs) -> None:
        """Set weight and centrifugal force."""
        x = pymunk_body.position.x + pymunk_body.velocity.x * lead
        pymunk_body.force = (centrifugal_force(mass, x, inputs.spindle_speed_squared) * inputs.kick_scale, weight_force * inputs.kick_scale)

    def apply_rigid_body_loads(lead: float, inputs: StepInputs) -> None:
        """Set weight, centrifugal force and centrifugal moment."""
        apply_point_mass_loads(lead, inputs)
        angle = pymunk_body.angle + pymunk_body.angular_velocity * lead
        pymunk_body.torque = (
            float(centrifugal_moment(*body.second_moments.in_plane, angle, inputs.spindle_speed_squared)) * inputs.kick_scale
        )

    if not is_centrifugal:
        return apply_gravity, law_names
    return (apply_point_mass_loads if body.second_moments == POINT_MASS_MOMENTS else apply_rigid_body_loads), law_names


def _make_pinned_body_force(proxy: BodyProxy, weight_force: float, is_centrifugal: bool) -> ForceCallback:
    """Return the callback that sets the loads of a body reduced to its pin as a moment about the pin."""
    body, pymunk_body = proxy.body, proxy.pymunk_body
    x, y, pin_x = -proxy.origin[0], -proxy.origin[1], pymunk_body.position.x

    def apply_torque(lead: float, inputs: StepInputs) -> None:
        """Set the moment about the pin."""
        angle = pymunk_body.angle + pymunk_body.angular_velocity * lead
        sine, cosine = math.sin(angle), math.cos(angle)
        arm_x, arm_y = x * cosine - y * sine, x * sine + y * cosine
        torque = arm_x * weight_force
        if is_centrifugal:
            torque -= arm_y * centrifugal_force(body.mass, pin_x + arm_x, inputs.spindle_speed_squared)
            if body.second_moments != POINT_MASS_MOMENTS:
                torque += float(centrifugal_moment(*body.second_moments.in_plane, angle, inputs.spindle_speed_squared))
        pymunk_body.torque = torque * inputs.kick_scale

    return apply_torque


def _is_on_spindle_axis(mechanism: Mechanism, body: Body) -> bool:
    """Return whether a body is guided along the spindle axis with its mass centre on it, so that no centrifugal load acts."""
    return not body.can_rotate and any(
        isinstance(joint, Slider)
        and joint.first.body == GROUND
        and joint.first.x == 0.0
        and math.isclose(abs(joint.angle), math.pi / 2)
        and joint.second == Point(body=body.name, y=joint.second.y)
        for joint in mechanism.joints
    )


class VelocityExtrapolator:
    """Velocities of bodies at the end of the coming step, extrapolated from the last two half steps."""

    def __init__(self, bodies: list[pymunk.Body]) -> None:
        self._bodies = bodies
        self._previous: dict[pymunk.Body, tuple[float, float, float]] = {}
        self._interval = 0.0
        self.predicted: dict[pymunk.Body, tuple[float, float, float]] = {}

    def predict(self, half_step: float) -> None:
        """Extrapolate from the present velocities to `half_step` seconds later, the kick that ends the step."""
        current = {body: (body.velocity.x, body.velocity.y, body.angular_velocity) for body in self._bodies}
        step_ratio = half_step / self._interval if self._interval > 0.0 else 0.0
        for body, (u, v, w) in current.items():
            a, b, c = self._previous.get(body, (u, v, w))
            self.predicted[body] = (u + step_ratio * (u - a), v + step_ratio * (v - b), w + step_ratio * (w - c))
        self._previous = current

    def set_interval(self, interval: float) -> None:
        """Set the time (s) between the velocities before the step and those after it."""
        self._interval = interval


def make_element_force(
    element: ForceElement,
    points: tuple[AttachedPoint, AttachedPoint],
    velocity_extrapolator: VelocityExtrapolator,
    program_indices: tuple[int, ...],
) -> ForceCallback:
    """Return the callback that adds one force element; `program_indices` are its functions in `StepInputs.load_values`."""
    first, second = points
    if isinstance(element, Spring | Damper):
        return _make_linear_element_force(element, first, second, velocity_extrapolator)
    if isinstance(element, TorsionSpring | TorsionDamper | Torque):
        return _make_torsional_element_force(element, first.body, second.body, velocity_extrapolator, program_indices)
    if isinstance(element, Force):
        x_program, y_program = program_indices

        def apply_force(lead: float, inputs: StepInputs) -> None:
            placement = second.predict(lead)
            _add_force(
                second.body, placement, inputs.load_values[x_program] * inputs.kick_scale, inputs.load_values[y_program] * inputs.kick_scale
            )

        return apply_force
    raise TypeError(f"engine 'impulse' has no force law for elements of type {type(element).__name__}")


def _make_linear_element_force(
    element: Spring | Damper, first: AttachedPoint, second: AttachedPoint, velocity_extrapolator: VelocityExtrapolator
) -> ForceCallback:
    """Return the callback of a spring or damper between two points."""

    def apply_force(lead: float, inputs: StepInputs) -> None:
        """Add the force of the spring or damper to both bodies."""
        first_placement, second_placement = first.predict(lead), second.predict(lead)
        dx, dy = second_placement[0] - first_placement[0], second_placement[1] - first_placement[1]
        length = math.hypot(dx, dy)
        if length == 0.0:
            return  # the direction of the force is undefined
        if isinstance(element, Spring):
            magnitude = spring_force(element.stiffness, element.free_length, length)
        else:
            u1, v1 = _point_velocity(first.body, first_placement, velocity_extrapolator)
            u2, v2 = _point_velocity(second.body, second_placement, velocity_extrapolator)
            magnitude = damper_force(element.damping, ((u2 - u1) * dx + (v2 - v1) * dy) / length)
        force_x, force_y = inputs.kick_scale * magnitude * dx / length, inputs.kick_scale * magnitude * dy / length
        _add_force(first.body, first_placement, force_x, force_y)
        _add_force(second.body, second_placement, -force_x, -force_y)

    return apply_force


def _make_torsional_element_force(
    element: TorsionSpring | TorsionDamper | Torque,
    first: pymunk.Body,
    second: pymunk.Body,
    velocity_extrapolator: VelocityExtrapolator,
    program_indices: tuple[int, ...],
) -> ForceCallback:
    """Return the callback of a torsional spring, torsional damper or torque between two bodies."""

    def apply_torque(lead: float, inputs: StepInputs) -> None:
        """Add the torque to both bodies."""
        if isinstance(element, TorsionSpring):
            angles = [body.angle + body.angular_velocity * lead for body in (first, second)]
            torque = -spring_force(element.stiffness, element.free_angle, angles[1] - angles[0])
        elif isinstance(element, TorsionDamper):
            rates = [
                velocity_extrapolator.predicted[body][2] if body in velocity_extrapolator.predicted else 0.0 for body in (first, second)
            ]
            torque = -damper_force(element.damping, rates[1] - rates[0])
        else:
            torque = inputs.load_values[program_indices[0]]
        for body, sign in ((second, 1.0), (first, -1.0)):
            if body.body_type != pymunk.Body.STATIC:
                body.torque += sign * torque * inputs.kick_scale

    return apply_torque


def _add_force(body: pymunk.Body, placement: tuple[float, float, float, float, float], force_x: float, force_y: float) -> None:
    """Add a force (N) at a point, with its moment about the body's centre."""
    if body.body_type == pymunk.Body.STATIC:
        return
    previous_force = body.force
    body.force = (previous_force.x + force_x, previous_force.y + force_y)
    body.torque += placement[2] * force_y - placement[3] * force_x


def _point_velocity(
    body: pymunk.Body, placement: tuple[float, float, float, float, float], velocity_extrapolator: VelocityExtrapolator
) -> tuple[float, float]:
    """Return the extrapolated velocity (m/s) of a point."""
    u, v, w = velocity_extrapolator.predicted.get(body, (0.0, 0.0, 0.0))
    return u - placement[3] * w, v + placement[2] * w
