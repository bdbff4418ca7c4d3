"""Reduced engine: one coordinate along tables of the assembled mechanism, integrated by DOP853 in compiled code."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, ClassVar, final

import numpy as np

from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.registry import EFFECT_TYPES
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.certificate import (
    COMPARISON_TOLERANCE_RATIO,
    check_engine_settings,
    classify_outcome,
    initial_tolerance,
    refine_tolerance,
)
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.reduced.integration import BECAME_STIFF, RUN_COMPLETED, RUN_STALLED, integrate_reduced
from governor_mechanism.engines.reduced.run import PATH_ENDED, REDUCED_MAX_STEP_RATIO, ReducedRun, ReducedSolution
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.time_grid import make_time_grid
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import StateHistory
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.observables.evaluation import Observables, ReadingEvaluator, RunResult
from governor_mechanism.observables.model_size import count_model_size
from governor_mechanism.observables.singular_configurations import DenseOutput

COMPARISON_WIDTH_RATIO = 0.7
"""Factor on the piece width of the comparison run, so that the certificate includes the interpolation error of the tables."""

MAX_REDUCED_STAGNANT_RUNS = 4
"""Number of tighter certificates without improvement after which refinement stops; a single one may be accidental."""

TURNING_POINT_SEARCH_INTERVAL = 0.25
"""Spacing of the states between which turning points are searched, in time scales and in coordinate scales."""

MAX_MONITOR_TRAVEL, MAX_MONITOR_TIMES = 0.5, 200_000
"""Travel between monitored states, in coordinate scales, above which more are inserted, and their largest number."""


@final
@dataclass(frozen=True, kw_only=True)
class ReducedEngine(Engine):
    """Engine of order 8 with error control for mechanisms with one degree of freedom; the fastest one.

    The error estimate is the difference from a run with a ten times larger tolerance along a table of its own.

    Attributes
    ----------
    name
        Name of the engine.
    effects
        Effects that it can simulate.
    joints
        Joints that it can simulate.
    tolerance
        Relative error of one step. Default: chosen from the requested accuracy.
    max_steps
        Largest number of steps of one run.
    """

    name: ClassVar[str] = "reduced"
    effects: ClassVar[frozenset[type[Effect]]] = EFFECT_TYPES - {Clearance}
    joints: ClassVar[frozenset[type[Joint]]] = JOINT_TYPES

    tolerance: float | None = None
    max_steps: int = 1_000_000

    def __post_init__(self) -> None:
        """Check the settings."""
        check_engine_settings("ReducedEngine", self.tolerance, self.max_steps)

    def _refuses(self, scene: Scene) -> str:
        position_solver = PositionSolver(scene.part.mechanism)
        if position_solver.equations.is_driven.any():
            return "engine 'reduced' integrates one free coordinate, but drives move this mechanism; choose engine 'multibody'"
        if position_solver.mobility != 1:
            return (
                f"engine 'reduced' integrates one degree of freedom; this mechanism has mobility {position_solver.mobility}; "
                "choose engine 'multibody'"
            )
        return ""

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        runner = ReducedRunner(self, scene, request)
        runner.compile_kernels()
        start_time = time.perf_counter()
        tolerance = self.tolerance or initial_tolerance(request.accuracy)
        if request.certify and self.tolerance is None:
            best = refine_tolerance(runner.run_certified, tolerance, request.accuracy, MAX_REDUCED_STAGNANT_RUNS)
        else:
            best = runner.run_certified(tolerance) if request.certify else runner.run_once(tolerance)
        return runner.make_trajectory(best, time.perf_counter() - start_time - runner.setup_time)


@dataclass(frozen=True)
class ReducedResult:
    """One run at a tolerance, and how it ended."""

    solution: ReducedSolution
    reduced_run: ReducedRun
    tolerance: float
    reported_states: StateHistory
    observables: Observables
    early_outcome: Outcome | None
    detail: str
    reading_errors: Mapping[str, float]
    error_estimate: float | None = None
    n_excluded: int = 0

    @property
    def n_reached(self) -> int:
        """Number of reported times that it reached."""
        return len(self.reported_states.times)


class ReducedRunner:
    """Runs of one scene at different tolerances, each width of table pieces with its own motion table."""

    def __init__(self, engine: ReducedEngine, scene: Scene, request: RunRequest) -> None:
        self.engine, self.scene, self.request = engine, scene, request
        poses, velocities = initial_state(scene)
        self.evaluator = ReadingEvaluator(scene, poses)
        coordinate_output = evaluate_output(scene.part.mechanism, scene.part.mechanism.coordinate, poses)
        self.initial_coordinate = float(coordinate_output.value), float(np.sum(coordinate_output.gradient * velocities))
        self._initial_poses = poses
        self.n_runs, self.counters = 0, np.zeros(4, dtype=np.int64)
        self._reduced_runs: dict[float, ReducedRun] = {}

    def compile_kernels(self) -> None:
        """Compile or load the kernels, once in a process, so that no measured time includes it."""
        kernel: Any = integrate_reduced
        if not kernel.signatures:
            warn_before_compiling("integrate_reduced", 30)
            motion_table = MotionTable(self.scene, self.initial_coordinate[0], self._initial_poses)
            if motion_table.is_started and motion_table.extend(0) and motion_table.extend(1):
                end_time = np.array([1e-9 * self.evaluator.time_scale])
                reduced_run = ReducedRun(motion_table, self.evaluator, self.initial_coordinate, end_time, self.engine.max_steps)
                reduced_run.state_history(reduced_run.integrate(1.0))

    @property
    def setup_time(self) -> float:
        """Wall time spent on the motion tables, s."""
        return sum(reduced_run.motion_table.setup_time for reduced_run in self._reduced_runs.values())

    def get_reduced_run(self, width_factor: float) -> ReducedRun:
        """Return the run along the table with this factor on the width of its first pieces."""
        if width_factor not in self._reduced_runs:
            motion_table = MotionTable(self.scene, self.initial_coordinate[0], self._initial_poses, width_factor)
            if not motion_table.is_started:
                raise MechanismError(f"engine 'reduced' cannot start: {motion_table.end_message(1)[1]}; choose engine 'multibody'")
            self._reduced_runs[width_factor] = ReducedRun(
                motion_table, self.evaluator, self.initial_coordinate, self.request.times, self.engine.max_steps
            )
        return self._reduced_runs[width_factor]

    def run_certified(self, tolerance: float) -> ReducedResult:
        """Return the better of two runs, with their difference as its error estimate."""
        # Where the largest step and not the tolerance limits the steps, twice as long steps make the runs differ.
        worse = self.run_once(COMPARISON_TOLERANCE_RATIO * tolerance, 2 * REDUCED_MAX_STEP_RATIO, COMPARISON_WIDTH_RATIO)
        better = self.run_once(tolerance)
        n_shared = min(len(worse.reported_states.times), len(better.reported_states.times))
        event_time_error, is_near_event = compare_event_logs(better.solution.events, worse.solution.events, better.reported_states.times[:n_shared],
                              self.request.accuracy * self.evaluator.time_scale)  # fmt: skip
        better_observables, worse_observables = better.observables, worse.observables
        if is_near_event.any() or n_shared < max(len(worse.reported_states.times), len(better.reported_states.times)):
            indices = np.flatnonzero(~is_near_event)
            better_observables, worse_observables = (
                self.evaluator.evaluate(result.reported_states.first(n_shared).at(indices)) for result in (better, worse)
            )
        errors = self.evaluator.compare_observables(better_observables, worse_observables)
        estimate = self.evaluator.to_relative_error(errors)
        if better.reduced_run.has_contacts:
            errors["event times"] = event_time_error
            estimate = max(estimate, event_time_error / self.evaluator.time_scale)
        return replace(better, reading_errors=errors, error_estimate=estimate, n_excluded=int(is_near_event.sum()))

    def run_once(self, tolerance: float, max_step_ratio: float = REDUCED_MAX_STEP_RATIO, width_factor: float = 1.0) -> ReducedResult:
        """Return one run with steps up to max_step_ratio step scales of the scene."""
        self.n_runs += 1
        reduced_run = self.get_reduced_run(width_factor)
        solution = reduced_run.integrate(tolerance, max_step_ratio)
        reported_states = reduced_run.state_history(solution)
        time_text = f"t = {solution.end_time:.9g} s"
        early_outcome, detail = None, ""
        if solution.status == PATH_ENDED:
            is_at_limit, message = reduced_run.motion_table.end_message(solution.side)
            early_outcome = Outcome.LEFT_RANGE if is_at_limit else Outcome.DEAD_CENTRE
            detail = f"{message}, at {time_text}"
        elif solution.status == BECAME_STIFF:
            early_outcome, detail = Outcome.STIFF, f"at {time_text}"
        elif solution.status == RUN_STALLED:
            early_outcome, detail = Outcome.STALLED, f"at {time_text}"
        elif solution.status != RUN_COMPLETED:
            early_outcome, detail = Outcome.STEP_LIMIT, f"max_steps = {self.engine.max_steps} reached at {time_text}"
        return ReducedResult(
            solution, reduced_run, tolerance, reported_states, self.evaluator.evaluate(reported_states), early_outcome, detail, {}
        )

    def make_trajectory(self, best: ReducedResult, wall_time: float) -> Trajectory:
        """Return the trajectory of the best run."""
        settings = {**asdict(self.engine), "asked_accuracy": self.request.accuracy, "certified": best.error_estimate is not None}
        return self.evaluator.make_trajectory(
            RunResult(
                reported_states=best.reported_states,
                monitor_states=partial(self._make_monitor_states, best),
                observables=best.observables,
                outcome=classify_outcome(best, self.request.accuracy),
                detail=best.detail,
                error_estimate=best.error_estimate,
                reading_errors=dict(best.reading_errors),
                contact_modes=best.reduced_run.contact_modes(best.solution, best.reported_states.poses),
                reported_indices=slice(None),
                contact_events=best.solution.events,
                n_excluded=best.n_excluded,
            ),
            cost=self._make_cost(best, wall_time),
            settings=settings,
        )

    def _make_monitor_states(self, best: ReducedResult) -> tuple[StateHistory, DenseOutput | None]:
        """Return states close enough to each other that no singular configuration is missed, and the dense output between them."""
        end = best.reported_states.times[-1:]
        breakpoints = np.unique(np.concatenate([function.breakpoints for function in best.reduced_run.motion_table.time_functions]))
        monitor_times = make_time_grid(end, breakpoints, np.inf, TURNING_POINT_SEARCH_INTERVAL * self.evaluator.time_scale).monitor_times
        while True:
            reduced_run = ReducedRun(
                best.reduced_run.motion_table, self.evaluator, self.initial_coordinate, monitor_times, self.engine.max_steps
            )
            solution = reduced_run.integrate(best.tolerance)
            displacements = np.abs(np.diff(solution.states[:, 0])) / best.reduced_run.motion_table.arrays.coordinate_scale
            if not len(displacements) or np.max(displacements) < MAX_MONITOR_TRAVEL or len(monitor_times) > MAX_MONITOR_TIMES:
                break
            n_intervals = np.ceil(displacements / TURNING_POINT_SEARCH_INTERVAL).astype(int).clip(1)
            segments = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(monitor_times, monitor_times[1:], n_intervals, strict=False)]
            monitor_times = np.concatenate([monitor_times[:1], *segments])
        return reduced_run.state_history(solution), partial(reduced_run.integrate_from_row, solution.states, best.tolerance)

    def _make_cost(self, best: ReducedResult, wall_time: float) -> Cost:
        reduced_runs = self._reduced_runs.values()
        counters = sum((reduced_run.counts for reduced_run in reduced_runs), np.zeros(4, dtype=np.int64))
        steps, rejected, evaluations, moving_evaluations = (int(count) for count in counters)
        n_pieces = sum(reduced_run.motion_table.n_pieces for reduced_run in reduced_runs)
        law_counts = {"equations of motion": evaluations, "table pieces": n_pieces}
        reduced_forces = best.reduced_run.motion_table.forces
        for law, n_elements, count in (
            ("springs on readings", len(reduced_forces.one_sided_springs), evaluations),
            ("dashpots", len(reduced_forces.output_dampers), moving_evaluations),
            ("dry friction", int(np.sum(reduced_forces.contacts[:, 1] >= 0)), moving_evaluations),
        ):
            if n_elements:
                law_counts[law] = n_elements * count
        return Cost(
            engine=self.engine.name,
            reason=self.request.reason,
            step=best.solution.last_step,
            steps=steps,
            rejected=rejected,
            runs=self.n_runs,
            evaluations=law_counts,
            wall_time=wall_time,
            setup_time=self.setup_time,
            events=len(best.solution.events),
            model_size=count_model_size(self.scene),
            method="explicit (DOP853) along one coordinate",
        )
