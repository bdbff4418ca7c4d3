"""Forces along output variables, and event functions of contacts, as compiled kernels.

An output row is a constraint row whose residual is the value of an output variable (see `output_rows`).
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from governor_mechanism.mechanics.dynamics.force_kernels import dashpot_force_jit, spring_force_jit
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows, RowColumn, evaluate_rows
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_input
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
        ("kind", "i8"),
        ("source_index", "i8"),
        ("sign", "f8"),
        ("threshold", "f8"),
        ("tolerance", "f8"),
        ("input_index", "i8"),
        ("contact_index", "i8"),
    ]
)
"""One event function g = sign * quantity - threshold - input. An event is an upward zero crossing of g.

source_index: the output row, or for a force the constraint row that holds the output. tolerance: rounding level
of g. input_index: the input that is subtracted, or -1. contact_index: the contact or one-sided spring concerned.
"""


@jit_internal
def output_rate(output_rows: ConstraintRows, jacobian: FloatArray, k: int, velocities: FloatArray) -> float:
    """Return the rate of an output (m/s or rad/s) from its row of the evaluated output Jacobian."""
    rate = 0.0
    for side in range(2):
        body = output_rows.row_bodies[k, side]
        if body >= 0:
            for c in range(3):
                rate += jacobian[k, side, c] * velocities[body, c]
    return rate


@jit_internal
def add_output_forces(
    output_rows: ConstraintRows,
    output_forces: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    row_values: FloatArray,
    jacobian: FloatArray,
    result: FloatArray,
) -> float:
    """Add the generalised forces of all output forces to result (bodies, 3) and return the power (W) they dissipate."""
    if output_forces.size == 0:
        return 0.0
    evaluate_rows(output_rows, poses, velocities, row_values, jacobian)
    dissipated_power = 0.0
    for i in range(output_forces.size):
        output_force = output_forces[i]
        k = output_force.output_index
        if output_force.kind == OutputForceKind.SPRING:
            force = -spring_force_jit(output_force.a, output_force.b, row_values[k, RowColumn.RESIDUAL])
        else:
            rate = output_rate(output_rows, jacobian, k, velocities)
            resistance = (
                dashpot_force_jit(output_force.a, output_force.b, rate)
                if output_force.kind == OutputForceKind.DASHPOT
                else output_force.a * evaluate_input(input_cubics, output_force.input_index, local_time)
            )
            force = -resistance
            dissipated_power -= force * rate
        for side in range(2):
            body = output_rows.row_bodies[k, side]
            if body >= 0:
                for c in range(3):
                    result[body, c] += force * jacobian[k, side, c]
    return dissipated_power


@jit_internal
def evaluate_multibody_event_functions(
    output_rows: ConstraintRows,
    event_functions: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    multipliers: FloatArray,
    row_values: FloatArray,
    jacobian: FloatArray,
    event_values: FloatArray,
) -> None:
    """Evaluate the event functions of a system at one state.

    Parameters
    ----------
    output_rows
        Output rows of the system.
    event_functions
        Records of `EVENT_FUNCTION_DTYPE`; shape (n,).
    poses
        Poses of the body origins, m and rad; shape (bodies, 3).
    velocities
        Their time derivatives; shape (bodies, 3).
    input_cubics
        Local cubics of all inputs; shape (inputs, 5).
    local_time
        Time since the start of these cubics, s.
    multipliers
        Lagrange multipliers that `evaluate_accelerations` leaves in the workspace, N; shape (rows,).
    row_values
        Workspace; shape (outputs, 5).
    jacobian
        Workspace; shape (outputs, 2, 3).
    event_values
        Result: values of the event functions; shape (n,).
    """
    evaluate_rows(output_rows, poses, velocities, row_values, jacobian)
    for i in range(event_functions.size):
        event_function = event_functions[i]
        if event_function.kind == EventFunctionKind.VALUE:
            value = row_values[event_function.source_index, RowColumn.RESIDUAL]
        elif event_function.kind == EventFunctionKind.RATE:
            value = output_rate(output_rows, jacobian, event_function.source_index, velocities)
        else:
            value = -multipliers[event_function.source_index]
        event_values[i] = (
            event_function.sign * value - event_function.threshold - evaluate_input(input_cubics, event_function.input_index, local_time)
        )


EVENT_SAMPLE_FRACTIONS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Fractions of a step at which the event functions are sampled for upward zero crossings."""
