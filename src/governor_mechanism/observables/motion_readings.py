"""Readings that follow from the motion, as velocities of points or instantaneous centres; NaN where one is not defined."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import compute_inverse_dynamics
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.motion_readings import (
    InstantaneousCentre,
    MechanicalAdvantage,
    PathCurvature,
    PointAcceleration,
    PointVelocity,
    TransmissionAngle,
)
from governor_mechanism.model.output_variables import DerivedReading
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import GROUND_INDEX, FloatArray

REST_RATIO = 1e-9
"""Velocity relative to the largest of the motion below which a point, a body or a reading stands still; rounding leaves 1e-15."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Poses, velocities and accelerations (n, bodies, 3) of a mechanism, and the rates (n,) of its readings where they are needed."""

    mechanism: Mechanism
    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    rates: Mapping[str, FloatArray]

    def path(self, point: Point) -> FloatArray:
        """Return the positions (n, 2) of a point, m."""
        return point_path(self.mechanism, self.poses, point)

    def velocity(self, point: Point) -> FloatArray:
        """Return the velocities (n, 2) of a point relative to the plane, m/s."""
        return point_velocity(self.mechanism, self.poses, self.velocities, point)

    def acceleration(self, point: Point) -> FloatArray:
        """Return the accelerations (n, 2) of a point relative to the plane, m/s2."""
        index = self.mechanism.body_index(point.body)
        if index == GROUND_INDEX:
            return np.zeros((len(self.poses), 2))
        arm = self.path(point) - self.poses[:, index, :2]
        body, spin = self.accelerations[:, index], self.velocities[:, index, 2:]
        acceleration: FloatArray = body[:, :2] + body[:, 2:] * turn_left(arm) - spin**2 * arm
        return acceleration


def point_velocity(mechanism: Mechanism, poses: FloatArray, velocities: FloatArray, point: Point) -> FloatArray:
    """Return the velocities (n, 2), m/s, of a point relative to the plane at poses and velocities (n, bodies, 3)."""
    index = mechanism.body_index(point.body)
    if index == GROUND_INDEX:
        return np.zeros((len(poses), 2))
    arm = point_path(mechanism, poses, point) - poses[:, index, :2]
    velocity: FloatArray = velocities[:, index, :2] + velocities[:, index, 2:] * turn_left(arm)
    return velocity


def turn_left(vectors: FloatArray) -> FloatArray:
    """Return vectors (n, 2) turned by a right angle, anticlockwise."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)


def _component(vectors: FloatArray, component: str) -> FloatArray:
    """Return a component (n,) of vectors (n, 2), or their magnitude."""
    values: FloatArray = np.hypot(*vectors.T) if component == "magnitude" else vectors[:, "xy".index(component)]
    return values


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross products (n,) of vectors (n, 2)."""
    product: FloatArray = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return product


def _quotient(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Return quotients (n,); NaN where the denominator is negligible beside its largest value."""
    largest = float(np.max(np.abs(denominator), initial=0.0))
    is_regular = np.abs(denominator) > REST_RATIO * largest
    quotient: FloatArray = np.divide(numerator, denominator, out=np.full(len(numerator), np.nan), where=is_regular)
    return quotient


def _transmission_lines(motion: Motion, angle: TransmissionAngle) -> tuple[FloatArray, FloatArray]:
    """Return the vectors (n, 2) from the pin along the coupler and along the output link."""
    pin = motion.path(angle.pin)
    coupler = motion.path(angle.start) - pin
    if angle.pivot is not None:
        return coupler, motion.path(angle.pivot) - pin
    return coupler, np.tile([np.cos(angle.normal), np.sin(angle.normal)], (len(pin), 1))


def _transmission_angle(motion: Motion, angle: TransmissionAngle) -> FloatArray:
    coupler, link = _transmission_lines(motion, angle)
    values: FloatArray = np.arctan2(np.abs(_cross(coupler, link)), np.sum(coupler * link, axis=1))
    return values


def transmission_sine(motion: Motion, angle: TransmissionAngle) -> FloatArray:
    """Return the sine (n,) of the angle from coupler to output link, anticlockwise: it changes its sign where both are aligned."""
    coupler, link = _transmission_lines(motion, angle)
    sine: FloatArray = _cross(coupler, link) / (np.hypot(*coupler.T) * np.hypot(*link.T))
    return sine


def _curvature(motion: Motion, curvature: PathCurvature) -> FloatArray:
    velocity = motion.velocity(curvature.point)
    speed = np.hypot(*velocity.T)
    fastest = float(np.max(np.hypot(*motion.velocities[:, :, :2].T), initial=0.0))
    moves = speed > REST_RATIO * fastest
    turning = _cross(velocity, motion.acceleration(curvature.point))
    values: FloatArray = np.divide(turning, speed**3, out=np.full(len(speed), np.nan), where=moves)
    return values


def _instantaneous_centre(motion: Motion, centre: InstantaneousCentre) -> FloatArray:
    """Return a coordinate (n,) of the point P with v1 + w1 x P = v2 + w2 x P, v being velocities of the bodies at the origin."""
    if centre.pin is not None:
        return _component(motion.path(centre.pin), centre.component)
    (first, first_spin), (second, second_spin) = (_velocity_at_origin(motion, body) for body in (centre.first, centre.second))
    spin = second_spin - first_spin
    largest = float(np.max(np.abs(motion.velocities[:, :, 2]), initial=0.0))
    spin = np.where(np.abs(spin) > REST_RATIO * largest, spin, 0.0)
    return _quotient(_component(turn_left(second - first), centre.component), spin)


def _velocity_at_origin(motion: Motion, body: str) -> tuple[FloatArray, FloatArray]:
    """Return the velocity (n, 2) that a body has at the origin of the plane, m/s, and its angular velocity (n,), rad/s."""
    if body == GROUND:
        return np.zeros((len(motion.poses), 2)), np.zeros(len(motion.poses))
    index = motion.mechanism.body_index(body)
    spin = motion.velocities[:, index, 2]
    return motion.velocities[:, index, :2] - spin[:, np.newaxis] * turn_left(motion.poses[:, index, :2]), spin


def evaluate_motion_reading(motion: Motion, reading: DerivedReading) -> FloatArray | None:
    """Return the values (n,) of a reading that follows from a motion, SI; None of one that follows from forces."""
    match reading:
        case PointVelocity():
            return _component(motion.velocity(reading.point), reading.component)
        case PointAcceleration():
            return _component(motion.acceleration(reading.point), reading.component)
        case TransmissionAngle():
            return _transmission_angle(motion, reading)
        case PathCurvature():
            return _curvature(motion, reading)
        case InstantaneousCentre():
            return _instantaneous_centre(motion, reading)
        case MechanicalAdvantage():
            return _quotient(motion.rates[reading.input], motion.rates[reading.output])
    return None


def evaluate_run_readings(scene: Scene, history: StateHistory, modes: Sequence[ContactMode]) -> dict[str, FloatArray]:
    """Return the readings of a run that follow from its motion, by name, in SI; shape (n,) each."""
    outputs = scene.mechanism.derived_readings
    needs_accelerations = any(isinstance(one, PointAcceleration) for one in outputs)
    accelerations = _accelerations(scene, history, modes) if needs_accelerations else np.zeros_like(history.poses)
    motion = Motion(mechanism=scene.mechanism, poses=history.poses, velocities=history.velocities, accelerations=accelerations, rates={})
    values = {one.name: evaluate_motion_reading(motion, one) for one in outputs}
    return {name: one for name, one in values.items() if one is not None}


def _accelerations(scene: Scene, history: StateHistory, modes: Sequence[ContactMode]) -> FloatArray:
    """Return the accelerations (n, bodies, 3) at the states of a motion in their contact modes."""
    return compute_inverse_dynamics(scene, history.times, history.poses, history.velocities, history.lags, modes).accelerations
