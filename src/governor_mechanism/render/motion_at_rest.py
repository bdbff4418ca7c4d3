"""Poses as a motion that drawings take."""

from collections.abc import Mapping

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS
from governor_mechanism.model.results.cost import Cost
from governor_mechanism.model.results.energy import Energy
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


def motion_at_rest(
    scene: Scene,
    poses: FloatArray,  # shape (n, bodies, 3)
    readings: Mapping[str, FloatArray] | None = None,
) -> Trajectory:
    """Return poses as a motion at rest in each of them: a drawing asks for ranges of readings and for the space that is swept."""
    zeros = np.zeros(len(poses))
    units = {one.name: READING_UNITS[one.quantity] for one in scene.mechanism.readings}
    return Trajectory(
        scene=scene,
        times=np.arange(len(poses), dtype=np.float64),
        poses=poses,
        velocities=np.zeros_like(poses),
        readings=readings or {},
        rates={},
        units=units,
        scales={},
        joint_gap=zeros,
        energy=Energy(kinetic=zeros, potential=zeros, rotation=zeros, jacobi=zeros, dissipated_energy=zeros, scale=1.0),
        outcome=Outcome.NOT_CERTIFIED,
        cost=Cost(engine="none", reason="", step=0.0, steps=0, runs=0, evaluations={}, wall_time=0.0),
    )
