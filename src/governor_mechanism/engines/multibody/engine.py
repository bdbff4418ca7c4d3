"""The multibody engine: bodies and joints, index-reduced and projected, integrated by DOP853 in compiled code."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects.registry import EFFECT_TYPES, FORCE_LAWS
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import CertifiedRunner, ErrorControlledEngine, StepPlan, describe_end
from governor_mechanism.engines.exit_location import count_before, find_first_exit
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.multibody.integration import IntegrationResult, MultibodySettings
from governor_mechanism.integrators.dop853 import STABILITY_LIMIT
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.mechanics.dynamics.contacts import FRICTION_LAW_NAME, contacts_of
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Joint
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult, modes_at

STIFF_STEP_RATIO = 0.2
"""Step relative to the largest stable one from which stability limits it: error control wavers about that limit."""


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
        return MultibodyRunner(self, scene, request).run()


class MultibodyRunner(CertifiedRunner):
    """Runs of one scene with given tolerances."""

    method = "explicit (DOP853)"

    def __init__(self, engine: MultibodyEngine, scene: Scene, request: RunRequest) -> None:
        # Not before: runs of other engines, which the choice of an engine compares with this one, need none of it.
        from governor_mechanism.engines.multibody.integration import SINGULAR_CONSTRAINT_TOLERANCE_RATIO
        from governor_mechanism.engines.multibody.run import ConstrainedIntegrator

        initial_motion = initial_state(scene)
        super().__init__(engine, request, ReadingEvaluator(scene, initial_motion[0]))
        limits = self.max_steps, engine.settings, request.accuracy
        self.integrator = ConstrainedIntegrator(self.evaluator, initial_motion, request.times, *limits)
        self.singular_violation = engine.settings.constraint_tolerance_ratio * SINGULAR_CONSTRAINT_TOLERANCE_RATIO

    def run_once(self, tolerance: float, plan: StepPlan) -> RunResult:
        """Run once."""
        self.n_runs += 1
        integrator, time_grid = self.integrator, self.integrator.time_grid
        integration = integrator.integrate(tolerance, plan)
        if integrator.is_stiff:
            onset = f"t = {integrator.stiffness_onset:.4g} s"
            self.method = f"stiff from {onset}: implicit (Radau) in independent coordinates from there"
        samples, status = integrator.sample_run(integration), integration.status
        history = integrator.state_history(integration.states, time_grid.monitor_times[: len(integration.states)])
        n_kept = len(history.times)
        if status == IntegrationStatus.DONE and len(time_grid.reported_indices) < len(self.request.times):
            status = IntegrationStatus.STEP_LIMIT
        outcome, detail = describe_end(self.scene, status, f"t = {integration.end_time:.9g} s", self.max_steps)
        if outcome is Outcome.STEP_LIMIT:
            detail += self._describe_stiffness(integration)
        event_times = np.array([event.time for event in integration.events]) if integrator.is_searched else None
        state_at = partial(integrator.state_between, integration, tolerance)
        motion_exit = find_first_exit(self.evaluator, samples, state_at, event_times, self.request.accuracy)
        if motion_exit is not None:
            n_kept = count_before(history.times, motion_exit.time)
            outcome = motion_exit.outcome
            detail = motion_exit.detail
        reported_indices = time_grid.truncate(n_kept).reported_indices
        reported_states = history.at(reported_indices)
        modes = integration.contact_modes[:n_kept]
        return RunResult(
            reported_states=reported_states,
            monitor_states=history.at(slice(n_kept)),
            observables=self.evaluator.evaluate(reported_states, modes_at(modes, reported_indices)),
            outcome=outcome,
            detail=detail,
            step=integration.last_step,
            dense_output=partial(integrator.integrate_between, integration, tolerance),
            contact_modes=modes,
            reported_indices=reported_indices,
            contact_events=integration.events,
        )

    def _describe_stiffness(self, integration: IntegrationResult) -> str:
        """Return a clause on what makes a motion stiff whose explicit steps are no longer than its fastest decay allows, or nothing."""
        integrator = self.integrator
        if not integrator.is_damped or not len(integration.states) or integrator.is_stiff:
            return ""
        time = float(integrator.time_grid.monitor_times[len(integration.states) - 1])
        decay_rate, _ = integrator.make_implicit_integrator().rates_at(integrator.input_cubics(time), integration.states[-1])
        if decay_rate * integration.last_step < STIFF_STEP_RATIO * STABILITY_LIMIT:
            return ""
        return (
            f"; the motion is stiff: a part of it decays within {1 / decay_rate:.1g} s, as that of a light body on a strong damper "
            "(give the body no mass or a larger one, or soften the damper)"
        )

    def complete_result(self, best: RunResult) -> RunResult:
        """Remove the dense output of a stiff motion, and events after the end of the motion."""
        times = self.integrator.time_grid.monitor_times[: len(best.contact_modes)]
        events = tuple(event for event in best.contact_events if not len(times) or event.time <= times[-1])
        return replace(best, dense_output=None if self.integrator.is_stiff else best.dense_output, contact_events=events)

    def count_steps(self) -> int:
        """Return the steps of all runs so far, rejected ones included."""
        return int(self.integrator.counters[StepCounter.ACCEPTED] + self.integrator.counters[StepCounter.REJECTED])

    def count_work(self) -> tuple[int, int, Mapping[str, int]]:
        """Return the steps, the rejected steps, and the evaluations by force law."""
        integrator = self.integrator
        system = self.integrator.system
        elements = self.scene.mechanism.force_elements
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
