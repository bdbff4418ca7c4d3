"""Equations of motion of the reduced model, one coordinate q and one shaft, and the rates of work and dissipation; compiled."""

from typing import NamedTuple

from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_given_speed
from governor_mechanism.mechanics.reduction.model_outputs import (
    evaluate_force,
    evaluate_model_inputs,
    evaluate_output,
    evaluate_table_output,
    friction_limit,
)
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.reduced_forces import ForceParameter, OutputForceColumn
from governor_mechanism.mechanics.reduction.reduced_model import ReducedModel, StateIndex
from governor_mechanism.numerics.chebyshev import evaluate_piece
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray


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
    """Evaluate the acceleration of the coordinate from all forces, and the rates of the other states.

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

    Returns
    -------
    StateRates
        Accelerations and rates of energy.
    """
    coefficients, parameters, inputs = model.coefficients, model.parameters, model.inputs
    evaluate_model_inputs(model, piece, t, v, shaft_angle, shaft_speed, local_time)
    inverse_inertia = evaluate_piece(coefficients, piece, TableColumn.INVERSE_INERTIA, t)
    spindle_inertia = evaluate_piece(coefficients, piece, TableColumn.SPINDLE_INERTIA, t)
    damping = evaluate_piece(coefficients, piece, TableColumn.DAMPING, t)
    centrifugal = evaluate_piece(coefficients, piece, TableColumn.CENTRIFUGAL, t)
    power, ratio, shaft_acceleration = damping * v * v / inverse_inertia, parameters[ForceParameter.SPINDLE_RATIO], 0.0
    if parameters[ForceParameter.HAS_SHAFT] != 0.0:
        shaft_acceleration, power = _evaluate_shaft(model, piece, t, v, shaft_speed, spindle_inertia, centrifugal, inverse_inertia, power)
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
    acceleration, power, dissipated_power = _add_output_forces(model, piece, t, v, inverse_inertia, acceleration, power)
    if with_friction:
        acceleration, dissipated_power = _add_friction(model, piece, t, v, inverse_inertia, acceleration, dissipated_power)
    work_rate = dissipated_power - power
    if parameters[ForceParameter.IS_SPINDLE_LOADED] != 0.0 and parameters[ForceParameter.HAS_REACTION] == 0.0:
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
    parameters, ratio = model.parameters, model.parameters[ForceParameter.SPINDLE_RATIO]
    shaft_inertia, torque = parameters[ForceParameter.SHAFT_INERTIA], -parameters[ForceParameter.SHAFT_DAMPING] * shaft_speed
    for i in range(model.shaft_torques.shape[0]):
        torque += model.inputs[int(model.shaft_torques[i, 0])] * model.shaft_torques[i, 1]
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
    return torque / shaft_inertia, power


@jit_in_place
def _add_output_forces(
    model: ReducedModel, piece: int, t: float, v: float, inverse_inertia: float, acceleration: float, power: float
) -> tuple[float, float, float]:
    """Return acceleration and power (W) with those of the forces along outputs added, and the power (W) that these forces dissipate."""
    dissipated_power = 0.0
    for i in range(model.output_forces.shape[0]):
        output_force = model.output_forces[i]
        mode_index = int(output_force[OutputForceColumn.MODE])
        if mode_index == NO_INDEX or model.mode[mode_index] != 0:
            value, output_derivative = evaluate_table_output(model, piece, t, output_force[OutputForceColumn.OUTPUT])
            force = evaluate_force(model, output_force, piece, t, value, output_derivative * v)
            if output_force[OutputForceColumn.INPUT] >= 0.0:
                power += force * output_derivative * v
            acceleration += force * output_derivative * inverse_inertia
            dissipated_power -= output_force[OutputForceColumn.DISSIPATES] * force * output_derivative * v
    return acceleration, power, dissipated_power


@jit_in_place
def _add_friction(
    model: ReducedModel, piece: int, t: float, v: float, inverse_inertia: float, acceleration: float, dissipated_power: float
) -> tuple[float, float]:
    """Return acceleration and dissipated power (W) with those of the sliding contacts added."""
    for i in range(model.contacts.shape[0]):
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
    rates = evaluate_state_rates(model, piece, t, v, shaft_angle, shaft_speed, local_time, True)
    further_rates[0, stage] = rates.work_rate
    further_rates[1, stage] = rates.dissipated_power
    further_rates[2, stage] = shaft_speed
    further_rates[3, stage] = rates.shaft_acceleration
    return 0.0 if model.mode[model.mode_layout.held] != 0 else rates.acceleration


@jit_in_place
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
    angle, speed = state[StateIndex.SHAFT_ANGLE], state[StateIndex.SHAFT_SPEED]
    acceleration = evaluate_state_rates(model, piece, t, 0.0, angle, speed, local_time, False).acceleration
    limit = 0.0
    for k in range(model.contacts.shape[0]):
        limit += friction_limit(model, k) * abs(evaluate_table_output(model, piece, t, model.contacts[k].output_index)[1])
    return acceleration / evaluate_piece(model.coefficients, piece, TableColumn.INVERSE_INERTIA, t), limit
