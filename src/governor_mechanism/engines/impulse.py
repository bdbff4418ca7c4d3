"""The impulse engine: pymunk's bodies and joints, second order, extrapolated from three runs, and certified."""

from __future__ import annotations

import math
import time
from collections import Counter
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects import Centrifugal, Effect, Gravity
from governor_mechanism.engines.base import Engine, Task
from governor_mechanism.engines.chipmunk import Assembly
from governor_mechanism.engines.grid import make_grid
from governor_mechanism.engines.march import March, march
from governor_mechanism.engines.report import Report, Reporter, State
from governor_mechanism.equations.points import Array
from governor_mechanism.errors import MechanismError
from governor_mechanism.joints import Distance, Joint, Pin, Slider
from governor_mechanism.scene import Scene
from governor_mechanism.statics import starting_state
from governor_mechanism.trajectory import Cost, Outcome, Trajectory

LONGEST_STATION = 0.25
"""In time scales: how far apart the poses are at which limits are watched, and the longest step tried."""

FIRST_GUESS = 2e-4
"""Estimated error of a run whose step is one time scale (extrapolated as its cube): sets the first step tried."""

MOST_DOUBLINGS = 12
"""How often the step may be halved below the first one before the engine gives up."""

GAP_FLOOR = 1e-11
"""A joint gap below this fraction of the machine's size is rounding, not a sign of unsolved joints."""


@final
@dataclass(frozen=True, kw_only=True)
class ImpulseEngine(Engine):
    """pymunk as a second-order staggered scheme; steps h, h/2, h/4 give order 3 and a certificate.

    step (s) is the longest step, chosen from the accuracy where it is left out. runs = 1, 2, 3 steps are halved and
    extrapolated (orders 2, 3, and with certify=False 4). iterations of the joint solver are doubled, up to
    max_iterations, while joints stay open wider than the step explains. plain=True is pymunk's ordinary use: order 1.
    """

    name: ClassVar[str] = "impulse"
    effects: ClassVar[frozenset[type[Effect]]] = frozenset({Gravity, Centrifugal})
    joints: ClassVar[frozenset[type[Joint]]] = frozenset({Distance, Pin, Slider})

    step: float | None = None
    runs: int = 3
    plain: bool = False
    iterations: int = 20
    max_iterations: int = 1280
    max_steps: int = 4_000_000

    def __post_init__(self) -> None:
        if self.runs not in (1, 2, 3):
            raise MechanismError(f"ImpulseEngine.runs must be 1, 2 or 3; got {self.runs!r}")
        if self.plain and self.runs != 1:
            raise MechanismError("ImpulseEngine(plain=True) is first order and is not extrapolated; set runs=1")
        if self.step is None and self.runs != 3:
            raise MechanismError("ImpulseEngine needs 3 runs to find a step of its own; give step=, or leave runs at 3")
        if self.step is not None and not (self.step > 0 and math.isfinite(self.step)):
            raise MechanismError(f"ImpulseEngine.step must be a positive number of seconds; got {self.step!r}")
        for name in ("iterations", "max_iterations", "max_steps"):
            if getattr(self, name) < 1:
                raise MechanismError(f"ImpulseEngine.{name} must be at least 1; got {getattr(self, name)!r}")

    def _run(self, scene: Scene, task: Task) -> Trajectory:
        started = time.perf_counter()
        climb = Climb(self, scene, task)
        best = climb.to_accuracy() if self.step is None else climb.at(0)
        return climb.trajectory(best, time.perf_counter() - started)


@dataclass(frozen=True)
class Best:
    """The best states reached so far; errors and their largest relative one, where three runs certify them."""

    state: State
    report: Report
    errors: dict[str, float]
    estimate: float | None
    level: int
    opened: bool


class Climb:
    """One scene climbed to its accuracy: runs on one grid, each level half the step of the one before."""

    def __init__(self, engine: ImpulseEngine, scene: Scene, task: Task) -> None:
        self.engine, self.scene, self.task = engine, scene, task
        self.reporter = Reporter(scene)
        self.start = starting_state(scene)
        scale = self.reporter.time_scale
        step, longest = engine.step, math.inf  # an engine that is told its step takes that step
        if step is None:
            longest = LONGEST_STATION * scale
            step = min(scale * (task.accuracy / FIRST_GUESS) ** (1 / 3), longest)
        self.grid = make_grid(task.times, self.reporter.program.breaks, step, longest)
        self.ended: Outcome | None = None
        self.detail = ""
        self.iterations = engine.iterations
        self.marches: dict[int, March] = {}
        self.steps, self.runs, self.laws = 0, 0, Counter[str]()
        self._cut_to_allowed_steps()

    def to_accuracy(self) -> Best:
        """Refine until the estimate is within the accuracy, or falls no further."""
        level, best = 0, self.at(0)
        while best.estimate is not None and best.estimate > self.task.accuracy and not best.opened:
            level += min(max(1, math.ceil(math.log2(2 * best.estimate / self.task.accuracy) / 3)), 4)
            if level > MOST_DOUBLINGS or int(self.grid.steps.sum()) << (level + 2) > self.engine.max_steps:
                break
            finer = self.at(level)
            if finer.opened or finer.estimate is None or finer.estimate > best.estimate:
                break  # rounding, not the step, sets the error now
            best = finer
        return best

    def at(self, level: int) -> Best:
        """The extrapolated result of runs whose coarsest has its steps doubled `level` times."""
        levels = range(level, level + self.engine.runs)
        opened = self._march_all(levels)
        states = [self._state(self.marches[one]) for one in levels]
        if len(states) > 1:
            states = [_extrapolate(worse, better, 4) for worse, better in pairwise(states)]
        certified = self.engine.runs == 3 and (self.task.certify or self.engine.step is None)
        if not certified:
            highest = states[0] if len(states) == 1 else _extrapolate(states[0], states[1], 8)
            return Best(highest, self.reporter.report(highest), {}, None, level, opened)
        worse, better = (self.reporter.report(state) for state in states)
        errors = self.reporter.errors(better, worse)
        return Best(states[1], better, errors, self.reporter.relative(errors), level, opened)

    def trajectory(self, best: Best, wall_time: float) -> Trajectory:
        """The result of the climb."""
        report, certified = best.report, best.estimate is not None
        return Trajectory(
            scene=self.scene,
            times=best.state.times,
            poses=best.state.poses,
            velocities=best.state.velocities,
            readings=report.readings,
            rates=report.rates,
            units=report.units,
            scales=self.reporter.scales(),
            joint_gap=report.joint_gap,
            energy=report.energy,
            outcome=self._outcome(best),
            detail=self.detail,
            cost=self._cost(best, wall_time),
            error_estimate=best.estimate,
            reading_errors=best.errors,
            settings={**asdict(self.engine), "asked_accuracy": self.task.accuracy, "certified": certified},
        )

    def _outcome(self, best: Best) -> Outcome:
        if best.opened:
            return Outcome.JOINT_OPENED
        if self.ended is not None:
            return self.ended
        if best.estimate is None:
            return Outcome.UNCERTIFIED
        return Outcome.DONE if best.estimate <= self.task.accuracy else Outcome.ACCURACY_MISSED

    def _cost(self, best: Best, wall_time: float) -> Cost:
        finest = self.grid.steps << (best.level + self.engine.runs - 1)
        step = float(np.max(np.diff(self.grid.stations) / finest, initial=0.0))
        return Cost(
            engine=self.engine.name,
            reason=self.task.reason,
            step=step,
            steps=self.steps,
            runs=self.runs,
            iterations=self.iterations,
            evaluations=dict(self.laws),
            wall_time=wall_time,
        )

    def _march_all(self, levels: range) -> bool:
        """March every level; more solver iterations while joints stay open. True when they stay open at the cap."""
        while True:
            for level in levels:
                if level not in self.marches:
                    self.marches[level] = self._march(level)
            exits = [self._exit(self.marches[level]) for level in levels]
            if not self._unsolved(levels, exits):
                self._cut_to_range(exits)
                return False
            if 2 * self.iterations > self.engine.max_iterations:
                self.detail = f"{self.iterations} solver iterations did not close the joints"
                self._cut(min(len(self.marches[level].work) for level in levels))
                return True
            self.iterations *= 2
            self.marches.clear()

    def _march(self, level: int) -> March:
        assembly = Assembly(self.scene, iterations=self.iterations, plain=self.engine.plain)
        result = march(assembly, self.grid, level, self.reporter.program, *self.start, self.reporter.mechanism.size)
        steps = int(self.grid.steps.sum()) << level
        self.steps += steps
        self.runs += 1
        for law, count in assembly.laws.items():
            self.laws[law] += count * steps
        return result

    def _exit(self, result: March) -> tuple[int, str] | None:
        """The first station at which a march is outside the mechanism's limits, and what happens there."""
        return self.reporter.first_outside(result.poses[: len(self.grid.stations)])

    def _unsolved(self, levels: range, exits: list[tuple[int, str] | None]) -> bool:
        """Bodies lost, or joint gaps that do not shrink as the step is halved (a second-order scheme quarters them).

        Looked at up to the first station outside the limits, and there: joints torn open leave the limits too.
        """
        count = min([len(self.grid.stations), *(found[0] + 1 for found in exits if found is not None)])
        if any(len(self.marches[level].work) < count for level in levels):
            return True
        if self.engine.plain:
            return False
        gaps = [float(np.max(self.reporter.gap(self.marches[level].poses[:count]))) for level in levels]
        floor = GAP_FLOOR * self.reporter.mechanism.size
        return any(finer > max(0.5 * coarser, floor) for coarser, finer in pairwise(gaps))

    def _cut_to_range(self, exits: list[tuple[int, str] | None]) -> None:
        """End the run at the last station before any march leaves the mechanism's limits."""
        outside = min((found for found in exits if found is not None), default=None)
        if outside is not None:
            index, sentence = outside
            self.ended = Outcome.LEFT_RANGE
            self.detail = f"{sentence}, at about t = {self.grid.stations[index]:.6g} s"
            self._cut(index)

    def _cut_to_allowed_steps(self) -> None:
        allowed = self.engine.max_steps >> (self.engine.runs - 1)
        reach = int(np.searchsorted(np.cumsum(self.grid.steps), allowed, side="right")) + 1
        if reach < len(self.grid.stations):
            self.ended = Outcome.STEP_LIMIT
            self.detail = f"max_steps = {self.engine.max_steps} end at t = {self.grid.stations[reach - 1]:.6g} s"
            self._cut(reach)

    def _cut(self, stations: int) -> None:
        self.grid = self.grid.first(stations)

    def _state(self, result: March) -> State:
        at = self.grid.reported
        return State(
            times=self.grid.stations[at], poses=result.poses[at], velocities=result.velocities[at], work=result.work[at]
        )


def _extrapolate(worse: State, better: State, gain: int) -> State:
    """Remove the leading error, which falls by `gain` from one state to the next (Richardson)."""

    def combine(coarse: Array, fine: Array) -> Array:
        return fine + (fine - coarse) / (gain - 1)

    return State(
        times=better.times,
        poses=combine(worse.poses, better.poses),
        velocities=combine(worse.velocities, better.velocities),
        work=combine(worse.work, better.work),
    )
