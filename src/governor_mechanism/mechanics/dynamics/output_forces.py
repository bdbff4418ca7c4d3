"""Forces along output variables as compiled kernels, and records of the event functions of contacts.

An output row is a constraint row whose residual is the value of an output variable (see `output_rows`).
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from governor_mechanism.mechanics.dynamics.force_kernels import dashpot_force_jit, spring_force_jit
from governor_mechanism.mechanics.dynamics.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows, RowColumn
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, RecordArray


class OutputForceKind(IntEnum):
    """Kind of an output force.

    The coefficients (a, b) are: rate and free value of a spring; linear and quadratic coefficient of a dashpot; sign of
    sliding and 0 for Coulomb friction.
    """

    SPRING = 0
    DASHPOT = 1
    FRICTION = 2


OUTPUT_FORCE_DTYPE = np.dtype([("kind", "i8"), ("output_index", "i8"), ("a", "f8"), ("b", "f8"), ("input_index", "i8")])
"""One force along an output row: kind, index of the row, coefficients a and b, and the input of a friction force, or -1."""


class EventFunctionKind(IntEnum):
    """Quantity of an event function: value or rate of an output, or force of the constraint row that holds it."""

    VALUE = 0
    RATE = 1
    FORCE = 2


EVENT_FUNCTION_DTYPE = np.dtype(
    [
        *((name, "i8") for name in ("kind", "source_index")),
        *((name, "f8") for name in ("sign", "threshold", "tolerance")),
        *((name, "i8") for name in ("input_index", "contact_index")),
    ]
)
"""One event function g = sign * quantity - threshold - input. An event is an upward zero crossing of g.

source_index: the output row, or for a force the constraint row that holds the output. tolerance: rounding level
of g. input_index: the input that is subtracted, or -1. contact_index: the contact or one-sided spring concerned.
"""


@jit_internal
def add_output_forces(
    output_rows: ConstraintRows,
    output_forces: RecordArray,
    velocities: FloatArray,
    inputs: FloatArray,
    row_values: FloatArray,
    jacobian: FloatArray,
    result: FloatArray,
) -> float:
    """Add the generalised forces of all output forces to result (bodies, 3) and return the power (W) they dissipate.

    The output rows were evaluated at the state.
    """
    dissipated_power = 0.0
    for i in range(output_forces.size):
        output_force = output_forces[i]
        k = output_force.output_index
        if output_force.kind == OutputForceKind.SPRING:
            force = -spring_force_jit(output_force.a, output_force.b, row_values[k, RowColumn.RESIDUAL])
        else:
            rate = output_rate(output_rows, jacobian, k, velocities)
            if output_force.kind == OutputForceKind.DASHPOT:
                force = -dashpot_force_jit(output_force.a, output_force.b, rate)
            else:
                force = -(output_force.a * inputs[output_force.input_index])
            dissipated_power -= force * rate
        for side in range(2):
            body = output_rows.row_bodies[k, side]
            if body >= 0:
                for c in range(3):
                    result[body, c] += force * jacobian[k, side, c]
    return dissipated_power


EVENT_SAMPLE_FRACTIONS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Fractions of a step at which the event functions are sampled for upward zero crossings."""
