"""Richardson refinement of fixed-step runs: step halving, extrapolation, error estimate, and control of the solver iterations."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.certificate import classify_accuracy
from governor_mechanism.engines.impulse.event_extrapolation import ExtrapolatedEvents, extrapolate_events
from governor_mechanism.engines.impulse.pymunk.model import PymunkModel
from governor_mechanism.engines.impulse.run import FixedStepSolution, integrate_over_grid
from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.engines.initial_state import part_initial_state
from governor_mechanism.integrators.time_grid import TimeGrid, make_time_grid
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.mechanics.dynamics.projection import StateProjector
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.model_size import count_model_size
from governor_mechanism.observables.run_result import Observables, RunResult
from governor_mechanism.observables.state_history import StateHistory
from governor_mechanism.observables.work import integrate_work
from governor_mechanism.types import FloatArray, IntArray

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

    @property
    def has_open_joints(self) -> bool:
        """Return whether the run ended because joints opened."""
        return self.outcome is Outcome.JOINT_OPENED


@dataclass(frozen=True)
class RefinementResult:
    """Best states so far, with the error of each output and the largest relative error if three runs certify them.

    `n_excluded` counts the samples too close to an event to be compared.
    """

    state: StateHistory
    report: Observables
    errors: dict[str, float]
    error_estimate: float | None
    level: int
    termination: Termination
    extrapolated_events: ExtrapolatedEvents = field(default_factory=ExtrapolatedEvents)
    n_excluded: int = 0


class RichardsonRefinement:
    """Refinement of one scene to its accuracy: runs on one grid, each level with half the step of the one before."""

    def __init__(self, settings: ImpulseSettings, scene: Scene, request: RunRequest) -> None:
        self.settings, self.scene, self.request = settings, scene, request
        self.start = part_initial_state(scene)
        self.evaluator = ReadingEvaluator(scene, self.start[0])
        self._projector = StateProjector(scene)
        self.time_inputs = TimeInputs(scene)
        self.has_contacts, self.has_output_effects = has_contacts(scene), bool(scene.output_effects)
        time_scale = self.evaluator.time_scale
        step, max_step = settings.step, math.inf  # a given step is used as it is
        if step is None:
            max_step = settings.monitor_interval * time_scale
            step = min(time_scale * (request.accuracy / ERROR_AT_UNIT_STEP) ** (1 / 3), max_step)
        times = request.times
        if math.isfinite(max_step):  # no run within max_steps gets further, so the grid needs no monitor times there
            times = times[times <= max_step * (settings.max_steps >> (settings.levels - 1))]
        breakpoints = self.time_inputs.breakpoints
        self.grid = make_time_grid(times, breakpoints, step, max_step)
        if settings.step is None and not self._is_within_max_steps(self.grid):
            # A first step that is too short must not shorten the run: begin with the largest step.
            self.grid = make_time_grid(times, breakpoints, max_step, max_step)
        self.grid_termination = self._truncate_grid(has_all_times=len(times) == len(request.times))
        self.iterations = settings.iterations
        self.solutions: dict[int, FixedStepSolution] = {}
        self.steps, self.runs, self.evaluation_counts = 0, 0, Counter[str]()

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
            if level > self.settings.max_step_halvings or not self._is_within_max_steps(self.grid, level):
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
        best, level = self.extrapolate_at_level(0), 0
        while best.termination.has_open_joints and level < MAX_OPEN_JOINT_HALVINGS and self._is_within_max_steps(self.grid, level + 1):
            level += 1
            self.iterations = self.settings.iterations
            self.solutions.clear()
            best = self.extrapolate_at_level(level)
        return best

    def _is_accurate(self, result: RefinementResult) -> bool:
        """Return whether a result needs no further refinement: accurate, not certifiable, or with open joints."""
        return result.termination.has_open_joints or result.error_estimate is None or result.error_estimate <= self.request.accuracy

    @np.errstate(all="ignore")
    def extrapolate_at_level(self, level: int) -> RefinementResult:
        """Return the extrapolated result of runs whose coarsest has its steps halved `level` times."""
        levels = range(level, level + self.settings.levels)
        termination = self._integrate_levels(levels)
        reported = self.grid.truncate(termination.n_monitor_times).reported_indices
        extrapolated_events = self._extrapolate_events(levels, termination.n_monitor_times)
        states = self._extrapolate_states(levels, termination.n_monitor_times, extrapolated_events, reported)
        is_certified = self.settings.levels == 3 and (self.request.certify or self.settings.step is None)
        if not is_certified:
            extrapolated = states[0] if len(states) == 1 else _extrapolate(states[0], states[1], 8)
            return RefinementResult(extrapolated, self.evaluator.evaluate(extrapolated), {}, None, level, termination, extrapolated_events)
        report = self.evaluator.evaluate(states[1])
        if not self.has_contacts:
            errors = self.evaluator.compare_observables(report, self.evaluator.evaluate(states[0]))
            return RefinementResult(states[1], report, errors, self.evaluator.to_relative_error(errors), level, termination)
        is_near_event = extrapolated_events.are_near_events(states[1].times, self.request.accuracy * self.evaluator.time_scale)
        coarse_report, fine_report = (self.evaluator.evaluate(state.at(np.flatnonzero(~is_near_event))) for state in states)
        errors = self.evaluator.compare_observables(fine_report, coarse_report)
        time_error = max(extrapolated_events.time_error, extrapolated_events.wrong_side_error(states[1].times[~is_near_event]))
        error_estimate = max(self.evaluator.to_relative_error(errors), time_error / self.evaluator.time_scale)
        errors["event times"] = time_error
        return RefinementResult(
            states[1], report, errors, error_estimate, level, termination, extrapolated_events, int(is_near_event.sum())
        )

    def make_trajectory(self, result: RefinementResult, wall_time: float) -> Trajectory:
        """Return the trajectory of a result."""
        levels = range(result.level, result.level + self.settings.levels)
        n_monitor_times = result.termination.n_monitor_times
        monitor_states = self._extrapolate_states(levels, n_monitor_times, result.extrapolated_events)[-1]
        state, report = result.state, result.report
        contact_modes = self.solutions[levels[-1]].contact_modes[:n_monitor_times]
        uncounted_work = self.evaluator.integrate_missing_work(monitor_states)
        if contact_modes and uncounted_work is not None:
            uncounted_work = -integrate_work(self.scene, monitor_states, contact_modes)
        if uncounted_work is not None or self.has_output_effects:
            work = monitor_states.work + monitor_states.dissipated_energy
            monitor_states = replace(monitor_states, work=work if uncounted_work is None else work + uncounted_work)
            reported = self.grid.truncate(n_monitor_times).reported_indices
            state = replace(state, work=monitor_states.work[reported])
            report = self.evaluator.evaluate(state)
        is_certified = result.error_estimate is not None
        return self.evaluator.make_trajectory(
            RunResult(
                reported_states=state,
                monitor_states=monitor_states,
                observables=report,
                outcome=result.termination.outcome or classify_accuracy(result.error_estimate, self.request.accuracy),
                detail=result.termination.detail,
                error_estimate=result.error_estimate,
                reading_errors=result.errors,
                contact_modes=contact_modes,
                reported_indices=self.grid.truncate(n_monitor_times).reported_indices,
                contact_events=result.extrapolated_events.events,
                n_excluded=result.n_excluded,
            ),
            cost=self._cost(result, wall_time),
            settings={**asdict(self.settings), "asked_accuracy": self.request.accuracy, "certified": is_certified},
        )

    def _cost(self, result: RefinementResult, wall_time: float) -> Cost:
        finest_counts = self.grid.min_steps << (result.level + self.settings.levels - 1)
        step = float(np.max(np.diff(self.grid.monitor_times) / finest_counts, initial=0.0))
        return Cost(
            engine="impulse",
            reason=self.request.reason,
            step=step,
            steps=self.steps,
            runs=self.runs,
            iterations=self.iterations,
            evaluations=dict(self.evaluation_counts),
            wall_time=wall_time,
            events=len(result.extrapolated_events.events),
            model_size=count_model_size(self.scene),
            method=EVENT_METHOD_NAME if self.has_contacts else "",
        )

    def _integrate_levels(self, levels: range) -> Termination:
        """Run every level, with more solver iterations while joints stay open or the runs leave the limits at different times."""
        while True:
            for level in levels:
                if level not in self.solutions:
                    self.solutions[level] = self._integrate_level(level)
            exits = [self.evaluator.find_first_out_of_range(self.solutions[level].poses) for level in levels]
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
        model = PymunkModel(self.scene, iterations=self.iterations, plain=self.settings.plain)
        solution = integrate_over_grid(
            self.scene,
            model,
            self.grid,
            level,
            self.time_inputs,
            self.start,
            self.settings,
            time_scale=self.evaluator.time_scale,
            is_within_limits=lambda poses: self.evaluator.find_first_out_of_range(poses) is None,
        )
        steps = (int(self.grid.min_steps[: len(solution.work) - 1].sum()) << level) + solution.n_split_steps
        self.steps += steps
        self.runs += 1
        for law, count in model.forces.evaluation_counts.items():
            self.evaluation_counts[law] += count * steps
        return solution

    def _has_open_joints(self, levels: range, exits: list[tuple[int, str] | None]) -> bool:
        """Return whether bodies diverged or joint gaps do not shrink as the step is halved (second order divides them by four).

        The check ends at the first monitor time outside the limits, inclusive: torn joints leave the limits too.
        """
        count = min([len(self.grid.monitor_times), *(limit_exit[0] + 1 for limit_exit in exits if limit_exit is not None)])
        if any(len(self.solutions[level].work) < count for level in levels):
            return True
        if self.settings.plain:
            return False
        gaps = [float(np.max(self._gaps(level, count))) for level in levels]
        min_gap = MIN_SIGNIFICANT_GAP_RATIO * self.evaluator.mechanism.length_scale
        return any(finer > max(0.5 * coarser, min_gap) for coarser, finer in pairwise(gaps))

    def _gaps(self, level: int, count: int) -> FloatArray:
        """Return the joint gaps (count,) m of a run."""
        return self.evaluator.evaluate_joint_gap(self.solutions[level].poses[:count], self.grid.monitor_times[:count])

    def _n_closed_monitor_times(self, levels: range) -> int:
        """Return the number of monitor times that the finest two runs reach with joint gaps that their steps explain."""
        count = min(len(self.solutions[level].work) for level in levels)
        gaps = [np.maximum.accumulate(self._gaps(level, count)) for level in levels[-2:]]
        is_open = gaps[-1] > np.maximum(0.5 * gaps[0], MIN_SIGNIFICANT_GAP_RATIO * self.evaluator.mechanism.length_scale)
        return int(np.argmax(is_open)) if is_open.any() else count

    def _is_within_max_steps(self, grid: TimeGrid, level: int = 0) -> bool:
        """Return whether the finest of the runs at a level stays within `max_steps`."""
        return int(grid.min_steps.sum()) << (level + self.settings.levels - 1) <= self.settings.max_steps

    def _truncate_grid(self, *, has_all_times: bool) -> Termination:
        """Truncate the grid to what `max_steps` allows the finest of the first runs."""
        max_steps = self.settings.max_steps >> (self.settings.levels - 1)
        n_monitor_times = int(np.searchsorted(np.cumsum(self.grid.min_steps), max_steps, side="right")) + 1
        if n_monitor_times >= len(self.grid.monitor_times) and has_all_times:
            return Termination(len(self.grid.monitor_times))
        self.grid = self.grid.truncate(n_monitor_times)
        detail = f"max_steps = {self.settings.max_steps} is reached at t = {self.grid.monitor_times[-1]:.6g} s"
        return Termination(len(self.grid.monitor_times), Outcome.STEP_LIMIT, detail)

    def _project_states(self, solution: FixedStepSolution, n_monitor_times: int, indices: IntArray | None = None) -> StateHistory:
        """Return the states of a run at its first monitor times, or at some of them, with compatible velocities."""
        selected = np.arange(n_monitor_times) if indices is None else indices
        times, poses, velocities = (self.grid.monitor_times[selected], solution.poses[selected], solution.velocities[selected])
        if not self.settings.plain and len(selected):
            # The mean of two half steps opens the joints slightly, and more where the step length changes.
            # With contacts the gap depends on the step, which differs where a step was split.
            poses, velocities = self._projector.project(times, poses, velocities, closes_joints=self.has_contacts)
        speeds = self.evaluator.evaluate_spindle_speeds(times, poses)
        poses, velocities = self.evaluator.with_shaft(poses, velocities, solution.spindle_angle[selected], speeds)
        work = solution.work[selected]
        return StateHistory(
            times=times,
            poses=poses,
            velocities=velocities,
            work=work,
            dissipated_energy=solution.dissipated_energy[selected],
            lags=np.zeros((len(times), 0)),
        )

    def _extrapolate_states(
        self, levels: range, n_monitor_times: int, extrapolated_events: ExtrapolatedEvents, indices: IntArray | None = None
    ) -> list[StateHistory]:
        """Return the states of a single run, or those extrapolated from each pair of neighbouring levels.

        Between the impact times of two runs there is nothing to extrapolate.
        """
        states = [self._project_states(self.solutions[level], n_monitor_times, indices) for level in levels]
        if len(states) == 1:
            return states
        between_impacts = extrapolated_events.are_between_impacts(states[-1].times)
        return [_extrapolate(coarse, fine, 4, between_impacts) for coarse, fine in pairwise(states)]

    def _extrapolate_events(self, levels: range, n_monitor_times: int) -> ExtrapolatedEvents:
        """Return the extrapolated events of the runs up to a monitor time."""
        if not (self.has_contacts and n_monitor_times):
            return ExtrapolatedEvents()
        end = float(self.grid.monitor_times[n_monitor_times - 1])
        return extrapolate_events([[event for event in self.solutions[level].events if event.time <= end] for level in levels], end)


def _is_improvement(finer: RefinementResult, best: RefinementResult) -> bool:
    """Return whether a finer result has closed joints and a smaller error estimate."""
    return (
        not finer.termination.has_open_joints
        and finer.error_estimate is not None
        and finer.error_estimate < (best.error_estimate or math.inf)
    )


def _exits_disagree(exits: list[tuple[int, str] | None]) -> bool:
    """Return whether runs leave the limits at different monitor times, or only some of them do."""
    exit_indices = [-MAX_EXIT_DISAGREEMENT if limit_exit is None else limit_exit[0] for limit_exit in exits]
    return max(exit_indices) - min(exit_indices) >= MAX_EXIT_DISAGREEMENT


def _extrapolate(
    coarse_state: StateHistory, fine_state: StateHistory, error_ratio: int, keep_fine: NDArray[np.bool_] | None = None
) -> StateHistory:
    """Remove the leading error by Richardson extrapolation; it falls by `error_ratio` per level. Samples in `keep_fine` stay."""

    def combine(coarse: FloatArray, fine: FloatArray) -> FloatArray:
        extrapolated: FloatArray = fine + (fine - coarse) / (error_ratio - 1)
        if keep_fine is not None:
            extrapolated[keep_fine] = fine[keep_fine]
        return extrapolated

    return StateHistory(
        times=fine_state.times,
        poses=combine(coarse_state.poses, fine_state.poses),
        velocities=combine(coarse_state.velocities, fine_state.velocities),
        work=combine(coarse_state.work, fine_state.work),
        dissipated_energy=combine(coarse_state.dissipated_energy, fine_state.dissipated_energy),
        lags=fine_state.lags,
    )
