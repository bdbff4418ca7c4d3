"""Integrate one scene over its monitor times at a given tolerance: explicitly, and implicitly once it becomes stiff."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.certificate import StepPlan, speed_jump_work
from governor_mechanism.engines.exit_location import LastStep, find_first_excursion, is_searched_between_samples
from governor_mechanism.engines.initial_state import Motion
from governor_mechanism.engines.multibody.implicit import ImplicitIntegrator, estimate_implicit_steps
from governor_mechanism.engines.multibody.integration import (
    IntegrationResult,
    MultibodyEquation,
    MultibodySettings,
    MultibodyStep,
    integrate_multibody,
    make_limit_rows,
)
from governor_mechanism.integrators.dop853 import STABILITY_LIMIT, StepLimits
from governor_mechanism.integrators.equation import make_step_buffers
from governor_mechanism.integrators.radau import RadauLimits
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.integrators.time_grid import make_time_grid, sort_distinct
from governor_mechanism.mechanics.contact.event_log import drop_cancelled_events
from governor_mechanism.mechanics.contact.scene_contacts import SceneContacts
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.dynamics.arrays import (
    N_ENERGY_STATES,
    System,
    SystemWorkspace,
    count_output_forces,
    from_mass_centres,
    make_system_workspace,
    to_mass_centres,
)
from governor_mechanism.mechanics.dynamics.characteristic_scales import loading_rate, max_step_scale
from governor_mechanism.mechanics.dynamics.constrained_solution import project_state
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, has_contacts
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.dynamics.event_functions import EventFunctionKind, find_gaps
from governor_mechanism.mechanics.dynamics.inputs import has_kinks, initial_lags
from governor_mechanism.mechanics.dynamics.lowering import make_system, stands_still
from governor_mechanism.mechanics.dynamics.output_forces import SLIDING_FRICTION
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.force_elements import Damper, TorsionDamper
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

MIN_STEPS_TO_SWITCH = 1500
"""Fewest remaining explicit steps that justify an implicit method.

In the two runs of a certificate they take about 0.06 s, the time in which its kernels are loaded from the cache.
"""

MIN_IMPLICIT_STEPS = 100
"""Implicit steps after which the explicit method may take over again: about what a smooth motion needs for a transient and its end."""

NO_TIMES = np.empty(0)
"""Output times of a run that records no states."""

FAR_STEPS = 4.0
"""Longest steps within which no event is expected where all are far: the fastest change may become as many times faster."""

MAX_EXIT_STEPS = 400
"""Step limit from the start of the step in which the motion ends to a time within it: many only beside a singular configuration."""

EXCURSION_SAMPLES = 33
"""Samples of a step in which a turning point near a limit is looked for: cubics between them are good to 1e-8 of the change within it."""


class ConstrainedIntegrator:
    """Integrator of a scene from given initial poses and velocities over monitor times that include the reported times."""

    def __init__(
        self,
        evaluator: ReadingEvaluator,
        initial_motion: Motion,
        reported_times: FloatArray,
        max_steps: int,
        settings: MultibodySettings,
        accuracy: float = 0.0,
    ) -> None:
        self.scene = evaluator.scene
        self.evaluator = evaluator
        self.max_steps = max_steps
        self.settings = settings
        self.accuracy, self.limits = accuracy, make_limit_rows(self.scene.mechanism)
        self.no_limits = make_limit_rows(self.scene.mechanism, is_empty=True)
        self.system, self.input_functions = make_system(self.scene)
        self.model = self.system, make_system_workspace(self.system)
        self._cubics_start, self._cubics = math.nan, np.zeros((0, 0))
        break_times = list(self.scene.system.breaking_gears.values())
        self._max_step_scale = max_step_scale(self.scene)
        breakpoints = sort_distinct(np.concatenate([break_times, *(function.breakpoints for function in self.input_functions)]))
        self.counters = np.zeros(len(StepCounter), dtype=np.int64)
        self.implicit_steps, self.stiffness_onset = 0, np.inf
        self.output_force_counts = np.zeros(SLIDING_FRICTION + 1, dtype=np.int64)
        """Evaluations of output forces by law, as in `count_output_forces`."""
        self.constraint_tolerance = settings.constraint_tolerance_ratio * evaluator.mechanism.length_scale
        self.max_distance = settings.max_distance_ratio * evaluator.mechanism.length_scale
        self.shafts = np.array([evaluator.mechanism.body_index(limit.body) for limit in evaluator.mechanism.stall_limits], dtype=np.int64)
        self.scene_contacts = (
            SceneContacts(self.scene, evaluator.time_scale, self.constraint_tolerance) if has_contacts(self.scene) else None
        )
        # The implicit method knows no events, kinks and shafts that stall.
        is_smooth = self.scene_contacts is None and not has_kinks(self.scene)
        self._min_stiff_steps = float(MIN_STEPS_TO_SWITCH) if is_smooth else np.inf
        self.initial_state = self._make_initial_state(*from_mass_centres(self.system, *initial_motion))
        self.error_scale = self._make_error_scale(evaluator.time_scale)
        self.implicit_step_cost = settings.implicit_step_cost + settings.implicit_step_cost_per_state * self.error_scale.size
        self.stable_step, motion_time = self._find_stable_step(float(np.max(reported_times, initial=0.0)))
        self.error_scale = self._make_error_scale(motion_time)
        self.is_searched = is_searched_between_samples(self.scene)
        interval_ratio = settings.monitor_interval_ratio if self.is_searched else settings.max_step_ratio
        max_interval = interval_ratio * max(motion_time, self._max_step_scale)  # a fast spindle alone does not make it shorter
        self.time_grid = make_time_grid(reported_times[reported_times <= max_interval * max_steps], breakpoints, np.inf, max_interval)
        inner_breakpoints = breakpoints[(breakpoints > 0) & (breakpoints < self.time_grid.monitor_times[-1])]
        self.breakpoints = np.concatenate([[0.0], inner_breakpoints, self.time_grid.monitor_times[-1:]])

    @property
    def is_stiff(self) -> bool:
        """Whether a run became stiff."""
        return self.stiffness_onset < np.inf

    def integrate(self, tolerance: float, plan: StepPlan) -> IntegrationResult:
        """Integrate from the start over all monitor times, with a plan of the steps."""
        times = self.time_grid.monitor_times
        state = self.initial_state.copy()
        contacts = self.scene_contacts
        max_step = self.settings.max_step_ratio * self._max_step_scale
        records = (plan.coarser_steps, plan.steps)
        first_step = self.settings.first_step_ratio * max_step
        limits = StepLimits(tolerance, first_step, max_step, plan.max_steps, self._min_stiff_steps, *records)
        if contacts is not None:
            contacts.start(state, self.input_cubics(0.0))
        run, status = ExplicitRun(self, limits, state, 0.0, times), IntegrationStatus.DONE
        method = MethodChoice(self, run, limits)
        for start, end in pairwise(self.breakpoints.tolist()):
            run.time = start
            status = method.advance(end)
            if status != IntegrationStatus.DONE:
                break
            self._apply_speed_jump(run, end)
            if contacts is not None:  # an input function has a jump or a kink
                contacts.change_mode(end, state, self.input_cubics(end))
        method.count_implicit_work()
        self.counters += run.counts
        self.output_force_counts += run.output_force_counts
        events = drop_cancelled_events(contacts.events if contacts else (), SIMULTANEITY_TOLERANCE * self.evaluator.time_scale)
        return IntegrationResult(
            states=run.states[: run.n_filled],
            status=status,
            last_step=run.step,
            end_time=run.time,
            exit_step=run.last_step,
            contact_modes=tuple(run.contact_modes),
            events=events,
        )

    def _apply_speed_jump(self, run: "ExplicitRun", time: float) -> None:
        """Add the work of a jump of the given spindle speed; the state recorded there is the one after the jump."""
        work_index = self.system.state_layout.work
        run.state[work_index] += speed_jump_work(self.evaluator, time, lambda: self._to_mass_centres(run.state)[0])
        run.states[run.n_filled - 1, work_index] = run.state[work_index]

    def make_implicit_integrator(self) -> ImplicitIntegrator:
        """Return an integrator of the same model with implicit steps."""
        return ImplicitIntegrator(*self.model, self.error_scale, self.constraint_tolerance, self.max_distance, self.limits)

    @property
    def is_damped(self) -> bool:
        """Whether the scene has dampers, dashpots or lags: only these make a motion stiff."""
        is_damped = any(isinstance(element, Damper | TorsionDamper) for element in self.scene.mechanism.force_elements)
        return is_damped or len(self.system.lags) > 0 or any(effect.dissipates for effect in output_forces_of(self.scene))

    def _find_stable_step(self, duration: float) -> tuple[float, float]:
        """Return the largest stable explicit step (s) if implicit steps cost less, else infinity, and the time of the motion (s)."""
        # Without such stiffness the second is the time scale of the scene. Only dampers, dashpots
        # and lags make a motion stiff in that sense: undamped oscillations are followed, whatever
        # the method.
        if not self.is_damped or self._min_stiff_steps == np.inf:
            return math.inf, self.evaluator.time_scale
        decay_rate, oscillation_rate = self.make_implicit_integrator().rates_at(self.input_cubics(0.0), self.initial_state)
        motion_rate = max(oscillation_rate, loading_rate(self.scene))
        n_explicit = duration * decay_rate / STABILITY_LIMIT
        n_implicit = estimate_implicit_steps(duration, motion_rate)
        is_stiff = n_explicit > max(self._min_stiff_steps, self.implicit_step_cost * n_implicit)
        return (STABILITY_LIMIT / decay_rate, 1 / (motion_rate or 1.0)) if is_stiff else (math.inf, self.evaluator.time_scale)

    def state_history(self, states: FloatArray, times: FloatArray) -> StateHistory:
        """Return mass centres and spindle from state vectors (n, components) at times (n,) s."""
        layout = self.system.state_layout
        motion = states[:, : layout.work].reshape(len(states), 2, -1, 3)
        poses, velocities = to_mass_centres(self.system, motion[:, 0], motion[:, 1])
        return StateHistory(
            times=times,
            poses=poses,
            velocities=velocities,
            work=states[:, layout.work],
            dissipated_energy=states[:, layout.dissipated_energy],
            lags=states[:, layout.lags :],
        )

    def is_out_of_range(self, state: FloatArray) -> bool:
        """Return whether a state is outside the mechanism's limits."""
        return self.evaluator.find_first_out_of_range(self._to_mass_centres(state)[0][np.newaxis]) is not None

    def sample_run(self, integration: IntegrationResult) -> StateHistory:
        """Return the states at the monitor times reached, and those at both ends of the step in which the motion leaves its range."""
        states, times = integration.states, self.time_grid.monitor_times[: len(integration.states)]
        if integration.exit_step is not None:
            times, states = integration.exit_step.continue_samples(times, states)
        return self.state_history(states, times)

    def find_excursion(self, step: MultibodyStep, tolerance: float) -> MultibodyStep | None:
        """Return a step up to where a reading is farthest beyond a limit, or None if that is within the accuracy."""
        times = np.linspace(step.start, step.outside, EXCURSION_SAMPLES)
        # The present contact mode is that of the step.
        limits = self._explicit_limits(tolerance, MAX_EXIT_STEPS)
        run = self._start_from(step.start, step.state, None, limits, times)
        run.integrate_smoothly(step.outside)
        history = self.state_history(run.states[: run.n_filled], times[: run.n_filled])
        excursion = find_first_excursion(self.scene.mechanism, history, np.zeros(0), self.accuracy)
        if excursion is None:
            return None
        peak = self._start_from(step.start, step.state, None, limits)
        peak.integrate_smoothly(excursion.time)
        return replace(step, outside=excursion.time, outside_state=peak.state)

    def state_between(self, integration: IntegrationResult, tolerance: float, k: int, time: float) -> StateHistory | None:
        """Return the state at a time (s) after sample k of `sample_run`, or None if the integration fails; limits do not end it."""
        last = integration.exit_step
        n_times = len(integration.states)
        modes = integration.contact_modes
        if last is not None and last.start <= time:
            start, state, mode = last.start, last.state, last.mode
            max_steps = MAX_EXIT_STEPS
        else:
            k, max_steps = min(k, n_times - 1), self.max_steps
            start = float(self.time_grid.monitor_times[k])
            state = integration.states[k]
            mode = modes[k] if modes else None
        if self.is_stiff:
            end_state = state.copy()
            outputs = NO_TIMES, end_state, RadauLimits(tolerance, time - start or 1.0, max_steps), np.empty((0, state.size))
            status, *_ = self.make_implicit_integrator().integrate(self.input_cubics(start), (start, time), *outputs)
        else:
            run = self._start_from(start, state, mode, self._explicit_limits(tolerance, max_steps))
            status, end_state = run.integrate(time), run.state
        if status not in (IntegrationStatus.DONE, IntegrationStatus.LEFT_LIMITS):
            return None
        return self.state_history(end_state[np.newaxis], np.array([time]))

    def _start_from(
        self, start: float, state: FloatArray, mode: ContactMode | None, limits: StepLimits, output_times: FloatArray = NO_TIMES
    ) -> "ExplicitRun":
        """Return a run from a state at a time (s) in a contact mode, or the present one, which no limits of readings end."""
        contacts, state = self.scene_contacts, state.copy()
        if contacts is not None and mode is not None:
            contacts.continue_from(mode)
            if start in self.breakpoints[1:]:
                contacts.change_mode(start, state, self.input_cubics(start))  # a state at a breakpoint has the mode before it
        return ExplicitRun(self, limits, state, start, output_times, has_limits=False)

    def _explicit_limits(self, tolerance: float, max_steps: int) -> StepLimits:
        """Return the limits of explicit steps from within a run, however stiff the motion is."""
        max_step = self.settings.max_step_ratio * self._max_step_scale
        return StepLimits(tolerance, 0.01 * self.evaluator.time_scale, max_step, max_steps, np.inf)

    def integrate_between(self, integration: IntegrationResult, tolerance: float, k: int, time: float) -> Motion | None:
        """Return poses and velocities of the mass centres at a time (s) after monitor time k, or None if that fails."""
        start, mode = float(self.time_grid.monitor_times[k]), None
        limits = self._explicit_limits(tolerance, self.max_steps)
        if self.scene_contacts is not None:
            mode = integration.contact_modes[k]
        else:
            limits = limits._replace(max_step=np.inf, max_steps=self.settings.max_interpolation_steps)
        run = self._start_from(start, integration.states[k], mode, limits._replace(min_stiff_steps=self._min_stiff_steps))
        return self._to_mass_centres(run.state) if run.integrate(time) == IntegrationStatus.DONE else None

    def _to_mass_centres(self, state: FloatArray) -> Motion:
        """Return poses and velocities of the mass centres of one state."""
        return to_mass_centres(self.system, *state[: self.system.state_layout.work].reshape(2, -1, 3))

    def _make_initial_state(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the initial state vector, with constraints satisfied to rounding."""
        project_state(*self.model, self.input_cubics(0.0), 0.0, poses, velocities, self.constraint_tolerance)
        centres = to_mass_centres(self.system, poses, velocities)
        return np.concatenate([poses.ravel(), velocities.ravel(), np.zeros(N_ENERGY_STATES), initial_lags(self.scene, *centres)])

    def input_cubics(self, start: float) -> FloatArray:
        """Return the local cubics (functions, columns) of spindle, drivers and force elements from a time (s) to the next breakpoint."""
        if start != self._cubics_start:  # a contact event and the integration after it ask for the same
            self._cubics_start, self._cubics = start, stack_local_cubics(self.input_functions, np.array([start]))[0]
        return self._cubics

    def _make_error_scale(self, motion_time: float) -> FloatArray:
        """Return the scales to which errors of a state vector are relative, for a motion that changes within a time (s)."""
        length_scale = self.evaluator.mechanism.length_scale
        pose_scale = np.tile([length_scale, length_scale, 1.0], len(self.system.bodies))
        lag_scale = np.maximum(np.abs(self.initial_state[self.system.state_layout.lags :]), 1.0)
        energy_scale = [self.evaluator.energy_scale] * N_ENERGY_STATES
        return np.concatenate([pose_scale, pose_scale / motion_time, energy_scale, lag_scale])


MIN_STANDING_STEPS = 8
"""Smallest number of steps of a mechanism that stands, from one breakpoint of its inputs to the next."""


class MethodChoice:
    """The method of a run: explicit steps, implicit ones from where the motion is stiff, and explicit ones where those take more work."""

    def __init__(self, context: ConstrainedIntegrator, run: "ExplicitRun", limits: StepLimits) -> None:
        self._context = context
        self._run, self._limits = run, limits
        self._implicit: ImplicitIntegrator | None = None
        self._explicit_step = limits.step
        self._worthwhile_steps = 0
        """Implicit steps that take as much work as the explicit ones they replace."""
        self._max_implicit_steps = math.ceil(limits.max_steps / context.implicit_step_cost)

    def advance(self, end: float) -> IntegrationStatus:
        """Integrate up to a time (s), without breakpoints before it."""
        run, context = self._run, self._context
        implicit = self._implicit
        if implicit is None and context.stable_step < np.inf:
            run.step = context.stable_step
            implicit = self._become_implicit()
        elif implicit is None or run.is_never_stiff:
            status = run.integrate(end)
            if status != IntegrationStatus.STIFF:
                return status
            implicit = self._become_implicit()
        status = self._integrate_implicitly(implicit, end)
        if status == IntegrationStatus.STEP_LIMIT and self._worthwhile_steps < self._max_implicit_steps:
            run.continue_explicitly(self._explicit_step)
            return run.integrate(end)
        return status

    def _become_implicit(self) -> ImplicitIntegrator:
        """Take implicit steps from the present state on, up to a number that is worth while."""
        run, context = self._run, self._context
        self._implicit = context.make_implicit_integrator()
        self._explicit_step = run.step
        context.stiffness_onset = min(context.stiffness_onset, run.time)
        n_explicit = (context.breakpoints[-1] - run.time) / (context.implicit_step_cost * run.step)
        self._worthwhile_steps = min(max(math.ceil(n_explicit), MIN_IMPLICIT_STEPS), self._max_implicit_steps)
        return self._implicit

    def _integrate_implicitly(self, implicit: ImplicitIntegrator, end: float) -> IntegrationStatus:
        """Take implicit steps up to a time (s)."""
        run, times = self._run, self._context.time_grid.monitor_times
        rows, cubics_start = run.rows_until(end), run.time
        cubics = self._context.input_cubics(run.time)
        limits = RadauLimits(
            self._limits.tolerance, run.step, self._worthwhile_steps - implicit.n_steps, self._limits.coarser_steps, self._limits.steps
        )
        status, run.step, n_reached, run.time = implicit.integrate(
            cubics, (run.time, end), times[rows], run.state, limits, run.states[rows]
        )
        run.n_filled += n_reached
        if status == IntegrationStatus.LEFT_LIMITS:
            step_start = cubics_start + float(implicit.step_start[-1])
            run.last_step = LastStep(step_start, implicit.step_start[:-1].copy(), run.time, run.state.copy(), None)
        return status

    def count_implicit_work(self) -> None:
        """Add the work of implicit steps to the counters of the run."""
        if self._implicit is not None:
            self._context.implicit_steps += self._implicit.n_steps
            self._run.counts += self._implicit.counts
            n_evaluations = self._implicit.counts[StepCounter.EVALUATIONS]
            self._run.output_force_counts += n_evaluations * count_output_forces(self._context.system)


class ExplicitRun:
    """Explicit integration of one run between breakpoints, with contact events.

    It holds the present state, its time (s), the next step (s), the states and contact modes at the output times reached so far, the
    counters, and the step in which the motion left its range. With `has_limits` false, nothing but a flight ends the motion.
    """

    last_step: MultibodyStep | None

    def __init__(
        self,
        context: ConstrainedIntegrator,
        limits: StepLimits,
        state: FloatArray,
        time: float,
        output_times: FloatArray,
        has_limits: bool = True,
    ) -> None:
        self._has_limits, self.last_step, self._step_start = has_limits, None, np.zeros(state.size + 1)
        self._context = context
        self._limits, self._output_times = limits, output_times
        self.state, self.time, self.step = state, time, limits.step
        self.n_filled = int(np.searchsorted(output_times, time, side="right"))
        self.states = np.empty((len(output_times), state.size))
        self.states[: self.n_filled] = state
        self.contact_modes = [context.scene_contacts.mode] * self.n_filled if context.scene_contacts else []
        self._last_event_time, self._n_simultaneous = -np.inf, 0
        self._buffers = np.empty(state.size), np.empty(state.size)
        self.counts = np.zeros(len(StepCounter), dtype=np.int64)
        self.output_force_counts = np.zeros(SLIDING_FRICTION + 1, dtype=np.int64)
        """Evaluations of output forces by law, as in `count_output_forces`; sticking friction is not evaluated."""

    @property
    def is_never_stiff(self) -> bool:
        """Whether the explicit method is not left where the motion is stiff."""
        return self._limits.min_stiff_steps == math.inf

    def continue_explicitly(self, step: float) -> None:
        """Continue a stiff motion with explicit steps, beginning with a given one (s): implicit ones have taken more work."""
        self.step, self._limits = step, self._limits._replace(min_stiff_steps=math.inf)

    def rows_until(self, end: float) -> slice:
        """Return the indices of the output times that are not reached yet, up to a time (s)."""
        return slice(self.n_filled, int(np.searchsorted(self._output_times, end, side="right")))

    def integrate(self, end: float) -> IntegrationStatus:
        """Integrate the state in place up to a time (s), without breakpoints before it, and record it at the output times."""
        context, contacts = self._context, self._context.scene_contacts
        settings = self._context.settings
        while True:
            if contacts and contacts.is_jammed:
                return IntegrationStatus.UNDETERMINED
            status, triggered = self._integrate_to_event(*(contacts.model if contacts else context.model), end)
            if status == IntegrationStatus.LEFT_LIMITS and not self._has_left_limits() and self.time < end:
                continue
            if status == IntegrationStatus.LEFT_LIMITS and self.last_step is None:
                return IntegrationStatus.DONE
            if contacts is None or status != IntegrationStatus.EVENT:
                return status
            is_simultaneous = self.time - self._last_event_time <= settings.event_time_tolerance * context.evaluator.time_scale
            self._n_simultaneous = self._n_simultaneous + 1 if is_simultaneous else 0
            self._last_event_time = self.time
            if self._n_simultaneous >= settings.max_simultaneous_events:
                return IntegrationStatus.ENDLESS_EVENTS
            contacts.change_mode(self.time, self.state, context.input_cubics(self.time), triggered)
            self.step = min(self.step, settings.restart_step_ratio * self._limits.max_step)

    def integrate_smoothly(self, end: float) -> None:
        """Integrate the state in place up to a time (s), or to the first event before it."""
        contacts = self._context.scene_contacts
        self._integrate_to_event(*(contacts.model if contacts else self._context.model), end)

    def _has_left_limits(self) -> bool:
        """Return whether a reading is outside its limits at the end of the last step, or at a turning point within it."""
        context, step = self._context, self.last_step
        if step is None or context.is_out_of_range(self.state):
            return True
        self.last_step = context.find_excursion(step, self._limits.tolerance)
        return self.last_step is not None

    def _integrate_to_event(self, system: System, workspace: SystemWorkspace, end: float) -> tuple[IntegrationStatus, set[int]]:
        """Integrate up to a time (s) or to the first event; return the status and the contacts of event functions that are positive."""
        context = self._context
        n_evaluations = int(self.counts[StepCounter.EVALUATIONS])
        rows = self.rows_until(end)
        n_states = len(self.state)
        event_tolerances = system.event_functions["tolerance"].copy()
        cubics, gap = context.input_cubics(self.time), context.constraint_tolerance
        shafts, limit_rows = (context.shafts, context.limits) if self._has_limits else (context.shafts[:0], context.no_limits)
        ends, cubics_start = (context.max_distance, shafts, limit_rows, self._step_start), self.time
        equation = MultibodyEquation(system, workspace, cubics, gap, *ends, *self._buffers, self.counts)
        has_events = context.scene_contacts is not None and system.event_functions.size > 0
        max_step, near_step = self._limits.max_step, math.inf
        if system.watches_gaps_alone:
            near_step = context.settings.event_step_ratio * max_step
        elif has_events:
            max_step *= context.settings.event_step_ratio
        records = event_tolerances, self.counts, system.n_kinks, near_step, FAR_STEPS * max_step
        buffers = make_step_buffers(n_states, n_states, context.error_scale, *records, find_gaps(context.scene, system.event_functions))
        is_held = has_events and stands_still(system, self.state, cubics, context.evaluator.mechanism.length_scale)
        motion = self.state[: system.state_layout.work].copy()
        if is_held:  # only inputs change, slowly, and with them the loads and their work
            max_step = max(max_step, (end - self.time) / MIN_STANDING_STEPS)
        limits, outputs = self._limits._replace(step=self.step, max_step=max_step), self.states[rows]
        status, self.step, n_reached, self.time = integrate_multibody(
            equation, buffers, (self.time, end), self._output_times[rows], self.state, limits, outputs
        )
        if is_held:  # without the rounding of long steps
            self.state[: len(motion)] = outputs[:n_reached, : len(motion)] = motion
        self.n_filled += n_reached
        if status in (IntegrationStatus.LEFT_LIMITS, IntegrationStatus.TURNED_BACK):
            mode = context.scene_contacts.mode if context.scene_contacts else None
            start = cubics_start + float(self._step_start[-1])
            self.last_step = LastStep(start, self._step_start[:-1].copy(), self.time, self.state.copy(), mode)
        self.contact_modes += [context.scene_contacts.mode] * n_reached if context.scene_contacts else []
        n_evaluations = int(self.counts[StepCounter.EVALUATIONS]) - n_evaluations
        self.output_force_counts += n_evaluations * count_output_forces(system)
        functions = system.event_functions[buffers.event_values[-1] > 0.0]
        if status == IntegrationStatus.EVENT and EventFunctionKind.OTHER_GAP in functions["kind"]:
            status = IntegrationStatus.TWO_ROLLERS
        return status, set(functions["contact_index"].tolist())
