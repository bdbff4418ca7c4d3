"""Choice of independent coordinates of a mechanism, and integration of its stiff motion in them."""

import numpy as np

from governor_mechanism.engines.multibody.implicit import PartitionedEquation, evaluate_linearisation, integrate_implicitly
from governor_mechanism.engines.multibody.limit_rows import LimitRows
from governor_mechanism.integrators.radau import RadauLimits
from governor_mechanism.integrators.radau_systems import RadauBuffers, make_radau_buffers
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.dynamics.system.arrays import N_ENERGY_STATES, System, SystemWorkspace
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_jacobian
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import FloatArray, IntArray

N_STAGES = 5
"""Stages of the Radau IIA method: order 9, with an error estimate and dense output of order 5."""

ROTATION_WEIGHT = 0.1
"""Weight of rotations in the choice of the dependent coordinates: joints and torsional forces are linear in them.

With displacements as independent coordinates the force of a stiff joint is strongly nonlinear, and Newton's method converges in short steps
only.
"""


class ImplicitIntegrator:
    """Implicit integration of one system without contacts, by coordinate partitioning.

    Parameters
    ----------
    system
        Mechanism and force elements as arrays.
    workspace
        Arrays of one evaluation, overwritten.
    error_scale
        Scale of every component of the state, as in `integrate_multibody`.
    constraint_tolerance
        Largest constraint violation, m.
    max_distance
        Distance from the origin beyond which a body has flown away, m.
    limits
        Readings with limits.

    Attributes
    ----------
    counts
        Counters of all integrations, indexed by `StepCounter`.
    step_start
        State at the start of the last step, and its time after the start of the cubics, s; shape (components + 1,).
    """

    def __init__(
        self,
        system: System,
        workspace: SystemWorkspace,
        error_scale: FloatArray,
        constraint_tolerance: float,
        max_distance: float,
        limits: LimitRows,
    ) -> None:
        self._limits, self.step_start = limits, np.zeros(0)
        self._model, self._error_scale = (system, workspace), error_scale
        self._constraint_tolerance, self._max_distance = constraint_tolerance, max_distance
        self.counts = np.zeros(len(StepCounter), dtype=np.int64)

    def integrate(
        self,
        input_cubics: FloatArray,
        span: tuple[float, float],
        output_times: FloatArray,
        state: FloatArray,
        limits: RadauLimits,
        output_states: FloatArray,
    ) -> tuple[IntegrationStatus, float, int, float]:
        """Integrate the state in place, as `integrate_multibody` does; returns what that returns."""
        warn_before_compiling(integrate_implicitly, 15)
        (t, end), cubics_start, step, n_reached = span, span[0], limits.step, 0
        status, n_before = IntegrationStatus.SINGULAR_COORDINATES, self.n_steps
        while status == IntegrationStatus.SINGULAR_COORDINATES and t < end:
            equation, buffers = self._make_arguments(input_cubics, state)
            reduced_state, n_left = state[equation.components], limits.max_steps + n_before - self.n_steps
            rows, remaining_limits = slice(n_reached, None), limits._replace(step=step, max_steps=n_left)
            status, step, n_rows, t = integrate_implicitly(
                equation, buffers, (t, end), cubics_start, reduced_state, remaining_limits, output_times[rows], output_states[rows]
            )
            n_reached += n_rows
            state[:] = equation.full_state
            self.step_start = equation.step_start
        is_done = status == IntegrationStatus.SINGULAR_COORDINATES
        return IntegrationStatus.DONE if is_done else IntegrationStatus(status), step, n_reached, t

    def compile_kernel(self, input_cubics: FloatArray, state: FloatArray) -> None:
        """Compile or load the integration by one over an empty interval; the arguments are those of `integrate`."""
        warn_before_compiling(integrate_implicitly, 15)
        limits = RadauLimits(1.0, 1.0, 1)
        outputs = np.empty((0, state.size))
        equation, buffers = self._make_arguments(input_cubics, state)
        integrate_implicitly(equation, buffers, (0.0, 0.0), 0.0, state[equation.components], limits, outputs[:, 0], outputs)

    def rates_at(self, input_cubics: FloatArray, state: FloatArray) -> tuple[float, float]:
        """Return the rates of the linearised motion at the start of the cubics in a state.

        Results: decay_rate, largest rate at which a displacement decays without oscillation, 1/s; 0 without
        one, or if the start is singular; oscillation_rate, largest rate of all other motion, 1/s.
        """
        equation, buffers = self._make_arguments(input_cubics, state)
        jacobian, derivative = buffers.jacobian, buffers.start_derivative
        if evaluate_linearisation(equation, 0.0, state[equation.components], derivative, jacobian) < 0.0:
            return 0.0, 0.0  # the start is singular: nothing is known of the rates
        eigenvalues = np.linalg.eigvals(jacobian[: jacobian.shape[1]])
        decays = -eigenvalues.real > np.abs(eigenvalues.imag)
        sizes = np.abs(eigenvalues)
        return float(np.max(sizes[decays], initial=0.0)), float(np.max(sizes[~decays], initial=0.0))

    @property
    def n_steps(self) -> int:
        """Return the steps so far, rejected ones included."""
        return int(self.counts[StepCounter.ACCEPTED] + self.counts[StepCounter.REJECTED])

    def _make_arguments(self, input_cubics: FloatArray, state: FloatArray) -> tuple[PartitionedEquation, RadauBuffers]:
        """Return the equation in the independent coordinates that suit a state, and buffers."""
        system, workspace = self._model
        layout, n = system.state_layout, state.size
        independent = self._choose_independent(state[: layout.velocities])
        inverse_mass = system.inverse_mass.copy()
        inverse_mass.ravel()[independent] = 0.0
        energies, lags = np.arange(layout.work, layout.lags), np.arange(layout.lags, n)
        components = np.concatenate([independent, layout.velocities + independent, lags, energies])
        equation = PartitionedEquation(
            system=system,
            projected_system=system._replace(inverse_mass=inverse_mass),
            workspace=workspace,
            input_cubics=input_cubics,
            components=components,
            n_independent=len(independent),
            error_scale=self._error_scale,
            constraint_tolerance=self._constraint_tolerance,
            max_distance=self._max_distance,
            limits=self._limits,
            step_start=np.zeros(n + 1),
            present_time=np.zeros(1),
            full_state=state.copy(),
            stage_poses=np.empty((N_STAGES, layout.velocities)),
            buffer=np.empty(n),
            derivative=np.empty(n),
            shifted_derivative=np.empty(components.size),
            dependence=np.zeros(2),
            counts=self.counts,
        )
        buffers = make_radau_buffers(N_STAGES, components.size - N_ENERGY_STATES, self._error_scale[components], self.counts)
        return equation, buffers

    def _choose_independent(self, poses: FloatArray) -> IntArray:
        """Return the coordinates that the pivoted QR factorisation of the constraint Jacobian chooses last."""
        from scipy.linalg import qr  # slow to import

        system = self._model[0]
        free: IntArray = np.flatnonzero(system.inverse_mass.ravel() > 0.0)
        jacobian = evaluate_jacobian(system.constraint_rows, poses.reshape(1, -1, 3))[0].reshape(-1, poses.size)
        if not len(jacobian):
            return free
        weights = np.where(free % 3 == 2, ROTATION_WEIGHT, 1.0) * self._error_scale[free]
        _, triangle, order = qr(jacobian[:, free] * weights, mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        return np.sort(free[order[np.sum(pivots > RANK_TOLERANCE * pivots[0]) :]])
