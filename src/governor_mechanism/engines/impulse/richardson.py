"""Richardson refinement of fixed-step runs: step halving, extrapolation, error estimate, and control of the solver iterations."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, replace
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.base import Runner, RunRequest
from governor_mechanism.engines.impulse.event_extrapolation import ExtrapolatedEvents, are_in_intervals, extrapolate_events
from governor_mechanism.engines.impulse.records import FixedStepProblem, FixedStepSolution, ImpulseSettings
from governor_mechanism.engines.impulse.run import integrate_over_grid
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.engines.initial_state import part_initial_state
from governor_mechanism.integrators.time_grid import TimeGrid, make_time_grid
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome
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


Termination = tuple[int, Outcome | None, str]
"""Number of monitor times that a run keeps; how and why it ends if it ends early."""


class RichardsonRefinement(Runner):
    """Refinement of one scene to its accuracy: runs on one grid, each level with half the step of the one before."""

    def __init__(self, settings: ImpulseSettings, scene: Scene, request: RunRequest) -> None:
        start, time_inputs = part_initial_state(scene), TimeInputs(scene)
        super().__init__("impulse", asdict(settings), request, ReadingEvaluator(scene, start[0]))
        self.settings, self.iterations, self.has_contacts = settings, settings.iterations, has_contacts(scene)
        self.method = EVENT_METHOD_NAME if self.has_contacts else ""
        self.grid, self.grid_termination = self._make_grid(time_inputs.breakpoints)
        self.problem = FixedStepProblem(scene, settings, self.evaluator, self.grid, time_inputs, start)
        self.solutions: dict[int, FixedStepSolution] = {}
        self.steps, self.evaluation_counts = 0, Counter[str]()

    def _make_grid(self, breakpoints: FloatArray) -> tuple[TimeGrid, Termination]:
        """Return the grid for the first step, as far as `max_steps` allows the finest of the first runs."""
        settings, times, time_scale = self.settings, self.request.times, self.evaluator.time_scale
        step, max_step = settings.step, math.inf  # a given step is used as it is
        if step is None:
            # A step as long as a cycle of the spindle speed would not see it.
            speeds = [plane.given_speed for plane in self.evaluator.planes if plane.given_speed and plane.given_speed.speed_fluctuation]
            rates = [max(map(abs, speed.speeds)) * speed.cycles_per_turn for speed in speeds]
            max_step = min(settings.monitor_interval * time_scale, *(1 / rate for rate in rates if rate), math.inf)
            step = min(time_scale * (self.request.accuracy / ERROR_AT_UNIT_STEP) ** (1 / 3), max_step)
            # No run within max_steps gets further, so the grid needs no monitor times there.
            times = times[times <= max_step * self._max_coarse_steps()]
        grid = make_time_grid(times, breakpoints, step, max_step)
        if settings.step is None and grid.min_steps.sum() > self._max_coarse_steps():
            # A first step that is too short must not shorten the run: begin with the largest step.
            grid = make_time_grid(times, breakpoints, max_step, max_step)
        n_monitor_times = int(np.searchsorted(np.cumsum(grid.min_steps), self._max_coarse_steps(), side="right")) + 1
        if n_monitor_times >= len(grid.monitor_times) and len(times) == len(self.request.times):
            return grid, (len(grid.monitor_times), None, "")
        grid = grid.truncate(n_monitor_times)
        detail = f"max_steps = {settings.max_steps} is reached at t = {grid.monitor_times[-1]:.6g} s"
        return grid, (len(grid.monitor_times), Outcome.STEP_LIMIT, detail)

    def _max_coarse_steps(self, level: int = 0) -> int:
        """Return how many steps of the grid keep the finest of the runs at a level within `max_steps`."""
        return self.settings.max_steps >> (level + self.settings.levels - 1)

    def find_best(self) -> RunResult:
        """Return the result at the given step, or the best of those with shorter and shorter steps."""
        return self._refine_to_accuracy() if self.settings.step is None else self.extrapolate_at_level(0)

    def _refine_to_accuracy(self) -> RunResult:
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

    def _refine(self) -> tuple[RunResult, bool]:
        """Shorten the step until the accuracy is met; return the best result and whether progress has stagnated."""
        best, level = self._first_closed_result()
        iterations, stagnant_levels = self.iterations, 0
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

    def _first_closed_result(self) -> tuple[RunResult, int]:
        """Return the first result and its level; halve the step while joints open because it is too long for the speeds that occur."""
        best, level = self.extrapolate_at_level(0), 0
        while best.outcome is Outcome.JOINT_OPENED and level < MAX_OPEN_JOINT_HALVINGS and self._is_within_max_steps(level + 1):
            if self.iterations > self.settings.iterations:
                self.iterations = self.settings.iterations
                self.solutions.clear()
            level += 1
            best = self.extrapolate_at_level(level)
        return best, level

    def _is_accurate(self, result: RunResult) -> bool:
        """Return whether a result needs no further refinement: accurate, not certifiable, or with open joints."""
        return result.outcome is Outcome.JOINT_OPENED or result.error_estimate is None or result.error_estimate <= self.request.accuracy

    def _is_within_max_steps(self, level: int) -> bool:
        """Return whether the finest of the runs at a level stays within `max_steps`."""
        return bool(self.grid.min_steps.sum() <= self._max_coarse_steps(level))

    @np.errstate(all="ignore")
    def extrapolate_at_level(self, level: int) -> RunResult:
        """Return the extrapolated result of runs whose coarsest has its steps halved `level` times."""
        levels = range(level, level + self.settings.levels)
        count, outcome, detail = self._integrate_levels(levels)
        solutions = [self.solutions[one] for one in levels]
        reported_indices, events = self.grid.truncate(count).reported_indices, ExtrapolatedEvents()
        if self.has_contacts and count:
            end = float(self.grid.monitor_times[count - 1])
            events = extrapolate_events([[event for event in solution.events if event.time <= end] for solution in solutions], end)
        extrapolated = [solution.states.at(slice(count)) for solution in solutions]
        if len(extrapolated) > 1:  # between the impact times of two runs there is nothing to extrapolate
            between_impacts = are_in_intervals(extrapolated[-1].times, events.impact_intervals)
            extrapolated = [_extrapolate(coarse, fine, 4, between_impacts) for coarse, fine in pairwise(extrapolated)]
        reported = [states.at(reported_indices) for states in extrapolated]
        is_certified = self.settings.levels == 3 and (self.request.certify or self.settings.step is None)
        best_states = reported[-1] if is_certified or len(reported) == 1 else _extrapolate(reported[0], reported[1], 8)
        result = RunResult(
            reported_states=best_states,
            monitor_states=extrapolated[-1],
            observables=self.evaluator.evaluate(best_states),
            outcome=outcome,
            detail=detail,
            step=float(np.max(np.diff(self.grid.monitor_times) / (self.grid.min_steps << levels[-1]), initial=0.0)),
            contact_modes=solutions[-1].contact_modes[:count],
            reported_indices=reported_indices,
            contact_events=events.events,
        )
        return self._certify(result, reported[0], events) if is_certified else result

    def _certify(self, result: RunResult, coarse: StateHistory, events: ExtrapolatedEvents) -> RunResult:
        """Return a result with its errors, estimated by the difference from coarser extrapolated states."""
        times, tolerance = result.reported_states.times, self.request.accuracy * self.evaluator.time_scale
        is_near_event = are_in_intervals(times, [(event.time - tolerance, event.time + tolerance) for event in events.events])
        time_error = max(events.time_error, events.wrong_side_error(times[~is_near_event]))
        coarse_result = replace(result, reported_states=coarse, observables=self.evaluator.evaluate(coarse))
        return self.with_error_estimate(result, coarse_result, is_near_event, time_error)

    def complete_result(self, best: RunResult) -> RunResult:
        """Add the work that the runs do not integrate."""
        states = best.monitor_states
        if not isinstance(states, StateHistory):
            return best
        uncounted_work = self.evaluator.integrate_missing_work(states, best.contact_modes)
        if uncounted_work is None and not self.scene.output_effects:
            return best
        work = states.work + states.dissipated_energy
        states = replace(states, work=work if uncounted_work is None else work + uncounted_work)
        reported_states = replace(best.reported_states, work=states.work[best.reported_indices])
        return replace(best, monitor_states=states, reported_states=reported_states, observables=self.evaluator.evaluate(reported_states))

    def count_work(self) -> tuple[int, int, Mapping[str, int]]:
        """Return the steps, no rejected steps, and the evaluations by force law."""
        return self.steps, 0, dict(self.evaluation_counts)

    def _integrate_levels(self, levels: range) -> Termination:
        """Run every level, with more solver iterations while joints stay open or the runs leave the limits at different times."""
        while True:
            for level in [one for one in levels if one not in self.solutions]:
                solution = self.solutions[level] = integrate_over_grid(self.problem, level, self.iterations)
                self.evaluation_counts.update(solution.evaluation_counts)
                self.steps, self.n_runs = self.steps + solution.n_steps, self.n_runs + 1
            exits = [self.evaluator.find_first_out_of_range(self.solutions[level].raw_poses) for level in levels]
            has_open_joints = self._has_open_joints(levels, exits)
            # Shorter steps, rather than more iterations, resolve many events in a step: the step is halved first.
            has_chatter = any(self.solutions[level].has_chatter for level in levels) and levels.start < MAX_OPEN_JOINT_HALVINGS
            if has_chatter or not (has_open_joints or _exits_disagree(exits)) or not self._raise_iterations():
                break
        if has_open_joints:
            n_closed = self._n_closed_monitor_times(levels)
            when = f"at about t = {self.grid.monitor_times[min(n_closed, len(self.grid.monitor_times) - 1)]:.6g} s"
            detail = f"{self.iterations} solver iterations did not close the joints {when}"
            return n_closed, Outcome.JOINT_OPENED, detail
        first_exit = min((limit_exit for limit_exit in exits if limit_exit is not None), default=None)
        if first_exit is None:
            return self.grid_termination
        index, message = first_exit
        return index, Outcome.LEFT_RANGE, f"{message}, at about t = {self.grid.monitor_times[index]:.6g} s"

    def _raise_iterations(self) -> bool:
        """Discard the runs and raise the solver iterations; return False at the maximum."""
        if self.iterations >= self.settings.max_iterations:
            return False
        self.iterations = min(ITERATION_GROWTH_FACTOR * self.iterations, self.settings.max_iterations)
        self.solutions.clear()
        return True

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
        is_open = self._open_joint_mask((levels[-2:][0], levels[-1]), count)
        return int(np.argmax(is_open)) if is_open.any() else count

    def _open_joint_mask(self, levels: tuple[int, int], count: int) -> BoolArray:
        """Return up to which monitor times (count,) the largest joint gap so far is larger than the steps of two levels explain."""
        times, min_gap = self.grid.monitor_times[:count], MIN_SIGNIFICANT_GAP_RATIO * self.evaluator.mechanism.length_scale
        gaps = [self.evaluator.evaluate_joint_gap(self.solutions[level].raw_poses[:count], times) for level in levels]
        coarser, finer = np.maximum.accumulate(gaps, axis=1)
        is_open: BoolArray = finer > np.maximum(0.5 * coarser, min_gap)
        return is_open


def _is_improvement(finer: RunResult, best: RunResult) -> bool:
    """Return whether a finer result has closed joints and a smaller error estimate."""
    return finer.outcome is not Outcome.JOINT_OPENED and (finer.error_estimate or math.inf) < (best.error_estimate or math.inf)


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
