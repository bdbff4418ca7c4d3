"""Size of the model of a scene."""

from collections.abc import Mapping

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import contacts_of, output_forces_of
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names
from governor_mechanism.mechanics.kinematics.constraint_equations import make_constraint_table
from governor_mechanism.model.scene import Scene


def count_model_size(scene: Scene) -> Mapping[str, int]:
    """Count the elements of the model of a scene.

    Parameters
    ----------
    scene
        Scene with one part.

    Returns
    -------
    Mapping[str, int]
        Number of bodies, constraint equations, force elements, contacts and so on; only those that are not zero.
    """
    mechanism, contacts = scene.mechanism, contacts_of(scene)
    counts = {
        "bodies": len(mechanism.bodies),
        "joint equations": len(make_constraint_table(mechanism).joint_indices),
        "force elements": len(mechanism.force_elements),
        "readings with forces": len(forced_output_names(scene)),
        "springs and dashpots along readings": len(output_forces_of(scene)),
        "frictions": sum(contact.friction is not None for contact in contacts),
        "stops": sum(int(np.isfinite(contact.low)) + int(np.isfinite(contact.high)) for contact in contacts),
    }
    return {name: count for name, count in counts.items() if count}
