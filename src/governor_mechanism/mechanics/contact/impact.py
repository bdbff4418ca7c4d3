"""Velocities changed by impulses of the joints and of what strikes or holds."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import MIN_SPARSE_ROWS, mass_weighted_least_norm
from governor_mechanism.types import FloatArray

PSEUDOINVERSE_CUTOFF_RATIO = 1e-13
"""Singular values below this fraction of the largest one belong to equations that others contain."""

N_CLOSURE_ITERATIONS = 3
"""Newton's steps in which joints are closed: from what one step of the motion opens, to rounding."""


class ImpactSolver:
    """Throws the bodies of one mechanism so that its joints move with them and some readings have given rates."""

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
        """Velocities (bodies, 3) from others at poses (bodies, 3), readings with gradients (readings, bodies, 3) having
        the rates (readings,): the nearest in kinetic energy, so impulses along joints and readings bring them about.
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
        """Poses (n, bodies, 3) with closed joints at times (n,) s, nearest to others in their masses."""
        equations, free = self._position_solver.equations, self._position_solver.free_mask
        closed_poses = poses.copy()
        for _ in range(N_CLOSURE_ITERATIONS):
            correction = np.zeros((len(poses), free.size))
            correction[:, free] = self._solve_correction(self._joint_jacobian(closed_poses), -equations.residuals(closed_poses, times))
            closed_poses += correction.reshape(poses.shape)
        return closed_poses

    def _joint_jacobian(self, poses: FloatArray) -> FloatArray:
        """Gradients (n, equations, free coordinates) of the joints at poses (n, bodies, 3)."""
        free = self._position_solver.free_mask
        jacobian: FloatArray = self._position_solver.equations.jacobian(poses).reshape(len(poses), -1, free.size)[..., free]
        return jacobian

    def _solve_correction(self, jacobian: FloatArray, residual: FloatArray) -> FloatArray:
        """The least change (n, free coordinates), weighed by mass, that changes rows . change by what is wanted."""
        n_rows, n_coordinates = jacobian.shape[1], len(self._masses)
        if n_rows >= MIN_SPARSE_ROWS:
            systems = zip(jacobian, residual, strict=True)
            corrections = [mass_weighted_least_norm(one, self._masses, right_hand_side) for one, right_hand_side in systems]
            if all(one is not None for one in corrections):
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
        """Kinetic energy in the plane (J) at velocities (bodies, 3)."""
        free_velocities = velocities.ravel()[self._position_solver.free_mask]
        return 0.5 * float(np.sum(self._masses * free_velocities**2))
