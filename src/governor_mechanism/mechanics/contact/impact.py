"""Velocity jumps by impulses of joints and contacts, projection onto the velocity constraints, and closure of joints."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import MIN_SPARSE_ROWS, mass_weighted_least_norm
from governor_mechanism.types import FloatArray

PSEUDOINVERSE_CUTOFF_RATIO = 1e-13
"""Singular values below this fraction of the largest belong to redundant equations."""

N_CLOSURE_ITERATIONS = 3
"""Number of Newton iterations that close the joints: enough to go from the gap of system_jacobian step to rounding."""


class ImpactSolver:
    """Impulsive velocity changes of a mechanism: joints stay compatible and some output variables get prescribed rates.

    Parameters
    ----------
    mechanism
        Mechanism whose bodies the impulses move.

    Attributes
    ----------
    mobility
        Number of degrees of freedom of the mechanism.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._position_solver = PositionSolver(mechanism)
        self._masses = self._position_solver.free_masses
        self._n_equations = len(self._position_solver.equations.joint_indices)
        self.mobility = self._position_solver.mobility
        self._has_full_rank = len(self._masses) - self.mobility == self._n_equations

    def apply_impulses(
        self, time: float, poses: FloatArray, velocities: FloatArray, output_jacobian: FloatArray, output_rates: FloatArray
    ) -> FloatArray:
        """Return the velocities (bodies, 3) after impulses along the joints and along output variables with prescribed rates.

        They are the velocities nearest to the given ones in the kinetic-energy norm. Poses are (bodies, 3), `output_jacobian` is
        (outputs, bodies, 3), `output_rates` (outputs,) in m/s or rad/s, `time` in s.
        """
        equations, free = self._position_solver.equations, self._position_solver.free_mask
        jacobian = np.concatenate([self._position_solver.joint_jacobian(poses), output_jacobian.reshape(-1, free.size)[:, free]])
        drive_rates = equations.prescribed_motion(np.array(time))[:, 1]
        free_velocities = velocities.ravel()[free]
        velocity_residual = np.concatenate([drive_rates, output_rates]) - jacobian @ free_velocities
        correction = self._solve_correction(jacobian[np.newaxis], velocity_residual[np.newaxis])[0]
        return self._position_solver.expand_free(free_velocities + correction)

    def close_joints(self, times: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the poses (n, bodies, 3) with closed joints at times (n,) s that are nearest in the mass-weighted norm."""
        closed_poses = poses.copy()
        for _ in range(N_CLOSURE_ITERATIONS):
            residuals = self._position_solver.equations.residuals(closed_poses, times)
            correction = self._solve_correction(self._position_solver.joint_jacobian(closed_poses), -residuals)
            closed_poses += self._position_solver.expand_free(correction)
        return closed_poses

    def project_velocities(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Project velocities onto the velocity constraints, in the metric of the mass matrix.

        The result is the admissible velocity nearest in kinetic energy: the one that impulses of the joints alone bring about.

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
        if self._n_equations < MIN_SPARSE_ROWS:
            return self._project_onto_null_space(poses, velocities, times)
        instants = [slice(k, k + 1) for k in range(len(poses))]
        projected = [self._project_by_impulses(poses[k], velocities[k], times[k]) for k in instants]
        return np.concatenate([np.zeros((0, *velocities.shape[1:])), *projected])

    def _project_by_impulses(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Project at one time by the impulses of the joints; use the null space where the joints are redundant."""
        position_solver = self._position_solver
        jacobian = position_solver.joint_jacobian(poses)[0]
        prescribed_rates = position_solver.equations.prescribed_motion(times)[0, :, 1]
        rate_residual = prescribed_rates - jacobian @ velocities.ravel()[position_solver.free_mask]
        change = mass_weighted_least_norm(jacobian, self._masses, rate_residual)
        if change is None:
            return self._project_onto_null_space(poses, velocities, times)
        return velocities + position_solver.expand_free(change)

    def _project_onto_null_space(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Project onto the null space of the joint Jacobian."""
        equations, jacobian = self._position_solver.equations, self._position_solver.joint_jacobian(poses)
        free_velocities = velocities.reshape(len(poses), -1)[:, self._position_solver.free_mask]
        driven_velocities = np.zeros_like(free_velocities)
        if equations.is_driven.any():
            prescribed_rates = equations.prescribed_motion(times)[..., 1]
            driven_velocities = (np.linalg.pinv(jacobian) @ prescribed_rates[..., np.newaxis])[..., 0]
        # The last right singular vectors span the null space of the joints.
        null_space = np.linalg.svd(jacobian)[2][:, len(self._masses) - self.mobility :, :]
        weighted_null_space = null_space * self._masses
        momentum = weighted_null_space @ (free_velocities - driven_velocities)[..., np.newaxis]
        independent_velocities = np.linalg.solve(weighted_null_space @ np.swapaxes(null_space, 1, 2), momentum)
        return self._position_solver.expand_free(driven_velocities + np.sum(null_space * independent_velocities, axis=1))

    def _solve_correction(self, jacobian: FloatArray, residual: FloatArray) -> FloatArray:
        """Return the least mass-weighted correction (n, free coordinates) with jacobian @ correction = residual."""
        n_rows, n_coordinates = jacobian.shape[1], len(self._masses)
        if n_rows >= MIN_SPARSE_ROWS:
            systems = zip(jacobian, residual, strict=True)
            corrections = [mass_weighted_least_norm(rows, self._masses, right_hand_side) for rows, right_hand_side in systems]
            if all(correction is not None for correction in corrections):
                return np.array(corrections).reshape(len(jacobian), n_coordinates)
        matrix = np.zeros((len(jacobian), n_coordinates + n_rows, n_coordinates + n_rows))
        matrix[:, :n_coordinates, :n_coordinates] = np.diag(self._masses)
        matrix[:, :n_coordinates, n_coordinates:], matrix[:, n_coordinates:, :n_coordinates] = (np.swapaxes(jacobian, 1, 2), jacobian)
        right_hand_side = np.zeros((len(jacobian), n_coordinates + n_rows, 1))
        right_hand_side[:, n_coordinates:, 0] = residual
        if self._has_full_rank and n_rows == self._n_equations:
            solution = np.linalg.solve(matrix, right_hand_side)
        else:
            solution = np.linalg.pinv(matrix, rcond=PSEUDOINVERSE_CUTOFF_RATIO, hermitian=True) @ right_hand_side
        correction: FloatArray = solution[:, :n_coordinates, 0]
        return correction

    def kinetic_energy(self, velocities: FloatArray) -> float:
        """Return the kinetic energy in the plane (J) at velocities (bodies, 3)."""
        free_velocities = velocities.ravel()[self._position_solver.free_mask]
        return 0.5 * float(np.sum(self._masses * free_velocities**2))
