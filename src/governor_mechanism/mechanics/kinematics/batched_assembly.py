"""Many poses of a mechanism of mobility one closed at once, each at its value of the leading coordinate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.types import FloatArray

MAX_BATCHED_NEWTON_STEPS = 12
"""So many Newton steps are made."""

MAX_BRANCH_DISTANCE = 0.05
"""Machine sizes, and rad: poses that close farther from where they were expected may be on another branch."""

NEWTON_DIVERGENCE_STEP = 1.0
"""Machine sizes, and rad: after a Newton step of this size nothing is near by."""

NEWTON_CONVERGENCE_STEP = 1e-8
"""Machine sizes, and rad: after a Newton step of this size rounding alone is left."""


class BatchedPositionSolver:
    """Closes the joints of one mechanism at many values of its coordinate, and says how the bodies move along it."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.position_solver = PositionSolver(mechanism)
        self.coordinate_scale = 1.0 if mechanism.reading(mechanism.coordinate).quantity == "angle" else mechanism.length_scale
        """What a radian, or a machine size, of the coordinate is in SI."""
        self.pose_scales = np.array([mechanism.length_scale, mechanism.length_scale, 1.0])
        """The same of a pose's coordinates."""
        self._coordinate_wraps = isinstance(mechanism.reading(mechanism.coordinate), LineAngle)

    def solve(self, guesses: FloatArray, values: FloatArray) -> FloatArray:
        """Poses (n, bodies, 3) at values (n,), on the branches of expected ones.

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        poses, converged = self.try_solve(guesses, values)
        for k in np.flatnonzero(~converged):
            poses[k] = self.position_solver.solve_at_coordinate(float(values[k]), guesses[k])
        return poses

    def try_solve(self, guesses: FloatArray, values: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Poses (n, bodies, 3) at values (n,), and which of them closed near enough to the expected ones."""
        poses, active, converged = guesses.copy(), np.arange(len(values)), np.zeros(len(values), dtype=np.bool_)
        for _ in range(MAX_BATCHED_NEWTON_STEPS):
            try:
                step = self._newton_step(poses[active], values[active])
            except MechanismError:
                break
            poses[active] -= step
            step_sizes = np.max(np.abs(step) / self.pose_scales, axis=(-2, -1))
            converged[active] = step_sizes < NEWTON_CONVERGENCE_STEP
            active = active[(step_sizes >= NEWTON_CONVERGENCE_STEP) & (step_sizes < NEWTON_DIVERGENCE_STEP)]
            if not active.size:
                break
        distances = np.max(np.abs(poses - guesses) / self.pose_scales, axis=(-2, -1))
        return poses, converged & (distances < MAX_BRANCH_DISTANCE)

    def path_derivatives(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of poses (n, bodies, 3) by the coordinate.

        Raises MechanismError at a dead centre of the coordinate.
        """
        output = evaluate_output(self.mechanism, self.mechanism.coordinate, poses)
        jacobian = self._jacobian(poses, output)
        tangent_rhs = np.zeros(jacobian.shape[:-1])
        tangent_rhs[:, -1] = 1.0
        tangents = self._solve_linear(jacobian, tangent_rhs)
        gamma = self.position_solver.equations.gamma(poses, tangents)
        output_gamma = -evaluate_output(self.mechanism, self.mechanism.coordinate, poses, tangents).quadratic_velocity_term
        return tangents, self._solve_linear(jacobian, np.concatenate([gamma, output_gamma[:, np.newaxis]], axis=1))

    def _newton_step(self, poses: FloatArray, values: FloatArray) -> FloatArray:
        output = evaluate_output(self.mechanism, self.mechanism.coordinate, poses)
        residual = output.value - values
        residual = np.remainder(residual + np.pi, 2 * np.pi) - np.pi if self._coordinate_wraps else residual
        return self._solve_linear(
            self._jacobian(poses, output), np.column_stack([self.position_solver.equations.residuals(poses), residual])
        )

    def _jacobian(self, poses: FloatArray, coordinate_output: OutputDerivatives) -> FloatArray:
        joint_jacobian = self.position_solver.equations.jacobian(poses).reshape(len(poses), -1, self.position_solver.free_mask.size)
        jacobian = np.concatenate([joint_jacobian, coordinate_output.gradient.reshape(len(poses), 1, -1)], axis=1)
        return jacobian[..., self.position_solver.free_mask]

    def _solve_linear(self, jacobian: FloatArray, rhs: FloatArray) -> FloatArray:
        """Changes of all poses (n, bodies, 3) that the joints and the coordinate ask for."""
        free_mask, is_square = self.position_solver.free_mask, jacobian.shape[1] == jacobian.shape[2]
        column = rhs[..., np.newaxis]
        try:
            solution = np.linalg.solve(jacobian, column) if is_square else np.linalg.pinv(jacobian) @ column
        except np.linalg.LinAlgError as error:
            raise MechanismError(f"{self.mechanism.coordinate!r} stands at a dead centre there and does not settle the others") from error
        changes = np.zeros((len(jacobian), free_mask.size))
        changes[:, free_mask] = solution[..., 0]
        return changes.reshape(len(jacobian), -1, 3)
