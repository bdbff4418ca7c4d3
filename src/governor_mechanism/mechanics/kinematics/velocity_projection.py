"""Projection of velocities onto the velocity constraints of the joints."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import MIN_SPARSE_ROWS, mass_weighted_least_norm
from governor_mechanism.types import FloatArray


class VelocityProjector:
    """Project velocities of one mechanism onto its velocity constraints, in the metric of the mass matrix.

    The result is the admissible velocity nearest in kinetic energy: the one that impulses of the joints alone bring about.

    Parameters
    ----------
    mechanism
        The mechanism whose joints and drives constrain the velocities.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._position_solver = PositionSolver(mechanism)
        self._degrees_of_freedom = self._position_solver.mobility
        bodies = mechanism.bodies
        masses = np.array([[b.mass, b.mass, b.second_moments.xx + b.second_moments.yy] for b in bodies])
        self._mass_diagonal: FloatArray = masses.ravel()[self._position_solver.free_mask]

    def project(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Project velocities at n times.

        Parameters
        ----------
        poses
            Assembled poses; shape (n, bodies, 3).
        velocities
            Velocities to project; shape (n, bodies, 3).
        times
            Times at which the drives are evaluated, s; shape (n,).

        Returns
        -------
        FloatArray
            Velocities that satisfy joints and drives; shape (n, bodies, 3).
        """
        if len(self._position_solver.equations.joint_indices) < MIN_SPARSE_ROWS:
            return self._project_onto_null_space(poses, velocities, times)
        instants = [slice(k, k + 1) for k in range(len(poses))]
        projected = [self._project_by_impulses(poses[k], velocities[k], times[k]) for k in instants]
        return np.concatenate([np.zeros((0, *velocities.shape[1:])), *projected])

    def _project_by_impulses(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Project at one time by the impulses of the joints; use the null space where the joints are redundant."""
        equations, free_mask = self._position_solver.equations, self._position_solver.free_mask
        jacobian = equations.jacobian(poses).reshape(-1, free_mask.size)[:, free_mask]
        rate_residual = equations.prescribed_motion(times)[0, :, 1] - jacobian @ velocities.reshape(-1)[free_mask]
        change = mass_weighted_least_norm(jacobian, self._mass_diagonal, rate_residual)
        if change is None:
            return self._project_onto_null_space(poses, velocities, times)
        return velocities + self._position_solver.expand_free(change)

    def _project_onto_null_space(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Project onto the null space of the joint Jacobian."""
        equations, free_mask, count = self._position_solver.equations, self._position_solver.free_mask, len(poses)
        jacobian = equations.jacobian(poses).reshape(count, -1, free_mask.size)[..., free_mask]
        free_velocities = velocities.reshape(count, -1)[:, free_mask]
        driven_velocities = np.zeros_like(free_velocities)
        if equations.is_driven.any():
            prescribed_rates = equations.prescribed_motion(times)[..., 1]
            driven_velocities = (np.linalg.pinv(jacobian) @ prescribed_rates[..., np.newaxis])[..., 0]
        # The last right singular vectors span the null space of the joints.
        null_space = np.linalg.svd(jacobian, full_matrices=True)[2][:, jacobian.shape[2] - self._degrees_of_freedom :, :]
        weighted_null_space = null_space * self._mass_diagonal
        momentum = weighted_null_space @ (free_velocities - driven_velocities)[..., np.newaxis]
        independent_velocities = np.linalg.solve(weighted_null_space @ np.swapaxes(null_space, 1, 2), momentum)
        projected = np.zeros((count, free_mask.size))
        projected[:, free_mask] = driven_velocities + np.sum(null_space * independent_velocities, axis=1)
        return projected.reshape(velocities.shape)
