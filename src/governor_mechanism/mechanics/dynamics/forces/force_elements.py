"""Force elements of a mechanism: forces along outputs of their own, with the same laws as effects."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.gas_pressure import GasPressure, gas_work
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.dynamics.forces.output_forces import LOAD, OUTPUT_FORCE_DTYPE, OutputForceRecord, make_output_force
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives
from governor_mechanism.mechanics.kinematics.points import Origins
from governor_mechanism.model.effect import ForceLaw
from governor_mechanism.model.force_elements import CylinderGas, Damper, ForceElement, Spring, TorsionDamper, TorsionSpring
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.types import NO_INDEX, FloatArray, RecordArray

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
    """Return the rows of the outputs along which effects and force elements act, and the forces of the force elements.

    Results: rows, a row for each name, then one for each displacement and each different argument of the
    force elements; forces, records of `OUTPUT_FORCE_DTYPE`, one for each displacement. Raises TypeError if no
    law is defined for a type of element.
    """
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
    """Return the potential energy of all springs of a mechanism, less the work of its gas since the crank angle zero.

    Result: energy, J; shape (...).
    """
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
