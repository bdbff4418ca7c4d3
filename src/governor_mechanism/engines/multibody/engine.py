"""The multibody engine: bodies and joints, index-reduced and projected, integrated by DOP853 in compiled code."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.registry import EFFECT_TYPES
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.certificate import (
    COMPARISON_TOLERANCE_RATIO,
    check_engine_settings,
    classify_outcome,
    initial_tolerance,
    refine_tolerance,
)
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.multibody.run import ConstrainedIntegrator, IntegrationResult
from governor_mechanism.engines.multibody.settings import MultibodySettings
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import StateHistory
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.observables.evaluation import Observables, ReadingEvaluator, RunResult
from governor_mechanism.observables.model_size import count_model_size
from governor_mechanism.observables.singular_configurations import DenseOutput
from governor_mechanism.types import FloatArray


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
        warn_before_compiling("integrate_projected_dop853", 12)
        runner = MultibodyRunner(self, scene, request)
        runner.integrator.compile_kernels()
        start_time = time.perf_counter()
        tolerance = self.tolerance or initial_tolerance(request.accuracy)
        if request.certify and self.tolerance is None:
            best = refine_tolerance(runner.run_certified, tolerance, request.accuracy, self.settings.max_stagnant_runs)
        else:
            best = runner.run_certified(tolerance) if request.certify else runner.run_once(tolerance)
        return runner.make_trajectory(best, time.perf_counter() - start_time)


@dataclass(frozen=True)
class MultibodyResult:
    """One run: states at the reported and monitor times, their observables, and why the run ended early if it did."""

    reported_states: StateHistory
    monitor_states: StateHistory
    integration: IntegrationResult
    tolerance: float
    observables: Observables
    early_outcome: Outcome | None
    detail: str
    reading_errors: dict[str, float]
    error_estimate: float | None = None
    n_excluded: int = 0

    @property
    def n_reached(self) -> int:
        """Return how many of the reported times were reached."""
        return len(self.reported_states.times)


class MultibodyRunner:
    """Run one scene with given tolerances."""

    def __init__(self, engine: MultibodyEngine, scene: Scene, request: RunRequest) -> None:
        self.engine, self.scene, self.request = engine, scene, request
        initial_motion = initial_state(scene)
        self.evaluator = ReadingEvaluator(scene, initial_motion[0])
        self.integrator = ConstrainedIntegrator(scene, self.evaluator, initial_motion, request.times, engine.max_steps, engine.settings)
        self.n_runs = 0

    def run_certified(self, tolerance: float) -> MultibodyResult:
        """Run twice, and estimate the error of the more accurate run by the difference."""
        # Where max_step and not the tolerance limits the steps, doubling it makes the runs differ.
        worse, better = (self.run_once(COMPARISON_TOLERANCE_RATIO * tolerance, 2.0), self.run_once(tolerance))
        n_shared = min(len(worse.reported_states.times), len(better.reported_states.times))
        event_time_error, is_near_event = compare_event_logs(
            better.integration.events,
            worse.integration.events,
            better.reported_states.times[:n_shared],
            self.request.accuracy * self.evaluator.time_scale,
        )
        indices = np.flatnonzero(~is_near_event)
        worse_observables = self.evaluator.evaluate(worse.reported_states.first(n_shared).at(indices))
        better_observables = self.evaluator.evaluate(better.reported_states.first(n_shared).at(indices))
        errors = self.evaluator.compare_observables(better_observables, worse_observables)
        estimate = self.evaluator.to_relative_error(errors)
        if self.integrator.contact_solver:
            errors["event times"] = event_time_error
            estimate = max(estimate, event_time_error / self.evaluator.time_scale)
        return replace(better, reading_errors=errors, error_estimate=estimate, n_excluded=int(is_near_event.sum()))

    def run_once(self, tolerance: float, step_factor: float = 1.0) -> MultibodyResult:
        """Run once, with the largest step multiplied by a factor."""
        self.n_runs += 1
        integration = self.integrator.integrate(tolerance, step_factor * self.engine.settings.max_step_ratio)
        history = self.integrator.state_history(integration.states)
        n_kept, early_outcome, detail = len(history.times), None, ""
        range_exit = self.evaluator.find_first_out_of_range(history.poses)
        time_text = f"t = {self.integrator.time_grid.monitor_times[n_kept - 1]:.6g} s"
        if range_exit is not None:
            n_kept, early_outcome = range_exit[0], Outcome.LEFT_RANGE
            detail = f"{range_exit[1]}, at {self._describe_exit(integration.states, tolerance, n_kept)}"
        elif integration.status == IntegrationStatus.STALLED:
            early_outcome, detail = Outcome.STALLED, f"at {time_text}"
        elif integration.status != IntegrationStatus.DONE or len(self.integrator.time_grid.reported_indices) < len(self.request.times):
            early_outcome, detail = Outcome.STEP_LIMIT, f"max_steps = {self.engine.max_steps} are used up at {time_text}"
        reported_states = history.at(self.integrator.time_grid.truncate(n_kept).reported_indices)
        observables = self.evaluator.evaluate(reported_states)
        return MultibodyResult(reported_states, history.first(n_kept), integration, tolerance, observables, early_outcome, detail, {})

    def _describe_exit(self, states: FloatArray, tolerance: float, exit_index: int) -> str:
        """Return when the motion leaves its range before a monitor time, located by bisection since the previous one."""
        times = self.integrator.time_grid.monitor_times
        if exit_index == 0 or self.integrator.stiffness_onset < np.inf or self.integrator.contact_solver:
            return f"about t = {times[exit_index]:.6g} s"
        time_inside, time_outside = float(times[exit_index - 1]), float(times[exit_index])
        for _ in range(self.engine.settings.max_exit_bisections):
            middle = 0.5 * (time_inside + time_outside)
            motion = self.integrator.integrate_between(states, tolerance, exit_index - 1, middle)
            if motion is None:
                return f"about t = {time_outside:.6g} s"
            if self.evaluator.find_first_out_of_range(motion[0][np.newaxis]) is None:
                time_inside = middle
            else:
                time_outside = middle
        return f"t = {time_outside:.9g} s"

    def make_trajectory(self, best: MultibodyResult, wall_time: float) -> Trajectory:
        """Return the trajectory of the best run."""
        settings = {**asdict(self.engine), "asked_accuracy": self.request.accuracy, "certified": best.error_estimate is not None}
        return self.evaluator.make_trajectory(
            RunResult(
                reported_states=best.reported_states,
                monitor_states=best.monitor_states,
                observables=best.observables,
                outcome=classify_outcome(best, self.request.accuracy),
                detail=best.detail,
                error_estimate=best.error_estimate,
                reading_errors=best.reading_errors,
                dense_output=self._make_dense_output(best),
                contact_modes=best.integration.contact_modes[: len(best.monitor_states.times)],
                reported_indices=self.integrator.time_grid.truncate(len(best.monitor_states.times)).reported_indices,
                contact_events=tuple(
                    event
                    for event in best.integration.events
                    if not len(best.monitor_states.times) or event.time <= best.monitor_states.times[-1]
                ),
                n_excluded=best.n_excluded,
            ),
            cost=self._make_cost(best, wall_time),
            settings=settings,
        )

    def _make_dense_output(self, best: MultibodyResult) -> DenseOutput | None:
        """Return the dense output of a smooth run, or None for a stiff run or one with contacts."""
        if self.integrator.stiffness_onset < np.inf or self.integrator.contact_solver:
            return None
        return partial(self.integrator.integrate_between, best.integration.states, best.tolerance)

    def _make_cost(self, best: MultibodyResult, wall_time: float) -> Cost:
        """Return the cost over all runs."""
        steps, rejected, evaluations, _ = (int(count) for count in self.integrator.counters)
        law_counts = Counter({"equations of motion": evaluations})
        system = self.integrator.system
        n_bodies = len(system.bodies)
        if system.gravity:
            law_counts["gravity"] = n_bodies * evaluations
        if system.has_centrifugal_forces:
            law_counts["centrifugal"] = n_bodies * evaluations
        if self.scene.part.mechanism.force_elements:
            law_counts["springs, dampers, forces"] = len(self.scene.part.mechanism.force_elements) * evaluations
        effect_classes = {"springs on readings": OutputSpring, "dashpots": Dashpot, "dry friction": DryFriction}
        for (law, effect_class), count in zip(effect_classes.items(), self.integrator.output_force_counts.tolist(), strict=True):
            if any(isinstance(effect, effect_class) for effect in self.scene.output_effects):
                law_counts[law] = count
        return Cost(
            engine=self.engine.name,
            reason=self.request.reason,
            step=best.integration.last_step,
            steps=steps + self.integrator.implicit_steps,
            rejected=rejected,
            runs=self.n_runs,
            evaluations=dict(law_counts),
            wall_time=wall_time,
            events=len(best.integration.events),
            model_size=count_model_size(self.scene),
            method=self._describe_method(),
        )

    def _describe_method(self) -> str:
        """Return the integration method as text."""
        if self.integrator.stiffness_onset == np.inf:
            return "explicit (DOP853)"
        return f"stiff from t = {self.integrator.stiffness_onset:.4g} s: implicit (Radau) in independent coordinates from there"
