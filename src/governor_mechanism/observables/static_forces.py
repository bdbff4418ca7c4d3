"""What a mechanism tells beside its readings: forces that follow from where it stands, at any poses of a run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.force_laws import spring_force
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.kinematics.points import body_point
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism, SpringForce, StaticForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


def evaluate_derived_forces(scene: Scene, poses: FloatArray) -> dict[str, FloatArray]:
    """The outputs (n,) N of a scene's mechanism by name, at poses (n, bodies, 3) that close its joints.

    Raises MechanismError for a static force of a mechanism of another mobility than one, or at a dead centre.
    """
    mechanism = scene.part.mechanism

    @cache
    def cached_static_force(reading: str) -> FloatArray:
        return compute_static_force(scene, reading, poses)

    forces: dict[str, FloatArray] = {}
    for output in mechanism.derived_forces:
        match output:
            case SpringForce():
                forces[output.name] = _spring_force(mechanism, output.spring, poses)
            case StaticForce():
                forces[output.name] = output.fraction * cached_static_force(output.reading)
            case _:
                raise TypeError(f"no equation is written for outputs of type {type(output).__name__}")
    return forces


def compute_static_force(scene: Scene, reading: str, poses: FloatArray) -> FloatArray:
    """Force (n,) N that has to push along a reading to hold the mechanism at poses (n, bodies, 3) on a still spindle.

    By virtual work: what springs and weights take up on a small way along the coordinate, over the reading's way.
    Drives, which may be what holds it, are left out. Raises MechanismError as `outputs_of` does.
    """
    if not len(poses):
        return np.zeros(0)
    part = scene.part
    undriven_joints = tuple(joint for joint in part.mechanism.joints if not isinstance(joint, TranslationalDriver | RotationalDriver))
    mechanism = replace(part.mechanism, joints=undriven_joints)
    reduction = SingleDofReduction(replace(scene, parts=(replace(part, mechanism=mechanism),)))
    coefficients = reduction.evaluate_at_poses(poses, evaluate_output_value(mechanism, mechanism.coordinate, poses))
    reading_derivative = reduction.output_derivative(coefficients, reading)
    force: FloatArray = np.divide(
        coefficients.potential_derivative, reading_derivative, out=np.full_like(reading_derivative, np.inf), where=reading_derivative != 0.0
    )
    return force


def _spring_force(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    spring = next((load for load in mechanism.force_elements if load.name == name), None)
    if not isinstance(spring, Spring):
        spring_names = [load.name for load in mechanism.force_elements if isinstance(load, Spring)]
        raise MechanismError(f"there is no spring {name!r} among the loads; springs are {spring_names}")
    separation = body_point(mechanism, spring.second).position(poses) - body_point(mechanism, spring.first).position(poses)
    force: FloatArray = spring_force(spring.stiffness, spring.free_length, np.linalg.norm(separation, axis=-1))
    return force
