"""Forces along output variables as compiled kernels.

An output row is a constraint row whose residual is the value of an output variable (see `output_rows`).
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

from governor_mechanism.effects.gas_pressure import GasPressure, gas_phase, travel_in_stroke
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.mechanics.dynamics.forces.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows, RowColumn
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.numerics.jit import jit_in_place, record_dtype
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, FloatArray, RecordArray

MAX_COEFFICIENTS = 8
"""Largest number of coefficients of a force law along an output."""

SLIDING_FRICTION, LOAD = len(FORCE_LAWS), len(FORCE_LAWS) + 1
"""Indices of Coulomb friction and of a given load among the laws of output forces. Both are -coefficient * input: that of friction is the
sign of sliding, that of a load -1.
"""

IN_NO_PHASE = -1
"""Phase of a gas that follows from travel and crank angle."""

OUTPUT_FORCE_DTYPE = record_dtype(
    ("law", "i8"),  # index in FORCE_LAWS, SLIDING_FRICTION or LOAD
    ("output_index", "i8"),  # the output row
    ("argument_index", "i8"),  # the row whose value the law of gas takes in place of the rate, or NO_INDEX
    ("has_power", "i8"),  # whether the force has no potential
    ("input_index", "i8"),  # input of a friction force or load, or that multiplies the force of a law, or NO_INDEX
    ("switch_input", "i8"),  # input that is the switch of a gas, or NO_INDEX
    ("spring_index", "i8"),  # the one-sided spring whose contact mode says whether the force acts, or NO_INDEX (reduced model only)
    ("phase", "i8"),  # phase of the cycle in which a gas is kept, or IN_NO_PHASE
    ("slack_below", "f8"),  # value of the output below which the force is slack
    ("coefficients", "f8", (MAX_COEFFICIENTS,)),  # of the law
)
"""One force along an output row."""

OutputForceRecord = tuple[int, int, int, bool, int, int, int, int, float, tuple[float, ...]]
"""A record of `OUTPUT_FORCE_DTYPE`."""


def make_output_force(
    law: int,
    output_index: int,
    coefficients: Sequence[float],
    *,
    argument_index: int = NO_INDEX,
    has_power: bool = False,
    input_index: int = NO_INDEX,
    switch_input: int = NO_INDEX,
    spring_index: int = NO_INDEX,
    slack_below: float = -math.inf,
) -> OutputForceRecord:
    """Return a record of `OUTPUT_FORCE_DTYPE`; coefficients that are left out are zero."""
    indices = law, output_index, argument_index, has_power, input_index, switch_input, spring_index
    return *indices, IN_NO_PHASE, slack_below, pad_coefficients(coefficients)


def pad_coefficients(coefficients: Sequence[float]) -> tuple[float, ...]:
    """Return coefficients of a law with zeros up to the number in a record."""
    return (*coefficients, *(0.0,) * (MAX_COEFFICIENTS - len(coefficients)))


def output_force_record(effect: OutputForce, output_index: int, spring_index: int = NO_INDEX) -> OutputForceRecord:
    """Return the record of an effect with a force law along an output."""
    law, has_power, slack_below = FORCE_LAWS.index(type(effect)), effect.dissipates, effect.slack_below
    return make_output_force(
        law, output_index, effect.coefficients, has_power=has_power, spring_index=spring_index, slack_below=slack_below
    )


def _compile_laws(functions: Sequence[Callable[..., Any]]) -> Callable[..., Any]:
    """Return a kernel that calls the function of a law by its index: a chain of comparisons, which the compiler inlines."""
    call_first = jit_in_place(functions[0])

    def call_last(law: int, *arguments: Any) -> Any:
        return call_first(*arguments)

    if len(functions) == 1:
        return jit_in_place(call_last)
    call_others = _compile_laws(functions[1:])

    def call(law: int, *arguments: Any) -> Any:
        return call_first(*arguments) if law == 0 else call_others(law - 1, *arguments)

    return jit_in_place(call)


_KERNEL_LAWS = [GasPressure.force_in_phase if law is GasPressure else law.force for law in FORCE_LAWS]

evaluate_force_law: Callable[[int, FloatArray, float, float], float] = _compile_laws(_KERNEL_LAWS)
"""Force (N or N m) of a law by its index in `FORCE_LAWS`, its coefficients, and value and rate of the output; gas takes its phase."""

evaluate_gas_phase: Callable[[FloatArray, float, float], float] = jit_in_place(gas_phase)
"""Phase of the cycle of a gas by its coefficients, the travel (m) and the crank angle (rad)."""

evaluate_travel_in_stroke: Callable[[float, float, float], float] = jit_in_place(travel_in_stroke)
"""Travel since the last dead centre, relative to the stroke, by 1 / stroke (1/m), the travel (m) and the crank angle (rad)."""

evaluate_potential: Callable[[int, FloatArray, float], tuple[float, float, float]] = _compile_laws([law.potential for law in FORCE_LAWS])
"""Energy (J) of a law by its index in `FORCE_LAWS`, its coefficients and value of the output, and the derivatives by that value."""


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
    """Add the generalised forces of all output forces to result (bodies, 3) and return the power (W) of those without a potential.

    The output rows were evaluated at the state. Between coincident points a force has no line of action and is left out.
    """
    power = 0.0
    for i in range(output_forces.size):
        output_force = output_forces[i]
        k = output_force.output_index
        if output_rows.table[k].kind == RowKind.DISTANCE and math.isnan(jacobian[k, 1, 0]):
            continue
        rate = output_rate(output_rows, jacobian, k, velocities) if output_force.has_power else 0.0
        if output_force.law in (SLIDING_FRICTION, LOAD):
            force = -(output_force.coefficients[0] * inputs[output_force.input_index])
        else:
            argument, value = rate, row_values[k, RowColumn.RESIDUAL]
            if output_force.phase != IN_NO_PHASE:
                argument = float(output_force.phase)
            elif output_force.argument_index != NO_INDEX:
                crank_angle = row_values[output_force.argument_index, RowColumn.RESIDUAL]
                argument = evaluate_gas_phase(output_force.coefficients, value, crank_angle)
            force = evaluate_force_law(output_force.law, output_force.coefficients, value, argument)
            if output_force.input_index != NO_INDEX:
                force *= inputs[output_force.input_index]
        power += force * rate
        for side in range(2):
            body = output_rows.row_bodies[k, side]
            if body != GROUND_INDEX:
                for c in range(3):
                    result[body, c] += force * jacobian[k, side, c]
    return power
