"""Every force law, written once for all engines. Each takes floats or arrays; SI, radians.

Plane: x from the spindle axis, y up. Loads act at the mass centre; moments are anticlockwise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from governor_mechanism.mechanism import SecondMoments

# Any: one law serves floats in the impulse engine's loop and arrays everywhere else.


def weight(mass: float, gravity: float) -> float:
    """Force along y (N) of uniform gravity (m/s2)."""
    return -mass * gravity


def height_energy(mass: float, gravity: float, y: Any) -> Any:
    """Potential energy (J) at height y (m)."""
    return mass * gravity * y


def centrifugal_force(mass: float, x: Any, speed_squared: Any) -> Any:
    """Force along x (N) on a body whose mass centre is x (m) from the spindle axis."""
    return mass * speed_squared * x


def centrifugal_moment(moments: SecondMoments, angle: Any, speed_squared: Any) -> Any:
    """Moment (N m) about the mass centre: the product of inertia turns the body toward the horizontal."""
    difference = moments.xx - moments.yy
    return -0.5 * speed_squared * (difference * np.sin(2 * angle) + 2 * moments.xy * np.cos(2 * angle))


def spindle_inertia(mass: float, moments: SecondMoments, x: Any, angle: Any) -> Any:
    """Moment of inertia (kg m2) of a body about the spindle axis."""
    own = moments.xx * np.cos(angle) ** 2 + moments.yy * np.sin(angle) ** 2 - moments.xy * np.sin(2 * angle)
    return mass * x * x + own + moments.zz


def spindle_inertia_rate(mass: float, moments: SecondMoments, x: Any, angle: Any, x_rate: Any, turning: Any) -> Any:
    """Rate (kg m2/s) of that inertia for a mass centre moving at x_rate (m/s) and a body turning (rad/s)."""
    difference = moments.yy - moments.xx
    own = difference * np.sin(2 * angle) - 2 * moments.xy * np.cos(2 * angle)
    return 2 * mass * x * x_rate + own * turning
