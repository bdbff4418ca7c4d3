"""Kinetic and potential energy of the motion in the plane, from poses and velocities."""

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.dynamics.force_laws import gravitational_energy
from governor_mechanism.mechanics.dynamics.output_forces import element_potential_energy
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray


def evaluate_mechanical_energy(
    scene: Scene,
    poses: FloatArray,  # poses of the mass centres, m and rad; shape (n, bodies, 3)
    velocities: FloatArray,  # their time derivatives; same shape
) -> tuple[FloatArray, FloatArray]:
    """Return the kinetic energy, and the potential energy of gravity and springs; J, shape (n,) each."""
    weights, inertias = _energy_coefficients(scene)
    kinetic = (velocities**2).reshape(len(velocities), inertias.size) @ inertias.ravel()
    potential = poses[:, :, 1] @ weights + element_potential_energy(scene.mechanism, poses)
    for effect in output_forces_of(scene):
        value = evaluate_output_value(scene.mechanism, effect.reading, poses)
        potential += np.where(value < effect.slack_below, 0.0, effect.potential(effect.coefficients, value)[0])
    return kinetic, potential


@once_per_object
def _energy_coefficients(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Weight (bodies,) N of each body, and half the inertia (bodies, 3) of its motion in the plane; zero for shafts of spindles."""
    mechanism = scene.mechanism
    shafts = {mechanism.body_index(plane.shaft) for plane in scene.system.planes if plane.shaft and plane.has_reaction}
    counted = np.array([index not in shafts for index in range(len(mechanism.bodies))])
    masses = np.array([body.mass for body in mechanism.bodies])
    inertias = np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies]).reshape(-1, 3)
    weights = gravitational_energy(masses, np.array(scene.system.gravity), 1.0)
    return counted * weights, 0.5 * counted[:, np.newaxis] * inertias
