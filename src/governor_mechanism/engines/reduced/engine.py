"""The reduced engine: one coordinate along tables of the assembled mechanism, stepped by DOP853 in compiled code."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, ClassVar, final

import numpy as np

from governor_mechanism.effects.clearance import Play
from governor_mechanism.effects.registry import ALL_EFFECTS
from governor_mechanism.engines.base import Engine, Task
from governor_mechanism.engines.certificate import LOOSER, first_tolerance, outcome_of, refuse_settings, tightened
from governor_mechanism.engines.initial_state import starting_state
from governor_mechanism.engines.reduced.integration import DONE, STALLED, STIFF, advance
from governor_mechanism.engines.reduced.run import LEFT, LONGEST_STEP, Ridden, Rider
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.time_grid import make_grid
from governor_mechanism.mechanics.contact.event_log import assembled, compared
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import measure
from governor_mechanism.mechanics.reduction.motion_table import Way
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import ALL_JOINTS, Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.numerics.jit import announce
from governor_mechanism.observables.evaluation import Finding, Report, Reporter
from governor_mechanism.observables.singular_configurations import Between

NARROWER = 0.7
"""How much narrower its pieces are, so that what the fits leave out is told apart as well."""

PATIENCE = 4
"""So many tighter certificates that are no better are believed; one may be bad luck."""

LONGEST_STATION = 0.25
"""In time scales, and of the coordinate's unit: how far apart the poses are at which dead centres are looked for."""

FARTHEST, MOST_STATIONS = 0.5, 200_000
"""Of the coordinate's unit: poses farther apart get others between them, up to so many."""


@final
@dataclass(frozen=True, kw_only=True)
class ReducedEngine(Engine):
    """Order 8 with error control for mechanisms of mobility one: the fastest.

    tolerance is the error of one step, chosen from the accuracy where it is left out. max_steps bounds one run.
    The error estimate is the difference from a run ten times looser along tables of its own.
    """

    name: ClassVar[str] = "reduced"
    effects: ClassVar[frozenset[type[Effect]]] = ALL_EFFECTS - {Play}
    joints: ClassVar[frozenset[type[Joint]]] = ALL_JOINTS

    tolerance: float | None = None
    max_steps: int = 1_000_000

    def __post_init__(self) -> None:
        refuse_settings("ReducedEngine", self.tolerance, self.max_steps)

    def _refuses(self, scene: Scene) -> str:
        assembler = Assembler(scene.part.mechanism)
        if assembler.equations.driven.any():
            return "engine 'reduced' follows one free coordinate, and drives move this mechanism; choose multibody"
        if assembler.mobility != 1:
            return f"engine 'reduced' follows one coordinate, not a mobility of {assembler.mobility}; choose multibody"
        return ""

    def _run(self, scene: Scene, task: Task) -> Trajectory:
        follower = Follower(self, scene, task)
        follower.load()
        started = time.perf_counter()
        tolerance = self.tolerance or first_tolerance(task.accuracy)
        if task.certify and self.tolerance is None:
            best = tightened(follower.certified, tolerance, task.accuracy, PATIENCE)
        else:
            best = follower.certified(tolerance) if task.certify else follower.followed(tolerance)
        return follower.trajectory(best, time.perf_counter() - started - follower.building)


@dataclass(frozen=True)
class Followed:
    """One run at a tolerance, and how it ended."""

    ridden: Ridden
    rider: Rider
    tolerance: float
    state: State
    report: Report
    ended: Outcome | None
    detail: str
    errors: Mapping[str, float]
    estimate: float | None = None
    excluded: int = 0

    @property
    def reached(self) -> int:
        """How many of the reported times it came to."""
        return len(self.state.times)


class Follower:
    """Follows one scene at given tolerances."""

    def __init__(self, engine: ReducedEngine, scene: Scene, task: Task) -> None:
        self.engine, self.scene, self.task = engine, scene, task
        poses, velocities = starting_state(scene)
        self.reporter = Reporter(scene, poses)
        lead = measure(scene.part.mechanism, scene.part.mechanism.coordinate, poses)
        self.start = float(lead.value), float(np.sum(lead.gradient * velocities))
        self._poses = poses
        self.runs, self.counts = 0, np.zeros(4, dtype=np.int64)
        self._riders: dict[float, Rider] = {}

    def load(self) -> None:
        """Have the kernels compiled or loaded, once in a process, so that no run's cost includes it."""
        kernel: Any = advance
        if not kernel.signatures:
            announce("advance", 30)
            way = Way(self.scene, self.start[0], self._poses)
            if way.begun and way.extended(0) and way.extended(1):
                soon = np.array([1e-9 * self.reporter.time_scale])
                rider = Rider(way, self.reporter, self.start, soon, self.engine.max_steps)
                rider.state(rider.ridden(1.0))

    @property
    def building(self) -> float:
        """Seconds that laying the ways has taken."""
        return sum(rider.way.building for rider in self._riders.values())

    def rider(self, share: float) -> Rider:
        """One along pieces that are so much narrower at first."""
        if share not in self._riders:
            way = Way(self.scene, self.start[0], self._poses, share)
            if not way.begun:
                raise MechanismError(f"engine 'reduced' cannot begin: {way.words(1)[1]}; choose engine 'multibody'")
            self._riders[share] = Rider(way, self.reporter, self.start, self.task.times, self.engine.max_steps)
        return self._riders[share]

    def certified(self, tolerance: float) -> Followed:
        """Two runs, and the difference between them as the estimate of the better one's error."""
        # Where it is not the tolerance that bounds the steps, twice as long ones tell the runs apart.
        worse = self.followed(LOOSER * tolerance, 2 * LONGEST_STEP, NARROWER)
        better = self.followed(tolerance)
        shared = min(len(worse.state.times), len(better.state.times))
        late, near = compared(better.ridden.events, worse.ridden.events, better.state.times[:shared],
                              self.task.accuracy * self.reporter.time_scale)  # fmt: skip
        tight, loose = better.report, worse.report
        if near.any() or shared < max(len(worse.state.times), len(better.state.times)):
            kept = np.flatnonzero(~near)
            tight, loose = (self.reporter.report(one.state.first(shared).at(kept)) for one in (better, worse))
        errors = self.reporter.errors(tight, loose)
        estimate = self.reporter.relative(errors)
        if better.rider.switching:
            errors["event times"] = late
            estimate = max(estimate, late / self.reporter.time_scale)
        return replace(better, errors=errors, estimate=estimate, excluded=int(near.sum()))

    def followed(self, tolerance: float, longest: float = LONGEST_STEP, share: float = 1.0) -> Followed:
        """One run, its steps at most so many of the scene's paces long."""
        self.runs += 1
        rider = self.rider(share)
        ridden = rider.ridden(tolerance, longest)
        state = rider.state(ridden)
        reached = f"t = {ridden.ended:.9g} s"
        ended, detail = None, ""
        if ridden.code == LEFT:
            limited, words = rider.way.words(ridden.side)
            ended = Outcome.LEFT_RANGE if limited else Outcome.DEAD_CENTRE
            detail = f"{words}, at {reached}"
        elif ridden.code == STIFF:
            ended, detail = Outcome.STIFF, f"at {reached}"
        elif ridden.code == STALLED:
            ended, detail = Outcome.STALLED, f"at {reached}"
        elif ridden.code != DONE:
            ended, detail = Outcome.STEP_LIMIT, f"max_steps = {self.engine.max_steps} end at {reached}"
        return Followed(ridden, rider, tolerance, state, self.reporter.report(state), ended, detail, {})

    def trajectory(self, best: Followed, wall_time: float) -> Trajectory:
        """The result."""
        settings = {**asdict(self.engine), "asked_accuracy": self.task.accuracy, "certified": best.estimate is not None}
        return self.reporter.trajectory(
            Finding(
                state=best.state,
                stations=partial(self._stations, best),
                report=best.report,
                outcome=outcome_of(best, self.task.accuracy),
                detail=best.detail,
                estimate=best.estimate,
                errors=dict(best.errors),
                modes=best.rider.modes(best.ridden, best.state.poses),
                reported=slice(None),
                happened=best.ridden.events,
                excluded=best.excluded,
            ),
            cost=self._cost(best, wall_time),
            settings=settings,
        )

    def _stations(self, best: Followed) -> tuple[State, Between | None]:
        """States near enough to each other that nothing is passed unseen, and what lies between; ridden anew."""
        end = best.state.times[-1:]
        breaks = np.unique(np.concatenate([curve.breaks for curve in best.rider.way.curves]))
        times = make_grid(end, breaks, np.inf, LONGEST_STATION * self.reporter.time_scale).stations
        while True:
            rider = Rider(best.rider.way, self.reporter, self.start, times, self.engine.max_steps)
            ridden = rider.ridden(best.tolerance)
            ways = np.abs(np.diff(ridden.rows[:, 0])) / best.rider.way.plan.unit
            if not len(ways) or np.max(ways) < FARTHEST or len(times) > MOST_STATIONS:
                break
            pieces = np.ceil(ways / LONGEST_STATION).astype(int).clip(1)
            parts = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(times, times[1:], pieces, strict=False)]
            times = np.concatenate([times[:1], *parts])
        return rider.state(ridden), partial(rider.between, ridden.rows, best.tolerance)

    def _cost(self, best: Followed, wall_time: float) -> Cost:
        riders = self._riders.values()
        counts = sum((rider.counts for rider in riders), np.zeros(4, dtype=np.int64))
        steps, rejected, evaluations, moving = (int(count) for count in counts)
        pieces = sum(rider.way.pieces for rider in riders)
        laws = {"equations of motion": evaluations, "pieces laid": pieces}
        acts = best.rider.way.acts
        for law, many, count in (
            ("springs on readings", len(acts.springs), evaluations),
            ("oil brakes", len(acts.brakes), moving),
            ("dry friction", int(np.sum(acts.keepers[:, 1] >= 0)), moving),
        ):
            if many:
                laws[law] = many * count
        return Cost(
            engine=self.engine.name,
            reason=self.task.reason,
            step=best.ridden.step,
            steps=steps,
            rejected=rejected,
            runs=self.runs,
            evaluations=laws,
            wall_time=wall_time,
            building=self.building,
            events=len(best.ridden.events),
            assembled=assembled(self.scene),
            method="explicit (DOP853) along one coordinate",
        )
