"""Readings with limits, whose values and rates the steps of an integration check; compiled."""

from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.inputs import output_rate
from governor_mechanism.mechanics.dynamics.system.arrays import StateLayout
from governor_mechanism.mechanics.dynamics.system.reference_points import body_reference_point
from governor_mechanism.mechanics.kinematics.constraint_kernels import N_ROW_COLUMNS, ConstraintRows, RowColumn, evaluate_rows
from governor_mechanism.mechanics.kinematics.output_rows import make_output_rows
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray


class LimitRows(NamedTuple):
    """Readings with limits.

    Attributes
    ----------
    rows
        Output rows of the readings.
    bounds
        Low and high limit of each, SI; shape (readings, 2).
    row_values
        Buffer; shape (readings, 5).
    jacobian
        Buffer; shape (readings, 2, 3).
    start_values, end_values, sample_values
        Buffers: value and rate of each reading at the start, the end and inside of a step, SI; shape (readings, 2).
    """

    rows: ConstraintRows
    bounds: FloatArray
    row_values: FloatArray
    jacobian: FloatArray
    start_values: FloatArray
    end_values: FloatArray
    sample_values: FloatArray


def make_limit_rows(mechanism: Mechanism, is_empty: bool = False) -> LimitRows:
    """Return the limits of a mechanism for poses of its body origins."""
    limits = () if is_empty else mechanism.limits
    origins = {body.name: body_reference_point(mechanism, body) for body in mechanism.bodies}
    n = len(limits)
    return LimitRows(
        rows=make_output_rows(mechanism, [limit.reading for limit in limits], origins),
        bounds=np.array([(limit.low, limit.high) for limit in limits], dtype=np.float64).reshape(n, 2),
        row_values=np.zeros((n, N_ROW_COLUMNS)),
        jacobian=np.zeros((n, 2, 3)),
        start_values=np.zeros((n, 2)),
        end_values=np.zeros((n, 2)),
        sample_values=np.zeros((n, 2)),
    )


@jit_in_place
def evaluate_limit_rows(limits: LimitRows, layout: StateLayout, state: FloatArray, values: FloatArray) -> None:
    """Fill the value and the rate (readings, 2) of each reading in a state."""
    poses, velocities = state[: layout.velocities].reshape(-1, 3), state[layout.velocities : layout.work].reshape(-1, 3)
    evaluate_rows(limits.rows, poses, velocities, limits.row_values, limits.jacobian)
    for i in range(values.shape[0]):
        values[i, 0] = limits.row_values[i, RowColumn.RESIDUAL]
        values[i, 1] = output_rate(limits.rows, limits.jacobian, i, velocities)
