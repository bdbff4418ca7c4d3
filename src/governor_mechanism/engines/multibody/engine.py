"""The multibody engine: bodies and joints, index-reduced and projected, integrated by DOP853 in compiled code."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects.registry import EFFECT_TYPES, FORCE_LAWS
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import CertifiedRunner, ErrorControlledEngine, StepPlan, describe_end
from governor_mechanism.engines.exit_location import describe_stall, locate_exit
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.multibody.integration import SINGULAR_CONSTRAINT_TOLERANCE_RATIO
from governor_mechanism.engines.multibody.run import ConstrainedIntegrator, IntegrationResult, MultibodySettings
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.dynamics.forces.contacts import FRICTION_LAW_NAME, contacts_of
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Joint
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import find_first_control_exit
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.limit_excursions import find_first_excursion
from governor_mechanism.observables.run_result import RunResult, StateHistory


@final
@dataclass(frozen=True, kw_only=True)
class MultibodyEngine(ErrorControlledEngine):
    """Order 8 with error control and constraints satisfied to rounding at every step; the reference engine.

    The error estimate is twice the difference from a run that takes at most half of every step.

    Attributes
    ----------
    name
        Name of the engine.
    effects
        Types of effects the engine can model.
    joints
        Types of joints the engine can model.
    settings
        Numerical settings.
    """

    name: ClassVar[str] = "multibody"
    effects: ClassVar[frozenset[type[Effect]]] = EFFECT_TYPES
    joints: ClassVar[frozenset[type[Joint]]] = JOINT_TYPES

    settings: MultibodySettings = field(default_factory=MultibodySettings)

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        runner = MultibodyRunner(self, scene, request)
        runner.integrator.compile_kernels()
        return runner.run()


class MultibodyRunner(CertifiedRunner):
    """Runs of one scene with given tolerances."""

    method = "explicit (DOP853)"

    def __init__(self, engine: MultibodyEngine, scene: Scene, request: RunRequest) -> None:
        initial_motion = initial_state(scene)
        super().__init__(engine, request, ReadingEvaluator(scene, initial_motion[0]))
        self.integrator = ConstrainedIntegrator(self.evaluator, initial_motion, request.times, self.max_steps, engine.settings)
        self.singular_violation = engine.settings.constraint_tolerance_ratio * SINGULAR_CONSTRAINT_TOLERANCE_RATIO

    def run_once(self, tolerance: float, plan: StepPlan) -> RunResult:
        """Run once."""
        self.n_runs += 1
        integrator, time_grid = self.integrator, self.integrator.time_grid
        integration = integrator.integrate(tolerance, plan)
        if integrator.is_stiff:
            onset = f"t = {integrator.stiffness_onset:.4g} s"
            self.method = f"stiff from {onset}: implicit (Radau) in independent coordinates from there"
        history, status = integrator.state_history(integration.states), integration.status
        n_kept = len(history.times)
        if status == IntegrationStatus.DONE and len(time_grid.reported_indices) < len(self.request.times):
            status = IntegrationStatus.STEP_LIMIT
        outcome, detail = describe_end(self.scene, status, f"t = {time_grid.monitor_times[n_kept - 1]:.6g} s", self.max_steps)
        range_exit = self.evaluator.find_first_out_of_range(history.poses)
        if range_exit is not None:
            n_kept, outcome = range_exit[0], Outcome.LEFT_RANGE
            detail = f"{range_exit[1]}, at {self._describe_exit(integration, tolerance, n_kept)}"
        event_times = np.array([event.time for event in integration.events])
        excursion = find_first_excursion(self.evaluator.mechanism, history.at(slice(n_kept)), event_times, self.request.accuracy)
        if excursion is not None:
            n_kept, outcome = excursion[0], Outcome.LEFT_RANGE
            detail = f"{excursion[1]}, at about t = {history.times[n_kept]:.6g} s"
        if (control_exit := find_first_control_exit(self.scene, history.at(slice(n_kept)))) is not None:
            n_kept, outcome = control_exit[0], Outcome.CONTROL_OUT_OF_RANGE
            detail = f"{control_exit[1]}, at about t = {history.times[n_kept]:.6g} s"
        elif status == IntegrationStatus.TURNED_BACK and n_kept == len(history.times):  # else something else ended the run before
            n_kept, detail = self._find_stall(integration, tolerance, history)
            outcome = Outcome.SHAFT_STALLED
        reported_indices = time_grid.truncate(n_kept).reported_indices
        reported_states = history.at(reported_indices)
        return RunResult(
            reported_states=reported_states,
            monitor_states=history.at(slice(n_kept)),
            observables=self.evaluator.evaluate(reported_states),
            outcome=outcome,
            detail=detail,
            step=integration.last_step,
            dense_output=partial(integrator.integrate_between, integration, tolerance),
            contact_modes=integration.contact_modes[:n_kept],
            reported_indices=reported_indices,
            contact_events=integration.events,
        )

    def _describe_exit(self, integration: IntegrationResult, tolerance: float, exit_index: int) -> str:
        """Return when the motion leaves its range before a monitor time, located by bisection since the previous one."""
        integrator, times = self.integrator, self.integrator.time_grid.monitor_times
        if exit_index == 0 or integrator.is_stiff or integrator.scene_contacts:
            return f"about t = {times[exit_index]:.6g} s"

        def is_inside(time: float) -> bool | None:
            motion = integrator.integrate_between(integration, tolerance, exit_index - 1, time)
            return None if motion is None else self.evaluator.find_first_out_of_range(motion[0][np.newaxis]) is None

        inside, outside = float(times[exit_index - 1]), float(times[exit_index])
        time = locate_exit(is_inside, inside, outside, integrator.settings.max_exit_bisections)
        return f"t = {time:.9g} s" if time is not None else f"about t = {outside:.6g} s"

    def _find_stall(self, integration: IntegrationResult, tolerance: float, history: StateHistory) -> tuple[int, str]:
        """Return the number of monitor times before a shaft stalls, and how and when it does."""
        integrator, times = self.integrator, self.integrator.time_grid.monitor_times
        found = self.evaluator.find_first_stall(history.poses, history.velocities)
        n_moving = found[0] if found else len(history.times)
        if not n_moving:
            return 0, f"{found[1] if found else ''}, at t = 0 s"
        motion_at = partial(integrator.integrate_between, integration, tolerance, n_moving - 1)
        span, poses = (float(times[n_moving - 1]), float(times[n_moving])), history.poses[n_moving - 1]
        return n_moving, describe_stall(self.evaluator, motion_at, span, poses, integrator.settings.max_exit_bisections)

    def complete_result(self, best: RunResult) -> RunResult:
        """Remove the dense output of a stiff motion, and events after the end of the motion."""
        times = self.integrator.time_grid.monitor_times[: len(best.contact_modes)]
        events = tuple(event for event in best.contact_events if not len(times) or event.time <= times[-1])
        return replace(best, dense_output=None if self.integrator.is_stiff else best.dense_output, contact_events=events)

    def count_work(self) -> tuple[int, int, Mapping[str, int]]:
        """Return the steps, the rejected steps, and the evaluations by force law."""
        integrator, system, elements = self.integrator, self.integrator.system, self.scene.mechanism.force_elements
        steps, rejected, evaluations, _ = integrator.counters.tolist()
        n_bodies = len(system.bodies)
        counts_per_evaluation = {
            "equations of motion": 1,
            "gravity": n_bodies * any(system.bodies["gravity"]),
            "centrifugal": n_bodies * bool(len(system.planes)),
            "springs, dampers, forces": len(elements),
        }
        law_counts = {name: count * evaluations for name, count in counts_per_evaluation.items() if count}
        *force_counts, friction_count = integrator.output_force_counts.tolist()
        for law, count in zip(FORCE_LAWS, force_counts, strict=True):
            if any(isinstance(effect, law) for effect in self.scene.output_effects):
                law_counts[law.law_name] = count
        if any(contact.friction is not None for contact in contacts_of(self.scene)):
            law_counts[FRICTION_LAW_NAME] = friction_count
        return steps, rejected, law_counts
