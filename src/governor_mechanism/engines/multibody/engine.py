"""The multibody engine: bodies and joints, index-reduced and projected, integrated by DOP853 in compiled code."""

from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects.registry import EFFECT_TYPES, FORCE_LAWS
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.certificate import CertifiedRunner, check_engine_settings, describe_end
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.multibody.run import ConstrainedIntegrator, IntegrationResult
from governor_mechanism.engines.multibody.settings import MultibodySettings
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.dynamics.contacts import FRICTION_LAW_NAME, contacts_of
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult


@final
@dataclass(frozen=True, kw_only=True)
class MultibodyEngine(Engine):
    """Order 8 with error control and constraints satisfied to rounding at every step; the reference engine.

    The error estimate is the difference from a run with a ten times larger tolerance.

    Attributes
    ----------
    name
        Name of the engine.
    effects
        Types of effects the engine can model.
    joints
        Types of joints the engine can model.
    tolerance
        Error of one step relative to the scales; None chooses it from the accuracy.
    max_steps
        Largest number of steps of one run.
    settings
        Numerical settings.
    """

    name: ClassVar[str] = "multibody"
    effects: ClassVar[frozenset[type[Effect]]] = EFFECT_TYPES
    joints: ClassVar[frozenset[type[Joint]]] = JOINT_TYPES

    tolerance: float | None = None
    max_steps: int = 1_000_000
    settings: MultibodySettings = field(default_factory=MultibodySettings)

    def __post_init__(self) -> None:
        check_engine_settings("MultibodyEngine", self.tolerance, self.max_steps)

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        warn_before_compiling("integrate_multibody", 12)
        runner = MultibodyRunner(self, scene, request)
        runner.integrator.compile_kernels()
        return runner.run(self.tolerance, self.settings.max_stagnant_runs, asdict(self))


@dataclass(frozen=True, kw_only=True)
class MultibodyResult(RunResult):
    """Result of one run with the integration behind it."""

    integration: IntegrationResult
    tolerance: float


class MultibodyRunner(CertifiedRunner[MultibodyResult]):
    """Runs of one scene with given tolerances."""

    def __init__(self, engine: MultibodyEngine, scene: Scene, request: RunRequest) -> None:
        initial_motion = initial_state(scene)
        super().__init__(scene, request, ReadingEvaluator(scene, initial_motion[0]))
        self.engine = engine
        self.integrator = ConstrainedIntegrator(scene, self.evaluator, initial_motion, request.times, engine.max_steps, engine.settings)

    def run_once(self, tolerance: float, is_comparison: bool = False) -> MultibodyResult:
        """Run once; a comparison run may take steps twice as long."""
        self.n_runs += 1
        integration = self.integrator.integrate(tolerance, 2.0 if is_comparison else 1.0)
        history = self.integrator.state_history(integration.states)
        n_kept = len(history.times)
        is_cut_short = len(self.integrator.time_grid.reported_indices) < len(self.request.times)
        status = IntegrationStatus.STEP_LIMIT if is_cut_short and integration.status == IntegrationStatus.DONE else integration.status
        outcome, detail = describe_end(status, f"t = {self.integrator.time_grid.monitor_times[n_kept - 1]:.6g} s", self.engine.max_steps)
        range_exit = self.evaluator.find_first_out_of_range(history.poses)
        if range_exit is not None:
            n_kept, outcome = range_exit[0], Outcome.LEFT_RANGE
            detail = f"{range_exit[1]}, at {self._describe_exit(integration, tolerance, n_kept)}"
        reported_indices = self.integrator.time_grid.truncate(n_kept).reported_indices
        reported_states = history.at(reported_indices)
        return MultibodyResult(
            reported_states=reported_states,
            monitor_states=history.at(slice(n_kept)),
            observables=self.evaluator.evaluate(reported_states),
            outcome=outcome,
            detail=detail,
            contact_modes=integration.contact_modes[:n_kept],
            reported_indices=reported_indices,
            contact_events=integration.events,
            integration=integration,
            tolerance=tolerance,
        )

    def _describe_exit(self, integration: IntegrationResult, tolerance: float, exit_index: int) -> str:
        """Return when the motion leaves its range before a monitor time, located by bisection since the previous one."""
        times = self.integrator.time_grid.monitor_times
        if exit_index == 0 or self.integrator.stiffness_onset < np.inf or self.integrator.scene_contacts:
            return f"about t = {times[exit_index]:.6g} s"
        time_inside, time_outside = float(times[exit_index - 1]), float(times[exit_index])
        for _ in range(self.engine.settings.max_exit_bisections):
            middle = 0.5 * (time_inside + time_outside)
            motion = self.integrator.integrate_between(integration, tolerance, exit_index - 1, middle)
            if motion is None:
                return f"about t = {time_outside:.6g} s"
            if self.evaluator.find_first_out_of_range(motion[0][np.newaxis]) is None:
                time_inside = middle
            else:
                time_outside = middle
        return f"t = {time_outside:.9g} s"

    def complete_result(self, best: MultibodyResult) -> MultibodyResult:
        """Add the dense output of a run that is not stiff, and remove events after the end of the motion."""
        is_stiff = self.integrator.stiffness_onset < np.inf
        times = self.integrator.time_grid.monitor_times[: len(best.contact_modes)]
        return replace(
            best,
            dense_output=None if is_stiff else partial(self.integrator.integrate_between, best.integration, best.tolerance),
            contact_events=tuple(event for event in best.contact_events if not len(times) or event.time <= times[-1]),
        )

    def make_cost(self, best: MultibodyResult, wall_time: float) -> Cost:
        """Return the cost over all runs."""
        steps, rejected, evaluations, _ = (int(count) for count in self.integrator.counters)
        law_counts = Counter({"equations of motion": evaluations})
        system = self.integrator.system
        n_bodies = len(system.bodies)
        if any(system.bodies["gravity"]):
            law_counts["gravity"] = n_bodies * evaluations
        if len(system.planes):
            law_counts["centrifugal"] = n_bodies * evaluations
        if self.scene.mechanism.force_elements:
            law_counts["springs, dampers, forces"] = len(self.scene.mechanism.force_elements) * evaluations
        *force_counts, friction_count = self.integrator.output_force_counts.tolist()
        for law, count in zip(FORCE_LAWS, force_counts, strict=True):
            if any(isinstance(effect, law) for effect in self.scene.output_effects):
                law_counts[law.law_name] = count
        if any(contact.friction is not None for contact in contacts_of(self.scene)):
            law_counts[FRICTION_LAW_NAME] = friction_count
        return Cost(
            engine=self.engine.name,
            reason=self.request.reason,
            step=best.integration.last_step,
            steps=steps + self.integrator.implicit_steps,
            rejected=rejected,
            runs=self.n_runs,
            wall_time=wall_time,
            evaluations=dict(law_counts),
            events=len(best.contact_events),
            model_size=self.evaluator.count_model_size(),
            method=self._describe_method(),
        )

    def _describe_method(self) -> str:
        """Return the integration method as text."""
        if self.integrator.stiffness_onset == np.inf:
            return "explicit (DOP853)"
        return f"stiff from t = {self.integrator.stiffness_onset:.4g} s: implicit (Radau) in independent coordinates from there"
