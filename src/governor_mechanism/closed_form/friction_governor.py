"""A friction governor: weights on a shaft press on a fixed drum from a speed on, and its friction balances the driving torque.

The mass centres keep their radius while the weights press; springs hold them up to the speed at which they begin to. SI, rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument, validate_fields
from governor_mechanism.types import FloatOrArray


@dataclass(frozen=True, kw_only=True)
class FrictionGovernor:
    """A friction governor. MechanismError is raised unless all values are positive.

    Attributes
    ----------
    weights
        Number of weights.
    mass
        Mass of a weight, kg.
    radius
        Radius of the mass centre of a weight that presses, m.
    drum
        Radius at which the weights rub, m.
    friction
        Coefficient of friction.
    rubbing_speed
        Speed from which on they press, rad/s.
    """

    weights: int
    mass: float
    radius: float
    drum: float
    friction: float
    rubbing_speed: float

    def __post_init__(self) -> None:
        """Validate the values."""
        units = {"weights": "1", "mass": "kg", "radius": "m", "drum": "m", "friction": "1", "rubbing_speed": "rad/s"}
        validate_fields(self, units, minimum=0.0)
        for name, unit in units.items():
            validate_argument(getattr(self, name), name, unit, greater_than=0.0)

    @property
    def torque_coefficient(self) -> float:
        """Braking torque over the excess of the squared speed, kg m2: weights x friction x mass x radius x drum radius."""
        return self.weights * self.friction * self.mass * self.radius * self.drum


def braking_torque(governor: FrictionGovernor, *, speed: FloatOrArray) -> FloatOrArray:
    """Return the torque of the friction on the shaft.

    Parameters
    ----------
    governor
        The governor.
    speed
        Speed of the shaft, rad/s.

    Returns
    -------
    float or ndarray
        Torque against the rotation, N m; 0 below the speed at which the weights begin to press.
    """
    excess = np.asarray(validate_argument(speed, "speed", "rad/s")) ** 2 - governor.rubbing_speed**2
    return as_scalar_or_array(governor.torque_coefficient * np.maximum(excess, 0.0))


def steady_speed(governor: FrictionGovernor, *, torque: float) -> float:
    """Return the speed at which the friction balances a driving torque.

    Parameters
    ----------
    governor
        The governor.
    torque
        Driving torque, N m.

    Returns
    -------
    float
        Speed, rad/s.
    """
    validate_argument(torque, "torque", "N m", greater_than=0.0)
    return math.sqrt(governor.rubbing_speed**2 + torque / governor.torque_coefficient)


def speed_at(governor: FrictionGovernor, *, time: FloatOrArray, torque: float, inertia: float) -> FloatOrArray:
    """Return the speed of a shaft that a constant torque drives, from the time on at which the weights begin to press.

    Parameters
    ----------
    governor
        The governor.
    time
        Time since then, s.
    torque
        Driving torque, N m.
    inertia
        Moment of inertia of shaft and weights about the axis, kg m2.

    Returns
    -------
    float or ndarray
        Speed, rad/s: a hyperbolic tangent of the time.
    """
    validate_argument(inertia, "inertia", "kg m2", greater_than=0.0)
    end = steady_speed(governor, torque=torque)
    elapsed = np.asarray(validate_argument(time, "time", "s"))
    rate = governor.torque_coefficient * end / inertia
    return as_scalar_or_array(end * np.tanh(rate * elapsed + math.atanh(governor.rubbing_speed / end)))
