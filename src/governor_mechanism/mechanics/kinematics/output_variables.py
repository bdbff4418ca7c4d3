"""Output variables: value, gradient and velocity-dependent acceleration term of every reading, along whole trajectories."""

import math
from functools import cached_property

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_gamma, evaluate_jacobian, evaluate_residuals
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle, Reading
from governor_mechanism.types import FloatArray

READING_UNITS = {"angle": "rad", "length": "m"}
"""Unit of a reading by its quantity."""


class OutputDerivatives:
    """An output variable and its derivatives at poses (..., bodies, 3), evaluated on demand.

    Parameters
    ----------
    mechanism
        Mechanism with its bodies.
    reading
        Output variable; the mechanism need not list it among its readings.
    poses
        Poses; shape (..., bodies, 3).
    velocities
        Velocities; same shape. Default: zero.
    """

    def __init__(self, mechanism: Mechanism, reading: Reading, poses: FloatArray, velocities: FloatArray | None = None) -> None:
        self._rows = rows_of_readings(mechanism, [reading], {})
        self._shape = poses.shape
        self._poses, self._velocities = (
            np.ascontiguousarray(motion, dtype=np.float64).reshape(-1, *poses.shape[-2:])
            for motion in (poses, np.zeros_like(poses) if velocities is None else velocities)
        )
        self._undriven = np.zeros((len(self._poses), 1, 3))

    @cached_property
    def value(self) -> FloatArray:
        """Value in SI; shape (...)."""
        return evaluate_residuals(self._rows, self._poses, self._undriven).reshape(self._shape[:-2])

    @cached_property
    def gradient(self) -> FloatArray:
        """Derivatives by the poses, in SI per m and per rad; shape (..., bodies, 3)."""
        return evaluate_jacobian(self._rows, self._poses).reshape(self._shape)

    @cached_property
    def quadratic_velocity_term(self) -> FloatArray:
        """Second time derivative minus gradient times accelerations, SI/s2; shape (...)."""
        return -evaluate_gamma(self._rows, self._poses, self._velocities, self._undriven).reshape(self._shape[:-2])

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
    return OutputDerivatives(mechanism, mechanism.reading(name), poses, velocities)


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
