"""Readings of the forces and moments of joints."""

from collections.abc import Sequence

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.forces.contact_modes import ContactMode
from governor_mechanism.model.output_variables import DerivedReading, JointForce, JointMoment
from governor_mechanism.model.results.reaction import Reaction
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.run_result import StateHistory, compute_reactions
from governor_mechanism.types import FloatArray


def evaluate_joint_forces(scene: Scene, history: StateHistory, modes: Sequence[ContactMode]) -> dict[str, FloatArray]:
    """Return the forces and moments of joints that the run reports, by name, in SI; shape (n,) each.

    Raises MechanismError if rigid-body mechanics determines one of them at none of the times.
    """
    outputs = [one for one in scene.mechanism.derived_readings if isinstance(one, JointForce | JointMoment)]
    if not outputs:
        return {}
    reactions = compute_reactions(scene, history, modes)
    joints = dict.fromkeys(output.joint for output in outputs)
    undetermined = [name for name in joints if len(history.times) and not reactions[name].determined.any()]
    if undetermined:
        raise MechanismError(*map(_undetermined_message, undetermined))
    return {output.name: _value(reactions[output.joint], output) for output in outputs}


def _undetermined_message(joint: str) -> str:
    return (
        f"run.readings names 'reaction.{joint}', a joint whose force rigid-body mechanics does not determine: joints hold the bodies "
        "more often than their motion needs; leave the joint out, or remove a joint that is redundant"
    )


def _value(reaction: Reaction, output: DerivedReading) -> FloatArray:
    """Return the component (n,) of a reaction that a reading is."""
    components = {"x": reaction.force[:, 0], "y": reaction.force[:, 1], "magnitude": reaction.magnitude}
    return components[output.component] if isinstance(output, JointForce) else reaction.moment
