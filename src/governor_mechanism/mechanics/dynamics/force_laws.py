"""Every force law, written once for all engines. Each takes floats or arrays; SI, radians.

Plane: x from the spindle axis, y up. Loads act at the mass centre; moments are anticlockwise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# Any: one law serves floats in the impulse engine's loop and arrays everywhere else.


def weight(mass: float, gravity: float) -> float:
    """Force along y (N) of uniform gravity (m/s2)."""
    return -mass * gravity


def gravitational_energy(mass: float, gravity: float, y: Any) -> Any:
    """Potential energy (J) at height y (m)."""
    return mass * gravity * y


def centrifugal_force(mass: float, x: Any, speed_squared: Any) -> Any:
    """Force along x (N) on a body whose mass centre is x (m) from the spindle axis."""
    return mass * speed_squared * x


def centrifugal_moment(xx: float, yy: float, xy: float, angle: Any, speed_squared: Any) -> Any:
    """Moment (N m) about the mass centre: second moments (kg m2, body axes) turn a body toward the horizontal."""
    return -0.5 * speed_squared * ((xx - yy) * np.sin(2 * angle) + 2 * xy * np.cos(2 * angle))


def spindle_inertia(mass: float, xx: float, yy: float, xy: float, zz: float, x: Any, angle: Any) -> Any:
    """Moment of inertia (kg m2) of a body about the spindle axis, x (m) away from its mass centre."""
    return mass * x * x + xx * np.cos(angle) ** 2 + yy * np.sin(angle) ** 2 - xy * np.sin(2 * angle) + zz


def spindle_inertia_rate(mass: float, xx: float, yy: float, xy: float, x: Any, angle: Any, x_rate: Any, angular_velocity: Any) -> Any:
    """Rate (kg m2/s) of that inertia for a mass centre moving at x_rate (m/s) and a body turning (rad/s)."""
    return 2 * mass * x * x_rate + ((yy - xx) * np.sin(2 * angle) - 2 * xy * np.cos(2 * angle)) * angular_velocity


def spring_force(stiffness: float, free_length: float, length: Any) -> Any:
    """Pull (N, or N m) of a spring whose length (m, or rad) is `stretch`, and which is at rest at `free`."""
    return stiffness * (length - free_length)


def spring_energy(stiffness: float, free_length: float, length: Any) -> Any:
    """Potential energy (J) of that spring."""
    return 0.5 * stiffness * (length - free_length) ** 2


def damper_force(damping: float, rate: Any) -> Any:
    """Pull (N, or N m) of a damper that grows longer at `rate` (m/s, or rad/s)."""
    return damping * rate


def dashpot_force(linear: float, quadratic: float, rate: Any) -> Any:
    """Pull (N, or N m) of a dashpot whose reading changes at `rate` (m/s, or rad/s)."""
    return (linear + quadratic * abs(rate)) * rate


def free_spindle_speed(momentum: Any, inertia: Any) -> Any:
    """Speed (rad/s) of a free spindle with so much angular momentum (kg m2/s) at so much inertia (kg m2) in all."""
    return momentum / inertia


def spindle_inertia_second_derivative(
    mass: float, second_moments: tuple[float, float, float], x: Any, angle: Any, tangent: Any, second_derivative: Any
) -> Any:
    """Second derivative of that inertia along a path, by the path's two derivatives (..., 3)."""
    xx, yy, xy = second_moments
    angle_derivative = (yy - xx) * np.sin(2 * angle) - 2 * xy * np.cos(2 * angle)
    angle_second_derivative = 2 * (yy - xx) * np.cos(2 * angle) + 4 * xy * np.sin(2 * angle)
    mass_term = 2 * mass * (tangent[..., 0] ** 2 + x * second_derivative[..., 0])
    return mass_term + angle_second_derivative * tangent[..., 2] ** 2 + angle_derivative * second_derivative[..., 2]
