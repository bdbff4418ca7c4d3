"""What a mechanism tells beside its readings: forces that follow from where it stands, at any poses of a run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.force_laws import spring_force
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.mechanics.kinematics.points import place
from governor_mechanism.mechanics.reduction.lagrangian import Reduction
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import DrivenSlide, DrivenTurn
from governor_mechanism.model.mechanism import Mechanism, SpringForce, StaticForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


def outputs_of(scene: Scene, poses: FloatArray) -> dict[str, FloatArray]:
    """The outputs (n,) N of a scene's mechanism by name, at poses (n, bodies, 3) that close its joints.

    Raises MechanismError for a static force of a mechanism of another mobility than one, or at a dead centre.
    """
    mechanism = scene.part.mechanism

    @cache
    def static(reading: str) -> FloatArray:
        return static_force(scene, reading, poses)

    found: dict[str, FloatArray] = {}
    for output in mechanism.outputs:
        match output:
            case SpringForce():
                found[output.name] = _pull(mechanism, output.spring, poses)
            case StaticForce():
                found[output.name] = output.part * static(output.reading)
            case _:
                raise TypeError(f"no equation is written for outputs of type {type(output).__name__}")
    return found


def static_force(scene: Scene, reading: str, poses: FloatArray) -> FloatArray:
    """Force (n,) N that has to push along a reading to hold the mechanism at poses (n, bodies, 3) on a still spindle.

    By virtual work: what springs and weights take up on a small way along the coordinate, over the reading's way.
    Drives, which may be what holds it, are left out. Raises MechanismError as `outputs_of` does.
    """
    if not len(poses):
        return np.zeros(0)
    part = scene.part
    loose = tuple(joint for joint in part.mechanism.joints if not isinstance(joint, DrivenSlide | DrivenTurn))
    mechanism = replace(part.mechanism, joints=loose)
    reduction = Reduction(replace(scene, parts=(replace(part, mechanism=mechanism),)))
    along = reduction.over(poses, reading_value(mechanism, mechanism.coordinate, poses))
    slope = reduction.slopes(along, reading)
    force: FloatArray = np.divide(along.potential_slope, slope, out=np.full_like(slope, np.inf), where=slope != 0.0)
    return force


def _pull(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    spring = next((load for load in mechanism.loads if load.name == name), None)
    if not isinstance(spring, Spring):
        known = [load.name for load in mechanism.loads if isinstance(load, Spring)]
        raise MechanismError(f"there is no spring {name!r} among the loads; springs are {known}")
    line = place(mechanism, spring.second).position(poses) - place(mechanism, spring.first).position(poses)
    pull: FloatArray = spring_force(spring.stiffness, spring.free_length, np.linalg.norm(line, axis=-1))
    return pull
