"""Scalar force laws, each written once for all engines.

They take floats or arrays, in SI units and radians. The x axis points away from the spindle axis, y points up. Forces
act at the mass centre; moments are positive anticlockwise.
"""

from typing import Any

import numpy as np

# Any: the same law takes floats in the loops of the impulse engine and arrays elsewhere.


def weight(
    mass: float,  # mass, kg
    gravity: float,  # gravitational acceleration, m/s2
) -> float:
    """Return the force of gravity on a body (N)."""
    return -mass * gravity


def gravitational_energy(
    mass: Any,  # mass, kg
    gravity: Any,  # gravitational acceleration, m/s2
    y: Any,  # height of the mass centre, m
) -> Any:
    """Return the gravitational potential energy (J) of a body, zero at y = 0."""
    return mass * gravity * y


def centrifugal_force(
    mass: float,  # mass, kg
    x: Any,  # distance of the mass centre from the spindle axis, m
    speed_squared: Any,
) -> Any:
    """Return the centrifugal force on a body (N)."""
    return mass * speed_squared * x


def centrifugal_moment(
    xx: float,  # second moment of mass along the body's x axis, kg m2
    yy: float,  # second moment of mass along the body's y axis, kg m2
    xy: float,  # mixed second moment of mass in body axes, kg m2
    angle: Any,  # angle of the body axes, rad
    speed_squared: Any,
) -> Any:
    """Return the centrifugal moment on a body about its mass centre; it turns the longer principal axis toward the horizontal."""
    return -0.5 * speed_squared * ((xx - yy) * np.sin(2 * angle) + 2 * xy * np.cos(2 * angle))


def spindle_inertia(
    mass: Any,  # mass, kg
    xx: Any,  # second moment of mass along the body's x axis, kg m2
    yy: Any,  # second moment of mass along the body's y axis, kg m2
    xy: Any,  # mixed second moment of mass in body axes, kg m2
    zz: Any,  # second moment of mass out of the plane, kg m2
    x: Any,  # distance of the mass centre from the spindle axis, m
    angle: Any,  # angle of the body axes, rad
) -> Any:
    """Return the moment of inertia of a body about the spindle axis (kg m2)."""
    return mass * x * x + xx * np.cos(angle) ** 2 + yy * np.sin(angle) ** 2 - xy * np.sin(2 * angle) + zz


def spindle_inertia_rate(
    mass: Any,  # mass, kg
    xx: Any,  # second moment of mass along the body's x axis, kg m2
    yy: Any,  # second moment of mass along the body's y axis, kg m2
    xy: Any,  # mixed second moment of mass in body axes, kg m2
    x: Any,  # distance of the mass centre from the spindle axis, m
    angle: Any,  # angle of the body axes, rad
    x_rate: Any,  # rate of x, m/s
    angular_velocity: Any,  # rate of the angle, rad/s
) -> Any:
    """Return the time derivative of the moment of inertia of a body about the spindle axis (kg m2/s)."""
    return 2 * mass * x * x_rate + ((yy - xx) * np.sin(2 * angle) - 2 * xy * np.cos(2 * angle)) * angular_velocity


def spindle_inertia_second_derivative(
    mass: float, second_moments: tuple[float, float, float], x: Any, angle: Any, tangent: tuple[Any, Any], curvature: tuple[Any, Any]
) -> Any:
    """Return the second derivative (kg m2 per squared unit) of the spindle inertia along a path.

    `tangent` and `curvature` are the first and second derivatives of x and the angle along the path.
    """
    xx, yy, xy = second_moments
    angle_derivative = (yy - xx) * np.sin(2 * angle) - 2 * xy * np.cos(2 * angle)
    angle_second_derivative = 2 * (yy - xx) * np.cos(2 * angle) + 4 * xy * np.sin(2 * angle)
    mass_term = 2 * mass * (tangent[0] ** 2 + x * curvature[0])
    return mass_term + angle_second_derivative * tangent[1] ** 2 + angle_derivative * curvature[1]
