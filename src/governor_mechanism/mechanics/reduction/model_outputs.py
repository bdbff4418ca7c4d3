"""Outputs, inputs and single forces of the reduced model in a state; compiled.

A place in the motion table is a piece and the local coordinate t in it, from -1 to 1; v is the rate of the coordinate.
"""

from governor_mechanism.mechanics.dynamics.forces.inputs import InputTermKind, add_input_term
from governor_mechanism.mechanics.dynamics.forces.output_forces import IN_NO_PHASE, evaluate_force_law, evaluate_gas_phase
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_input
from governor_mechanism.mechanics.reduction.node_evaluation import TableColumn
from governor_mechanism.mechanics.reduction.reduced_model import COORDINATE, ReducedModel
from governor_mechanism.mechanics.reduction.shaft_outputs import evaluate_shaft_outputs
from governor_mechanism.numerics.chebyshev import evaluate_piece, evaluate_piece_derivative
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import NO_INDEX, RecordArray


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
    """Return an output and its derivative by the coordinate, or for an output of the shaft, as last evaluated, by its angle.

    Outputs of the shaft are counted from the number of outputs of the table on; COORDINATE is the coordinate itself.
    """
    shaft_output = output_index - model.parameters[0].n_outputs
    if shaft_output >= 0:
        return model.shaft_outputs.row_values[shaft_output, RowColumn.RESIDUAL], model.shaft_outputs.derivatives[shaft_output]
    if output_index == COORDINATE:
        return model.intervals[piece, 2] + t / model.intervals[piece, 3], 1.0
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
    return float(evaluate_piece_derivative(model.coefficients, piece, column, t) * model.intervals[piece, 3])
