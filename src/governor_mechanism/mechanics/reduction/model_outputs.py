"""Outputs, inputs and single forces of the reduced model in a state; compiled."""

from governor_mechanism.mechanics.dynamics.forces.inputs import InputTermKind, add_input_term
from governor_mechanism.mechanics.dynamics.forces.output_forces import IN_NO_PHASE, evaluate_force_law, evaluate_gas_phase
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_input
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.reduced_forces import COORDINATE, ForceParameter, OutputForceColumn
from governor_mechanism.mechanics.reduction.reduced_model import ReducedModel
from governor_mechanism.mechanics.reduction.shaft_outputs import evaluate_shaft_outputs
from governor_mechanism.numerics.chebyshev import evaluate_piece, evaluate_piece_derivative
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, FloatArray


@jit_in_place
def evaluate_model_inputs(
    model: ReducedModel, piece: int, t: float, v: float, shaft_angle: float, shaft_speed: float, local_time: float
) -> None:
    """Evaluate the inputs of the model in a state.

    Parameters
    ----------
    model
        The reduced model; its `inputs` are filled.
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
    """
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
    if phase_index != NO_INDEX:
        argument = float(model.mode[phase_index])
        if argument == IN_NO_PHASE:
            argument = evaluate_gas_phase(coefficients, value, evaluate_output(model, piece, t, force[OutputForceColumn.CRANK_ANGLE])[0])
    result = evaluate_force_law(int(force[OutputForceColumn.LAW]), coefficients, value, argument)
    return float(result * model.inputs[factor] if factor != NO_INDEX else result)


@jit_in_place
def friction_limit(model: ReducedModel, k: int) -> float:
    """Return the friction force of a contact, from the inputs as last evaluated.

    Parameters
    ----------
    model
        The reduced model.
    k
        Index of the contact.

    Returns
    -------
    float
        Friction force, N or N m; 0 without friction.
    """
    friction_input = int(model.contacts[k].friction_input)
    return float(model.inputs[friction_input]) if friction_input != NO_INDEX else 0.0


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
    """Evaluate an output of the table, of the coordinate, or of the shaft as last evaluated.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    output_index
        Index of the output: of the table, COORDINATE, or from the number of outputs of the table on those of the shaft.

    Returns
    -------
    value : float
        Value of the output.
    derivative : float
        Its derivative by the coordinate, or for an output of the shaft by the angle of that.
    """
    shaft_output = int(output_index) - int(model.parameters[ForceParameter.OUTPUT_COUNT])
    if shaft_output >= 0:
        return model.shaft_outputs.row_values[shaft_output, RowColumn.RESIDUAL], model.shaft_outputs.derivatives[shaft_output]
    if output_index == COORDINATE:
        return model.intervals[piece, 2] + t / model.intervals[piece, 3], 1.0
    return evaluate_table_output(model, piece, t, output_index)


@jit_in_place
def evaluate_output_rate(model: ReducedModel, piece: int, t: float, output_index: float, v: float, shaft_speed: float) -> float:
    """Evaluate the rate of an output: of the shaft with its speed, of any other with the rate of the coordinate.

    Parameters
    ----------
    model
        The reduced model.
    piece
        Index of the table piece.
    t
        Local coordinate in that piece, -1 to 1.
    output_index
        Index of the output, as for `evaluate_output`.
    v
        Rate of the coordinate.
    shaft_speed
        Speed of the shaft, rad/s.

    Returns
    -------
    float
        Rate of the output.
    """
    is_of_shaft = output_index >= model.parameters[ForceParameter.OUTPUT_COUNT]
    return float(evaluate_output(model, piece, t, output_index)[1] * (shaft_speed if is_of_shaft else v))


@jit_in_place
def evaluate_output_second_derivative(model: ReducedModel, piece: int, t: float, output_index: float) -> float:
    """Evaluate the second derivative of an output of the table.

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
    float
        Second derivative of the output by the coordinate.
    """
    column = TableColumn.FIRST_LOAD + int(model.parameters[ForceParameter.LOAD_COUNT]) + 2 * int(output_index) + 1
    return float(evaluate_piece_derivative(model.coefficients, piece, column, t) * model.intervals[piece, 3])
