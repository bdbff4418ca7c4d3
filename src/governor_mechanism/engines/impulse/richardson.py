"""The climb of fixed-step runs to an accuracy: halved steps, extrapolation, certificate, enough solver iterations."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.engines.base import Task
from governor_mechanism.engines.impulse.event_extrapolation import Happened, compare
from governor_mechanism.engines.impulse.pymunk import Assembly
from governor_mechanism.engines.impulse.run import March, march, march_through
from governor_mechanism.engines.impulse.time_inputs import Clock
from governor_mechanism.engines.initial_state import starting_state
from governor_mechanism.integrators.time_grid import Grid, make_grid
from governor_mechanism.mechanics.contact.event_log import assembled
from governor_mechanism.mechanics.contact.impact import Thrower
from governor_mechanism.mechanics.dynamics.contacts import switches
from governor_mechanism.mechanics.kinematics.velocity_projection import Projector
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.observables.evaluation import Finding, Report, Reporter
from governor_mechanism.observables.work import work_between
from governor_mechanism.types import FloatArray, IntArray

LONGEST_STATION = 0.25
"""In time scales: how far apart the poses are at which limits are watched, and the longest step tried."""

FIRST_GUESS = 2e-4
"""Estimated error of a run whose step is one time scale (extrapolated as its cube): sets the first step tried."""

MOST_DOUBLINGS = 12
"""How often the step may be halved below the first one before the engine gives up."""

MOST_OPENED = 5
"""How often the first step may be halved because joints open."""

GAP_FLOOR = 1e-11
"""A joint gap below this fraction of the machine's size is rounding, not a sign of unsolved joints."""

RETRY = 4
"""How many times more solver iterations a doubtful result is tried with."""

ROUNDING = 1e-11
"""An estimate below this that does not fall with the step is rounding."""

MISSES = 1
"""How many halved steps in a row may not help where something sticks, strikes or goes slack."""

METHOD = "second order, begun anew at every event"
"""How a scene is stepped in which something sticks, strikes or goes slack."""

NEAR = 4
"""Stations within which marches of different steps must leave the limits to be believed."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """The numbers of an impulse run; see ImpulseEngine, which checks them."""

    step: float | None = None
    runs: int = 3
    plain: bool = False
    iterations: int = 20
    max_iterations: int = 1280
    max_steps: int = 4_000_000

    @property
    def levels(self) -> int:
        """How many runs, each with half the step of the one before, make one result."""
        return 1 if self.plain else self.runs


@dataclass(frozen=True)
class Ending:
    """How many stations a run keeps, and why it keeps no more."""

    stations: int
    outcome: Outcome | None = None
    detail: str = ""

    @property
    def opened(self) -> bool:
        return self.outcome is Outcome.JOINT_OPENED


@dataclass(frozen=True)
class Best:
    """The best states reached so far; errors and their largest relative one, where three runs certify them.

    happened is what they passed; excluded counts the samples too near to that to be compared.
    """

    state: State
    report: Report
    errors: dict[str, float]
    estimate: float | None
    level: int
    ending: Ending
    happened: Happened = field(default_factory=Happened)
    excluded: int = 0


class Climb:
    """One scene climbed to its accuracy: runs on one grid, each level half the step of the one before."""

    def __init__(self, tuning: Tuning, scene: Scene, task: Task) -> None:
        self.tuning, self.scene, self.task = tuning, scene, task
        self.start = starting_state(scene)
        self.reporter = Reporter(scene, self.start[0])
        self.projector = Projector(self.reporter.mechanism)
        self.thrower = Thrower(self.reporter.mechanism)
        self.clock = Clock(scene)
        self.switches, self.acted = switches(scene), bool(scene.acting)
        scale = self.reporter.time_scale
        step, longest = tuning.step, math.inf  # a run that is told its step takes that step
        if step is None:
            longest = LONGEST_STATION * scale
            step = min(scale * (task.accuracy / FIRST_GUESS) ** (1 / 3), longest)
        times = task.times
        if math.isfinite(longest):  # beyond this no allowed run can come, so no stations are laid out there
            times = times[times <= longest * (tuning.max_steps >> (tuning.levels - 1))]
        breaks = self.clock.breaks
        self.grid = make_grid(times, breaks, step, longest)
        if tuning.step is None and not self._allowed(self.grid):
            # A guess that asks for too much is no reason to run less far: begin with the longest steps.
            self.grid = make_grid(times, breaks, longest, longest)
        self.whole = self._cut_to_allowed_steps(all_there=len(times) == len(task.times))
        self.iterations = tuning.iterations
        self.marches: dict[int, March] = {}
        self.steps, self.runs, self.laws = 0, 0, Counter[str]()

    def to_accuracy(self) -> Best:
        """Refine until the estimate is within the accuracy, or falls no further whatever the joint solver does."""
        overall = None
        while True:
            iterations = self.iterations
            best, stuck = self._refine()
            overall = best if overall is None or _falls(best, overall) else overall
            if self._reached(overall):
                return overall
            if self.iterations > iterations:
                continue  # raised on the way: the longer steps were not solved well enough either
            # Near a dead centre, unsolved joints show in the estimate alone.
            if not stuck or (overall.estimate or 0.0) < ROUNDING or not self._more_iterations():
                return overall

    def _refine(self) -> tuple[Best, bool]:
        """Shorten the step until the accuracy is reached; the best result, and whether that stopped helping."""
        best = self._closed_start()
        level, iterations, missed = best.level, self.iterations, 0
        while not self._reached(best):
            level += min(max(1, math.ceil(math.log2(2 * (best.estimate or 1.0) / self.task.accuracy) / 3)), 4)
            if level > MOST_DOUBLINGS or not self._allowed(self.grid, level):
                return best, False
            finer = self.at(level)
            if not _falls(finer, best):
                # What an event leaves falls with the step unevenly: one that does not help may be followed by one.
                missed += 1
                if missed > MISSES * self.switches:
                    return best, True
                continue
            best, missed = finer, 0
            if self.iterations > iterations:
                return best, True
        return best, False

    def _closed_start(self) -> Best:
        """The first result; with shorter steps where joints open because steps are too long for how fast it gets."""
        best, level = self.at(0), 0
        while best.ending.opened and level < MOST_OPENED and self._allowed(self.grid, level + 1):
            level += 1
            self.iterations = self.tuning.iterations
            self.marches.clear()
            best = self.at(level)
        return best

    def _reached(self, best: Best) -> bool:
        return best.ending.opened or best.estimate is None or best.estimate <= self.task.accuracy

    @np.errstate(all="ignore")
    def at(self, level: int) -> Best:
        """The extrapolated result of runs whose coarsest has its steps doubled `level` times."""
        levels = range(level, level + self.tuning.levels)
        ending = self._march_all(levels)
        at = self.grid.first(ending.stations).reported
        happened = self._happened(levels, ending.stations)
        states = self._combined(levels, ending.stations, happened, at)
        certified = self.tuning.levels == 3 and (self.task.certify or self.tuning.step is None)
        if not certified:
            highest = states[0] if len(states) == 1 else _extrapolate(states[0], states[1], 8)
            return Best(highest, self.reporter.report(highest), {}, None, level, ending, happened)
        report = self.reporter.report(states[1])
        if not self.switches:
            errors = self.reporter.errors(report, self.reporter.report(states[0]))
            return Best(states[1], report, errors, self.reporter.relative(errors), level, ending)
        near = happened.near(states[1].times, self.task.accuracy * self.reporter.time_scale)
        worse, better = (self.reporter.report(state.at(np.flatnonzero(~near))) for state in states)
        errors = self.reporter.errors(better, worse)
        late = max(happened.late, happened.early(states[1].times[~near]))
        estimate = max(self.reporter.relative(errors), late / self.reporter.time_scale)
        errors["event times"] = late
        return Best(states[1], report, errors, estimate, level, ending, happened, int(near.sum()))

    def trajectory(self, best: Best, wall_time: float) -> Trajectory:
        """The result of the climb."""
        levels = range(best.level, best.level + self.tuning.levels)
        kept = best.ending.stations
        stations = self._combined(levels, kept, best.happened)[-1]
        state, report = best.state, best.report
        modes = self.marches[levels[-1]].modes[:kept]
        uncounted = self.reporter.uncounted_work(stations)
        if modes and uncounted is not None:
            uncounted = -work_between(self.scene, stations, self.reporter.spindle_speeds, modes)
        if uncounted is not None or self.acted:
            work = stations.work + stations.lost
            stations = replace(stations, work=work if uncounted is None else work + uncounted)
            at = self.grid.first(kept).reported
            state = replace(state, work=stations.work[at])
            report = self.reporter.report(state)
        certified = best.estimate is not None
        return self.reporter.trajectory(
            Finding(
                state=state,
                stations=stations,
                report=report,
                outcome=self._outcome(best),
                detail=best.ending.detail,
                estimate=best.estimate,
                errors=best.errors,
                modes=modes,
                reported=self.grid.first(kept).reported,
                happened=best.happened.events,
                excluded=best.excluded,
            ),
            cost=self._cost(best, wall_time),
            settings={**asdict(self.tuning), "asked_accuracy": self.task.accuracy, "certified": certified},
        )

    def _outcome(self, best: Best) -> Outcome:
        if best.ending.outcome is not None:
            return best.ending.outcome
        if best.estimate is None:
            return Outcome.UNCERTIFIED
        return Outcome.DONE if best.estimate <= self.task.accuracy else Outcome.ACCURACY_MISSED

    def _cost(self, best: Best, wall_time: float) -> Cost:
        finest = self.grid.steps << (best.level + self.tuning.levels - 1)
        step = float(np.max(np.diff(self.grid.stations) / finest, initial=0.0))
        return Cost(
            engine="impulse",
            reason=self.task.reason,
            step=step,
            steps=self.steps,
            runs=self.runs,
            iterations=self.iterations,
            evaluations=dict(self.laws),
            wall_time=wall_time,
            events=len(best.happened.events),
            assembled=assembled(self.scene),
            method=METHOD if self.switches else "",
        )

    def _march_all(self, levels: range) -> Ending:
        """March every level, with more solver iterations while joints stay open or the marches tell two stories."""
        while True:
            for level in levels:
                if level not in self.marches:
                    self.marches[level] = self._march(level)
            exits = [self.reporter.first_outside(self.marches[level].poses) for level in levels]
            opened = self._open(levels, exits)
            if not (opened or _disagree(exits)) or not self._more_iterations():
                break
        if opened:
            kept = self._closed_stations(levels)
            where = f"at about t = {self.grid.stations[min(kept, len(self.grid.stations) - 1)]:.6g} s"
            detail = f"{self.iterations} solver iterations did not close the joints, {where}"
            return Ending(kept, Outcome.JOINT_OPENED, detail)
        first = min((found for found in exits if found is not None), default=None)
        if first is None:
            return self.whole
        station, sentence = first
        return Ending(station, Outcome.LEFT_RANGE, f"{sentence}, at about t = {self.grid.stations[station]:.6g} s")

    def _more_iterations(self) -> bool:
        """Forget the marches and solve the joints with more iterations, unless that is beyond the cap."""
        if self.iterations >= self.tuning.max_iterations:
            return False
        self.iterations = min(RETRY * self.iterations, self.tuning.max_iterations)
        self.marches.clear()
        return True

    @np.errstate(all="ignore")  # bodies that are lost give infinite numbers before they are missed
    def _march(self, level: int) -> March:
        assembly = Assembly(self.scene, iterations=self.iterations, plain=self.tuning.plain)
        size = self.reporter.mechanism.size

        def inside(poses: FloatArray) -> bool:
            return self.reporter.first_outside(poses) is None

        if self.switches:
            second = self.reporter.time_scale
            result = march_through(
                self.scene, assembly, self.grid, level, self.clock, self.start, second=second, size=size, inside=inside
            )
        else:
            result = march(assembly, self.grid, level, self.clock, self.start, size=size, inside=inside)
        steps = (int(self.grid.steps[: len(result.work) - 1].sum()) << level) + result.splits
        self.steps += steps
        self.runs += 1
        for law, count in assembly.laws.items():
            self.laws[law] += count * steps
        return result

    def _open(self, levels: range, exits: list[tuple[int, str] | None]) -> bool:
        """Bodies lost, or joint gaps that do not shrink as the step is halved (a second-order scheme quarters them).

        Looked at up to the first station outside the limits, and there: joints torn open leave the limits too.
        """
        count = min([len(self.grid.stations), *(found[0] + 1 for found in exits if found is not None)])
        if any(len(self.marches[level].work) < count for level in levels):
            return True
        if self.tuning.plain:
            return False
        gaps = [float(np.max(self._gaps(level, count))) for level in levels]
        floor = GAP_FLOOR * self.reporter.mechanism.size
        return any(finer > max(0.5 * coarser, floor) for coarser, finer in pairwise(gaps))

    def _gaps(self, level: int, count: int) -> FloatArray:
        return self.reporter.gap(self.marches[level].poses[:count], self.grid.stations[:count])

    def _closed_stations(self, levels: range) -> int:
        """How many stations the finest two marches reached with joints as closed as their steps explain."""
        count = min(len(self.marches[level].work) for level in levels)
        gaps = [np.maximum.accumulate(self._gaps(level, count)) for level in levels[-2:]]
        open_ = gaps[-1] > np.maximum(0.5 * gaps[0], GAP_FLOOR * self.reporter.mechanism.size)
        return int(np.argmax(open_)) if open_.any() else count

    def _allowed(self, grid: Grid, level: int = 0) -> bool:
        """Whether the finest of the runs at this level stays within max_steps."""
        return int(grid.steps.sum()) << (level + self.tuning.levels - 1) <= self.tuning.max_steps

    def _cut_to_allowed_steps(self, *, all_there: bool) -> Ending:
        """Cut the grid to what max_steps allow the finest of the first runs."""
        allowed = self.tuning.max_steps >> (self.tuning.levels - 1)
        reach = int(np.searchsorted(np.cumsum(self.grid.steps), allowed, side="right")) + 1
        if reach >= len(self.grid.stations) and all_there:
            return Ending(len(self.grid.stations))
        self.grid = self.grid.first(reach)
        detail = f"max_steps = {self.tuning.max_steps} end at t = {self.grid.stations[-1]:.6g} s"
        return Ending(len(self.grid.stations), Outcome.STEP_LIMIT, detail)

    def _at_stations(self, result: March, stations: int, at: IntArray | None = None) -> State:
        """The state of a march at its first stations, or at those of them that are asked for."""
        which = np.arange(stations) if at is None else at
        times, poses, velocities = self.grid.stations[which], result.poses[which], result.velocities[which]
        if not self.tuning.plain and len(which):
            # The mean of two half steps opens the joints a little, and more where the step changes its length.
            if self.switches:  # how far joints open hangs on the step, which is another where a step was split
                poses = self.thrower.closed(times, poses)
            velocities = self.projector.velocities(poses, velocities, times)
        spindle = np.stack([result.angle[which], self.reporter.spindle_speeds(times, poses)], axis=-1)
        work = result.work[which]
        return State(
            times=times, poses=poses, velocities=velocities, work=work, lost=result.lost[which], spindle=spindle
        )

    def _combined(self, levels: range, stations: int, happened: Happened, at: IntArray | None = None) -> list[State]:
        """The state of one march at its first stations (or some of them), or what pairs of neighbours extrapolate to.

        Between the times at which marches strike a stop one after the other there is nothing to extrapolate.
        """
        states = [self._at_stations(self.marches[level], stations, at) for level in levels]
        if len(states) == 1:
            return states
        between = happened.between(states[-1].times)
        return [_extrapolate(worse, better, 4, between) for worse, better in pairwise(states)]

    def _happened(self, levels: range, stations: int) -> Happened:
        """What the marches passed up to a station."""
        if not (self.switches and stations):
            return Happened()
        end = float(self.grid.stations[stations - 1])
        return compare([[one for one in self.marches[k].events if one.time <= end] for k in levels], end)


def _falls(finer: Best, best: Best) -> bool:
    return not finer.ending.opened and finer.estimate is not None and finer.estimate < (best.estimate or math.inf)


def _disagree(exits: list[tuple[int, str] | None]) -> bool:
    """Whether marches of one motion leave the limits at different stations, or only some of them."""
    stations = [-NEAR if found is None else found[0] for found in exits]
    return max(stations) - min(stations) >= NEAR


def _extrapolate(worse: State, better: State, gain: int, as_it_is: NDArray[np.bool_] | None = None) -> State:
    """Remove the leading error, which falls by `gain` from one state to the next (Richardson), but where as_it_is."""

    def combine(coarse: FloatArray, fine: FloatArray) -> FloatArray:
        found: FloatArray = fine + (fine - coarse) / (gain - 1)
        if as_it_is is not None:
            found[as_it_is] = fine[as_it_is]
        return found

    return State(
        times=better.times,
        poses=combine(worse.poses, better.poses),
        velocities=combine(worse.velocities, better.velocities),
        work=combine(worse.work, better.work),
        lost=combine(worse.lost, better.lost),
        spindle=combine(worse.spindle, better.spindle),
    )
