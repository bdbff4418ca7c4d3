"""Forces along output variables as compiled kernels, and records of the event functions of contacts.

An output row is a constraint row whose residual is the value of an output variable (see `output_rows`).
"""

from collections.abc import Callable, Sequence
from enum import IntEnum

import numpy as np

from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows, RowColumn
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, RecordArray, record_dtype

MAX_COEFFICIENTS = 4
"""Largest number of coefficients of a force law along an output."""

SLIDING_FRICTION = len(FORCE_LAWS)
"""Index of Coulomb friction among the laws of output forces; its coefficient is the sign of sliding."""

OUTPUT_FORCE_DTYPE = np.dtype(
    [*((name, "i8") for name in ("law", "output_index", "dissipates", "input_index")), ("coefficients", "f8", (MAX_COEFFICIENTS,))]
)
"""One force along an output row: index in `FORCE_LAWS` or `SLIDING_FRICTION`, index of the row, whether it dissipates energy,
the input of a friction force, or -1, and its coefficients."""


def output_force_record(effect: OutputForce, output_index: int) -> tuple[int, int, bool, int, tuple[float, ...]]:
    """Return the record of an effect with a force law along an output.

    Parameters
    ----------
    effect
        Effect with a force law.
    output_index
        Index of the output row.

    Returns
    -------
    tuple[int, int, bool, int, tuple[float, ...]]
        Record of `OUTPUT_FORCE_DTYPE`.
    """
    coefficients = (*effect.coefficients, *(0.0,) * (MAX_COEFFICIENTS - len(effect.coefficients)))
    return FORCE_LAWS.index(type(effect)), output_index, effect.dissipates, -1, coefficients


@jit_in_place
def _no_force(law: int, coefficients: FloatArray, value: float, rate: float) -> float:
    return 0.0


def _compile_force_laws(laws: Sequence[type[OutputForce]]) -> Callable[[int, FloatArray, float, float], float]:
    """Return a kernel that evaluates the law of an index: a chain of comparisons, which the compiler inlines."""
    if not laws:
        return _no_force
    evaluate_first, evaluate_others = jit_in_place(laws[0].force), _compile_force_laws(laws[1:])

    def evaluate(law: int, coefficients: FloatArray, value: float, rate: float) -> float:
        return float(evaluate_first(coefficients, value, rate)) if law == 0 else evaluate_others(law - 1, coefficients, value, rate)

    return jit_in_place(evaluate)


evaluate_force_law = _compile_force_laws(FORCE_LAWS)
"""Force (N or N m) of a law by its index in `FORCE_LAWS`, its coefficients, and value and rate of the output."""


@jit_in_place
def _no_potential(law: int, coefficients: FloatArray, value: float) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


def _compile_potentials(laws: Sequence[type[OutputForce]]) -> Callable[[int, FloatArray, float], tuple[float, float, float]]:
    """Return a kernel that evaluates the potential of the law of an index."""
    if not laws:
        return _no_potential
    evaluate_first, evaluate_others = jit_in_place(laws[0].potential), _compile_potentials(laws[1:])

    def evaluate(law: int, coefficients: FloatArray, value: float) -> tuple[float, float, float]:
        return evaluate_first(coefficients, value) if law == 0 else evaluate_others(law - 1, coefficients, value)

    return jit_in_place(evaluate)


evaluate_potential = _compile_potentials(FORCE_LAWS)
"""Energy (J) of a law by its index in `FORCE_LAWS`, its coefficients and value of the output, and the derivatives by that value."""


class EventFunctionKind(IntEnum):
    """Quantity of an event function: value or rate of an output, or force of the constraint row that holds it."""

    VALUE = 0
    RATE = 1
    FORCE = 2


EVENT_FUNCTION_DTYPE = record_dtype("i8 kind source_index", "f8 sign threshold tolerance", "i8 input_index contact_index")
"""One event function g = sign * quantity - threshold - input. An event is an upward zero crossing of g.

source_index: the output row, or for a force the constraint row that holds the output. tolerance: rounding level
of g. input_index: the input that is subtracted, or -1. contact_index: the contact or one-sided spring concerned.
"""


@jit_in_place
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
        rate = output_rate(output_rows, jacobian, k, velocities) if output_force.dissipates else 0.0
        if output_force.law == SLIDING_FRICTION:
            force = -(output_force.coefficients[0] * inputs[output_force.input_index])
        else:
            force = evaluate_force_law(output_force.law, output_force.coefficients, row_values[k, RowColumn.RESIDUAL], rate)
        dissipated_power -= force * rate
        for side in range(2):
            body = output_rows.row_bodies[k, side]
            if body >= 0:
                for c in range(3):
                    result[body, c] += force * jacobian[k, side, c]
    return dissipated_power
