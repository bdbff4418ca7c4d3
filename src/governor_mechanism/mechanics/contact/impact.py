"""Velocity jumps by impulses of joints and contacts, and closure of joints."""

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
        masses = np.array([[b.mass, b.mass, b.second_moments.xx + b.second_moments.yy] for b in mechanism.bodies])
        self._masses: FloatArray = masses.ravel()[self._position_solver.free_mask]
        self._n_equations = len(self._position_solver.equations.joint_indices)
        self.mobility = self._position_solver.mobility
        self._has_full_rank = int(self._position_solver.free_mask.sum()) - self.mobility == self._n_equations

    def apply_impulses(
        self, time: float, poses: FloatArray, velocities: FloatArray, output_jacobian: FloatArray, output_rates: FloatArray
    ) -> FloatArray:
        """Return the velocities (bodies, 3) after impulses along the joints and along output variables with prescribed rates.

        They are the velocities nearest to the given ones in the kinetic-energy norm. Poses are (bodies, 3), `output_jacobian` is
        (outputs, bodies, 3), `output_rates` (outputs,) in m/s or rad/s, `time` in s.
        """
        equations, free = self._position_solver.equations, self._position_solver.free_mask
        joint_jacobian = self._joint_jacobian(poses[np.newaxis])[0]
        jacobian = np.concatenate([joint_jacobian, output_jacobian.reshape(-1, free.size)[:, free]])
        drive_rates = np.zeros(len(joint_jacobian))
        if equations.is_driven.any():
            drive_rates = equations.prescribed_motion(np.array([time]))[0, :, 1]
        free_velocities = velocities.ravel()[free]
        velocity_residual = np.concatenate([drive_rates, output_rates]) - jacobian @ free_velocities
        new_velocities = np.zeros(free.size)
        new_velocities[free] = free_velocities + self._solve_correction(jacobian[np.newaxis], velocity_residual[np.newaxis])[0]
        return new_velocities.reshape(velocities.shape)

    def close_joints(self, times: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the poses (n, bodies, 3) with closed joints at times (n,) s that are nearest in the mass-weighted norm."""
        equations, free = self._position_solver.equations, self._position_solver.free_mask
        closed_poses = poses.copy()
        for _ in range(N_CLOSURE_ITERATIONS):
            correction = np.zeros((len(poses), free.size))
            correction[:, free] = self._solve_correction(self._joint_jacobian(closed_poses), -equations.residuals(closed_poses, times))
            closed_poses += correction.reshape(poses.shape)
        return closed_poses

    def _joint_jacobian(self, poses: FloatArray) -> FloatArray:
        """Return the Jacobian (n, equations, free coordinates) of the joints at poses (n, bodies, 3)."""
        free = self._position_solver.free_mask
        jacobian: FloatArray = self._position_solver.equations.jacobian(poses).reshape(len(poses), -1, free.size)[..., free]
        return jacobian

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
