"""Reduced engine: one coordinate along tables of the assembled mechanism, integrated by DOP853 in compiled code."""

from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, final

import numpy as np

from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.registry import EFFECT_TYPES, FORCE_LAWS
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.certificate import CertifiedRunner, check_engine_settings, describe_end
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.reduced.integration import integrate_reduced
from governor_mechanism.engines.reduced.refusals import find_refusal
from governor_mechanism.engines.reduced.run import ReducedRun, ReducedSolution, bodies_with_coordinate, make_start
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.integrators.time_grid import make_time_grid
from governor_mechanism.mechanics.dynamics.contacts import FRICTION_LAW_NAME, ContactMode
from governor_mechanism.mechanics.reduction.equation_of_motion import StateIndex
from governor_mechanism.mechanics.reduction.lowering import OutputForceColumn
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult, StateHistory
from governor_mechanism.observables.singular_configurations import DenseOutput
from governor_mechanism.types import FloatArray


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
    settings
        Numerical settings.
    """

    name: ClassVar[str] = "reduced"
    effects: ClassVar[frozenset[type[Effect]]] = EFFECT_TYPES - {Clearance}
    joints: ClassVar[frozenset[type[Joint]]] = JOINT_TYPES

    tolerance: float | None = None
    max_steps: int = 1_000_000
    settings: ReducedSettings = field(default_factory=ReducedSettings)

    def __post_init__(self) -> None:
        """Check the settings."""
        check_engine_settings("ReducedEngine", self.tolerance, self.max_steps)

    def _refuses(self, scene: Scene) -> str:
        return find_refusal(scene)

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        runner = ReducedRunner(self, scene, request)
        runner.compile_kernels()
        return runner.run(self.tolerance, self.settings.max_stagnant_runs, asdict(self))


@dataclass(frozen=True, kw_only=True)
class ReducedResult(RunResult):
    """Result of one run with its solution along the coordinate."""

    solution: ReducedSolution
    reduced_run: ReducedRun


class ReducedRunner(CertifiedRunner[ReducedResult]):
    """Runs of one scene at different tolerances, each width of table pieces with its own motion table."""

    def __init__(self, engine: ReducedEngine, scene: Scene, request: RunRequest) -> None:
        self._initial_poses, velocities = initial_state(scene)
        super().__init__(scene, request, ReadingEvaluator(scene, self._initial_poses))
        self.engine = engine
        self._start = make_start(scene, self._initial_poses, velocities)
        self._reduced_runs: dict[float, ReducedRun] = {}

    def compile_kernels(self) -> None:
        """Compile or load the kernels, once in a process, so that no measured time includes it."""
        kernel: Any = integrate_reduced
        if not kernel.signatures:
            warn_before_compiling("integrate_reduced", 30)
            motion_table = self._make_table(1.0)
            if motion_table.is_started and motion_table.extend(0) and motion_table.extend(1):
                end_time = np.array([1e-9 * self.evaluator.time_scale])
                reduced_run = self._make_run(motion_table, end_time)
                reduced_run.state_history(reduced_run.integrate(1.0))

    @property
    def setup_time(self) -> float:
        """Wall time spent on the motion tables, s."""
        return sum(reduced_run.motion_table.setup_time for reduced_run in self._reduced_runs.values())

    def get_reduced_run(self, width_factor: float) -> ReducedRun:
        """Return the run along the table with this factor on the width of its first pieces."""
        if width_factor not in self._reduced_runs:
            motion_table = self._make_table(width_factor)
            if not motion_table.is_started:
                raise MechanismError(f"engine 'reduced' cannot start: {motion_table.end_message(1)[1]}; choose engine 'multibody'")
            self._reduced_runs[width_factor] = self._make_run(motion_table, self.request.times)
        return self._reduced_runs[width_factor]

    def _make_table(self, width_factor: float) -> MotionTable:
        poses = self._initial_poses[bodies_with_coordinate(self.scene)]
        return MotionTable(self.scene, float(self._start[StateIndex.COORDINATE]), poses, width_factor)

    def _make_run(self, motion_table: MotionTable, times: FloatArray) -> ReducedRun:
        start = self._start, self._initial_poses
        return ReducedRun(motion_table, self.evaluator, *start, times, self.engine.max_steps, self.engine.settings)

    def run_once(self, tolerance: float, is_comparison: bool = False) -> ReducedResult:
        """Return one run; a comparison run may take steps twice as long along a table with narrower pieces."""
        self.n_runs += 1
        reduced_run = self.get_reduced_run(self.engine.settings.comparison_width_ratio if is_comparison else 1.0)
        solution = reduced_run.integrate(tolerance, step_factor=2.0 if is_comparison else 1.0)
        reported_states = reduced_run.state_history(solution)
        time_text = f"t = {solution.end_time:.9g} s"
        outcome, detail = describe_end(solution.status, time_text, self.engine.max_steps)
        if solution.status == IntegrationStatus.TABLE_ENDED:
            is_at_limit, message = reduced_run.motion_table.end_message(solution.side)
            outcome = Outcome.LEFT_RANGE if is_at_limit else Outcome.DEAD_CENTRE
            detail = f"{message}, at {time_text}"
        return ReducedResult(
            reported_states=reported_states,
            monitor_states=partial(self._make_monitor_states, reduced_run, tolerance, reported_states.times[-1:]),
            observables=self.evaluator.evaluate(reported_states),
            outcome=outcome,
            detail=detail,
            reported_indices=slice(None),
            contact_events=solution.events,
            solution=solution,
            reduced_run=reduced_run,
        )

    def complete_result(self, best: ReducedResult) -> ReducedResult:
        """Add the contact modes at the reported times."""
        return replace(best, contact_modes=best.reduced_run.contact_modes(best.solution, best.reported_states.poses))

    def _make_monitor_states(
        self, table_run: ReducedRun, tolerance: float, end: FloatArray
    ) -> tuple[StateHistory, tuple[ContactMode, ...], DenseOutput | None]:
        """Return states close enough to each other that no event is missed, their modes, and the dense output between them."""
        settings = self.engine.settings
        breakpoints = np.unique(np.concatenate([function.breakpoints for function in table_run.motion_table.time_functions]))
        monitor_times = make_time_grid(end, breakpoints, np.inf, settings.monitor_interval_ratio * self.evaluator.time_scale).monitor_times
        while True:
            reduced_run = self._make_run(table_run.motion_table, monitor_times)
            solution = reduced_run.integrate(tolerance)
            displacements = np.abs(np.diff(solution.states[:, 0])) / table_run.motion_table.arrays.coordinate_scale
            if (
                not len(displacements)
                or np.max(displacements) < settings.max_monitor_travel
                or len(monitor_times) > settings.max_monitor_times
            ):
                break
            n_intervals = np.ceil(displacements / settings.monitor_interval_ratio).astype(int).clip(1)
            segments = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(monitor_times, monitor_times[1:], n_intervals, strict=False)]
            monitor_times = np.concatenate([monitor_times[:1], *segments])
        states = reduced_run.state_history(solution)
        modes = reduced_run.contact_modes(solution, states.poses)
        return states, modes, partial(reduced_run.integrate_from_row, solution, tolerance)

    def make_cost(self, best: ReducedResult, wall_time: float) -> Cost:
        """Return the cost over all runs."""
        reduced_runs = self._reduced_runs.values()
        counters = sum((reduced_run.counts for reduced_run in reduced_runs), np.zeros(4, dtype=np.int64))
        steps, rejected, evaluations, moving_evaluations = (int(count) for count in counters)
        n_pieces = sum(reduced_run.motion_table.n_pieces for reduced_run in reduced_runs)
        law_counts = {"equations of motion": evaluations, "table pieces": n_pieces}
        reduced_forces = best.reduced_run.motion_table.forces
        for law_index in reduced_forces.output_forces[:, OutputForceColumn.LAW].astype(int):
            law = FORCE_LAWS[law_index]
            law_counts[law.law_name] = law_counts.get(law.law_name, 0) + (moving_evaluations if law.dissipates else evaluations)
        if n_frictions := int(np.sum(reduced_forces.contacts[:, 1] >= 0)):
            law_counts[FRICTION_LAW_NAME] = n_frictions * moving_evaluations
        return Cost(
            engine=self.engine.name,
            reason=self.request.reason,
            step=best.solution.last_step,
            steps=steps,
            rejected=rejected,
            runs=self.n_runs,
            wall_time=wall_time,
            setup_time=self.setup_time,
            evaluations=law_counts,
            events=len(best.solution.events),
            model_size=self.evaluator.count_model_size(),
            method="explicit (DOP853) along one coordinate",
        )
