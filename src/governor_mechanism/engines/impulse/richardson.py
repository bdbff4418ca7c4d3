"""Richardson refinement of fixed-step runs: step halving, extrapolation, error estimate, and control of the solver iterations."""

import math
from collections import Counter
from dataclasses import asdict, dataclass, replace
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import classify_accuracy
from governor_mechanism.engines.impulse.event_extrapolation import ExtrapolatedEvents, extrapolate_events
from governor_mechanism.engines.impulse.records import FixedStepProblem, FixedStepSolution
from governor_mechanism.engines.impulse.run import integrate_over_grid
from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.engines.initial_state import part_initial_state
from governor_mechanism.integrators.time_grid import TimeGrid, make_time_grid
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult, StateHistory
from governor_mechanism.types import BoolArray, FloatArray

ERROR_AT_UNIT_STEP = 2e-4
"""Estimated relative error of a run with a step of one time scale, extrapolated as the cube of the step; sets the first step."""

MAX_OPEN_JOINT_HALVINGS = 5
"""Largest number of halvings of the first step because of open joints."""

MIN_SIGNIFICANT_GAP_RATIO = 1e-11
"""Joint gap, relative to the length scale, below which it is rounding and no sign of unsolved joints."""

ITERATION_GROWTH_FACTOR = 4
"""Factor by which the solver iterations grow when a result is doubtful."""

ESTIMATE_ROUNDING_FLOOR = 1e-11
"""Relative error estimate below which a lack of convergence is rounding."""

MAX_STAGNANT_LEVELS = 1
"""Largest number of successive halvings without progress in a scene with contacts."""

EVENT_METHOD_NAME = "second order, restarted at every event"
"""Name of the method for a scene with contacts."""

MAX_EXIT_DISAGREEMENT = 4
"""Number of monitor times within which runs with different steps must leave the limits for the exit to be accepted."""


@dataclass(frozen=True)
class Termination:
    """Number of monitor times that a run keeps, and the reason if it ends early."""

    n_monitor_times: int
    outcome: Outcome | None = None
    detail: str = ""


@dataclass(frozen=True, kw_only=True)
class RefinementResult(RunResult):
    """Best states of runs whose coarsest has its steps halved `level` times; with an error estimate if three runs certify them."""

    monitor_states: StateHistory
    level: int

    @property
    def has_open_joints(self) -> bool:
        """Return whether the runs ended because joints opened."""
        return self.outcome is Outcome.JOINT_OPENED


class RichardsonRefinement:
    """Refinement of one scene to its accuracy: runs on one grid, each level with half the step of the one before."""

    def __init__(self, settings: ImpulseSettings, scene: Scene, request: RunRequest) -> None:
        self.settings, self.scene, self.request = settings, scene, request
        start, self.time_inputs = part_initial_state(scene), TimeInputs(scene)
        self.evaluator = ReadingEvaluator(scene, start[0])
        self.has_contacts = has_contacts(scene)
        self.grid, self.grid_termination = self._make_grid()
        self.problem = FixedStepProblem(scene, settings, self.evaluator, self.grid, self.time_inputs, start)
        self.iterations = settings.iterations
        self.solutions: dict[int, FixedStepSolution] = {}
        self.steps, self.runs, self.evaluation_counts = 0, 0, Counter[str]()

    def _make_grid(self) -> tuple[TimeGrid, Termination]:
        """Return the grid for the first step, as far as `max_steps` allows the finest of the first runs."""
        settings, times, time_scale = self.settings, self.request.times, self.evaluator.time_scale
        step, max_step = settings.step, math.inf  # a given step is used as it is
        if step is None:
            max_step = settings.monitor_interval * time_scale
            step = min(time_scale * (self.request.accuracy / ERROR_AT_UNIT_STEP) ** (1 / 3), max_step)
            # No run within max_steps gets further, so the grid needs no monitor times there.
            times = times[times <= max_step * self._max_coarse_steps()]
        grid = make_time_grid(times, self.time_inputs.breakpoints, step, max_step)
        if settings.step is None and grid.min_steps.sum() > self._max_coarse_steps():
            # A first step that is too short must not shorten the run: begin with the largest step.
            grid = make_time_grid(times, self.time_inputs.breakpoints, max_step, max_step)
        n_monitor_times = int(np.searchsorted(np.cumsum(grid.min_steps), self._max_coarse_steps(), side="right")) + 1
        if n_monitor_times >= len(grid.monitor_times) and len(times) == len(self.request.times):
            return grid, Termination(len(grid.monitor_times))
        grid = grid.truncate(n_monitor_times)
        detail = f"max_steps = {settings.max_steps} is reached at t = {grid.monitor_times[-1]:.6g} s"
        return grid, Termination(len(grid.monitor_times), Outcome.STEP_LIMIT, detail)

    def _max_coarse_steps(self, level: int = 0) -> int:
        """Return how many steps of the grid keep the finest of the runs at a level within `max_steps`."""
        return self.settings.max_steps >> (level + self.settings.levels - 1)

    def refine_to_accuracy(self) -> RefinementResult:
        """Refine until the estimate meets the accuracy, or stops falling even with more solver iterations."""
        best = None
        while True:
            iterations = self.iterations
            refined, has_stagnated = self._refine()
            best = refined if best is None or _is_improvement(refined, best) else best
            if self._is_accurate(best):
                return best
            if self.iterations > iterations:
                continue  # the iterations were raised on the way: the longer steps were not solved well enough either
            # Near a singular configuration, unsolved joints show only in the estimate.
            if not has_stagnated or (best.error_estimate or 0.0) < ESTIMATE_ROUNDING_FLOOR or not self._raise_iterations():
                return best

    def _refine(self) -> tuple[RefinementResult, bool]:
        """Shorten the step until the accuracy is met; return the best result and whether progress has stagnated."""
        best = self._first_closed_result()
        level, iterations, stagnant_levels = best.level, self.iterations, 0
        while not self._is_accurate(best):
            level += min(max(1, math.ceil(math.log2(2 * (best.error_estimate or 1.0) / self.request.accuracy) / 3)), 4)
            if level > self.settings.max_step_halvings or not self._is_within_max_steps(level):
                return best, False
            finer = self.extrapolate_at_level(level)
            if not _is_improvement(finer, best):
                # Event errors do not fall monotonically with the step: allow MAX_STAGNANT_LEVELS halvings without progress.
                stagnant_levels += 1
                if stagnant_levels > MAX_STAGNANT_LEVELS * self.has_contacts:
                    return best, True
                continue
            best, stagnant_levels = finer, 0
            if self.iterations > iterations:
                return best, True
        return best, False

    def _first_closed_result(self) -> RefinementResult:
        """Return the first result; halve the step while joints open because it is too long for the speeds that occur."""
        best = self.extrapolate_at_level(0)
        while best.has_open_joints and best.level < MAX_OPEN_JOINT_HALVINGS and self._is_within_max_steps(best.level + 1):
            self.iterations = self.settings.iterations
            self.solutions.clear()
            best = self.extrapolate_at_level(best.level + 1)
        return best

    def _is_accurate(self, result: RefinementResult) -> bool:
        """Return whether a result needs no further refinement: accurate, not certifiable, or with open joints."""
        return result.has_open_joints or result.error_estimate is None or result.error_estimate <= self.request.accuracy

    def _is_within_max_steps(self, level: int) -> bool:
        """Return whether the finest of the runs at a level stays within `max_steps`."""
        return bool(self.grid.min_steps.sum() <= self._max_coarse_steps(level))

    @np.errstate(all="ignore")
    def extrapolate_at_level(self, level: int) -> RefinementResult:
        """Return the extrapolated result of runs whose coarsest has its steps halved `level` times."""
        levels = range(level, level + self.settings.levels)
        termination = self._integrate_levels(levels)
        count, solutions = termination.n_monitor_times, [self.solutions[one] for one in levels]
        reported_indices, events = self.grid.truncate(count).reported_indices, ExtrapolatedEvents()
        if self.has_contacts and count:
            end = float(self.grid.monitor_times[count - 1])
            events = extrapolate_events([[event for event in solution.events if event.time <= end] for solution in solutions], end)
        extrapolated = [solution.states.at(slice(count)) for solution in solutions]
        if len(extrapolated) > 1:  # between the impact times of two runs there is nothing to extrapolate
            between_impacts = events.are_between_impacts(extrapolated[-1].times)
            extrapolated = [_extrapolate(coarse, fine, 4, between_impacts) for coarse, fine in pairwise(extrapolated)]
        reported = [states.at(reported_indices) for states in extrapolated]
        is_certified = self.settings.levels == 3 and (self.request.certify or self.settings.step is None)
        best_states = reported[-1] if is_certified or len(reported) == 1 else _extrapolate(reported[0], reported[1], 8)
        result = RefinementResult(
            reported_states=best_states,
            monitor_states=extrapolated[-1],
            observables=self.evaluator.evaluate(best_states),
            outcome=termination.outcome,
            detail=termination.detail,
            contact_modes=solutions[-1].contact_modes[:count],
            reported_indices=reported_indices,
            contact_events=events.events,
            level=level,
        )
        return self._with_error_estimate(result, reported[0], events) if is_certified else result

    def _with_error_estimate(self, result: RefinementResult, coarse: StateHistory, events: ExtrapolatedEvents) -> RefinementResult:
        """Return a result with its errors, estimated by the difference to coarser extrapolated states."""
        fine, time_scale = result.reported_states, self.evaluator.time_scale
        is_near_event = events.are_near_events(fine.times, self.request.accuracy * time_scale)
        far = np.flatnonzero(~is_near_event)
        fine_report = self.evaluator.evaluate(fine.at(far)) if is_near_event.any() else result.observables
        errors = self.evaluator.compare_observables(fine_report, self.evaluator.evaluate(coarse.at(far)))
        error_estimate = self.evaluator.to_relative_error(errors)
        if self.has_contacts:
            errors["event times"] = max(events.time_error, events.wrong_side_error(fine.times[far]))
            error_estimate = max(error_estimate, errors["event times"] / time_scale)
        return replace(result, error_estimate=error_estimate, reading_errors=errors, n_excluded=int(is_near_event.sum()))

    def make_trajectory(self, result: RefinementResult, wall_time: float) -> Trajectory:
        """Return the trajectory of a result."""
        monitor_states = result.monitor_states
        uncounted_work = self.evaluator.integrate_missing_work(monitor_states, result.contact_modes)
        if uncounted_work is not None or self.scene.output_effects:
            work = monitor_states.work + monitor_states.dissipated_energy
            monitor_states = replace(monitor_states, work=work if uncounted_work is None else work + uncounted_work)
            reported_states = replace(result.reported_states, work=monitor_states.work[result.reported_indices])
            observables = self.evaluator.evaluate(reported_states)
            result = replace(result, monitor_states=monitor_states, reported_states=reported_states, observables=observables)
        is_certified = result.error_estimate is not None
        return self.evaluator.make_trajectory(
            replace(result, outcome=result.outcome or classify_accuracy(result.error_estimate, self.request.accuracy)),
            cost=self._make_cost(result, wall_time),
            settings={**asdict(self.settings), "asked_accuracy": self.request.accuracy, "certified": is_certified},
        )

    def _make_cost(self, result: RefinementResult, wall_time: float) -> Cost:
        """Return the cost over all runs."""
        finest_counts = self.grid.min_steps << (result.level + self.settings.levels - 1)
        return Cost(
            engine="impulse",
            reason=self.request.reason,
            step=float(np.max(np.diff(self.grid.monitor_times) / finest_counts, initial=0.0)),
            steps=self.steps,
            runs=self.runs,
            iterations=self.iterations,
            evaluations=dict(self.evaluation_counts),
            wall_time=wall_time,
            events=len(result.contact_events),
            model_size=self.evaluator.count_model_size(),
            method=EVENT_METHOD_NAME if self.has_contacts else "",
        )

    def _integrate_levels(self, levels: range) -> Termination:
        """Run every level, with more solver iterations while joints stay open or the runs leave the limits at different times."""
        while True:
            for level in levels:
                if level not in self.solutions:
                    self.solutions[level] = self._integrate_level(level)
            exits = [self.evaluator.find_first_out_of_range(self.solutions[level].raw_poses) for level in levels]
            has_open_joints = self._has_open_joints(levels, exits)
            if not (has_open_joints or _exits_disagree(exits)) or not self._raise_iterations():
                break
        if has_open_joints:
            n_closed = self._n_closed_monitor_times(levels)
            when = f"at about t = {self.grid.monitor_times[min(n_closed, len(self.grid.monitor_times) - 1)]:.6g} s"
            detail = f"{self.iterations} solver iterations did not close the joints {when}"
            return Termination(n_closed, Outcome.JOINT_OPENED, detail)
        first_exit = min((limit_exit for limit_exit in exits if limit_exit is not None), default=None)
        if first_exit is None:
            return self.grid_termination
        index, message = first_exit
        return Termination(index, Outcome.LEFT_RANGE, f"{message}, at about t = {self.grid.monitor_times[index]:.6g} s")

    def _raise_iterations(self) -> bool:
        """Discard the runs and raise the solver iterations; return False at the maximum."""
        if self.iterations >= self.settings.max_iterations:
            return False
        self.iterations = min(ITERATION_GROWTH_FACTOR * self.iterations, self.settings.max_iterations)
        self.solutions.clear()
        return True

    @np.errstate(all="ignore")  # diverging bodies give infinite values before the run is abandoned
    def _integrate_level(self, level: int) -> FixedStepSolution:
        """Run one level; its states get compatible velocities and the shaft of a free spindle."""
        solution, evaluation_counts = integrate_over_grid(self.problem, level, self.iterations)
        states = solution.states
        steps = (int(self.grid.min_steps[: len(states.times) - 1].sum()) << level) + solution.n_split_steps
        self.steps += steps
        self.runs += 1
        for law, count in evaluation_counts.items():
            self.evaluation_counts[law] += count * steps
        poses, velocities = states.poses, states.velocities
        if not self.settings.plain:
            # The mean of two half steps opens the joints slightly, and more where the step length changes.
            # With contacts the gap depends on the step, which differs where a step was split.
            poses, velocities = self.problem.projector.project(states.times, poses, velocities, closes_joints=self.has_contacts)
        poses, velocities = self.evaluator.with_shaft(states.times, poses, velocities, solution.spindle_angle)
        return replace(solution, states=replace(states, poses=poses, velocities=velocities))

    def _has_open_joints(self, levels: range, exits: list[tuple[int, str] | None]) -> bool:
        """Return whether bodies diverged or joint gaps do not shrink as the step is halved (second order divides them by four).

        The check ends at the first monitor time outside the limits, inclusive: torn joints leave the limits too.
        """
        count = min([len(self.grid.monitor_times), *(limit_exit[0] + 1 for limit_exit in exits if limit_exit is not None)])
        if any(len(self.solutions[level].raw_poses) < count for level in levels):
            return True
        return not self.settings.plain and any(bool(self._open_joint_mask(pair, count)[-1]) for pair in pairwise(levels))

    def _n_closed_monitor_times(self, levels: range) -> int:
        """Return the number of monitor times that the finest two runs reach with joint gaps that their steps explain."""
        count = min(len(self.solutions[level].raw_poses) for level in levels)
        coarser, finest = levels[-2] if len(levels) > 1 else levels[-1], levels[-1]
        is_open = self._open_joint_mask((coarser, finest), count)
        return int(np.argmax(is_open)) if is_open.any() else count

    def _open_joint_mask(self, levels: tuple[int, int], count: int) -> BoolArray:
        """Return up to which monitor times (count,) the largest joint gap so far is larger than the steps of two levels explain."""
        times, min_gap = self.grid.monitor_times[:count], MIN_SIGNIFICANT_GAP_RATIO * self.evaluator.mechanism.length_scale
        coarser, finer = (
            np.maximum.accumulate(self.evaluator.evaluate_joint_gap(self.solutions[level].raw_poses[:count], times)) for level in levels
        )
        is_open: BoolArray = finer > np.maximum(0.5 * coarser, min_gap)
        return is_open


def _is_improvement(finer: RefinementResult, best: RefinementResult) -> bool:
    """Return whether a finer result has closed joints and a smaller error estimate."""
    return not finer.has_open_joints and finer.error_estimate is not None and finer.error_estimate < (best.error_estimate or math.inf)


def _exits_disagree(exits: list[tuple[int, str] | None]) -> bool:
    """Return whether runs leave the limits at different monitor times, or only some of them do."""
    exit_indices = [-MAX_EXIT_DISAGREEMENT if limit_exit is None else limit_exit[0] for limit_exit in exits]
    return max(exit_indices) - min(exit_indices) >= MAX_EXIT_DISAGREEMENT


def _extrapolate(coarse: StateHistory, fine: StateHistory, error_ratio: int, keep_fine: BoolArray | None = None) -> StateHistory:
    """Remove the leading error by Richardson extrapolation; it falls by `error_ratio` per level. Samples in `keep_fine` stay."""
    extrapolated: dict[str, FloatArray] = {}
    for name in ("poses", "velocities", "work", "dissipated_energy"):
        fine_values = getattr(fine, name)
        extrapolated[name] = fine_values + (fine_values - getattr(coarse, name)) / (error_ratio - 1)
        if keep_fine is not None:
            extrapolated[name][keep_fine] = fine_values[keep_fine]
    return replace(fine, **extrapolated)
