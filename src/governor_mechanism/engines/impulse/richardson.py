"""Richardson refinement of fixed-step runs: step halving, extrapolation and error estimate."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import chain, pairwise

import numpy as np

from governor_mechanism.engines.base import Runner, RunRequest
from governor_mechanism.engines.certificate import USELESS_ERROR
from governor_mechanism.engines.exit_location import count_before, find_first_exit
from governor_mechanism.engines.impulse.level_runs import MAX_EXIT_DISAGREEMENT, MAX_OPEN_JOINT_HALVINGS, LevelRuns, Termination
from governor_mechanism.engines.impulse.records import FixedStepProblem, FixedStepSolution
from governor_mechanism.engines.impulse.settings import ImpulseSettings, WorkBudget, make_first_grid
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.engines.initial_state import part_initial_state
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, has_contacts
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import compute_inverse_dynamics
from governor_mechanism.mechanics.dynamics.inputs import has_kinks
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.interpolation import quintic_hermite
from governor_mechanism.observables.error_scales import EVENT_TIMES, JOINT_GAP
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult, StateHistory, modes_at
from governor_mechanism.types import BoolArray, FloatArray

MIN_EVENT_TIME_ERROR_RATIO = 0.05
"""Smallest error of an extrapolated time relative to the difference of the last two runs: a closer agreement can be chance."""

SAME_STEP_TOLERANCE, SAME_STEP_ERROR_RATIO = 1e-9, 0.01
"""Relative difference up to which runs have reached an event by the same step, and the error of such a step relative to its length."""


@dataclass(frozen=True)
class ExtrapolatedEvents:
    """Events at their extrapolated times, and the largest error of these times.

    `impact_intervals` (s) contain the time of each impact in all runs; `extrapolation_intervals` (s) lie between the time of each impact in
    the last run and its extrapolated time. `time_error` is in seconds; `is_matched` states whether all runs have the same events.
    """

    events: tuple[Event, ...] = ()
    impact_intervals: tuple[tuple[float, float], ...] = ()
    extrapolation_intervals: tuple[tuple[float, float], ...] = ()
    time_error: float = 0.0
    is_matched: bool = True

    def wrong_side_error(self, times: FloatArray) -> float:
        """Return the largest impact-time error (s) of the last run whose interval contains one of the times (n,) s."""
        # At such a time either the last run or the exact motion is past the impact and the other is
        # not, so its values are not comparable.
        return max((high - low for low, high in self.extrapolation_intervals if are_in_intervals(times, [(low, high)]).any()), default=0.0)


def extrapolate_events(
    event_logs: Sequence[Sequence[Event]],
    end_time: float,
    first_step: float,
    min_error_ratio: float = MIN_EVENT_TIME_ERROR_RATIO,
    settled_difference: float = math.inf,
) -> ExtrapolatedEvents:
    """Extrapolate each event of the last log from the nearest events of its kind in the other logs, up to `end_time` (s)."""
    # The error of a time is at least `min_error_ratio` of the difference of the last two runs. Where
    # that exceeds `settled_difference` (s), nothing is known of what follows. An event within the first
    # step (s) of all runs is reached by one step of the same length in each: their agreement says
    # nothing.
    finest = event_logs[-1]
    time_error = 0.0
    is_matched = len({len(log) for log in event_logs}) == 1
    events = []
    impact_intervals = []
    extrapolation_intervals = []
    for event in finest:
        known = [time for log in event_logs if (time := _nearest_event_time(event, log)) is not None]
        if len(known) < len(event_logs):
            time_error, is_matched = max(time_error, end_time - event.time), False
        extrapolated = [fine + (fine - coarse) / 3 for coarse, fine in pairwise(known)]
        best_time = extrapolated[-1] if extrapolated else event.time
        events.append(replace(event, time=best_time))
        if event.kind == EventKind.IMPACT:
            impact_intervals.append((min(known), max(known)))
            extrapolation_intervals.append((min(event.time, best_time), max(event.time, best_time)))
        if len(known) > 1 and event.time < first_step and max(known) - min(known) <= SAME_STEP_TOLERANCE * event.time:
            time_error = max(time_error, SAME_STEP_ERROR_RATIO * event.time)
        if len(known) > 1 and abs(known[-1] - known[-2]) > settled_difference:
            time_error = max(time_error, end_time - event.time)
        if len(extrapolated) > 1:
            time_error = max(time_error, abs(extrapolated[-1] - extrapolated[-2]), min_error_ratio * abs(known[-1] - known[-2]))
    for event in chain.from_iterable(log for log in event_logs if len(log) != len(finest)):
        time = _nearest_event_time(event, finest)
        time_error = max(time_error, end_time - event.time if time is None else abs(time - event.time))
    return ExtrapolatedEvents(tuple(events), tuple(impact_intervals), tuple(extrapolation_intervals), time_error, is_matched)


def _nearest_event_time(event: Event, others: Sequence[Event]) -> float | None:
    """Return the time (s) of the nearest event of the same kind and subject, or None."""
    times = [other.time for other in others if (other.kind, other.subject) == (event.kind, event.subject)]
    return min(times, key=lambda time: abs(time - event.time), default=None)


def are_in_intervals(times: FloatArray, intervals: Iterable[tuple[float, float]]) -> BoolArray:
    """Return a mask of the times (n,) s that lie in any of the intervals (s)."""
    is_inside = np.zeros(len(times), dtype=np.bool_)
    for low, high in intervals:
        is_inside |= (times >= low) & (times <= high)
    return is_inside


ESTIMATE_ROUNDING_FLOOR = 1e-11
"""Relative error estimate below which a lack of convergence is rounding."""

# The errors of a flight grow as it does, so that no work yields the accuracy of a motion that stays near the
# origin.
FLIGHT_ACCURACY = 1e-2
"""Estimate that ends the refinement of a motion in which a body flies away: small against the distance at its end."""

UNKNOWN_EXIT_ERROR = 1.0
"""Estimate of a motion of which only some runs leave their limits: nothing is known of its end."""

MAX_STAGNANT_LEVELS = 1
"""Largest number of successive halvings without progress in a scene with contacts."""

EVENT_METHOD_NAME = "second order, restarted at every event"
"""Name of the method for a scene with contacts."""

# Where the order of 3 holds, the error is a seventh of the difference. With long steps it falls less from one
# level to the next; the bound holds as far as it falls to 0.37.
ERROR_TO_DIFFERENCE_RATIO = 0.6
"""Bound of the error of extrapolated runs relative to the difference from those with twice their steps."""

CUSTOM_ERROR_TO_DIFFERENCE_RATIO = 2.7
"""The same bound in mechanisms of a user's own, which may have several degrees of freedom and pass singular configurations: it holds as
far as the error falls to 0.73.
"""

IRREGULAR_ERROR_TO_DIFFERENCE_RATIO = 3.0
"""The same bound in scenes with contacts or kinks."""

UNSETTLED_ERROR_TO_DIFFERENCE_RATIO = 8.0
"""The same bound with contacts, and in mechanisms of a user's own, where the runs do not show the order of 2."""

MIN_SETTLED_DECREASE = 3.0
"""Decrease of the difference of poses or rates from one level to the next that shows the order of 2, which gives 4."""

UNSETTLED_DIFFERENCE = 1e-9
"""Difference of runs, relative to their largest value, from which on that is asked for: smaller ones may be rounding."""

USELESS_DIFFERENCE_RATIO = 3.0
"""Factor on an estimate from `USELESS_ERROR` on: such runs hardly resemble each other, and their difference is of the size of the error."""

MIN_READING_ERROR_RATIO = 0.005
"""Smallest error of extrapolated readings relative to the difference of the last two runs, in scenes with contacts, where a reversal of
the motion leaves an error that falls with no order.
"""

FIRST_ERROR_RATIO = 0.2
"""The same of event times in the first runs, and of readings where outlines touch: their steps may be too long for any order."""

SETTLED_EVENT_DIFFERENCE = 0.05
"""Difference of the last two runs in the time of an event, relative to the time scale, from which on later events may be others."""

# They fall irregularly, dry friction at reversals above all: a small difference may be chance.
TRUSTED_EVENT_DECREASE = 2.5
"""Factor by which the differences of event times may fall when the steps are halved."""

TRUSTED_DECREASE = 5.0
"""The same of the errors of readings in scenes with contacts."""


class RichardsonRefinement(Runner):
    """Refinement of one scene to its accuracy: runs on one grid, each level with half the step of the one before."""

    def __init__(self, settings: ImpulseSettings, scene: Scene, request: RunRequest) -> None:
        start, time_inputs = part_initial_state(scene), TimeInputs(scene)
        super().__init__("impulse", asdict(settings), request, ReadingEvaluator(scene, start[0]))
        self.settings, self.has_contacts = settings, has_contacts(scene)
        self.method = EVENT_METHOD_NAME if self.has_contacts else ""
        self.budget = WorkBudget(settings, scene, time_inputs.n_varying)
        self.grid, is_complete = make_first_grid(settings, request, self.evaluator, time_inputs.breakpoints, self.budget)
        problem = FixedStepProblem(scene, settings, self.evaluator, self.grid, time_inputs, start, self.budget)
        self.runs, self._is_flight = LevelRuns(problem, is_complete), False
        self._event_differences: dict[int, float] = {}
        """Differences of event times (s) by level."""
        self._reading_errors: dict[int, Mapping[str, float]] = {}
        """Errors of the readings (SI) by level, in scenes with contacts."""

    def find_best(self) -> RunResult:
        """Return the result at the given step, or the best of those with shorter and shorter steps."""
        best = self._refine_to_accuracy() if self.settings.step is None else self.extrapolate_at_level(0)
        self.iterations, self.n_runs = self.runs.iterations, self.runs.n_runs
        if best.outcome is not None or self._is_accurate(best):
            return best
        reasons = [f"max_steps = {self.budget.limit}, for all runs together, allows no better result"] if self.runs.is_limited else []
        of_events = {name: error for name, error in best.reading_errors.items() if name == EVENT_TIMES}
        if of_events and self.evaluator.to_relative_error(of_events, best.observables) == best.error_estimate:
            reasons.append("runs of different steps find other events, or other times of them, as where parts touch with hardly any force")
        return replace(best, detail="; ".join(reasons)) if reasons else best

    def _refine_to_accuracy(self) -> RunResult:
        """Refine until the estimate meets the accuracy, or stops falling even with more solver iterations, or the budget is spent."""
        best = None
        while True:
            iterations = self.runs.iterations
            refined, has_stagnated = self._refine()
            best = refined if best is None or _is_improvement(refined, best) else best
            if self._is_accurate(best):
                return best
            if self.runs.iterations > iterations and self.runs.fits_budget(0):
                continue  # the iterations were raised on the way: the longer steps were not solved well enough either
            # Near a singular configuration, unsolved joints show only in the estimate.
            if not has_stagnated or (best.error_estimate or 0.0) < ESTIMATE_ROUNDING_FLOOR or not self.runs.raise_iterations():
                return best

    def _refine(self) -> tuple[RunResult, bool]:
        """Shorten the step until the accuracy is met; return the best result and whether progress has stagnated."""
        best, level = self._first_closed_result()
        iterations, stagnant_levels = self.runs.iterations, 0
        while not self._is_accurate(best):
            level += min(max(1, math.ceil(math.log2(2 * (best.error_estimate or 1.0) / self._goal) / 3)), 4)
            if level > self.settings.max_step_halvings or not self.runs.fits_budget(level):
                return best, False
            finer = self.extrapolate_at_level(level)
            if not _is_improvement(finer, best):
                best = self._with_contradiction(best, finer)
                # Event errors do not fall monotonically with the step: allow MAX_STAGNANT_LEVELS halvings without progress.
                stagnant_levels += 1
                if stagnant_levels > MAX_STAGNANT_LEVELS * self.has_contacts:
                    return best, True
                continue
            best, stagnant_levels = finer, 0
            if self.runs.iterations > iterations:
                return best, True
        return best, False

    def _with_contradiction(self, best: RunResult, finer: RunResult) -> RunResult:
        """Return the best result with an estimate of at least what events of a finer one that it does not have, or later, mean."""
        if not self.has_contacts or finer.outcome is Outcome.JOINT_OPENED or finer.n_reached < best.n_reached:
            return best
        times = best.reported_states.times
        time_tolerance = self.request.accuracy * self.evaluator.time_scale
        difference, _ = compare_event_logs(best.contact_events, finer.contact_events, times, time_tolerance)
        return self.with_least_errors(best, {EVENT_TIMES: difference})

    def _first_closed_result(self) -> tuple[RunResult, int]:
        """Return the first result and its level; halve the step while joints open because it is too long for the speeds that occur."""
        best, level = self.extrapolate_at_level(0), 0
        while best.outcome is Outcome.JOINT_OPENED and level < MAX_OPEN_JOINT_HALVINGS:
            self.runs.restore_iterations()
            if not self.runs.fits_budget(level + 1):
                break
            level += 1
            finer = self.extrapolate_at_level(level)
            if finer.outcome is not Outcome.JOINT_OPENED or finer.n_reached >= best.n_reached:
                best = finer
        return best, level

    @property
    def _goal(self) -> float:
        """Return the estimate to reach."""
        return max(self.request.accuracy, FLIGHT_ACCURACY) if self._is_flight else self.request.accuracy

    def _is_accurate(self, result: RunResult) -> bool:
        """Return whether a result needs no further refinement: accurate, not certifiable, or with open joints."""
        return result.outcome is Outcome.JOINT_OPENED or result.error_estimate is None or result.error_estimate <= self._goal

    @np.errstate(all="ignore")
    def extrapolate_at_level(self, level: int) -> RunResult:
        """Return the extrapolated result of runs whose coarsest has its steps halved `level` times."""
        end = self.runs.integrate(level)
        self._is_flight = end.is_flight
        levels = self.runs.levels_from(level)
        solutions = [self.runs.solutions[one] for one in levels]
        end = self._end_at_exit(end, solutions)
        count = end.n_times
        events = ExtrapolatedEvents()
        if self.has_contacts and count:
            last = float(self.grid.monitor_times[count - 1])
            first_step = float(self.grid.monitor_times[1] / self.grid.min_steps[0]) / 2 ** levels[-1]
            logs = [[event for event in solution.events if event.time <= last] for solution in solutions]
            min_error_ratio = MIN_EVENT_TIME_ERROR_RATIO if level else FIRST_ERROR_RATIO
            settled_difference = SETTLED_EVENT_DIFFERENCE * self.evaluator.time_scale
            events = extrapolate_events(logs, last, first_step, min_error_ratio, settled_difference)
        extrapolated = [solution.states.at(slice(count)) for solution in solutions]
        if len(extrapolated) > 1:  # between the impact times of two runs there is nothing to extrapolate
            between_impacts = are_in_intervals(extrapolated[-1].times, events.impact_intervals)
            extrapolated = [_extrapolate(coarse, fine, 4, between_impacts) for coarse, fine in pairwise(extrapolated)]
        reported_indices = self.grid.truncate(count).reported_indices
        reported = [states.at(reported_indices) for states in extrapolated]
        is_certified = self.settings.levels == 3 and (self.request.certify or self.settings.step is None)
        best_states = reported[-1] if is_certified or len(reported) == 1 else _extrapolate(reported[0], reported[1], 8)
        modes = solutions[-1].contact_modes[:count]
        result = RunResult(
            reported_states=best_states,
            monitor_states=extrapolated[-1].at(slice(count)),
            observables=self.evaluator.evaluate(best_states, modes_at(modes, reported_indices)),
            outcome=end.outcome,
            detail=end.detail,
            step=float(np.max(np.diff(self.grid.monitor_times) / (self.grid.min_steps << levels[-1]), initial=0.0)),
            contact_modes=modes,
            reported_indices=reported_indices,
            contact_events=tuple(event for event in events.events if event.time <= self.grid.monitor_times[max(count - 1, 0)]),
        )
        if not is_certified:
            return result
        levels_up_to_end = [solution.states.at(slice(count)) for solution in solutions]
        error_ratio = self._choose_error_ratio(_decreases_of_differences(levels_up_to_end))
        result = self._certify(result, reported[0], events, level, error_ratio)
        if self.has_contacts:
            result = self._bound_by_last_runs(result, [states.at(reported_indices) for states in levels_up_to_end[-2:]], level)
        return self._with_exit_error(result, end)

    def _end_at_exit(self, end: Termination, solutions: Sequence[FixedStepSolution]) -> Termination:
        """Return the end of runs at the exit of their extrapolated motion, which is located between its monitor times."""
        n_common = min(len(solution.raw_poses) for solution in solutions)
        is_exit = end.outcome in (Outcome.LEFT_RANGE, Outcome.SHAFT_STALLED) and not end.is_flight
        count = min(n_common, end.n_times + MAX_EXIT_DISAGREEMENT) if is_exit else end.n_times
        states = [solution.states.at(slice(count)) for solution in solutions]
        motion = _extrapolate(states[-2], states[-1], 4) if len(states) > 1 else states[-1]
        event_times = np.array([event.time for event in solutions[-1].events])
        state_at = partial(interpolate_state, self.scene, motion, solutions[-1].contact_modes[:count])
        motion_exit = find_first_exit(self.evaluator, motion, state_at, event_times, self.request.accuracy)
        if motion_exit is None or motion_exit.time >= end.exit_time:
            return end
        return Termination(count_before(motion.times, motion_exit.time), motion_exit.outcome, motion_exit.detail)

    def _with_exit_error(self, result: RunResult, end: Termination) -> RunResult:
        """Return a result that ends between two monitor times with an estimate of at least the error of that time, in time scales."""
        if end.exit_time == math.inf:
            return result
        estimate = max(result.error_estimate or 0.0, min(end.exit_time_error / self.evaluator.time_scale, UNKNOWN_EXIT_ERROR))
        return replace(result, error_estimate=estimate)

    def _choose_error_ratio(self, decreases: Sequence[float]) -> float:
        """Return the bound of the error relative to the difference of two levels, given by how much less the runs differ at each level."""
        is_custom = any(part.machine == CUSTOM_MACHINE for part in self.scene.parts)
        if (self.has_contacts or is_custom) and min(decreases, default=math.inf) < MIN_SETTLED_DECREASE:
            return UNSETTLED_ERROR_TO_DIFFERENCE_RATIO
        if self.has_contacts or has_kinks(self.scene):
            return IRREGULAR_ERROR_TO_DIFFERENCE_RATIO
        return CUSTOM_ERROR_TO_DIFFERENCE_RATIO if is_custom else ERROR_TO_DIFFERENCE_RATIO

    def _trust_event_times(self, level: int, difference: float) -> float:
        """Return the difference (s) of event times at a level, but no less than the order of 2 makes of that at a coarser level."""
        coarser_level = max((one for one in self._event_differences if one < level), default=level)
        coarser = self._event_differences.get(coarser_level, 0.0)
        return max(difference, coarser / TRUSTED_EVENT_DECREASE ** (level - coarser_level))

    def _trust_readings(self, result: RunResult, level: int) -> RunResult:
        """Return a result with errors of readings that are no less than a trusted decrease makes of those at a coarser level."""
        coarser_level = max((one for one in self._reading_errors if one < level), default=level)
        coarser = self._reading_errors.get(coarser_level, {})
        return self.with_least_errors(result, _scale_reading_errors(coarser, TRUSTED_DECREASE ** (coarser_level - level)))

    def _bound_by_last_runs(self, result: RunResult, last_runs: Sequence[StateHistory], level: int) -> RunResult:
        """Return a result with errors of readings that are no less than a part of the difference of the last two runs."""
        difference = self.evaluator.compare_observables(*(self.evaluator.evaluate(states, result.reported_modes) for states in last_runs))
        ratio = MIN_READING_ERROR_RATIO if level or not outline_gaps_of(self.evaluator.scene) else FIRST_ERROR_RATIO
        return self.with_least_errors(result, _scale_reading_errors(difference, ratio))

    def _certify(self, result: RunResult, coarse: StateHistory, events: ExtrapolatedEvents, level: int, error_ratio: float) -> RunResult:
        """Return a result with its errors, estimated by the difference from coarser extrapolated states."""
        times = result.reported_states.times
        tolerance = self.request.accuracy * self.evaluator.time_scale
        is_near_event = are_in_intervals(times, [(event.time - tolerance, event.time + tolerance) for event in events.events])
        difference = max(events.time_error, events.wrong_side_error(times[~is_near_event]))
        time_error = self._trust_event_times(level, difference)
        observables = self.evaluator.evaluate(coarse, result.reported_modes)
        coarse_result = replace(result, reported_states=coarse, observables=observables)
        result = self.with_error_estimate(result, coarse_result, is_near_event, time_error, error_ratio)
        if (result.error_estimate or 0.0) > USELESS_ERROR:
            return self.with_least_errors(result, _scale_reading_errors(result.reading_errors, USELESS_DIFFERENCE_RATIO))
        if not self.has_contacts:
            return result
        trusted = self.with_bounce_error(self._trust_readings(result, level))
        if events.is_matched:  # else they say nothing about those at finer levels
            self._event_differences[level], self._reading_errors[level] = difference, result.reading_errors
        return trusted

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
        observables = self.evaluator.evaluate(reported_states, best.reported_modes)
        return replace(best, monitor_states=states, reported_states=reported_states, observables=observables)

    def count_work(self) -> tuple[int, int, Mapping[str, int]]:
        """Return the steps, no rejected steps, and the evaluations by force law."""
        return self.runs.steps, 0, dict(self.runs.evaluation_counts)


def interpolate_state(scene: Scene, states: StateHistory, contact_modes: Sequence[ContactMode], k: int, time: float) -> StateHistory:
    """Return the state at a time (s) after sample k, by quintic interpolation to the next one."""
    pair = states.at(slice(k, k + 2))
    motion = pair.times, pair.poses, pair.velocities
    accelerations = compute_inverse_dynamics(scene, *motion, pair.lags, tuple(contact_modes[k : k + 2])).accelerations
    ends = [(pair.poses[j], pair.velocities[j], accelerations[j]) for j in (0, 1)]
    length = float(pair.times[1] - pair.times[0])
    poses, velocities = quintic_hermite(*ends[0], *ends[1], length, (time - float(pair.times[0])) / length)
    return replace(pair.at(slice(1)), times=np.array([time]), poses=poses[np.newaxis], velocities=velocities[np.newaxis])


def _is_improvement(finer: RunResult, best: RunResult) -> bool:
    """Return whether a finer result has closed joints and a smaller error estimate; one that the budget cut short has not."""
    if finer.outcome is Outcome.JOINT_OPENED or (finer.outcome is Outcome.STEP_LIMIT and finer.n_reached < best.n_reached):
        return False
    return (finer.error_estimate or math.inf) < (best.error_estimate or math.inf)


def _scale_reading_errors(errors: Mapping[str, float], factor: float) -> dict[str, float]:
    """Return the errors of readings and rates times a factor, without event times and the gap of the joints."""
    return {name: factor * error for name, error in errors.items() if name not in (EVENT_TIMES, JOINT_GAP)}


def _decreases_of_differences(levels: Sequence[StateHistory]) -> list[float]:
    """Return the factors by which poses and rates of three runs differ less from one level to the next, where that is not rounding."""
    decreases = []
    for name in ("poses", "velocities"):
        values = [getattr(states, name) for states in levels]
        before, after = [float(np.max(np.abs(fine - coarse), initial=0.0)) for coarse, fine in pairwise(values)]
        if after > UNSETTLED_DIFFERENCE * float(np.max(np.abs(values[-1]), initial=0.0)):
            decreases.append(before / after)
    return decreases


def _extrapolate(coarse: StateHistory, fine: StateHistory, error_ratio: int, keep_fine: BoolArray | None = None) -> StateHistory:
    """Remove the leading error by Richardson extrapolation; it falls by `error_ratio` per level. Samples in `keep_fine` stay."""
    extrapolated: dict[str, FloatArray] = {}
    for name in ("poses", "velocities", "work", "dissipated_energy"):
        fine_values = getattr(fine, name)
        extrapolated[name] = fine_values + (fine_values - getattr(coarse, name)) / (error_ratio - 1)
        if keep_fine is not None:
            extrapolated[name][keep_fine] = fine_values[keep_fine]
    return replace(fine, **extrapolated)
