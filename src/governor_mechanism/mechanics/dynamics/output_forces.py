"""Forces along output variables as compiled kernels, those of effects and of force elements of a mechanism, with the same laws."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.gas_pressure import GasPressure, gas_phase, gas_work, travel_in_stroke
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.dynamics.inputs import output_rate
from governor_mechanism.mechanics.kinematics.constraint_rows import ConstraintRows, Origins, RowColumn
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, rows_of_readings
from governor_mechanism.model.effect import ForceLaw, OutputForce
from governor_mechanism.model.force_elements import CylinderGas, Damper, ForceElement, Spring, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Reading
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
    law = FORCE_LAWS.index(type(effect))
    has_power = effect.dissipates
    slack_below = effect.slack_below
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
    """Add the generalised forces of all output forces to result (bodies, 3), and return the power (W) of those without a potential."""
    # The output rows were evaluated at the state. Between coincident points a force has no line of
    # action and is left out.
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


_ELEMENT_LAWS: dict[type[ForceElement], tuple[type[ForceLaw], tuple[str, ...]]] = {
    Spring: (OutputSpring, ("stiffness", "free_length")),
    Damper: (Dashpot, ("damping",)),
    TorsionSpring: (OutputSpring, ("stiffness", "free_angle")),
    TorsionDamper: (Dashpot, ("damping",)),
    CylinderGas: (GasPressure, ()),
}
"""Law of each type of force elements, and the attributes that are its coefficients, unless it has them itself; the others are loads."""


CONSERVATIVE_TYPES = Spring | TorsionSpring | CylinderGas
"""Types of force elements with a potential, unless something moves their law."""


def lower_outputs(
    mechanism: Mechanism,
    names: Sequence[str],
    elements: Sequence[ForceElement],
    # origin of each body by name, in body axes (m), to which the poses refer; the mass centre if left out
    origins: Origins,
    first_input: int,  # index of the first load of the force elements among the inputs
) -> tuple[ConstraintRows, RecordArray]:
    """Return the rows of the outputs along which effects and force elements act, and the forces (`OUTPUT_FORCE_DTYPE`) of the latter."""
    # A row for each name, then one for each displacement and each different argument of the force
    # elements; a force for each displacement.
    records, readings = list[OutputForceRecord](), [*map(mechanism.reading, names)]
    for element in elements:
        if not element.loads and type(element) not in _ELEMENT_LAWS:
            raise TypeError(f"no force law is defined for force elements of type {type(element).__name__}")
        first_row = len(readings)
        readings += element.displacements
        for row in range(first_row, first_row + len(element.loads)):
            records.append(make_output_force(LOAD, row, (-1.0,), has_power=True, input_index=first_input))
            first_input += 1
        if not element.loads:
            law, coefficients = element_law(element)
            argument = _row_of_argument(element, readings)
            records.append(
                make_output_force(
                    FORCE_LAWS.index(law),
                    first_row,
                    coefficients,
                    argument_index=argument,
                    has_power=law.dissipates or not element.has_potential,
                    input_index=NO_INDEX if element.factor is None else first_input,
                    switch_input=NO_INDEX if element.switch is None else first_input + (element.factor is not None),
                )
            )
            first_input += len(element.inputs)
    return rows_of_readings(mechanism, readings, origins), np.array(records, dtype=OUTPUT_FORCE_DTYPE)


def _row_of_argument(element: ForceElement, readings: list[Reading]) -> int:
    """Return the row of the argument of a force element, appended to the readings if it is not among them; NO_INDEX without one."""
    if element.argument is None:
        return NO_INDEX
    if element.argument not in readings:
        readings.append(element.argument)
    return readings.index(element.argument)


def element_law(element: ForceElement) -> tuple[type[ForceLaw], tuple[float, ...]]:
    """Return the law of a spring, damper or gas, and its coefficients."""
    law, names = _ELEMENT_LAWS[type(element)]
    return law, element.coefficients if isinstance(element, CylinderGas) else tuple(getattr(element, name) for name in names)


def element_potential_energy(
    mechanism: Mechanism,
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (..., bodies, 3)
) -> FloatArray:
    """Return the potential energy (...) J of all springs of a mechanism, less the work of its gas since the crank angle zero."""
    total = np.zeros(poses.shape[:-2])
    for element in mechanism.force_elements:
        if isinstance(element, CONSERVATIVE_TYPES) and element.has_potential:
            law, coefficients = element_law(element)
            value = OutputDerivatives(rows_of_readings(mechanism, element.displacements[:1], {}), poses).value
            if isinstance(element, CylinderGas):
                crank_angle = OutputDerivatives(rows_of_readings(mechanism, [element.crank_angle], {}), poses).value
                total -= gas_work(coefficients, value, crank_angle)
            else:
                total += law.potential(coefficients, value)[0]
    return total
