"""Integrate one scene over its monitor times at a given tolerance: explicitly, and implicitly once it becomes stiff."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.certificate import speed_jump_work
from governor_mechanism.engines.multibody.integration import (
    MIN_STEPS_TO_SWITCH,
    MIN_STEPS_TO_SWITCH_PER_STATE,
    MultibodyEquation,
    integrate_multibody,
    make_multibody_buffers,
)
from governor_mechanism.engines.multibody.settings import MultibodySettings
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.radau import RadauIntegrator
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.time_grid import make_time_grid
from governor_mechanism.mechanics.contact.event_log import drop_cancelled_events
from governor_mechanism.mechanics.contact.scene_contacts import SceneContacts
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, has_contacts, initial_lags
from governor_mechanism.mechanics.dynamics.equations_of_motion import N_ENERGY_STATES, project_state
from governor_mechanism.mechanics.dynamics.lowering import (
    System,
    SystemWorkspace,
    count_output_forces,
    from_mass_centres,
    make_system,
    make_system_workspace,
    to_mass_centres,
)
from governor_mechanism.mechanics.dynamics.output_forces import SLIDING_FRICTION
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class IntegrationResult:
    """States (monitor times reached, components), status and last step size (s) of one integration.

    For a scene with contacts also the contact mode at each monitor time and the events.
    """

    states: FloatArray
    status: IntegrationStatus
    last_step: float
    contact_modes: tuple[ContactMode, ...] = ()
    events: tuple[Event, ...] = ()


class ConstrainedIntegrator:
    """Integrator of a scene from given initial poses and velocities over monitor times that include the reported times."""

    def __init__(
        self,
        scene: Scene,
        evaluator: ReadingEvaluator,
        initial_motion: tuple[FloatArray, FloatArray],
        reported_times: FloatArray,
        max_steps: int,
        settings: MultibodySettings,
    ) -> None:
        self.scene, self.evaluator, self.max_steps, self.settings = scene, evaluator, max_steps, settings
        self.system, self.input_functions = make_system(scene)
        self.model = self.system, make_system_workspace(self.system)
        constraint_tolerance = settings.constraint_tolerance_ratio * evaluator.mechanism.length_scale
        break_times = list(scene.system.breaking_gears.values())
        breakpoints = np.unique(np.concatenate([break_times, *(function.breakpoints for function in self.input_functions)]))
        self._max_step_scale = max_step_scale(scene)
        max_interval = settings.monitor_interval_ratio * evaluator.time_scale
        self.time_grid = make_time_grid(reported_times[reported_times <= max_interval * max_steps], breakpoints, np.inf, max_interval)
        inner_breakpoints = breakpoints[(breakpoints > 0) & (breakpoints < self.time_grid.monitor_times[-1])]
        self.breakpoints = np.concatenate([[0.0], inner_breakpoints, self.time_grid.monitor_times[-1:]])
        self.counters = np.zeros(len(StepCounter), dtype=np.int64)
        self.implicit_steps, self.stiffness_onset = 0, np.inf
        self.output_force_counts = np.zeros(SLIDING_FRICTION + 1, dtype=np.int64)
        """Evaluations of output forces by law, as in `count_output_forces`."""
        self.constraint_tolerance = constraint_tolerance
        self.initial_state = self._make_initial_state(*from_mass_centres(self.system, *initial_motion))
        self.error_scale = self._make_error_scale()
        self.scene_contacts = SceneContacts(scene, evaluator.time_scale, constraint_tolerance) if has_contacts(scene) else None

    def compile_kernels(self) -> None:
        """Compile or load the kernels by an integration over an empty interval, so that no run's cost includes it."""
        if self.scene_contacts is not None:
            self.scene_contacts.start(self.initial_state.copy(), self.input_cubics(0.0))
        ExplicitIntegration(self, 1.0, 1.0, 1).integrate((0.0, 0.0), np.empty(0), self.initial_state.copy(), 1.0, np.empty((0, 0)), [])

    def integrate(self, tolerance: float, step_factor: float = 1.0) -> IntegrationResult:
        """Integrate from the start over all monitor times, with the largest step multiplied by a factor."""
        monitor_times, state, contacts = self.time_grid.monitor_times, self.initial_state.copy(), self.scene_contacts
        states, contact_modes = np.empty((len(monitor_times), state.size)), list[ContactMode]()
        max_step = step_factor * self.settings.max_step_ratio * self._max_step_scale
        explicit = ExplicitIntegration(self, tolerance, max_step, self.max_steps)
        radau: RadauIntegrator | None = None
        if contacts is not None:
            contacts.start(state, self.input_cubics(0.0))
            contact_modes.append(contacts.mode)
        states[0], n_filled, status, step = state, 1, IntegrationStatus.DONE, self.settings.first_step_ratio * max_step
        for start, end in pairwise(self.breakpoints.tolist()):
            output_times, t = monitor_times[(monitor_times > start) & (monitor_times <= end)], start
            if radau is None:
                status, step, n_reached, t = explicit.integrate((start, end), output_times, state, step, states[n_filled:], contact_modes)
                n_filled += n_reached
                output_times = output_times[n_reached:]
            if status == IntegrationStatus.STIFF:
                radau = RadauIntegrator(*self.model, self.error_scale, self.constraint_tolerance)
                self.stiffness_onset, status = min(self.stiffness_onset, t), IntegrationStatus.DONE
            if radau is not None:
                input_cubics, max_steps = self.input_cubics(start), self.max_steps
                status, step, n_reached = radau.integrate(
                    input_cubics, (t, end), start, output_times, state, tolerance, max_steps, states[n_filled:]
                )
                n_filled += n_reached
            if status != IntegrationStatus.DONE:
                break
            self._add_speed_jump_work(end, state, states[n_filled - 1])
            if contacts is not None:  # an input function has a jump or a kink
                contacts.change_mode(end, state, self.input_cubics(end))
        if radau is not None:
            self.implicit_steps += radau.n_steps
            explicit.count_evaluations(self.system, radau.n_evaluations)
        self.counters += explicit.counts
        self.output_force_counts += explicit.output_force_counts
        events = drop_cancelled_events(contacts.events if contacts else (), SIMULTANEITY_TOLERANCE * self.evaluator.time_scale)
        return IntegrationResult(states[:n_filled], status, step, tuple(contact_modes), events)

    def _add_speed_jump_work(self, time: float, state: FloatArray, monitor_state: FloatArray) -> None:
        """Add the work of a jump of the given spindle speed at a breakpoint; the state recorded there is the one after the jump."""
        work_index = 6 * len(self.system.bodies)
        state[work_index] += speed_jump_work(self.evaluator, time, self._to_mass_centres(state)[0])
        monitor_state[work_index] = state[work_index]

    def state_history(self, states: FloatArray) -> StateHistory:
        """Return mass centres and spindle from state vectors (monitor times, components)."""
        n_bodies = len(self.system.bodies)
        parts = (states[:, : 3 * n_bodies], states[:, 3 * n_bodies : 6 * n_bodies])
        origins, origin_velocities = (part.reshape(-1, n_bodies, 3) for part in parts)
        poses, velocities = to_mass_centres(self.system, origins, origin_velocities)
        return StateHistory(
            times=self.time_grid.monitor_times[: len(states)],
            poses=poses,
            velocities=velocities,
            work=states[:, 6 * n_bodies],
            dissipated_energy=states[:, 6 * n_bodies + 1],
            lags=states[:, 6 * n_bodies + N_ENERGY_STATES :],
        )

    def is_out_of_range(self, state: FloatArray) -> bool:
        """Return whether a state is outside the mechanism's limits."""
        return self.evaluator.find_first_out_of_range(self._to_mass_centres(state)[0][np.newaxis]) is not None

    def integrate_between(
        self, integration: IntegrationResult, tolerance: float, k: int, time: float
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return poses and velocities of the mass centres at a time (s) after monitor time k, or None if that fails."""
        start, state, contacts = float(self.time_grid.monitor_times[k]), integration.states[k].copy(), self.scene_contacts
        max_step, max_steps = np.inf, self.settings.max_interpolation_steps
        if contacts is not None:
            max_step, max_steps = self.settings.max_step_ratio * self._max_step_scale, self.max_steps
            contacts.continue_from(integration.contact_modes[k])
            if start in self.breakpoints[1:]:
                contacts.change_mode(start, state, self.input_cubics(start))  # a state at a breakpoint has the mode before it
        explicit, step = ExplicitIntegration(self, tolerance, max_step, max_steps), 0.01 * self.evaluator.time_scale
        status, *_ = explicit.integrate((start, time), np.empty(0), state, step, np.empty((0, state.size)), [])
        if status != IntegrationStatus.DONE:
            return None
        return self._to_mass_centres(state)

    def _to_mass_centres(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities of the mass centres of one state."""
        return to_mass_centres(self.system, *state[: 6 * len(self.system.bodies)].reshape(2, -1, 3))

    def _make_initial_state(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the initial state vector, with constraints satisfied to rounding."""
        project_state(*self.model, self.input_cubics(0.0), 0.0, poses, velocities, self.constraint_tolerance)
        centres = to_mass_centres(self.system, poses, velocities)
        return np.concatenate([poses.ravel(), velocities.ravel(), np.zeros(N_ENERGY_STATES), initial_lags(self.scene, *centres)])

    def input_cubics(self, start: float) -> FloatArray:
        """Return the local cubics (functions, columns) of spindle, drivers and force elements from a time (s) to the next breakpoint."""
        cubics: FloatArray = stack_local_cubics(self.input_functions, np.array([start]))[0]
        return cubics

    def _make_error_scale(self) -> FloatArray:
        """Return the scales to which errors of a state vector are relative."""
        length_scale, time_scale = self.evaluator.mechanism.length_scale, self.evaluator.time_scale
        pose_scale = np.tile([length_scale, length_scale, 1.0], len(self.system.bodies))
        energy_scales, lag_scales = (
            [self.evaluator.energy_scale] * N_ENERGY_STATES,
            np.maximum(np.abs(self.initial_state[6 * len(self.system.bodies) + N_ENERGY_STATES :]), 1.0),
        )
        return np.concatenate([pose_scale, pose_scale / time_scale, energy_scales, lag_scales])


class ExplicitIntegration:
    """Explicit integration of one run between breakpoints, with contact events, and its counters."""

    def __init__(self, context: ConstrainedIntegrator, tolerance: float, max_step: float, max_steps: int) -> None:
        self._context, self._tolerance, self._max_step, self._max_steps = context, tolerance, max_step, max_steps
        self._last_event_time, self._n_simultaneous = -np.inf, 0
        self._simultaneity = context.settings.event_time_tolerance * context.evaluator.time_scale
        self._derivative = np.empty(context.error_scale.size)
        min_stiff_steps = MIN_STEPS_TO_SWITCH + MIN_STEPS_TO_SWITCH_PER_STATE * context.error_scale.size
        self._min_stiff_steps = np.inf if context.scene_contacts else min_stiff_steps  # the implicit method knows no events
        self.counts = np.zeros(len(StepCounter), dtype=np.int64)
        self.output_force_counts = np.zeros(SLIDING_FRICTION + 1, dtype=np.int64)
        """Evaluations of output forces by law, as in `count_output_forces`; sticking friction is not evaluated."""

    def count_evaluations(self, system: System, n_evaluations: int) -> None:
        """Count evaluations that the counters of the integrator do not contain."""
        self.counts[StepCounter.EVALUATIONS] += n_evaluations
        self.output_force_counts += n_evaluations * count_output_forces(system)

    def integrate(
        self,
        span: tuple[float, float],
        output_times: FloatArray,
        state: FloatArray,
        step: float,
        output_states: FloatArray,
        contact_modes: list[ContactMode],
    ) -> tuple[IntegrationStatus, float, int, float]:
        """Integrate the state in place over a span without breakpoints and fill output_states and contact modes at output_times.

        Returns the status, the last step size (s), the number of output times reached, and the time of the state (s).
        """
        (t, end), n_filled, contacts, settings = span, 0, self._context.scene_contacts, self._context.settings
        while True:
            system, workspace = contacts.model if contacts else self._context.model
            outputs = output_times[n_filled:], output_states[n_filled:]
            status, step, n_reached, t, triggered = self._integrate_to_event(system, workspace, (t, end), state, step, *outputs)
            n_filled += n_reached
            if contacts is None:
                return status, step, n_filled, t
            contact_modes += [contacts.mode] * n_reached
            if status != IntegrationStatus.EVENT:
                return status, step, n_filled, t
            if n_filled and self._context.is_out_of_range(output_states[n_filled - 1]):
                return IntegrationStatus.OUT_OF_RANGE, step, n_filled, t  # events beyond the limits are irrelevant and may never end
            self._n_simultaneous = self._n_simultaneous + 1 if t - self._last_event_time <= self._simultaneity else 0
            self._last_event_time = t
            if self._n_simultaneous >= settings.max_simultaneous_events:
                return IntegrationStatus.STALLED, step, n_filled, t
            contacts.change_mode(t, state, self._context.input_cubics(t), triggered)
            step = min(step, settings.restart_step_ratio * self._max_step)

    def _integrate_to_event(
        self,
        system: System,
        workspace: SystemWorkspace,
        span: tuple[float, float],
        state: FloatArray,
        step: float,
        output_times: FloatArray,
        output_states: FloatArray,
    ) -> tuple[IntegrationStatus, float, int, float, set[int]]:
        """Integrate up to the end of the span or to the first event; return also the contacts of the event functions that are positive."""
        context, evaluations_before = self._context, int(self.counts[StepCounter.EVALUATIONS])
        max_step = self._max_step * (context.settings.event_step_ratio if system.event_functions.size else 1.0)
        limits = StepLimits(self._tolerance, step, max_step, self._max_steps, self._min_stiff_steps)
        buffers = make_multibody_buffers(system, context.error_scale, self.counts)
        cubics, gap = context.input_cubics(span[0]), context.constraint_tolerance
        equation = MultibodyEquation(system, workspace, cubics, gap, self._derivative, self.counts)
        result = integrate_multibody(equation, buffers, span, output_times, state, limits, output_states)
        self.output_force_counts += (int(self.counts[StepCounter.EVALUATIONS]) - evaluations_before) * count_output_forces(system)
        return *result, set(system.event_functions["contact_index"][buffers.event_values[-1] > 0.0].tolist())
