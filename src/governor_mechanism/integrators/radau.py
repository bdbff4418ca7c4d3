"""Radau IIA in independent coordinates for stiff scenes: an unconstrained equation with few components."""

import numpy as np

from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.dynamics.equations_of_motion import N_ENERGY_STATES, evaluate_state_derivative, project_state
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_jacobian
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import FloatArray, IntArray

DIFFERENCE_STEP_RATIO = 1e-7
"""Step of the finite differences relative to a component or its scale: a compromise between rounding and curvature."""

MIN_PARTITION_RATIO = 1e-3
"""Smallest ratio of singular values of the dependent coordinates' Jacobian; below it, other coordinates are chosen.

Beyond this the dependent coordinates would move more than 1 / MIN_PARTITION_RATIO times as fast as the independent ones.
"""


class RadauIntegrator:
    """Radau IIA of order 5 with error control for one system, by coordinate partitioning.

    Parameters
    ----------
    system
        Mechanism, force elements and contact mode as arrays.
    workspace
        Arrays of one evaluation, overwritten.
    error_scale
        Scale of every component of the state, as in `integrate_multibody`.
    constraint_tolerance
        Largest constraint violation, m.
    max_distance
        Distance from the origin beyond which a body has flown away, m.

    Attributes
    ----------
    n_evaluations
        Number of evaluations of the state derivative.
    n_steps
        Number of accepted steps.
    """

    def __init__(
        self, system: System, workspace: SystemWorkspace, error_scale: FloatArray, constraint_tolerance: float, max_distance: float
    ) -> None:
        self._system, self._workspace, self._max_distance = system, workspace, max_distance
        self._error_scale, self._constraint_tolerance = error_scale, constraint_tolerance
        self._n_bodies = len(system.bodies)
        self.n_evaluations = self.n_steps = 0
        self._input_cubics, self._cubics_start = np.zeros((0, 5)), 0.0
        self._partitioned_system, self._independent, self._poses = system, np.zeros(0, dtype=np.int64), np.zeros((self._n_bodies, 3))

    def integrate(
        self,
        input_cubics: FloatArray,
        span: tuple[float, float],
        cubics_start: float,
        output_times: FloatArray,
        state: FloatArray,
        tolerance: float,
        max_steps: int,
        output_states: FloatArray,
    ) -> tuple[IntegrationStatus, float, int, float]:
        """Integrate the state in place, as `integrate_multibody` does; input_cubics count from `cubics_start` (s).

        Returns how the integration ended, the last step size (s), the number of output times reached, and the time of the state (s).
        """
        from scipy.integrate import Radau  # slow to import

        self._input_cubics, self._cubics_start = input_cubics, cubics_start
        t, end = span
        step, n_reached = (end - t) * 1e-3, 0
        while t < end:
            self._choose_partition(state)
            tolerances = {"rtol": max(tolerance, 2.3e-14), "atol": tolerance * self._reduce_state(self._error_scale)}
            start, options = self._reduce_state(state), {"jac": self._evaluate_jacobian, "first_step": min(step, end - t)}
            solver = Radau(self._evaluate_derivative, t, start, end, **options, **tolerances)
            while solver.status == "running":
                if self.n_steps >= max_steps:
                    return IntegrationStatus.STEP_LIMIT, step, n_reached, t
                solver.step()
                if solver.status == "failed":
                    return IntegrationStatus.STALLED, step, n_reached, t
                self.n_steps += 1
                rows = slice(n_reached, int(np.searchsorted(output_times, solver.t, side="right")))
                if rows.stop > n_reached:
                    reduced_states = solver.dense_output()(output_times[rows])
                    for row, reduced_state in zip(range(n_reached, rows.stop), reduced_states.T, strict=True):
                        output_states[row] = self._expand_state(output_times[row], reduced_state)
                    n_reached = rows.stop
                t, step = solver.t, solver.step_size or step
                state[:] = self._expand_state(t, solver.y)
                self._poses = state[: 3 * self._n_bodies].reshape(-1, 3).copy()
                if np.max(np.abs(self._poses[:, :2])) > self._max_distance:
                    return IntegrationStatus.OUT_OF_RANGE, step, n_reached, t
                if self._is_ill_conditioned():
                    break
        return IntegrationStatus.DONE, step, n_reached, t

    def rates_at(self, input_cubics: FloatArray, state: FloatArray) -> tuple[float, float]:
        """Return the rates of the linearised motion at the start of the cubics in a state.

        Parameters
        ----------
        input_cubics
            Inputs, as in `integrate`.
        state
            State.

        Returns
        -------
        decay_rate : float
            Largest rate at which a displacement decays without oscillation, 1/s; 0 without one, or if the start is singular.
        oscillation_rate : float
            Largest rate of all other motion, 1/s.
        """
        self._input_cubics, self._cubics_start = input_cubics, 0.0
        self._choose_partition(state)
        jacobian = self._evaluate_jacobian(0.0, self._reduce_state(state))
        if not np.all(np.isfinite(jacobian)):  # the start is singular: nothing is known of the rates
            return 0.0, 0.0
        eigenvalues = np.linalg.eigvals(jacobian)
        decays = -eigenvalues.real > np.abs(eigenvalues.imag)
        sizes = np.abs(eigenvalues)
        return float(np.max(sizes[decays], initial=0.0)), float(np.max(sizes[~decays], initial=0.0))

    def _choose_partition(self, state: FloatArray) -> None:
        """Take as independent the coordinates that the pivoted QR factorisation of the constraint Jacobian chooses last.

        The dependent coordinates are solved from the poses of this state.
        """
        from scipy.linalg import qr  # slow to import

        self._poses = state[: 3 * self._n_bodies].reshape(-1, 3).copy()
        self._independent, scaled_jacobian = self._free_coordinates(), self._scaled_constraint_jacobian()
        if len(scaled_jacobian):
            _, triangle, order = qr(scaled_jacobian, mode="economic", pivoting=True)
            pivots = np.abs(np.diag(triangle))
            self._independent = np.sort(self._independent[order[np.sum(pivots > RANK_TOLERANCE * pivots[0]) :]])
        inverse_mass = self._system.inverse_mass.copy()
        inverse_mass.ravel()[self._independent] = 0.0  # the projection does not change these
        self._partitioned_system = self._system._replace(inverse_mass=inverse_mass)

    def _free_coordinates(self) -> IntArray:
        """Return the indices of the coordinates with finite mass among all 3 n_bodies."""
        return np.flatnonzero(self._system.inverse_mass.ravel() > 0.0)

    def _scaled_constraint_jacobian(self) -> FloatArray:
        """Return the constraint Jacobian (rows, free coordinates), each column multiplied by the scale of its coordinate."""
        jacobian, free = evaluate_jacobian(self._system.constraint_rows, self._poses[np.newaxis])[0], self._free_coordinates()
        scaled_jacobian: FloatArray = jacobian.reshape(len(jacobian), self._poses.size)[:, free] * self._error_scale[free]
        return scaled_jacobian

    def _is_ill_conditioned(self) -> bool:
        """Return whether the dependent coordinates are close to singular."""
        dependent = self._scaled_constraint_jacobian()[:, ~np.isin(self._free_coordinates(), self._independent)]
        singular_values = np.linalg.svd(dependent, compute_uv=False)
        return bool(singular_values.size and singular_values[-1] < MIN_PARTITION_RATIO * singular_values[0])

    def _reduce_state(self, state: FloatArray) -> FloatArray:
        """Return independent coordinates, their velocities, energy states and lags."""
        n_coordinates = 3 * self._n_bodies
        return np.concatenate([state[self._independent], state[n_coordinates + self._independent], state[2 * n_coordinates :]])

    def _expand_state(self, time: float, z: FloatArray) -> FloatArray:
        """Return the state of all bodies, with constraints satisfied, from the reduced state z at a time (s)."""
        n_independent = len(self._independent)
        poses, velocities = self._poses.copy(), np.zeros_like(self._poses)
        poses.ravel()[self._independent] = z[:n_independent]
        velocities.ravel()[self._independent] = z[n_independent : 2 * n_independent]
        model, local_time = (self._partitioned_system, self._workspace), time - self._cubics_start
        project_state(*model, self._input_cubics, local_time, poses, velocities, self._constraint_tolerance)
        return np.concatenate([poses.ravel(), velocities.ravel(), z[2 * n_independent :]])

    def _evaluate_jacobian(self, time: float, z: FloatArray) -> FloatArray:
        """Return the Jacobian of the reduced derivative by finite differences.

        Work and dissipated energy act on nothing: their columns are zero.
        """
        derivative = self._evaluate_derivative(time, z)
        result = np.zeros((z.size, z.size))
        steps = DIFFERENCE_STEP_RATIO * np.maximum(np.abs(z), self._reduce_state(self._error_scale))
        n_motion = 2 * len(self._independent)
        for k in (*range(n_motion), *range(n_motion + N_ENERGY_STATES, z.size)):
            z_shifted = z.copy()
            z_shifted[k] += steps[k]
            result[:, k] = (self._evaluate_derivative(time, z_shifted) - derivative) / (z_shifted[k] - z[k])
        return result

    def _evaluate_derivative(self, time: float, z: FloatArray) -> FloatArray:
        """Return the derivative of the reduced state z at a time (s)."""
        state = self._expand_state(time, z)
        self.n_evaluations += 1
        derivative = np.empty(state.size)
        evaluate_state_derivative(self._system, self._workspace, self._input_cubics, time - self._cubics_start, state, derivative)
        return self._reduce_state(derivative)
