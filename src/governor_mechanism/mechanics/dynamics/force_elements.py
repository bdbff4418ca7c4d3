"""Force elements of a mechanism: forces along outputs of their own, with the same laws as effects."""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.dynamics.output_forces import LOAD, OUTPUT_FORCE_DTYPE, pad_coefficients
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives
from governor_mechanism.mechanics.kinematics.points import Origins
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import Damper, ForceElement, Spring, TorsionDamper, TorsionSpring
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray, RecordArray

_ELEMENT_LAWS: dict[type[ForceElement], tuple[type[OutputForce], tuple[str, ...]]] = {
    Spring: (OutputSpring, ("stiffness", "free_length")),
    Damper: (Dashpot, ("damping",)),
    TorsionSpring: (OutputSpring, ("stiffness", "free_angle")),
    TorsionDamper: (Dashpot, ("damping",)),
}
"""Law of each type of force elements, and the attributes that are its coefficients; the others are loads."""


def lower_outputs(
    mechanism: Mechanism, names: Sequence[str], elements: Sequence[ForceElement], origins: Origins, first_input: int
) -> tuple[ConstraintRows, RecordArray]:
    """Return the rows of the outputs along which effects and force elements act, and the forces of the force elements.

    Parameters
    ----------
    mechanism
        Mechanism with its readings and bodies.
    names
        Names of the readings.
    elements
        Force elements of the mechanism.
    origins
        Origin of each body by name, in body axes (m), to which the poses refer; the mass centre if left out.
    first_input
        Index of the first load of the force elements among the inputs.

    Returns
    -------
    rows : ConstraintRows
        A row for each name, then one for each displacement of the force elements.
    forces : RecordArray
        Records of `OUTPUT_FORCE_DTYPE`, one for each displacement.

    Raises
    ------
    TypeError
        If no law is defined for a type of element.
    """
    records: list[tuple[int, int, bool, int, float, tuple[float, ...]]] = []
    for element in elements:
        if not element.loads and type(element) not in _ELEMENT_LAWS:
            raise TypeError(f"no force law is defined for force elements of type {type(element).__name__}")
        for _ in element.loads:
            records.append((LOAD, len(names) + len(records), True, first_input, -math.inf, pad_coefficients((-1.0,))))
            first_input += 1
        if not element.loads:
            law, coefficients = element_law(element)
            row = len(names) + len(records)
            records.append((FORCE_LAWS.index(law), row, law.dissipates, -1, -math.inf, pad_coefficients(coefficients)))
    readings = [*map(mechanism.reading, names), *(output for element in elements for output in element.displacements)]
    return rows_of_readings(mechanism, readings, origins), np.array(records, dtype=OUTPUT_FORCE_DTYPE)


def element_law(element: ForceElement) -> tuple[type[OutputForce], tuple[float, ...]]:
    """Return the law of a spring or damper, and its coefficients."""
    law, names = _ELEMENT_LAWS[type(element)]
    return law, tuple(getattr(element, name) for name in names)


def spring_potential_energy(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Return the potential energy of all springs of a mechanism.

    Parameters
    ----------
    mechanism
        Mechanism with its force elements.
    poses
        Poses of the mass centres, m and rad; shape (..., bodies, 3).

    Returns
    -------
    FloatArray
        Energy, J; shape (...).
    """
    total = np.zeros(poses.shape[:-2])
    for element in mechanism.force_elements:
        if isinstance(element, Spring | TorsionSpring):
            law, coefficients = element_law(element)
            total += law.potential(
                coefficients, OutputDerivatives(rows_of_readings(mechanism, element.displacements[:1], {}), poses).value
            )[0]
    return total
