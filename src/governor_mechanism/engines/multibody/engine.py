"""The multibody engine: bodies and joints, index-reduced and projected, stepped by DOP853 in compiled code."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.registry import ALL_EFFECTS
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.engines.base import Engine, Task
from governor_mechanism.engines.certificate import LOOSER, first_tolerance, outcome_of, refuse_settings, tightened
from governor_mechanism.engines.initial_state import starting_state
from governor_mechanism.engines.multibody.run import LONGEST_STEP, Passage, Stepper
from governor_mechanism.integrators.projected_dop853 import DONE, STALLED
from governor_mechanism.mechanics.contact.event_log import assembled, compared
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import ALL_JOINTS, Joint
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.numerics.jit import announce
from governor_mechanism.observables.evaluation import Finding, Report, Reporter
from governor_mechanism.observables.singular_configurations import Between
from governor_mechanism.types import FloatArray

PATIENCE = 4
"""So many tighter certificates that are no better are believed; one may be bad luck."""

HALVINGS = 40
"""Of the time between two stations, to find when a motion leaves its range: to rounding."""


@final
@dataclass(frozen=True, kw_only=True)
class MultibodyEngine(Engine):
    """Order 8 with error control, joints closed to rounding at every step; the reference.

    tolerance is the error of one step, chosen from the accuracy where it is left out. max_steps bounds one run.
    The error estimate is the difference from a run ten times looser.
    """

    name: ClassVar[str] = "multibody"
    effects: ClassVar[frozenset[type[Effect]]] = ALL_EFFECTS
    joints: ClassVar[frozenset[type[Joint]]] = ALL_JOINTS

    tolerance: float | None = None
    max_steps: int = 1_000_000

    def __post_init__(self) -> None:
        refuse_settings("MultibodyEngine", self.tolerance, self.max_steps)

    def _run(self, scene: Scene, task: Task) -> Trajectory:
        announce("integrate", 12)
        follower = Follower(self, scene, task)
        follower.stepper.compile()
        started = time.perf_counter()
        tolerance = self.tolerance or first_tolerance(task.accuracy)
        if task.certify and self.tolerance is None:
            best = tightened(follower.certified, tolerance, task.accuracy, PATIENCE)
        else:
            best = follower.certified(tolerance) if task.certify else follower.followed(tolerance)
        return follower.trajectory(best, time.perf_counter() - started)


@dataclass(frozen=True)
class Followed:
    """States at the reported times and at all stations, what they say, and why there are no more."""

    state: State
    stations: State
    passage: Passage
    tolerance: float
    report: Report
    ended: Outcome | None
    detail: str
    errors: dict[str, float]
    estimate: float | None = None
    excluded: int = 0

    @property
    def reached(self) -> int:
        """How many of the reported times it came to."""
        return len(self.state.times)


class Follower:
    """Follows one scene at given tolerances."""

    def __init__(self, engine: MultibodyEngine, scene: Scene, task: Task) -> None:
        self.engine, self.scene, self.task = engine, scene, task
        standing = starting_state(scene)
        self.reporter = Reporter(scene, standing[0])
        self.stepper = Stepper(scene, self.reporter, standing, task.times, engine.max_steps)
        self.runs = 0

    def certified(self, tolerance: float) -> Followed:
        """Two runs, and the difference between them as the estimate of the better one's error."""
        # Where it is not the tolerance that bounds the steps, twice as long ones tell the runs apart.
        worse, better = self.followed(LOOSER * tolerance, 2 * LONGEST_STEP), self.followed(tolerance)
        shared = min(len(worse.state.times), len(better.state.times))
        late, near = compared(better.passage.events, worse.passage.events, better.state.times[:shared],
                              self.task.accuracy * self.reporter.time_scale)  # fmt: skip
        kept = np.flatnonzero(~near)
        loose = self.reporter.report(worse.state.first(shared).at(kept))
        tight = self.reporter.report(better.state.first(shared).at(kept))
        errors = self.reporter.errors(tight, loose)
        estimate = self.reporter.relative(errors)
        if self.stepper.switching:
            errors["event times"] = late
            estimate = max(estimate, late / self.reporter.time_scale)
        return replace(better, errors=errors, estimate=estimate, excluded=int(near.sum()))

    def followed(self, tolerance: float, longest: float = LONGEST_STEP) -> Followed:
        """One run, its steps at most so many time scales long."""
        self.runs += 1
        passage = self.stepper.stepped(tolerance, longest)
        every = self.stepper.state(passage.rows)
        kept, ended, detail = len(every.times), None, ""
        outside = self.reporter.first_outside(every.poses)
        reached = f"t = {self.stepper.grid.stations[kept - 1]:.6g} s"
        if outside is not None:
            kept, ended = outside[0], Outcome.LEFT_RANGE
            detail = f"{outside[1]}, at {self._leaving(passage.rows, tolerance, kept)}"
        elif passage.code == STALLED:
            ended, detail = Outcome.STALLED, f"at {reached}"
        elif passage.code != DONE or len(self.stepper.grid.reported) < len(self.task.times):
            ended, detail = Outcome.STEP_LIMIT, f"max_steps = {self.engine.max_steps} end at {reached}"
        state = every.at(self.stepper.grid.first(kept).reported)
        report = self.reporter.report(state)
        return Followed(state, every.first(kept), passage, tolerance, report, ended, detail, {})

    def _leaving(self, rows: FloatArray, tolerance: float, station: int) -> str:
        """When the motion leaves its range, before this station: by halving the time from the one before."""
        times = self.stepper.grid.stations
        if station == 0 or self.stepper.stiff_from < np.inf or self.stepper.switching:
            return f"about t = {times[station]:.6g} s"
        inside, outside = float(times[station - 1]), float(times[station])
        for _ in range(HALVINGS):
            middle = 0.5 * (inside + outside)
            there = self.stepper.between(rows, tolerance, station - 1, middle)
            if there is None:
                return f"about t = {outside:.6g} s"
            if self.reporter.first_outside(there[0][np.newaxis]) is None:
                inside = middle
            else:
                outside = middle
        return f"t = {outside:.9g} s"

    def trajectory(self, best: Followed, wall_time: float) -> Trajectory:
        """The result."""
        settings = {**asdict(self.engine), "asked_accuracy": self.task.accuracy, "certified": best.estimate is not None}
        return self.reporter.trajectory(
            Finding(
                state=best.state,
                stations=best.stations,
                report=best.report,
                outcome=outcome_of(best, self.task.accuracy),
                detail=best.detail,
                estimate=best.estimate,
                errors=best.errors,
                between=self._between(best),
                modes=best.passage.modes[: len(best.stations.times)],
                reported=self.stepper.grid.first(len(best.stations.times)).reported,
                happened=tuple(
                    one
                    for one in best.passage.events
                    if not len(best.stations.times) or one.time <= best.stations.times[-1]
                ),
                excluded=best.excluded,
            ),
            cost=self._cost(best, wall_time),
            settings=settings,
        )

    def _between(self, best: Followed) -> Between | None:
        if self.stepper.stiff_from < np.inf or self.stepper.switching:
            return None
        return partial(self.stepper.between, best.passage.rows, best.tolerance)

    def _cost(self, best: Followed, wall_time: float) -> Cost:
        steps, rejected, evaluations, _ = (int(count) for count in self.stepper.counts)
        laws = Counter({"equations of motion": evaluations})
        system = self.stepper.system
        bodies = len(system.bodies)
        if system.gravity:
            laws["gravity"] = bodies * evaluations
        if system.centrifugal:
            laws["centrifugal"] = bodies * evaluations
        if self.scene.part.mechanism.loads:
            laws["springs, dampers, forces"] = len(self.scene.part.mechanism.loads) * evaluations
        kinds = {"springs on readings": SpringOn, "oil brakes": OilBrake, "dry friction": DryFriction}
        for (law, kind), count in zip(kinds.items(), self.stepper.acts.tolist(), strict=True):
            if any(isinstance(effect, kind) for effect in self.scene.acting):
                laws[law] = count
        return Cost(
            engine=self.engine.name,
            reason=self.task.reason,
            step=best.passage.step,
            steps=steps + self.stepper.implicit_steps,
            rejected=rejected,
            runs=self.runs,
            evaluations=dict(laws),
            wall_time=wall_time,
            events=len(best.passage.events),
            assembled=assembled(self.scene),
            method=self._method(),
        )

    def _method(self) -> str:
        if self.stepper.stiff_from == np.inf:
            return "explicit (DOP853)"
        return f"stiff from t = {self.stepper.stiff_from:.4g} s: implicit (Radau) in independent coordinates from there"
