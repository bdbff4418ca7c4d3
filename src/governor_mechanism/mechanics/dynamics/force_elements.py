"""Force elements of a mechanism: forces along outputs of their own, with the same laws as effects."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.registry import FORCE_LAWS
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.dynamics.output_forces import LOAD, MAX_COEFFICIENTS, OUTPUT_FORCE_DTYPE
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives
from governor_mechanism.mechanics.kinematics.points import Origins
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray, RecordArray

_ELEMENT_LAWS: dict[type[ForceElement], tuple[type[OutputForce] | None, tuple[str, ...]]] = {
    Spring: (OutputSpring, ("stiffness", "free_length")),
    Damper: (Dashpot, ("damping",)),
    TorsionSpring: (OutputSpring, ("stiffness", "free_angle")),
    TorsionDamper: (Dashpot, ("damping",)),
    Torque: (None, ()),
    Force: (None, ()),
}
"""Law of each type of force elements, and the attributes that are its coefficients; None for loads, which are inputs."""


def lower_force_elements(
    mechanism: Mechanism, elements: Sequence[ForceElement], origins: Origins, first_row: int, first_input: int
) -> tuple[RecordArray, RecordArray]:
    """Return force elements as output rows and as the forces along them.

    Parameters
    ----------
    mechanism
        Mechanism with their bodies.
    elements
        The force elements.
    origins
        Origin of each body by name, in body axes (m), to which the poses refer; the mass centre if left out.
    first_row
        Index of their first row among the output rows.
    first_input
        Index of their first load among the inputs.

    Returns
    -------
    rows : RecordArray
        Records of `CONSTRAINT_ROW_DTYPE`.
    forces : RecordArray
        Records of `OUTPUT_FORCE_DTYPE`, one for each row.

    Raises
    ------
    TypeError
        If no law is defined for a type of element.
    """
    rows = rows_of_readings(mechanism, [output for element in elements for output in element.displacements], origins).table
    forces, input_index = np.zeros(len(rows), dtype=OUTPUT_FORCE_DTYPE), first_input
    for element in elements:
        if type(element) not in _ELEMENT_LAWS:
            raise TypeError(f"no force law is defined for force elements of type {type(element).__name__}")
        law, names = _ELEMENT_LAWS[type(element)]
```
