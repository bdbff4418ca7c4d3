"""Output variables: value, gradient and velocity-dependent acceleration term of every reading, along whole trajectories."""

import math
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from governor_mechanism.mechanics.kinematics.points import BodyPoint, body_point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import BodyAngle, FollowerHeight, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.types import FloatArray

READING_UNITS = {"angle": "rad", "length": "m"}
"""Unit of a reading by its quantity."""


@dataclass(frozen=True)
class OutputDerivatives:
    """An output variable and its derivatives at poses (..., bodies, 3).

    value (...) in SI; gradient (..., bodies, 3) in SI per m and per rad; quadratic_velocity_term (...) in SI/s2: the second time
    derivative minus gradient times accelerations.
    """

    value: FloatArray
    gradient: FloatArray
    quadratic_velocity_term: FloatArray

    def rate(self, velocities: FloatArray) -> FloatArray:
        """Return the rate (...) in SI/s at velocities (..., bodies, 3)."""
        rate: FloatArray = np.sum(self.gradient * velocities, axis=(-2, -1))
        return rate

    def acceleration(self, accelerations: FloatArray) -> FloatArray:
        """Return the second time derivative (...) in SI/s2 at the velocities of the evaluation and accelerations (..., bodies, 3)."""
        return self.rate(accelerations) + self.quadratic_velocity_term


def evaluate_output(mechanism: Mechanism, name: str, poses: FloatArray, velocities: FloatArray | None = None) -> OutputDerivatives:
    """Evaluate a reading and its derivatives.

    Parameters
    ----------
    mechanism
        The mechanism with that reading.
    name
        Name of the reading.
    poses
        Poses; shape (..., bodies, 3).
    velocities
        Velocities; same shape. Default: zero.

    Returns
    -------
    OutputDerivatives
        Value, gradient and quadratic velocity term.
    """
    given_velocities = np.zeros_like(poses) if velocities is None else velocities
    return evaluate_output_variable(mechanism.reading(name), mechanism, poses, given_velocities)


def evaluate_output_value(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    """Return the value of a reading.

    Parameters
    ----------
    mechanism
        The mechanism with that reading.
    name
        Name of the reading.
    poses
        Poses; shape (..., bodies, 3).

    Returns
    -------
    FloatArray
        Value, SI; shape (...).
    """
    return evaluate_output(mechanism, name, poses).value


def wrap_difference(reading: Reading, difference: float) -> float:
    """Return a difference of two values of a reading; that of the angle of a line within half a turn."""
    return math.remainder(difference, math.tau) if isinstance(reading, LineAngle) else difference


def unwrap_output(reading: Reading, values: FloatArray) -> FloatArray:
    """Return the values (n,) of a reading along a motion, continuous over full turns."""
    return np.unwrap(values) if isinstance(reading, LineAngle) else values  # the angle of a body is continuous already


@singledispatch
def evaluate_output_variable(reading: Reading, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> OutputDerivatives:
    """Evaluate an output variable that the mechanism need not list among its readings."""
    raise TypeError(f"no equation exists for readings of type {type(reading).__name__}")


@evaluate_output_variable.register
def _(reading: LineAngle, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> OutputDerivatives:
    start, end = body_point(mechanism, reading.start), body_point(mechanism, reading.end)
    relative_position, relative_velocity, centripetal = _relative_motion(start, end, poses, velocities)
    squared = np.sum(relative_position**2, axis=-1)
    normal = _perpendicular(relative_position) / squared[..., np.newaxis]
    angular_velocity = _dot(normal, relative_velocity)
    return OutputDerivatives(
        np.arctan2(relative_position[..., 0], -relative_position[..., 1]) - reading.zero,
        end.gradient_along(poses, normal) - start.gradient_along(poses, normal),
        _dot(normal, centripetal) - 2 * angular_velocity * _dot(relative_position, relative_velocity) / squared,
    )


@evaluate_output_variable.register
def _(reading: BodyAngle, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> OutputDerivatives:
    value, gradient = np.zeros(poses.shape[:-2]), np.zeros(poses.shape)
    for name, sign in ((reading.body, 1.0), (reading.reference_body, -1.0)):
        index = mechanism.body_index(name)
        if index >= 0:
            value = value + sign * poses[..., index, 2]
            gradient[..., index, 2] += sign
    return OutputDerivatives(value, gradient, np.zeros(poses.shape[:-2]))


@evaluate_output_variable.register
def _(reading: PointDistance, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> OutputDerivatives:
    first, second = body_point(mechanism, reading.first), body_point(mechanism, reading.second)
    relative_position, relative_velocity, centripetal = _relative_motion(first, second, poses, velocities)
    length = np.linalg.norm(relative_position, axis=-1)
    unit_vector = relative_position / length[..., np.newaxis]
    elongation_rate = _dot(unit_vector, relative_velocity)
    return OutputDerivatives(
        length,
        second.gradient_along(poses, unit_vector) - first.gradient_along(poses, unit_vector),
        _dot(unit_vector, centripetal) + (np.sum(relative_velocity**2, axis=-1) - elongation_rate**2) / length,
    )


@evaluate_output_variable.register
def _(reading: PointCoordinate, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> OutputDerivatives:
    origin, point = body_point(mechanism, reading.origin), body_point(mechanism, reading.point)
    relative_position, relative_velocity, centripetal = _relative_motion(origin, point, poses, velocities)
    direction = origin.rotate_to_global(poses, np.array([reading.direction_x, reading.direction_y]))
    gradient = point.gradient_along(poses, direction) - origin.gradient_along(poses, direction)
    angular_velocity = np.zeros(poses.shape[:-2])
    if origin.body >= 0:  # the direction rotates with its body
        gradient[..., origin.body, 2] += _dot(_perpendicular(direction), relative_position)
        angular_velocity = velocities[..., origin.body, 2]
    quadratic_term = (
        _dot(direction, centripetal)
        + 2 * angular_velocity * _dot(_perpendicular(direction), relative_velocity)
        - angular_velocity**2 * _dot(direction, relative_position)
    )
    return OutputDerivatives(_dot(direction, relative_position) - reading.zero, gradient, quadratic_term)


@evaluate_output_variable.register
def _(reading: FollowerHeight, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> OutputDerivatives:
    top, end = body_point(mechanism, reading.top), body_point(mechanism, reading.knee)
    fraction = reading.fraction

    def interpolate(first: FloatArray, second: FloatArray) -> FloatArray:
        return (1 - fraction) * first + fraction * second

    knee = interpolate(top.position(poses), end.position(poses))
    relative_velocity = interpolate(top.velocity(poses, velocities), end.velocity(poses, velocities))
    centripetal = interpolate(top.centripetal_acceleration(poses, velocities), end.centripetal_acceleration(poses, velocities))
    horizontal_offset = knee[..., 0] - reading.guide_x
    vertical_offset = np.sqrt(np.maximum(reading.length**2 - horizontal_offset**2, 0.0))
    # Beyond the reach of the link there is no height; the limits of the machine end a run before that.
    divisor = np.where(vertical_offset > 0, vertical_offset, np.inf)
    drop_derivative = horizontal_offset / divisor
    drop_second_derivative = (1 + drop_derivative**2) / divisor
    direction = np.stack([drop_derivative, np.ones_like(horizontal_offset)], axis=-1)
    height = knee[..., 1] - vertical_offset
    gradient = interpolate(top.gradient_along(poses, direction), end.gradient_along(poses, direction))
    quadratic_term = _dot(direction, centripetal) + drop_second_derivative * relative_velocity[..., 0] ** 2
    if reading.reference_point is None:
        return OutputDerivatives(height - reading.zero, gradient, quadratic_term)
    other = body_point(mechanism, reading.reference_point)
    vertical = np.broadcast_to(np.array([0.0, 1.0]), direction.shape)
    return OutputDerivatives(
        other.position(poses)[..., 1] - height - reading.zero,
        other.gradient_along(poses, vertical) - gradient,
        other.centripetal_acceleration(poses, velocities)[..., 1] - quadratic_term,
    )


def _relative_motion(
    start: BodyPoint, end: BodyPoint, poses: FloatArray, velocities: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return position (..., 2) and velocity of end relative to start, and the difference of their centripetal accelerations."""
    return (
        end.position(poses) - start.position(poses),
        end.velocity(poses, velocities) - start.velocity(poses, velocities),
        end.centripetal_acceleration(poses, velocities) - start.centripetal_acceleration(poses, velocities),
    )


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    product: FloatArray = np.sum(first * second, axis=-1)
    return product


def _perpendicular(vector: FloatArray) -> FloatArray:
    """Return vectors (..., 2) rotated by 90 degrees counterclockwise."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)
