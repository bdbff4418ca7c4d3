"""Output variables: value, gradient and velocity-dependent acceleration term of every reading, along whole trajectories."""

import math

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows, RowEvaluation
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle, Reading
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray

READING_UNITS = {"angle": "rad", "length": "m", "ratio": "1"}
"""Unit of a reading by its quantity."""


class OutputDerivatives:
    """An output variable and its derivatives at poses (..., bodies, 3).

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
        self._row = RowEvaluation(row, poses, velocities)

    @property
    def value(self) -> FloatArray:
        """Value in SI; shape (...)."""
        return self._row.residuals[..., 0]

    @property
    def gradient(self) -> FloatArray:
        """Derivatives by the poses, in SI per m and per rad; shape (..., bodies, 3)."""
        return self._row.jacobian[..., 0, :, :]

    @property
    def quadratic_velocity_term(self) -> FloatArray:
        """Second time derivative minus gradient times accelerations, SI/s2; shape (...)."""
        return -self._row.gamma[..., 0]

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
    return _evaluate_rows(_select_rows(mechanism, slice(len(mechanism.readings))), poses, velocities)


def evaluate_reading_motions(
    mechanism: Mechanism,
    poses: FloatArray,  # poses; shape (n, bodies, 3)
    velocities: FloatArray,  # their derivatives by time, or by a coordinate; same shape
    accelerations: FloatArray,  # their second derivatives; same shape
) -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
    """Return all readings that a mechanism lists with their first two derivatives, by name.

    Result: values and derivatives, SI; shape (n,). Angles of lines lie within half a turn.
    """
    rows = RowEvaluation(_select_rows(mechanism, slice(len(mechanism.readings))), poses, velocities)
    values, rates, second = rows.residuals, rows.derivatives_along(velocities), rows.derivatives_along(accelerations) - rows.gamma
    return {reading.name: (values[:, k], rates[:, k], second[:, k]) for k, reading in enumerate(mechanism.readings)}


def evaluate_limited_readings(mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Evaluate the readings that the limits of a mechanism bound, in their order, and their rates, as `evaluate_readings` does."""
    indices = [mechanism.reading_index(limit.reading) for limit in mechanism.limits]
    return _evaluate_rows(_select_rows(mechanism, indices), poses, velocities)


def _evaluate_rows(rows: ConstraintRows, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return values and rates (rows, n) at poses and velocities (n, bodies, 3)."""
    evaluated = RowEvaluation(rows, poses)
    return evaluated.residuals.T, evaluated.derivatives_along(velocities).T


@once_per_object
def _output_rows(mechanism: Mechanism) -> ConstraintRows:
    """Return the output rows of all readings, in their order."""
    return rows_of_readings(mechanism, mechanism.all_readings, {})


def _select_rows(mechanism: Mechanism, selected: slice | list[int]) -> ConstraintRows:
    rows = _output_rows(mechanism)
    return rows._replace(table=rows.table[selected], row_bodies=rows.row_bodies[selected])


@once_per_object
def _known_output_rows(_: Mechanism) -> dict[str, ConstraintRows]:
    """Return the output rows of single readings that were asked for, by name."""
    return {}


def _output_row(mechanism: Mechanism, name: str) -> ConstraintRows:
    """Return the output row of a reading. Raise MechanismError if there is no reading of that name."""
    known = _known_output_rows(mechanism)
    if name not in known:
        index = mechanism.reading_index(name)
        known[name] = _select_rows(mechanism, slice(index, index + 1))
    return known[name]


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
