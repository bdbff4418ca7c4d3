"""Velocities that open no joint: the part of given velocities that the mechanism can have."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import MIN_SPARSE_ROWS, mass_weighted_least_norm
from governor_mechanism.types import FloatArray


class VelocityProjector:
    """Projects velocities of one mechanism along its momentum, so that the joints move with them.

    Of all velocities with closed joints these are nearest in kinetic energy: impulses of the joints alone would bring
    them about.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._position_solver = PositionSolver(mechanism)
        self._degrees_of_freedom = self._position_solver.mobility
        bodies = mechanism.bodies
        masses = np.array([[b.mass, b.mass, b.second_moments.xx + b.second_moments.yy] for b in bodies])
        self._mass_diagonal: FloatArray = masses.ravel()[self._position_solver.free_mask]

    def project(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """(n, bodies, 3) from poses and velocities (n, bodies, 3) at times (n,) s."""
        if len(self._position_solver.equations.joint_indices) < MIN_SPARSE_ROWS:
            return self._project_onto_null_space(poses, velocities, times)
        instants = [slice(k, k + 1) for k in range(len(poses))]
        projected = [self._project_by_impulses(poses[k], velocities[k], times[k]) for k in instants]
        return np.concatenate([np.zeros((0, *velocities.shape[1:])), *projected])

    def _project_by_impulses(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Of one instant, by the impulses of many joints; where they depend on each other, by the directions left."""
        equations, free_mask = self._position_solver.equations, self._position_solver.free_mask
        jacobian = equations.jacobian(poses).reshape(-1, free_mask.size)[:, free_mask]
        rate_residual = equations.prescribed_motion(times)[0, :, 1] - jacobian @ velocities.reshape(-1)[free_mask]
        change = mass_weighted_least_norm(jacobian, self._mass_diagonal, rate_residual)
        if change is None:
            return self._project_onto_null_space(poses, velocities, times)
        return velocities + self._position_solver.expand_free(change)

    def _project_onto_null_space(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """By the directions that joints leave."""
        equations, free_mask, count = self._position_solver.equations, self._position_solver.free_mask, len(poses)
        jacobian = equations.jacobian(poses).reshape(count, -1, free_mask.size)[..., free_mask]
        free_velocities = velocities.reshape(count, -1)[:, free_mask]
        driven_velocities = np.zeros_like(free_velocities)
        if equations.is_driven.any():
            prescribed_rates = equations.prescribed_motion(times)[..., 1]
            driven_velocities = (np.linalg.pinv(jacobian) @ prescribed_rates[..., np.newaxis])[..., 0]
        # The directions that open no joint are the last right singular vectors.
        null_space = np.linalg.svd(jacobian, full_matrices=True)[2][:, jacobian.shape[2] - self._degrees_of_freedom :, :]
        weighted_null_space = null_space * self._mass_diagonal
        momentum = weighted_null_space @ (free_velocities - driven_velocities)[..., np.newaxis]
        independent_velocities = np.linalg.solve(weighted_null_space @ np.swapaxes(null_space, 1, 2), momentum)
        projected = np.zeros((count, free_mask.size))
        projected[:, free_mask] = driven_velocities + np.sum(null_space * independent_velocities, axis=1)
        return projected.reshape(velocities.shape)
