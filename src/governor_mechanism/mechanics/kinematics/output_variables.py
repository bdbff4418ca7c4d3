"""Output variables: value, gradient and velocity-dependent acceleration term of every reading, along whole trajectories."""

import math
from functools import cached_property

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_kernels import (
    ConstraintRows,
    evaluate_gamma,
    evaluate_jacobian,
    evaluate_residuals,
    evaluate_values_and_derivatives,
    evaluate_values_and_rates,
)
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle, Reading
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray

READING_UNITS = {"angle": "rad", "length": "m", "ratio": "1"}
"""Unit of a reading by its quantity."""


class OutputDerivatives:
    """An output variable and its derivatives at poses (..., bodies, 3), evaluated on demand.

    Parameters
    ----------
    row
        Output row of the variable, for poses of the mass centres.
    poses
        Poses; shape (..., bodies, 3).
    velocities
        Velocities; same shape. Default: zero.
    """

    def __init__(self, row: ConstraintRows, poses: FloatArray, velocities: FloatArray | None = None) -> None:
        self._rows = row
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


def evaluate_output(
    mechanism: Mechanism,
    name: str,
    poses: FloatArray,  # poses; shape (..., bodies, 3)
    velocities: FloatArray | None = None,  # velocities; same shape. Default: zero
) -> OutputDerivatives:
    """Evaluate a reading and its derivatives.

    Result: value, gradient and quadratic velocity term.
    """
    return OutputDerivatives(_output_row(mechanism, name), poses, velocities)


def evaluate_readings(
    mechanism: Mechanism,
    poses: FloatArray,  # poses; shape (n, bodies, 3)
    velocities: FloatArray,  # velocities; same shape
) -> tuple[FloatArray, FloatArray]:
    """Evaluate all readings that a mechanism lists, and their rates.

    Results: values, values, SI; shape (readings, n). Angles of lines lie within half a turn; rates, rates,
    SI/s; same shape.
    """
    values, rates = evaluate_values_and_rates(_reading_rows(mechanism), poses, velocities)
    return values.T, rates.T


def evaluate_reading_motions(
    mechanism: Mechanism,
    poses: FloatArray,  # poses; shape (n, bodies, 3)
    velocities: FloatArray,  # their derivatives by time, or by a coordinate; same shape
    accelerations: FloatArray,  # their second derivatives; same shape
) -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
    """Return all readings that a mechanism lists with their first two derivatives, by name.

    Result: values and derivatives, SI; shape (n,). Angles of lines lie within half a turn.
    """
    rows = _reading_rows(mechanism)
    values, rates, second = evaluate_values_and_derivatives(rows, poses, velocities, accelerations)
    return {reading.name: (values[:, k], rates[:, k], second[:, k]) for k, reading in enumerate(mechanism.readings)}


def evaluate_limited_readings(mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Evaluate the readings that the limits of a mechanism bound, in their order, and their rates, as `evaluate_readings` does."""
    values, rates = evaluate_values_and_rates(_limit_rows(mechanism), poses, velocities)
    return values.T, rates.T


@once_per_object
def _limit_rows(mechanism: Mechanism) -> ConstraintRows:
    """Return the output rows of the readings that limits bound."""
    return rows_of_readings(mechanism, [mechanism.reading(limit.reading) for limit in mechanism.limits], {})


@once_per_object
def _reading_rows(mechanism: Mechanism) -> ConstraintRows:
    """Return the output rows of all readings that a mechanism lists."""
    return rows_of_readings(mechanism, mechanism.readings, {})


@once_per_object
def _output_rows_by_name(mechanism: Mechanism) -> dict[str, ConstraintRows]:
    """Return the output row of each reading by name."""
    readings = (*mechanism.internal_outputs, *mechanism.readings)
    return {reading.name: rows_of_readings(mechanism, [reading], {}) for reading in readings}


def _output_row(mechanism: Mechanism, name: str) -> ConstraintRows:
    """Return the output row of a reading. Raise MechanismError if there is no reading of that name."""
    row = _output_rows_by_name(mechanism).get(name)
    return rows_of_readings(mechanism, [mechanism.reading(name)], {}) if row is None else row


def evaluate_output_value(
    mechanism: Mechanism,
    name: str,
    poses: FloatArray,  # poses; shape (..., bodies, 3)
) -> FloatArray:
    """Return the value of a reading.

    Result: value, SI; shape (...).
    """
    return evaluate_output(mechanism, name, poses).value


def wrap_difference(reading: Reading, difference: float) -> float:
    """Return a difference of two values of a reading; that of the angle of a line within half a turn."""
    return math.remainder(difference, math.tau) if isinstance(reading, LineAngle) else difference


def unwrap_output(reading: Reading, values: FloatArray) -> FloatArray:
    """Return the values (..., n) of a reading along motions, continuous over full turns."""
    return np.unwrap(values) if isinstance(reading, LineAngle) else values  # the angle of a body is continuous already
