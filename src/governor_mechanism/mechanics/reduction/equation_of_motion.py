"""Equation of motion q'' = f(q, q', t) of the reduced model, and the rates of its quadrature states; compiled."""

from __future__ import annotations

from typing import NamedTuple

from governor_mechanism.mechanics.dynamics.force_kernels import dashpot_force_jit, free_spindle_speed_jit, spring_force_jit
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_input, fluctuating_speed_jit
from governor_mechanism.mechanics.reduction.lowering import ForceParameter, ReducedForces
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.table import PiecewiseTable
from governor_mechanism.numerics.chebyshev import evaluate_piece, evaluate_piece_derivative
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, IntArray

N_QUADRATURES = 3
"""Number of quadrature states: work (J) as in `StateHistory`, its dissipated part (J) and the spindle angle (rad).

The equation of motion does not depend on them.
"""

MODE_HELD = 0
"""Index in a mode (1 + contacts + springs,) of whether the mechanism is held at rest.

After it follow the state of each contact (1, -1, 0 or HELD, see `mechanics.contact.rules`) and whether each one-sided spring is taut.
"""


class ReducedModel(NamedTuple):
    """The motion table and the forces along it, in few arrays; see `PiecewiseTable` and `ReducedForces`.

    Attributes
    ----------
    coefficients
        As in `PiecewiseTable`.
    intervals
        As in `PiecewiseTable`.
    neighbours
        As in `PiecewiseTable`.
    periodicity
        As in `PiecewiseTable`.
    parameters
        As in `ReducedForces`.
    one_sided_springs
        As in `ReducedForces`.
    output_dampers
        As in `ReducedForces`.
    contacts
        As in `ReducedForces`.
    input_cubics
        Cubics of the inputs in local time, highest power first, then the integral at local time 0; shape (inputs, 5).
    mode
        Contact mode; see `MODE_HELD`; shape (1 + contacts + one-sided springs,).
    """

    coefficients: FloatArray
    intervals: FloatArray
    neighbours: IntArray
    periodicity: FloatArray
    parameters: FloatArray
    one_sided_springs: FloatArray
    output_dampers: FloatArray
    contacts: FloatArray
    input_cubics: FloatArray
    mode: IntArray


def make_reduced_model(table: PiecewiseTable, forces: ReducedForces, input_cubics: FloatArray, mode: IntArray) -> ReducedModel:
    """Combine a table, its forces and the inputs to a reduced model.

    Parameters
    ----------
    table
        The motion table.
    forces
        The forces along the coordinate.
    input_cubics
        Inputs from the local time 0 on; shape (inputs, 5).
    mode
        Contact mode; see `MODE_HELD`.

    Returns
    -------
    ReducedModel
        The arrays that the kernels read.
    """
    return ReducedModel(table.coefficients, table.intervals, table.neighbours, table.periodicity, *forces, input_cubics, mode)


@jit_internal
def evaluate_spindle(
    parameters: FloatArray, input_cubics: FloatArray, local_time: float, bodies_inertia: float
) -> tuple[float, float, float]:
    """Return the spindle speed (rad/s), the given acceleration (rad/s2), and the torque (N m) on a free spindle.

    input_cubics[0] is the given speed, or the torque on a free spindle; the integral of the torque, with the initial momentum, is the
    angular momentum.
    """
    a, b, c, d = input_cubics[0, 0], input_cubics[0, 1], input_cubics[0, 2], input_cubics[0, 3]
    value = ((a * local_time + b) * local_time + c) * local_time + d
    integral = input_cubics[0, 4] + (((0.25 * a * local_time + b / 3.0) * local_time + 0.5 * c) * local_time + d) * local_time
    if parameters[ForceParameter.IS_SPINDLE_FREE] != 0.0:
        return free_spindle_speed_jit(integral, parameters[ForceParameter.FREE_SPINDLE_INERTIA] + bodies_inertia), 0.0, value
    derivative = (3.0 * a * local_time + 2.0 * b) * local_time + c
    if parameters[ForceParameter.FLUCTUATION_AMPLITUDE] == 0.0:
        return value, derivative, 0.0
    speed, acceleration = fluctuating_speed_jit(
        parameters[ForceParameter.FLUCTUATION_AMPLITUDE], parameters[ForceParameter.CYCLES_PER_TURN], integral, value, derivative
    )
    return speed, acceleration, 0.0


@jit_internal
def evaluate_acceleration(
    model: ReducedModel, piece: int, t: float, v: float, local_time: float, with_friction: bool, quadrature_rates: FloatArray, stage: int
) -> float:
    """Evaluate the acceleration of the coordinate from all forces, and the rates of the quadrature states.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    v
        Rate of the coordinate.
    local_time
        Time since the inputs' cubics begin, s.
    with_friction
        Whether friction of sliding contacts is included.
    quadrature_rates
        Row `stage` is filled with the rates of the quadrature states; shape (stages, 3).
    stage
        Row to fill.

    Returns
    -------
    float
        Acceleration q''.
    """
    coefficients, parameters, mode = model.coefficients, model.parameters, model.mode
    inverse_inertia, spindle_inertia = (
        evaluate_piece(coefficients, piece, TableColumn.INVERSE_INERTIA, t),
        evaluate_piece(coefficients, piece, TableColumn.SPINDLE_INERTIA, t),
    )
    damping = evaluate_piece(coefficients, piece, TableColumn.DAMPING, t)
    omega, spindle_acceleration, torque = evaluate_spindle(parameters, model.input_cubics, local_time, spindle_inertia)
    acceleration = (
        evaluate_piece(coefficients, piece, TableColumn.QUADRATIC, t) * v * v
        + evaluate_piece(coefficients, piece, TableColumn.POTENTIAL, t)
        + damping * v
    )
    acceleration += evaluate_piece(coefficients, piece, TableColumn.CENTRIFUGAL, t) * omega * omega
    power, dissipated_power = damping * v * v / inverse_inertia, 0.0
    column: int = TableColumn.FIRST_PROGRAM
    for program in range(1, 1 + int(parameters[ForceParameter.PROGRAM_COUNT])):
        programmed_acceleration = evaluate_input(model.input_cubics, program, local_time) * evaluate_piece(coefficients, piece, column, t)
        acceleration += programmed_acceleration
        power += programmed_acceleration * v / inverse_inertia
        column += 1
    for i in range(model.one_sided_springs.shape[0]):
        if mode[1 + model.contacts.shape[0] + i] != 0:
            output_column = column + 2 * int(model.one_sided_springs[i, 0])
            force = spring_force_jit(
                model.one_sided_springs[i, 1], model.one_sided_springs[i, 2], evaluate_piece(coefficients, piece, output_column, t)
            )
            acceleration -= force * evaluate_piece(coefficients, piece, output_column + 1, t) * inverse_inertia
    for i in range(model.output_dampers.shape[0]):
        output_derivative = evaluate_piece(coefficients, piece, column + 2 * int(model.output_dampers[i, 0]) + 1, t)
        force = dashpot_force_jit(model.output_dampers[i, 1], model.output_dampers[i, 2], output_derivative * v)
        acceleration -= force * output_derivative * inverse_inertia
        dissipated_power += force * output_derivative * v
    for i in range(model.contacts.shape[0] if with_friction else 0):
        if mode[1 + i] != 0:
            output_derivative = evaluate_piece(coefficients, piece, column + 2 * int(model.contacts[i, 0]) + 1, t)
            force = mode[1 + i] * evaluate_input(model.input_cubics, int(model.contacts[i, 1]), local_time)
            acceleration -= force * output_derivative * inverse_inertia
            dissipated_power += force * output_derivative * v
    quadrature_rates[stage, 0] = dissipated_power - power - torque * omega
    if spindle_acceleration != 0.0 and parameters[ForceParameter.IS_SPINDLE_LOADED] != 0.0:
        quadrature_rates[stage, 0] += spindle_inertia * omega * spindle_acceleration
    quadrature_rates[stage, 1], quadrature_rates[stage, 2] = dissipated_power, omega
    return float(acceleration)


@jit_internal
def evaluate_equation_of_motion(
    model: ReducedModel, piece: int, t: float, v: float, local_time: float, quadrature_rates: FloatArray, stage: int
) -> float:
    """Evaluate the acceleration of the coordinate; zero while the mechanism is held.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    v
        Rate of the coordinate.
    local_time
        Time since the inputs' cubics begin, s.
    quadrature_rates
        Row `stage` is filled with the rates of the quadrature states, unless the model is conservative; shape (stages, 3).
    stage
        Row to fill.

    Returns
    -------
    float
        Acceleration q''.
    """
    if model.parameters[ForceParameter.IS_CONSERVATIVE] != 0.0:
        return evaluate_piece(model.coefficients, piece, TableColumn.QUADRATIC, t) * v * v + evaluate_piece(
            model.coefficients, piece, TableColumn.POTENTIAL, t
        )
    acceleration = evaluate_acceleration(model, piece, t, v, local_time, True, quadrature_rates, stage)
    return 0.0 if model.mode[MODE_HELD] != 0 else acceleration


@jit_internal
def evaluate_table_output(model: ReducedModel, piece: int, t: float, output_index: float) -> tuple[float, float]:
    """Evaluate an output from the table.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    output_index
        Index of the output.

    Returns
    -------
    value : float
        Value of the output.
    derivative : float
        Its derivative by the coordinate.
    """
    column = TableColumn.FIRST_PROGRAM + int(model.parameters[ForceParameter.PROGRAM_COUNT]) + 2 * int(output_index)
    return evaluate_piece(model.coefficients, piece, column, t), evaluate_piece(model.coefficients, piece, column + 1, t)


@jit_internal
def evaluate_output_second_derivative(model: ReducedModel, piece: int, t: float, output_index: float) -> float:
    """Return the second derivative of an output by the coordinate, at the local coordinate t of a table piece."""
    column = TableColumn.FIRST_PROGRAM + int(model.parameters[ForceParameter.PROGRAM_COUNT]) + 2 * int(output_index) + 1
    return float(evaluate_piece_derivative(model.coefficients, piece, column, t) * model.intervals[piece, 3])


@jit_internal
def evaluate_friction_limit(model: ReducedModel, piece: int, t: float, local_time: float) -> float:
    """Evaluate the generalised force up to which friction can hold the mechanism.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    local_time
        Time since the inputs' cubics begin, s.

    Returns
    -------
    float
        Sum of the friction forces along the coordinate.
    """
    total = 0.0
    for i in range(model.contacts.shape[0]):
        if model.contacts[i, 1] >= 0:
            output_derivative = evaluate_table_output(model, piece, t, model.contacts[i, 0])[1]
            total += evaluate_input(model.input_cubics, int(model.contacts[i, 1]), local_time) * abs(output_derivative)
    return float(total)


@jit_internal
def evaluate_static_force(model: ReducedModel, piece: int, t: float, local_time: float, quadrature_rates: FloatArray) -> float:
    """Evaluate the generalised force at zero rate, without friction.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    local_time
        Time since the inputs' cubics begin, s.
    quadrature_rates
        Buffer; shape (1, 3).

    Returns
    -------
    float
        Force along the coordinate.
    """
    return float(
        evaluate_acceleration(model, piece, t, 0.0, local_time, False, quadrature_rates, 0)
        / evaluate_piece(model.coefficients, piece, TableColumn.INVERSE_INERTIA, t)
    )
