"""Assembly of a mechanism with one degree of freedom at many values of its leading coordinate at once."""

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.types import FloatArray

MAX_BATCHED_NEWTON_STEPS = 12
"""Largest number of Newton steps."""

MAX_BRANCH_DISTANCE = 0.05
"""Distance from the guess, in length scales and rad, beyond which a solution may belong to another branch."""

NEWTON_DIVERGENCE_STEP = 1.0
"""Newton step, in length scales and rad, from which the iteration counts as diverged: no solution is near."""

NEWTON_CONVERGENCE_STEP = 1e-8
"""Newton step, in length scales and rad, below which the iteration has converged; the next error is of rounding size."""


class BatchedPositionSolver(PositionSolver):
    """Assemble one mechanism at many values of its leading coordinate and differentiate the poses along it."""

    @property
    def initial_coordinate(self) -> float:
        """Value of the leading coordinate at the initial guess, SI."""
        return float(evaluate_output(self.mechanism, self.mechanism.coordinate, self.initial_guess).value)

    def solve_at_coordinates(self, guesses: FloatArray, values: FloatArray) -> FloatArray:
        """Return poses (n, bodies, 3) at values (n,), on the branches of the guesses (n, bodies, 3).

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        poses, converged = self.try_solve_at_coordinates(guesses, values)
        for k in np.flatnonzero(~converged):
            poses[k] = self.solve_at_coordinate(float(values[k]), guesses[k])
        return poses

    def try_solve_at_coordinates(self, guesses: FloatArray, values: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return poses (n, bodies, 3) at values (n,), and which of them converged on the branch of their guess."""
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
        """Return the first and second derivative of poses (n, bodies, 3) with respect to the leading coordinate.

        Raises MechanismError at a turning point of the coordinate.
        """
        jacobian = self._coordinate_jacobian(poses, evaluate_output(self.mechanism, self.mechanism.coordinate, poses).gradient)
        tangent_rhs = np.zeros(jacobian.shape[:-1])
        tangent_rhs[:, -1] = 1.0
        tangents = self._solve_linear(jacobian, tangent_rhs)
        gamma = self.equations.gamma(poses, tangents)
        output_gamma = -evaluate_output(self.mechanism, self.mechanism.coordinate, poses, tangents).quadratic_velocity_term
        return tangents, self._solve_linear(jacobian, np.column_stack([gamma, output_gamma]))

    def _newton_step(self, poses: FloatArray, values: FloatArray) -> FloatArray:
        output = evaluate_output(self.mechanism, self.mechanism.coordinate, poses)
        residual = output.value - values
        if isinstance(self.mechanism.reading(self.mechanism.coordinate), LineAngle):
            residual = np.remainder(residual + np.pi, 2 * np.pi) - np.pi
        all_residuals = np.column_stack([self.equations.residuals(poses), residual])
        return self._solve_linear(self._coordinate_jacobian(poses, output.gradient), all_residuals)

    def _coordinate_jacobian(self, poses: FloatArray, coordinate_gradient: FloatArray) -> FloatArray:
        coordinate_rows = coordinate_gradient.reshape(len(poses), 1, -1)[..., self.free_mask]
        return np.concatenate([self.joint_jacobian(poses), coordinate_rows], axis=1)

    def _solve_linear(self, jacobian: FloatArray, rhs: FloatArray) -> FloatArray:
        """Return the changes of all poses (n, bodies, 3) that solve the linearised equations of joints and coordinate."""
        column = rhs[..., np.newaxis]
        try:
            solution = np.linalg.solve(jacobian, column) if jacobian.shape[1] == jacobian.shape[2] else np.linalg.pinv(jacobian) @ column
        except np.linalg.LinAlgError as error:
            raise MechanismError(f"{self.mechanism.coordinate!r} is at a turning point there and does not determine the poses") from error
        return self.expand_free(solution[..., 0])
