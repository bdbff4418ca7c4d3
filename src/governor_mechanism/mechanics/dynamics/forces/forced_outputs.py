"""Outputs along which forces act or on which loads depend, and the output forces in a contact mode."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.mechanics.dynamics.forces import output_forces
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode, active_forces_of
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.forces.loads import reading_functions_of
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import RecordArray


@once_per_object
def forced_output_names(scene: Scene) -> list[str]:
    """Return the readings along which effects act or on which loads depend.

    Result: names in the order of the output rows of a system.
    """
    functions = reading_functions_of(scene)
    return list(dict.fromkeys([effect.reading for effect in scene.output_effects] + [one.source for one in functions]))


def make_output_forces(
    scene: Scene,
    mode: ContactMode,
    friction_inputs: Sequence[int],  # input of the friction limit of each contact, see `InputLayout`
) -> RecordArray:
    """Return the output forces in a contact mode: effects with a force law, then friction of sliding contacts.

    Result: records of `OUTPUT_FORCE_DTYPE`; shape (forces,).
    """
    output_names = forced_output_names(scene)
    records = [output_forces.output_force_record(effect, output_names.index(effect.reading)) for effect in active_forces_of(scene, mode)]
    law = output_forces.SLIDING_FRICTION
    for contact, sign, friction_input in zip(contacts_of(scene), mode.sliding_signs, friction_inputs, strict=True):
        if sign:
            output = output_names.index(contact.output_name)
            records.append(output_forces.make_output_force(law, output, (float(sign),), has_power=True, input_index=friction_input))
    return np.array(records, dtype=output_forces.OUTPUT_FORCE_DTYPE)
