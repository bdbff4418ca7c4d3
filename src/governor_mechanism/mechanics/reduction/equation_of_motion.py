"""Equations of motion of the reduced model, one coordinate q and one shaft, and the rates of work and dissipation; compiled."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.dynamics.inputs import InputTermKind, add_input_term
from governor_mechanism.mechanics.dynamics.output_forces import IN_NO_PHASE, evaluate_force_law, evaluate_gas_phase
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_given_speed, evaluate_input
from governor_mechanism.mechanics.reduction.lowering import COORDINATE, ForceParameter, OutputForceColumn, ReducedForces
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.shaft_outputs import ShaftOutputs, evaluate_shaft_outputs
from governor_mechanism.mechanics.reduction.table import PiecewiseTable
from governor_mechanism.numerics.chebyshev import evaluate_piece, evaluate_piece_derivative
from governor_mechanism.numerics.jit import jit, jit_in_place
from governor_mechanism.types import FloatArray, IntArray, RecordArray


class StateIndex(IntEnum):
    """Indices in a state of the reduced model."""

    COORDINATE = 0
    RATE = 1
    WORK = 2
    """Work as in `StateHistory`, J."""
    DISSIPATED_ENERGY = 3
    """The dissipated part of the work, J."""
    SHAFT_ANGLE = 4
    """Angle of the shaft, rad; constant without one."""
    SHAFT_SPEED = 5
    """Its rate, rad/s."""


N_STATES = len(StateIndex)
"""Number of states."""

N_FURTHER_STATES = N_STATES - 2
"""Number of states after the coordinate and its rate, which a conservative model has none of."""

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
    output_forces
        As in `ReducedForces`.
    contacts
        As in `ReducedForces`.
    shaft_torques
        As in `ReducedForces`.
    shaft_forces
        As in `ReducedForces`.
    shaft_outputs
        As in `ReducedForces`.
    kinks
        As in `ReducedForces`.
    table_segments
        As in `ReducedForces`.
    input_terms
        As in `ReducedForces`.
    inputs
        As in `ReducedForces`.
    input_cubics
        Cubics of the inputs in local time, highest power first, then the integral at local time 0; shape (inputs, 5).
    mode
        Contact mode, see `MODE_HELD`; then the segment of each table, which kinks are monitored, and the phase of each gas; shape
        (1 + contacts + one-sided springs + tables + kinks + gases,).
    """

    coefficients: FloatArray
    intervals: FloatArray
    neighbours: IntArray
    periodicity: FloatArray
    parameters: FloatArray
    one_sided_springs: FloatArray
    output_forces: FloatArray
    contacts: RecordArray
    shaft_torques: FloatArray
    shaft_forces: FloatArray
    shaft_outputs: ShaftOutputs
    kinks: RecordArray
    table_segments: RecordArray
    input_terms: RecordArray
    inputs: FloatArray
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


@jit_in_place
def evaluate_model_inputs(model: ReducedModel, piece: int, t: float, shaft_angle: float, shaft_speed: float, local_time: float) -> None:
    """Evaluate the inputs of the model in a state.

    Parameters
    ----------
    model
        The reduced model; its `inputs` are filled.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    shaft_angle
        Angle of the shaft, rad.
    shaft_speed
        Its rate, rad/s.
    local_time
        Time since the inputs' cubics begin, s.
    """
    evaluate_shaft_outputs(model.shaft_outputs, shaft_angle)
    for k in range(1, model.inputs.size):
        model.inputs[k] = evaluate_input(model.input_cubics, k, local_time)
    for i in range(model.input_terms.size):
        term, source = model.input_terms[i], 0.0
        if term.kind == InputTermKind.RATE:
            source = evaluate_output(model, piece, t, term.source_index)[1] * shaft_speed
        elif term.kind != InputTermKind.PRODUCT and term.kind != InputTermKind.NOT_NEGATIVE:
            source = evaluate_output(model, piece, t, term.source_index)[0]
        add_input_term(model.input_terms, i, source, model.inputs)


@jit_in_place
def evaluate_acceleration(
    model: ReducedModel,
    piece: int,
    t: float,
    v: float,
    shaft_angle: float,
    shaft_speed: float,
    local_time: float,
    with_friction: bool,
    further_rates: FloatArray,
    stage: int,
) -> float:
    """Evaluate the acceleration of the coordinate from all forces, and the rates of the further states.

    With the ratio r of spindle to shaft, the inertia J of the bodies in the turning plane and the inertia S of all else that turns,
    (S + r^2 J) W' = torque - r^2 J' q' W for the speed W of the shaft; without reaction S W' = torque.

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
    shaft_angle
        Angle of the shaft, rad.
    shaft_speed
        Its rate, rad/s.
    local_time
        Time since the inputs' cubics begin, s.
    with_friction
        Whether friction of sliding contacts is included.
    further_rates
        Column `stage` is filled with the rates of the further states; shape (N_FURTHER_STATES, stages).
    stage
        Column to fill.

    Returns
    -------
    float
        Acceleration q''.
    """
    coefficients, parameters, mode, inputs = model.coefficients, model.parameters, model.mode, model.inputs
    evaluate_model_inputs(model, piece, t, shaft_angle, shaft_speed, local_time)
    inverse_inertia = evaluate_piece(coefficients, piece, TableColumn.INVERSE_INERTIA, t)
    spindle_inertia = evaluate_piece(coefficients, piece, TableColumn.SPINDLE_INERTIA, t)
    damping = evaluate_piece(coefficients, piece, TableColumn.DAMPING, t)
    centrifugal = evaluate_piece(coefficients, piece, TableColumn.CENTRIFUGAL, t)
    power, dissipated_power = damping * v * v / inverse_inertia, 0.0
    ratio, shaft_acceleration = parameters[ForceParameter.SPINDLE_RATIO], 0.0
    if parameters[ForceParameter.HAS_SHAFT] != 0.0:
        shaft_inertia, torque = parameters[ForceParameter.SHAFT_INERTIA], -parameters[ForceParameter.SHAFT_DAMPING] * shaft_speed
        for i in range(model.shaft_torques.shape[0]):
            torque += inputs[int(model.shaft_torques[i, 0])] * model.shaft_torques[i, 1]
        power += torque * shaft_speed
        for i in range(model.shaft_forces.shape[0]):
            gas = model.shaft_forces[i]
            travel, travel_derivative = evaluate_output(model, piece, t, gas[OutputForceColumn.OUTPUT])
            gas_torque = evaluate_force(model, gas, piece, t, travel, 0.0) * travel_derivative
            torque += gas_torque
            if gas[OutputForceColumn.INPUT] >= 0.0:
                power += gas_torque * shaft_speed
        if parameters[ForceParameter.HAS_REACTION] != 0.0:
            shaft_inertia += ratio * ratio * spindle_inertia
            torque -= 2.0 * ratio * ratio * centrifugal / inverse_inertia * v * shaft_speed
        shaft_acceleration = torque / shaft_inertia
    omega, spindle_acceleration = ratio * shaft_speed, ratio * shaft_acceleration
    if ratio == 0.0:
        amplitude, cycles_per_turn = parameters[ForceParameter.FLUCTUATION_AMPLITUDE], parameters[ForceParameter.CYCLES_PER_TURN]
        omega, spindle_acceleration = evaluate_given_speed(model.input_cubics, 0, local_time, amplitude, cycles_per_turn)
    quadratic = evaluate_piece(coefficients, piece, TableColumn.QUADRATIC, t)
    potential = evaluate_piece(coefficients, piece, TableColumn.POTENTIAL, t)
    acceleration = quadratic * v * v + potential + damping * v + centrifugal * omega * omega
    column: int = TableColumn.FIRST_LOAD
    first_load = int(parameters[ForceParameter.FIRST_LOAD_INPUT])
    for load in range(first_load, first_load + int(parameters[ForceParameter.LOAD_COUNT])):
        load_acceleration = inputs[load] * evaluate_piece(coefficients, piece, column, t)
        acceleration += load_acceleration
        power += load_acceleration * v / inverse_inertia
        column += 1
    for i in range(model.output_forces.shape[0]):
        output_force = model.output_forces[i]
        mode_index = int(output_force[OutputForceColumn.MODE])
        if mode_index < 0 or mode[mode_index] != 0:
            value, output_derivative = evaluate_table_output(model, piece, t, output_force[OutputForceColumn.OUTPUT])
            force = evaluate_force(model, output_force, piece, t, value, output_derivative * v)
            if output_force[OutputForceColumn.INPUT] >= 0.0:
                power += force * output_derivative * v
            acceleration += force * output_derivative * inverse_inertia
            dissipated_power -= output_force[OutputForceColumn.DISSIPATES] * force * output_derivative * v
    for i in range(model.contacts.shape[0] if with_friction else 0):
        if mode[1 + i] != 0:
            output_derivative = evaluate_table_output(model, piece, t, model.contacts[i].output_index)[1]
            force = mode[1 + i] * friction_limit(model, i)
            acceleration -= force * output_derivative * inverse_inertia
            dissipated_power += force * output_derivative * v
    work_rate = dissipated_power - power
    if parameters[ForceParameter.IS_SPINDLE_LOADED] != 0.0 and parameters[ForceParameter.HAS_REACTION] == 0.0:
        work_rate += spindle_inertia * omega * spindle_acceleration
    further_rates[0, stage], further_rates[1, stage] = work_rate, dissipated_power
    further_rates[2, stage], further_rates[3, stage] = shaft_speed, shaft_acceleration
    return float(acceleration)


@jit_in_place
def evaluate_force(model: ReducedModel, force: FloatArray, piece: int, t: float, value: float, rate: float) -> float:
    """Evaluate a force along an output, from the inputs and outputs of the shaft as last evaluated.

    Parameters
    ----------
    model
        The reduced model.
    force
        Its row of `ReducedForces.output_forces` or `shaft_forces`; shape (columns,).
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    value
        Value of the output.
    rate
        Its rate.

    Returns
    -------
    float
        Force, N or N m.
    """
    argument, phase_index = rate, int(force[OutputForceColumn.PHASE])
    coefficients, factor = force[OutputForceColumn.FIRST_COEFFICIENT :], int(force[OutputForceColumn.INPUT])
    if phase_index >= 0:
        argument = float(model.mode[phase_index])
        if argument == IN_NO_PHASE:
            argument = evaluate_gas_phase(coefficients, value, evaluate_output(model, piece, t, force[OutputForceColumn.CRANK_ANGLE])[0])
    result = evaluate_force_law(int(force[OutputForceColumn.LAW]), coefficients, value, argument)
    return float(result * model.inputs[factor] if factor >= 0 else result)


@jit_in_place
def friction_limit(model: ReducedModel, k: int) -> float:
    """Return the friction force of a contact, or 0 without friction, from the inputs as last evaluated."""
    friction_input = int(model.contacts[k].friction_input)
    return float(model.inputs[friction_input]) if friction_input >= 0 else 0.0


@jit_in_place
def evaluate_equation_of_motion(
    model: ReducedModel,
    piece: int,
    t: float,
    v: float,
    shaft_angle: float,
    shaft_speed: float,
    local_time: float,
    further_rates: FloatArray,
    stage: int,
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
    shaft_angle
        Angle of the shaft, rad.
    shaft_speed
        Its rate, rad/s.
    local_time
        Time since the inputs' cubics begin, s.
    further_rates
        Column `stage` is filled with the rates of the further states, unless the model is conservative; shape (N_FURTHER_STATES, stages).
    stage
        Column to fill.

    Returns
    -------
    float
        Acceleration q''.
    """
    if model.parameters[ForceParameter.IS_CONSERVATIVE] != 0.0:
        return evaluate_piece(model.coefficients, piece, TableColumn.QUADRATIC, t) * v * v + evaluate_piece(
            model.coefficients, piece, TableColumn.POTENTIAL, t
        )
    acceleration = evaluate_acceleration(model, piece, t, v, shaft_angle, shaft_speed, local_time, True, further_rates, stage)
    return 0.0 if model.mode[MODE_HELD] != 0 else acceleration


@jit_in_place
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
    column = TableColumn.FIRST_LOAD + int(model.parameters[ForceParameter.LOAD_COUNT]) + 2 * int(output_index)
    return evaluate_piece(model.coefficients, piece, column, t), evaluate_piece(model.coefficients, piece, column + 1, t)


@jit_in_place
def evaluate_output(model: ReducedModel, piece: int, t: float, output_index: float) -> tuple[float, float]:
    """Return value and derivative of an output of the table, of the coordinate, or of the shaft as last evaluated, by its index."""
    shaft_output = int(output_index) - int(model.parameters[ForceParameter.OUTPUT_COUNT])
    if shaft_output >= 0:
        return model.shaft_outputs.row_values[shaft_output, RowColumn.RESIDUAL], model.shaft_outputs.derivatives[shaft_output]
    if output_index == COORDINATE:
        return model.intervals[piece, 2] + t / model.intervals[piece, 3], 1.0
    return evaluate_table_output(model, piece, t, output_index)


@jit_in_place
def evaluate_output_second_derivative(model: ReducedModel, piece: int, t: float, output_index: float) -> float:
    """Return the second derivative of an output by the coordinate, at the local coordinate t of a table piece."""
    column = TableColumn.FIRST_LOAD + int(model.parameters[ForceParameter.LOAD_COUNT]) + 2 * int(output_index) + 1
    return float(evaluate_piece_derivative(model.coefficients, piece, column, t) * model.intervals[piece, 3])


@jit
def evaluate_static_force(model: ReducedModel, piece: int, t: float, state: FloatArray, local_time: float) -> tuple[float, float]:
    """Evaluate the generalised force at zero rate without friction, and the one up to which friction can hold the mechanism.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    state
        State, of which the shaft matters; shape (N_STATES,).
    local_time
        Time since the inputs' cubics begin, s.

    Returns
    -------
    force : float
        Force along the coordinate.
    limit : float
        Sum of the friction forces along the coordinate.
    """
    further_rates = np.empty((N_FURTHER_STATES, 1))
    angle, speed = state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED]
    acceleration = evaluate_acceleration(model, piece, t, 0.0, angle, speed, local_time, False, further_rates, 0)
    limit = 0.0
    for k in range(model.contacts.shape[0]):
        limit += friction_limit(model, k) * abs(evaluate_table_output(model, piece, t, model.contacts[k].output_index)[1])
    return acceleration / evaluate_piece(model.coefficients, piece, TableColumn.INVERSE_INERTIA, t), limit
