"""Runs of one scene with halved steps and enough solver iterations, within the budget, and how and when they end."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from governor_mechanism.engines.impulse.records import FixedStepProblem, FixedStepSolution
from governor_mechanism.engines.impulse.run import integrate_over_grid
from governor_mechanism.model.results.records import FLIGHT_DETAIL, Outcome
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.types import BoolArray, FloatArray

MIN_SIGNIFICANT_GAP_RATIO = 1e-11
"""Joint gap, relative to the length scale, below which it is rounding and no sign of unsolved joints."""


def has_open_joints(evaluator: ReadingEvaluator, solutions: Sequence[FixedStepSolution], times: FloatArray) -> bool:
    """Return whether joint gaps at the monitor times (n,) s do not shrink as the step is halved (second order divides them by four)."""
    return any(bool(_open_joint_mask(evaluator, pair, times)[-1]) for pair in pairwise(solutions))


def count_closed_times(evaluator: ReadingEvaluator, solutions: Sequence[FixedStepSolution], times: FloatArray) -> int:
    """Return the number of the monitor times (n,) s that the finest two runs reach with joint gaps that their steps explain."""
    count = min(len(times), *(len(solution.raw_poses) for solution in solutions))
    is_open = _open_joint_mask(evaluator, (solutions[-2:][0], solutions[-1]), times[:count])
    return int(np.argmax(is_open)) if is_open.any() else count


def _open_joint_mask(evaluator: ReadingEvaluator, pair: tuple[FixedStepSolution, FixedStepSolution], times: FloatArray) -> BoolArray:
    """Return up to which monitor times (n,) s the largest joint gap so far is larger than the steps of two runs explain."""
    min_gap = MIN_SIGNIFICANT_GAP_RATIO * evaluator.mechanism.length_scale
    gaps = [evaluator.evaluate_joint_gap(solution.raw_poses[: len(times)], times) for solution in pair]
    coarser, finer = np.maximum.accumulate(gaps, axis=1)
    is_open: BoolArray = finer > np.maximum(0.5 * coarser, min_gap)
    return is_open


MAX_OPEN_JOINT_HALVINGS = 5
"""Largest number of halvings of the first step because of open joints."""

ITERATION_GROWTH_FACTOR = 4
"""Factor by which the solver iterations grow when a result is doubtful."""

MAX_EXIT_DISAGREEMENT = 4
"""Number of monitor times within which runs with different steps must leave the limits for the exit to be accepted."""

MAX_TORN_GAP_RATIO = 0.1
"""Joint gap, relative to the length scale, beyond which a body far away has been torn off; a flight keeps the joints closed."""

# Steps of a quarter of the time scale follow a flight to a few hundredths. An instability grows by another
# factor in each run.
MAX_FLIGHT_DIFFERENCE_RATIO = 0.2
"""Largest difference of the places of a body that flies away, between runs with different steps and relative to its distance."""


IMPULSE_FLIGHT_DETAIL = f"{FLIGHT_DETAIL}, farther than engine impulse follows it; choose engine multibody, which follows it farther"
"""Cause of the end of a run of this engine in which a body goes beyond `max_distance_ratio`."""


class RangeExit(NamedTuple):
    """First monitor time outside the limits, with a body too far away or a shaft that turns back, and the sentence that describes it."""

    time_index: int
    message: str
    outcome: Outcome = Outcome.LEFT_RANGE
    time: float = math.inf


@dataclass(frozen=True)
class Termination:
    """Number of monitor times that runs keep; how and why they end if they end early, and whether because a body flies away.

    `exit_time` (s) is that of an exit from the limits between two monitor times, if steps show it, else infinity, and `exit_time_error`
    (s) its error, infinite if not all runs show the exit.
    """

    n_times: int
    outcome: Outcome | None = None
    detail: str = ""
    is_flight: bool = False
    exit_time: float = math.inf
    exit_time_error: float = 0.0


class LevelRuns:
    """Runs by level, each with half the step of the one before, all with the same solver iterations.

    `is_complete` states whether the grid reaches the last reported time; `steps`, `n_runs` and `evaluation_counts` count all runs.
    `is_limited` states whether the budget did not allow further runs.
    """

    def __init__(self, problem: FixedStepProblem, is_complete: bool) -> None:
        self._problem, self._is_complete, self._budget = problem, is_complete, problem.budget
        self._settings, self._evaluator, self._times = problem.settings, problem.evaluator, problem.grid.monitor_times
        self.iterations, self.solutions = problem.settings.iterations, dict[int, FixedStepSolution]()
        self.n_runs, self.steps, self.evaluation_counts = 0, 0, Counter[str]()
        self._works, self._works_iterations, self.is_limited = dict[int, float](), self.iterations, False

    def levels_from(self, level: int) -> range:
        """Return the levels of the runs that make one result, of which the coarsest is given."""
        return range(level, level + self._settings.levels)

    def integrate(self, level: int) -> Termination:
        """Run from a level on, with more iterations while joints stay open or the runs leave the limits at different times."""
        while True:
            self._run_missing(level)
            runs = [self.solutions[one] for one in self.levels_from(level)]
            n_times = min([len(self._times), *(len(run.raw_poses) for run in runs if run.reached_limit)])
            exits = [self._find_first_exit(run, n_times) for run in runs]
            is_open = self._has_open_joints(runs, n_times, exits)
            # Shorter steps, rather than more iterations, resolve many events in a step: the step is halved first.
            has_chatter = any(run.has_chatter for run in runs) and level < MAX_OPEN_JOINT_HALVINGS
            if has_chatter or not (is_open or _exits_disagree(exits)) or not self.raise_iterations(level):
                break
        if is_open:
            return self._end_with_open_joints(runs, n_times)
        first_exit = min((range_exit for range_exit in exits if range_exit is not None), key=lambda one: one[:2], default=None)
        if first_exit is not None:
            exit_time, time_error = _extrapolate_exit_time([math.inf if one is None else one.time for one in exits])
            end_time = exit_time if exit_time < math.inf else float(self._times[first_exit.time_index])
            detail = f"{first_exit.message}, at t = {end_time:.9g} s"
            is_flight = first_exit.message == IMPULSE_FLIGHT_DETAIL
            return Termination(first_exit.time_index, first_exit.outcome, detail, is_flight, exit_time, time_error)
        if n_times < len(self._times) or not self._is_complete:
            detail = f"max_steps = {self._budget.limit}, for all runs together, is reached at t = {self._times[n_times - 1]:.6g} s"
            return Termination(n_times, Outcome.STEP_LIMIT, detail)
        return Termination(n_times)

    def _find_first_exit(self, run: FixedStepSolution, n_times: int) -> RangeExit | None:
        """Return where a run leaves the limits or a shaft turns back, or where a body flies away if that is earlier."""
        poses, velocities = run.raw_poses[:n_times], run.states.velocities[:n_times]
        n_near, exits = self._count_near_times(poses), list[RangeExit]()
        if (limit_exit := self._evaluator.find_first_out_of_range(poses)) is not None:
            exits.append(RangeExit(*limit_exit))
        if (stall := self._evaluator.find_first_stall(poses, velocities)) is not None:
            exits.append(RangeExit(*stall, Outcome.SHAFT_STALLED))
        if run.first_exit is not None and run.first_exit.time_index < n_times:
            exits.append(RangeExit(run.first_exit.time_index, run.first_exit.message, Outcome.LEFT_RANGE, run.first_exit.time))
        if n_near < len(poses):
            exits.append(RangeExit(n_near, IMPULSE_FLIGHT_DETAIL))
        return min(exits, key=lambda one: (one.time_index, one.time), default=None)

    def _count_near_times(self, poses: FloatArray) -> int:
        """Return the number of monitor times before a body is too far away."""
        is_far = np.max(np.abs(poses[..., :2]), axis=(1, 2)) > self._settings.max_distance_ratio * self._evaluator.mechanism.length_scale
        return int(np.argmax(is_far)) if is_far.any() else len(poses)

    def _run_missing(self, level: int) -> None:
        """Run the levels that have no solution; a run ends where a coarser one has spent its share of the budget."""
        levels = self.levels_from(level)
        missing = [one for one in levels if one not in self.solutions]
        for index, one in enumerate(missing):
            work_before = self._budget.spent
            known = [self.solutions[other] for other in levels if other in self.solutions]
            n_times = min([len(self._times), *(len(solution.raw_poses) for solution in known if solution.reached_limit)])
            self._budget.begin_run([2.0 ** (later - one) for later in missing[index + 1 :]])
            solution = self.solutions[one] = integrate_over_grid(self._problem, one, self.iterations, n_times)
            if self._works_iterations != self.iterations:
                self._works, self._works_iterations = {}, self.iterations
            self._works[one] = self._budget.spent - work_before
            self.evaluation_counts.update(solution.evaluation_counts)
            self.steps, self.n_runs = self.steps + solution.n_steps, self.n_runs + 1

    def fits_budget(self, level: int) -> bool:
        """Return whether the runs from a level on are not expected to exceed the budget."""
        missing = [one for one in self.levels_from(level) if one not in self.solutions]
        return self._is_affordable(missing, self.iterations)

    def raise_iterations(self, level: int = 0) -> bool:
        """Raise the solver iterations and discard the runs; return False at the maximum, or if the budget does not suffice."""
        iterations = min(ITERATION_GROWTH_FACTOR * self.iterations, self._settings.max_iterations)
        if iterations == self.iterations or not self._is_affordable(self.levels_from(level), iterations):
            return False
        self.iterations = iterations
        self.solutions.clear()
        return True

    def _is_affordable(self, levels: Sequence[int], iterations: int) -> bool:
        """Return whether runs are expected to fit into the budget: the steps double from level to level, events and intervals do not."""
        coarse, fine = min(self._works), max(self._works)
        slope = max(self._works[fine] - self._works[coarse], 0.0) / (2.0**fine - 2.0**coarse) if fine > coarse else 0.0
        constant = self._works[fine] - slope * 2.0**fine
        ratio = self._budget.steps_per_step(iterations) / self._budget.steps_per_step(self._works_iterations)
        is_affordable = ratio * sum(constant + slope * 2.0**level for level in levels) <= self._budget.remaining
        self.is_limited |= not is_affordable
        return is_affordable

    def restore_iterations(self) -> None:
        """Return to the first number of iterations, and discard the runs with another one."""
        if self.iterations > self._settings.iterations:
            self.iterations = self._settings.iterations
            self.solutions.clear()

    def _has_open_joints(self, runs: list[FixedStepSolution], n_times: int, exits: list[RangeExit | None]) -> bool:
        """Return whether bodies diverged or joints opened up to the first monitor time outside the limits, which torn joints leave too."""
        count = min([n_times, *(range_exit[0] + 1 for range_exit in exits if range_exit is not None)])
        if any(len(run.raw_poses) < count for run in runs) or (any(exits) and self._have_diverged(runs, count)):
            return True
        return not self._settings.plain and has_open_joints(self._evaluator, runs, self._times[:count])

    def _have_diverged(self, runs: list[FixedStepSolution], count: int) -> bool:
        """Return whether a joint is torn at the first monitor times of a run, or steps too long for the forces alone throw a body away."""
        gaps = [self._evaluator.evaluate_joint_gap(run.raw_poses[:count], self._times[:count]) for run in runs]
        length_scale = self._evaluator.mechanism.length_scale
        positions = np.array([run.raw_poses[count - 1, :, :2] for run in runs])
        distance = float(np.max(np.abs(positions)))
        difference = float(np.max(np.ptp(positions, axis=0)))
        is_flight = distance > self._settings.max_distance_ratio * length_scale
        return float(np.max(gaps)) > MAX_TORN_GAP_RATIO * length_scale or (
            is_flight and difference > MAX_FLIGHT_DIFFERENCE_RATIO * distance
        )

    def _end_with_open_joints(self, runs: list[FixedStepSolution], n_times: int) -> Termination:
        n_closed = count_closed_times(self._evaluator, runs, self._times[:n_times])
        n_closed = min([n_closed, *(self._count_near_times(run.raw_poses) for run in runs)])
        detail = f"{self.iterations} solver iterations did not close the joints"
        detail += f" at about t = {self._times[min(n_closed, len(self._times) - 1)]:.6g} s"
        if self.iterations < self._settings.max_iterations:
            detail += f", and max_steps = {self._budget.limit}, for all runs together, allows no more of them"
        return Termination(n_closed, Outcome.JOINT_OPENED, detail)


def _extrapolate_exit_time(times: Sequence[float]) -> tuple[float, float]:
    """Return the time (s) of an exit, extrapolated from those of runs with halved steps, and its error; infinite for a run without it."""
    known = [time for time in times if time < math.inf]
    if len(known) < len(times) or len(times) < 2:
        return (known[-1] if known else math.inf), 0.0 if len(known) == len(times) else math.inf
    return times[-1] + (times[-1] - times[-2]) / 3, abs(times[-1] - times[-2])


def _exits_disagree(exits: list[RangeExit | None]) -> bool:
    """Return whether runs leave the limits at different monitor times, or only some of them do."""
    exit_indices = [-MAX_EXIT_DISAGREEMENT if range_exit is None else range_exit[0] for range_exit in exits]
    return max(exit_indices) - min(exit_indices) >= MAX_EXIT_DISAGREEMENT
