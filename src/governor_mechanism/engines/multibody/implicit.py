"""Choice of independent coordinates of a mechanism, and integration of its stiff motion in them."""

from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.multibody.integration import LimitRows, evaluate_limit_rows
from governor_mechanism.integrators.radau import RadauLimits, StiffEquationFunctions, make_radau
from governor_mechanism.integrators.radau_stages import RadauBuffers, make_radau_buffers
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.mechanics.dynamics.arrays import N_ENERGY_STATES, System, SystemWorkspace
from governor_mechanism.mechanics.dynamics.constrained_solution import project_state
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative
from governor_mechanism.mechanics.kinematics.constraint_equations import RowEvaluation
from governor_mechanism.numerics.array_copy import copy_array
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import FloatArray, IntArray

DIFFERENCE_STEP_RATIO = 1e-7
"""Step of the finite differences relative to a component or its scale: a compromise between rounding and curvature."""

MAX_OPEN_RATIO = 1e5
"""Largest constraint violation of a projected state, in constraint tolerances: beyond rounding far from the origin, a joint stays open."""

MAX_DEPENDENCE_GROWTH = 5.0
"""Growth of the dependence (see `PartitionedEquation`) with which other independent coordinates are chosen.

They are chosen so that the dependence is about 1 at first. Where it grows, the independent coordinates approach a turning point.
"""

OPEN_JOINT = -1.0
"""Quality of a state whose joints stay open, or whose derivative is not a number."""


class PartitionedEquation(NamedTuple):
    """Equation of a mechanism without contacts in independent coordinates.

    Its state has the independent coordinates, their velocities, the lags, and the energy states, of which nothing depends.
    The dependence is the largest change of a dependent coordinate relative to that of an independent one, both in their scales.
    """

    system: System  # mechanism and force elements as arrays
    # the same with infinite masses of the independent coordinates: a projection changes the others alone
    projected_system: System
    workspace: SystemWorkspace  # arrays of one evaluation, overwritten
    input_cubics: FloatArray  # local cubics of the input functions and their integrals; shape (functions, 5)
    components: IntArray  # index in the full state of each component; shape (components,)
    n_independent: int  # number of independent coordinates
    error_scale: FloatArray  # scale of each component of the full state; shape (full components,)
    constraint_tolerance: float  # largest constraint violation left by the projection, m
    max_distance: float  # distance from the origin beyond which a body has flown away, m
    limits: LimitRows  # readings with limits
    step_start: FloatArray  # full state at the start of the last step, and its local time, s; shape (full components + 1,)
    present_time: FloatArray  # local time of the present full state, s; shape (1,)
    full_state: FloatArray  # present full state; shape (full components,)
    # poses at the last evaluation of each stage, from which the next projection starts; shape (stages,
    # coordinates)
    stage_poses: FloatArray
    buffer: FloatArray  # full state of one evaluation; shape (full components,)
    derivative: FloatArray  # its derivative; shape (full components,)
    shifted_derivative: FloatArray  # derivative at a shifted state; shape (components,)
    # the dependence at the last Jacobian, and the largest allowed one, 0 before the first Jacobian; shape
    # (2,)
    dependence: FloatArray
    counts: IntArray  # counters, indexed by `StepCounter`


@jit_in_place
def _expand(equation: PartitionedEquation, local_time: float, state: FloatArray, poses: FloatArray, result: FloatArray) -> float:
    """Fill the full state of a reduced one, with dependent coordinates solved from given poses on; return the quality."""
    layout = equation.system.state_layout
    for i in range(layout.velocities):
        result[i] = poses[i]
        result[layout.velocities + i] = 0.0
    for i in range(state.size):
        result[equation.components[i]] = state[i]
    residual = project_state(
        equation.projected_system,
        equation.workspace,
        equation.input_cubics,
        local_time,
        result[: layout.velocities].reshape(-1, 3),
        result[layout.velocities : layout.work].reshape(-1, 3),
        equation.constraint_tolerance,
    )
    return 1.0 if residual <= MAX_OPEN_RATIO * equation.constraint_tolerance else OPEN_JOINT


@jit_in_place
def _evaluate_from(equation: PartitionedEquation, local_time: float, state: FloatArray, poses: FloatArray, result: FloatArray) -> float:
    """Fill the reduced derivative, and the full state and derivative into the buffers; return the quality."""
    if _expand(equation, local_time, state, poses, equation.buffer) < 0.0:
        return OPEN_JOINT
    evaluate_state_derivative(equation.system, equation.workspace, equation.input_cubics, local_time, equation.buffer, equation.derivative)
    equation.counts[StepCounter.EVALUATIONS] += 1
    total = 0.0
    for i in range(state.size):
        result[i] = equation.derivative[equation.components[i]]
        total += result[i]
    return 1.0 if abs(total) < np.inf else OPEN_JOINT


@jit_in_place
def _start_step(equation: PartitionedEquation) -> None:
    for stage in range(equation.stage_poses.shape[0]):
        for i in range(equation.stage_poses.shape[1]):
            equation.stage_poses[stage, i] = equation.full_state[i]


@jit_in_place
def _evaluate(equation: PartitionedEquation, local_time: float, state: FloatArray, derivative: FloatArray, stage: int) -> float:
    poses = equation.stage_poses[stage]
    quality = _evaluate_from(equation, local_time, state, poses, derivative)
    if quality >= 0.0:
        copy_array(poses, equation.buffer[: poses.size])
    return quality


@jit_in_place
def _evaluate_jacobian(
    equation: PartitionedEquation, local_time: float, state: FloatArray, derivative: FloatArray, jacobian: FloatArray
) -> float:
    """Fill the Jacobian by finite differences, and find the dependence."""
    scales = equation.error_scale
    poses = equation.full_state[: equation.stage_poses.shape[1]]
    dependence = 1.0
    for k in range(jacobian.shape[1]):
        value, scale = state[k], scales[equation.components[k]]
        state[k] = value + DIFFERENCE_STEP_RATIO * max(abs(value), scale)
        step = state[k] - value
        quality = _evaluate_from(equation, local_time, state, poses, equation.shifted_derivative)
        state[k] = value
        if quality < 0.0:
            return quality
        for i in range(jacobian.shape[0]):
            jacobian[i, k] = (equation.shifted_derivative[i] - derivative[i]) / step
        if k < equation.n_independent:
            for i in range(poses.size):
                dependence = max(dependence, abs(equation.buffer[i] - poses[i]) / scales[i] * (scale / step))
    equation.dependence[0] = dependence
    if equation.dependence[1] == 0.0:
        equation.dependence[1] = MAX_DEPENDENCE_GROWTH * dependence
    return 1.0


@jit_in_place
def _finish_step(equation: PartitionedEquation, local_time: float, state: FloatArray, derivative: FloatArray) -> IntegrationStatus:
    layout = equation.system.state_layout
    if _evaluate_from(equation, local_time, state, equation.full_state[: layout.velocities], derivative) < 0.0:
        return IntegrationStatus.STALLED
    copy_array(equation.step_start[: equation.full_state.size], equation.full_state)
    equation.step_start[equation.full_state.size] = equation.present_time[0]
    copy_array(equation.full_state, equation.buffer)
    equation.present_time[0] = local_time
    poses = equation.buffer[: layout.velocities].reshape(-1, 3)
    for k in range(poses.shape[0]):
        if not abs(poses[k, 0]) + abs(poses[k, 1]) <= equation.max_distance:
            return IntegrationStatus.OUT_OF_RANGE
    limits = equation.limits
    evaluate_limit_rows(limits, layout, equation.buffer, limits.end_values)
    for i in range(limits.bounds.shape[0]):
        if not limits.bounds[i, 0] < limits.end_values[i, 0] < limits.bounds[i, 1]:
            return IntegrationStatus.LEFT_LIMITS
    return IntegrationStatus.DONE if equation.dependence[0] <= equation.dependence[1] else IntegrationStatus.SINGULAR_COORDINATES


@jit_in_place
def _write_output(equation: PartitionedEquation, local_time: float, state: FloatArray, output: FloatArray) -> None:
    _expand(equation, local_time, state, equation.full_state[: equation.stage_poses.shape[1]], output)


_integrate = jit_in_place(make_radau(StiffEquationFunctions(_start_step, _evaluate, _evaluate_jacobian, _finish_step, _write_output)))


@jit_in_place
def integrate_implicitly(
    equation: PartitionedEquation,
    buffers: RadauBuffers,
    span: tuple[float, float],
    time_origin: float,
    state: FloatArray,
    limits: RadauLimits,
    times: FloatArray,
    states: FloatArray,
) -> tuple[IntegrationStatus, float, int, float]:
    """Integrate a reduced state in place between breakpoints; return status, next step (s), times reached, time of the state (s)."""
    # Full states are filled at the times. The input cubics begin at the time origin (s).
    return _integrate(equation, buffers, span, time_origin, state, limits, times, states)


@jit_in_place
def evaluate_linearisation(
    equation: PartitionedEquation, local_time: float, state: FloatArray, derivative: FloatArray, jacobian: FloatArray
) -> float:
    """Fill the derivative of a reduced state and its Jacobian by finite differences; return whether they are finite (positive)."""
    poses = equation.full_state[: equation.stage_poses.shape[1]]
    if _evaluate_from(equation, local_time, state, poses, derivative) < 0.0:
        return OPEN_JOINT
    copy_array(equation.full_state, equation.buffer)
    return _evaluate_jacobian(equation, local_time, state, derivative, jacobian)


N_STAGES = 5
"""Stages of the Radau IIA method: order 9, with an error estimate and dense output of order 5."""

ROTATION_WEIGHT = 0.1
"""Weight of rotations in the choice of the dependent coordinates: joints and torsional forces are linear in them.

With displacements as independent coordinates the force of a stiff joint is strongly nonlinear, and Newton's method converges in short steps
only.
"""


def estimate_implicit_steps(duration: float, motion_rate: float) -> float:
    """Return a rough number of implicit steps, as measured at 1e-6: of the transient at the start, and of a motion of given rate (1/s)."""
    return 40.0 + 3.0 * duration * motion_rate


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
        self._constraint_tolerance = constraint_tolerance
        self._max_distance = max_distance
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
        t, end = span
        cubics_start = span[0]
        step = limits.step
        n_reached = 0
        status, n_before = IntegrationStatus.SINGULAR_COORDINATES, self.n_steps
        while status == IntegrationStatus.SINGULAR_COORDINATES and t < end:
            equation, buffers = self._make_arguments(input_cubics, state)
            reduced_state = state[equation.components]
            n_left = limits.max_steps + n_before - self.n_steps
            rows = slice(n_reached, None)
            remaining_limits = limits._replace(step=step, max_steps=n_left)
            status, step, n_rows, t = integrate_implicitly(
                equation, buffers, (t, end), cubics_start, reduced_state, remaining_limits, output_times[rows], output_states[rows]
            )
            n_reached += n_rows
            state[:] = equation.full_state
            self.step_start = equation.step_start
        is_done = status == IntegrationStatus.SINGULAR_COORDINATES
        return IntegrationStatus.DONE if is_done else IntegrationStatus(status), step, n_reached, t

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
        jacobian = RowEvaluation(system.constraint_rows, poses.reshape(-1, 3)).jacobian.reshape(-1, poses.size)
        if not len(jacobian):
            return free
        weights = np.where(free % 3 == 2, ROTATION_WEIGHT, 1.0) * self._error_scale[free]
        _, triangle, order = qr(jacobian[:, free] * weights, mode="economic", pivoting=True)
        pivots = np.abs(np.diag(triangle))
        return np.sort(free[order[np.sum(pivots > RANK_TOLERANCE * pivots[0]) :]])
