"""Spring forces and static forces of a mechanism."""

from dataclasses import replace
from functools import cache, partial

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.forces.force_elements import element_law
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.force_elements import Spring
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import SpringForce, StaticForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


def evaluate_static_forces(scene: Scene, poses: FloatArray) -> dict[str, FloatArray]:
    """Return the spring forces and static forces (n,), N, by name at poses (n, bodies, 3) that close the joints.

    Raise as `compute_static_force` does.
    """
    mechanism = scene.mechanism

    static_force = cache(partial(compute_static_force, scene, poses=poses))
    forces: dict[str, FloatArray] = {}
    for output in mechanism.derived_readings:
        match output:
            case SpringForce():
                forces[output.name] = _spring_force(mechanism, output.spring, poses)
            case StaticForce():
                forces[output.name] = output.fraction * static_force(output.reading)
    return forces


def compute_static_force(
    scene: Scene,
    reading: str,
    poses: FloatArray,  # poses, m and rad; shape (n, bodies, 3)
) -> FloatArray:
    """Return the force along a reading that holds the mechanism without rotation of the spindle, by virtual work.

    It is the change of the potential of springs and weights over the change of the reading. Drivers are left out.

    Result: force, N or N m; shape (n,). Infinite at a turning point of the reading. Raises MechanismError if
    the mechanism has another number of degrees of freedom, or at a singular configuration.
    """
    if not len(poses):
        return np.zeros(0)
    part, reading = scene.part_of(reading)
    prefix = "" if len(scene.parts) == 1 else f"{part.name}."
    poses = poses[:, [scene.mechanism.body_index(prefix + body.name) for body in part.mechanism.bodies]]
    undriven_joints = tuple(joint for joint in part.mechanism.joints if not isinstance(joint, TranslationalDriver | RotationalDriver))
    mechanism = replace(part.mechanism, joints=undriven_joints)
    reduction = SingleDofReduction(Scene(title=scene.title, parts=(replace(part, mechanism=mechanism),)))
    coefficients = reduction.evaluate_near(poses, evaluate_output_value(mechanism, mechanism.coordinate, poses))
    reading_derivative = reduction.output_derivative(coefficients, reading)
    force = np.full_like(reading_derivative, np.inf)
    return np.divide(coefficients.potential_derivative, reading_derivative, out=force, where=reading_derivative != 0.0)


def _spring_force(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    spring = next((load for load in mechanism.force_elements if load.name == name), None)
    if not isinstance(spring, Spring):
        spring_names = [load.name for load in mechanism.force_elements if isinstance(load, Spring)]
        raise MechanismError(f"there is no spring {name!r} among the force elements; springs are {spring_names}")
    length = OutputDerivatives(rows_of_readings(mechanism, spring.displacements[:1], {}), poses).value
    law, coefficients = element_law(spring)
    force: FloatArray = -law.force(coefficients, length, 0.0)
    return force
