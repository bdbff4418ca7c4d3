"""Projection of the states of a scene onto its joints."""

import numpy as np

from governor_mechanism.mechanics.dynamics.equations_of_motion import project_state
from governor_mechanism.mechanics.dynamics.lowering import from_mass_centres, make_system, make_system_workspace, to_mass_centres
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

CLOSURE_TOLERANCE_RATIO = 1e-14
"""Gap of a closed joint, in length scales: rounding."""


class StateProjector:
    """Projection of states onto joints and drives, in the metric of the mass matrix.

    Parameters
    ----------
    scene
        The scene.
    """

    def __init__(self, scene: Scene) -> None:
        system, self._input_functions = make_system(scene)
        self._model = system, make_system_workspace(system)
        self._closure_tolerance = CLOSURE_TOLERANCE_RATIO * scene.mechanism.length_scale

    def project(
        self, times: FloatArray, poses: FloatArray, velocities: FloatArray, *, closes_joints: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Return the nearest admissible states; velocities are those that impulses of the joints bring about.

        Parameters
        ----------
        times
            Times at which the drives are evaluated, s; shape (n,).
        poses
            Poses of the mass centres, m and rad, with those of free shafts or without; shape (n, bodies, 3).
        velocities
            Their time derivatives; shape (n, bodies, 3).
        closes_joints
            Whether poses are projected as well; else they are kept.

        Returns
        -------
        poses : FloatArray
            Poses with closed joints; shape (n, bodies, 3).
        velocities : FloatArray
            Velocities that satisfy joints and drives; shape (n, bodies, 3).
        """
        system = self._model[0]
        n_bodies = poses.shape[1]
        without_shafts = ((0, 0), (0, len(system.bodies) - n_bodies), (0, 0))
        origins, origin_velocities = from_mass_centres(system, np.pad(poses, without_shafts), np.pad(velocities, without_shafts))
        cubics = stack_local_cubics(self._input_functions, times)
        tolerance = self._closure_tolerance if closes_joints else np.inf
        for k in range(len(times)):
            project_state(*self._model, cubics[k], 0.0, origins[k], origin_velocities[k], tolerance)
        projected_poses, projected_velocities = to_mass_centres(system, origins, origin_velocities)
        return projected_poses[:, :n_bodies], projected_velocities[:, :n_bodies]
