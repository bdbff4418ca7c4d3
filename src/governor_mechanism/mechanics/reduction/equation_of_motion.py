"""Equations of motion of the reduced model, one coordinate q and one shaft, and the rates of work and dissipation; compiled.

A place in the motion table is a piece and the local coordinate t in it, from -1 to 1; v is the rate of the coordinate.
"""

from typing import NamedTuple

from governor_mechanism.mechanics.dynamics.inputs import InputTermKind, add_input_term
from governor_mechanism.mechanics.dynamics.output_forces import IN_NO_PHASE, evaluate_force_law, evaluate_gas_phase
from governor_mechanism.mechanics.kinematics.constraint_rows import RowColumn
from governor_mechanism.mechanics.kinematics.time_functions import evaluate_given_speed, evaluate_input
from governor_mechanism.mechanics.reduction.lagrangian import TableColumn
from governor_mechanism.mechanics.reduction.reduced_model import COORDINATE, ReducedModel, StateIndex, evaluate_shaft_outputs
from governor_mechanism.mechanics.reduction.table import PieceColumn, coordinate_at
from governor_mechanism.numerics.interpolation import evaluate_piece, evaluate_piece_derivative
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray


@jit_in_place
def evaluate_model_inputs(
    model: ReducedModel, piece: int, t: float, v: float, shaft_angle: float, shaft_speed: float, local_time: float
) -> None:
    """Fill the inputs of the model at a local time (s), that of their cubics, and at an angle (rad) and speed of the shaft."""
    evaluate_shaft_outputs(model.shaft_outputs, shaft_angle)
    for k in range(1, model.inputs.size):
        model.inputs[k] = evaluate_input(model.input_cubics, k, local_time)
    for i in range(model.input_terms.size):
        term, source = model.input_terms[i], 0.0
        if term.kind == InputTermKind.RATE:
            source = evaluate_output_rate(model, piece, t, term.source_index, v, shaft_speed)
        elif term.kind != InputTermKind.PRODUCT and term.kind != InputTermKind.NOT_NEGATIVE:
            source = evaluate_output(model, piece, t, term.source_index)[0]
        add_input_term(model.input_terms, i, source, model.inputs)


@jit_in_place
def evaluate_force(model: ReducedModel, forces: RecordArray, index: int, piece: int, t: float, value: float, rate: float) -> float:
    """Return one of some forces (N or N m) at a value and a rate of its output; inputs and outputs of the shaft as last evaluated."""
    force, argument = forces[index], rate
    if force.phase != IN_NO_PHASE:
        argument = float(force.phase)
    elif force.argument_index != NO_INDEX:
        argument = evaluate_gas_phase(force.coefficients, value, evaluate_output(model, piece, t, force.argument_index)[0])
    result = evaluate_force_law(force.law, force.coefficients, value, argument)
    return float(result * model.inputs[force.input_index] if force.input_index != NO_INDEX else result)


@jit_in_place
def friction_limit(model: ReducedModel, k: int) -> float:
    """Return the friction force (N or N m) of a contact, from the inputs as last evaluated; 0 without friction."""
    friction_input = model.contacts[k].friction_input
    return float(model.inputs[friction_input]) if friction_input != NO_INDEX else 0.0


@jit_in_place
def evaluate_table_output(model: ReducedModel, piece: int, t: float, output_index: int) -> tuple[float, float]:
    """Return an output of the table, and its derivative by the coordinate."""
    column = TableColumn.FIRST_LOAD + model.parameters[0].n_loads + 2 * output_index
    return evaluate_piece(model.coefficients, piece, column, t), evaluate_piece(model.coefficients, piece, column + 1, t)


@jit_in_place
def evaluate_output(model: ReducedModel, piece: int, t: float, output_index: int) -> tuple[float, float]:
    """Return an output and its derivative by the coordinate, or for an output of the shaft, as last evaluated, by its angle."""
    # Outputs of the shaft are counted from the number of outputs of the table on; COORDINATE is the
    # coordinate itself.
    shaft_output = output_index - model.parameters[0].n_outputs
    if shaft_output >= 0:
        return model.shaft_outputs.row_values[shaft_output, RowColumn.RESIDUAL], model.shaft_outputs.derivatives[shaft_output]
    if output_index == COORDINATE:
        return coordinate_at(model.intervals, piece, t), 1.0
    return evaluate_table_output(model, piece, t, output_index)


@jit_in_place
def evaluate_output_rate(model: ReducedModel, piece: int, t: float, output_index: int, v: float, shaft_speed: float) -> float:
    """Return the rate of an output: of the shaft with its speed, of any other with the rate of the coordinate."""
    is_of_shaft = output_index >= model.parameters[0].n_outputs
    return float(evaluate_output(model, piece, t, output_index)[1] * (shaft_speed if is_of_shaft else v))


@jit_in_place
def evaluate_output_second_derivative(model: ReducedModel, piece: int, t: float, output_index: int) -> float:
    """Return the second derivative of an output of the table by the coordinate."""
    column = TableColumn.FIRST_LOAD + model.parameters[0].n_loads + 2 * output_index + 1
    return float(evaluate_piece_derivative(model.coefficients, piece, column, t) * model.intervals[piece, PieceColumn.INVERSE_HALF_WIDTH])


class StateRates(NamedTuple):
    """Accelerations of the coordinate and of the shaft (rad/s2), and the rates of work and dissipated energy (W)."""

    acceleration: float
    shaft_acceleration: float
    work_rate: float
    dissipated_power: float


@jit_in_place
def evaluate_state_rates(
    model: ReducedModel, piece: int, t: float, v: float, shaft_angle: float, shaft_speed: float, local_time: float, with_friction: bool
) -> StateRates:
    """Return the acceleration of the coordinate from all forces, and the rates of the other states."""
    # With the ratio r of spindle to shaft, the inertia J of the bodies in the turning plane and the
    # inertia S of all else that turns, (S + r^2 J) W' = torque - r^2 J' q' W for the speed W of the
    # shaft; without reaction S W' = torque.
    coefficients = model.coefficients
    parameters = model.parameters[0]
    inputs = model.inputs
    evaluate_model_inputs(model, piece, t, v, shaft_angle, shaft_speed, local_time)
    inverse_inertia = evaluate_piece(coefficients, piece, TableColumn.INVERSE_INERTIA, t)
    spindle_inertia = evaluate_piece(coefficients, piece, TableColumn.SPINDLE_INERTIA, t)
    damping = evaluate_piece(coefficients, piece, TableColumn.DAMPING, t)
    centrifugal = evaluate_piece(coefficients, piece, TableColumn.CENTRIFUGAL, t)
    power = damping * v * v / inverse_inertia
    ratio = parameters.spindle_ratio
    shaft_acceleration = 0.0
    if parameters.has_shaft != 0:
        shaft_acceleration, power = _evaluate_shaft(model, piece, t, v, shaft_speed, spindle_inertia, centrifugal, inverse_inertia, power)
    omega, spindle_acceleration = ratio * shaft_speed, ratio * shaft_acceleration
    if ratio == 0.0:
        amplitude = parameters.fluctuation_amplitude
        cycles_per_turn = parameters.cycles_per_turn
        omega, spindle_acceleration = evaluate_given_speed(model.input_cubics, 0, local_time, amplitude, cycles_per_turn)
    quadratic = evaluate_piece(coefficients, piece, TableColumn.QUADRATIC, t)
    potential = evaluate_piece(coefficients, piece, TableColumn.POTENTIAL, t)
    acceleration = quadratic * v * v + potential + damping * v + centrifugal * omega * omega
    column: int = TableColumn.FIRST_LOAD
    first_load = parameters.first_load_input
    for load in range(first_load, first_load + parameters.n_loads):
        load_acceleration = inputs[load] * evaluate_piece(coefficients, piece, column, t)
        acceleration += load_acceleration
        power += load_acceleration * v / inverse_inertia
        column += 1
    acceleration, power, dissipated_power = _add_output_forces(model, piece, t, v, inverse_inertia, acceleration, power)
    if with_friction:
        acceleration, dissipated_power = _add_friction(model, piece, t, v, inverse_inertia, acceleration, dissipated_power)
    work_rate = dissipated_power - power
    if parameters.is_spindle_loaded != 0 and parameters.has_reaction == 0:
        work_rate += spindle_inertia * omega * spindle_acceleration
    return StateRates(acceleration, shaft_acceleration, work_rate, dissipated_power)


@jit_in_place
def _evaluate_shaft(
    model: ReducedModel,
    piece: int,
    t: float,
    v: float,
    shaft_speed: float,
    spindle_inertia: float,
    centrifugal: float,
    inverse_inertia: float,
    power: float,
) -> tuple[float, float]:
    """Return the acceleration (rad/s2) of the shaft, and a power (W) with that of the torques on it which have no potential added."""
    parameters = model.parameters[0]
    ratio = parameters.spindle_ratio
    shaft_inertia = parameters.shaft_inertia
    torque = -parameters.shaft_damping * shaft_speed
    for i in range(model.shaft_torques.size):
        torque += model.inputs[model.shaft_torques[i].input_index] * model.shaft_torques[i].ratio
    power += torque * shaft_speed
    for i in range(model.shaft_forces.size):
        travel, travel_derivative = evaluate_output(model, piece, t, model.shaft_forces[i].output_index)
        gas_torque = evaluate_force(model, model.shaft_forces, i, piece, t, travel, 0.0) * travel_derivative
        torque += gas_torque
        if model.shaft_forces[i].input_index != NO_INDEX:
            power += gas_torque * shaft_speed
    if parameters.has_reaction != 0:
        shaft_inertia += ratio * ratio * spindle_inertia
        torque -= 2.0 * ratio * ratio * centrifugal / inverse_inertia * v * shaft_speed
    return torque / shaft_inertia, power


@jit_in_place
def _add_output_forces(
    model: ReducedModel, piece: int, t: float, v: float, inverse_inertia: float, acceleration: float, power: float
) -> tuple[float, float, float]:
    """Return acceleration and power (W) with those of the forces along outputs added, and the power (W) that these forces dissipate."""
    dissipated_power = 0.0
    for i in range(model.output_forces.size):
        output_force = model.output_forces[i]
        spring_index = output_force.spring_index
        if spring_index == NO_INDEX or model.mode[model.mode_layout.springs + spring_index] != 0:
            value, output_derivative = evaluate_table_output(model, piece, t, output_force.output_index)
            force = evaluate_force(model, model.output_forces, i, piece, t, value, output_derivative * v)
            if output_force.input_index != NO_INDEX:
                power += force * output_derivative * v
            acceleration += force * output_derivative * inverse_inertia
            if output_force.has_power != 0:
                dissipated_power -= force * output_derivative * v
    return acceleration, power, dissipated_power


@jit_in_place
def _add_friction(
    model: ReducedModel, piece: int, t: float, v: float, inverse_inertia: float, acceleration: float, dissipated_power: float
) -> tuple[float, float]:
    """Return acceleration and dissipated power (W) with those of the sliding contacts added."""
    for i in range(model.contacts.size):
        sliding_sign = model.mode[model.mode_layout.contacts + i]
        if sliding_sign != 0:
            output_derivative = evaluate_table_output(model, piece, t, model.contacts[i].output_index)[1]
            force = sliding_sign * friction_limit(model, i)
            acceleration -= force * output_derivative * inverse_inertia
            dissipated_power += force * output_derivative * v
    return acceleration, dissipated_power


@jit_in_place
def evaluate_equation_of_motion(
    model: ReducedModel,
    piece: int,
    t: float,
    v: float,
    shaft_angle: float,
    shaft_speed: float,
    local_time: float,
    further_rates: FloatArray,  # result in column `stage` unless the model is conservative; shape (N_FURTHER_STATES, stages)
    stage: int,
) -> float:
    """Return the acceleration of the coordinate; zero while the mechanism is held."""
    if model.parameters[0].is_conservative != 0:
        return evaluate_piece(model.coefficients, piece, TableColumn.QUADRATIC, t) * v * v + evaluate_piece(
            model.coefficients, piece, TableColumn.POTENTIAL, t
        )
    rates = evaluate_state_rates(model, piece, t, v, shaft_angle, shaft_speed, local_time, True)
    further_rates[0, stage] = rates.work_rate
    further_rates[1, stage] = rates.dissipated_power
    further_rates[2, stage] = shaft_speed
    further_rates[3, stage] = rates.shaft_acceleration
    return 0.0 if model.mode[model.mode_layout.held] != 0 else rates.acceleration


@jit_in_place
def evaluate_static_force(model: ReducedModel, piece: int, t: float, state: FloatArray, local_time: float) -> tuple[float, float]:
    """Return the generalised force at zero rate without friction, and the one up to which friction can hold the mechanism."""
    angle, speed = state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED]
    acceleration = evaluate_state_rates(model, piece, t, 0.0, angle, speed, local_time, False).acceleration
    limit = 0.0
    for k in range(model.contacts.size):
        limit += friction_limit(model, k) * abs(evaluate_table_output(model, piece, t, model.contacts[k].output_index)[1])
    return acceleration / evaluate_piece(model.coefficients, piece, TableColumn.INVERSE_INERTIA, t), limit
