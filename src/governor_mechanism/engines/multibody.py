"""The multibody engine: bodies and joints, index-reduced and projected, stepped by DOP853 in compiled code."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects import Centrifugal, Effect, Gravity
from governor_mechanism.engines.base import Engine, Task
from governor_mechanism.engines.dop853 import COUNTS, DONE, STALLED, integrate
from governor_mechanism.engines.grid import make_grid
from governor_mechanism.engines.report import Report, Reporter, State
from governor_mechanism.equations.motion import inertia_about_spindle, project
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.system import from_centres, make_system, make_workspace, to_centres
from governor_mechanism.errors import MechanismError
from governor_mechanism.joints import Distance, Joint, Pin, Slider
from governor_mechanism.scene import Scene
from governor_mechanism.statics import starting_state
from governor_mechanism.trajectory import Cost, Outcome, Trajectory

LONGEST_STATION = 0.25
"""In time scales: how far apart the poses are at which limits are watched."""

MARGIN = 100.0
"""How much tighter than the accuracy a step is held: the estimate is the error of a run ten times looser."""

LOOSER = 10.0
"""How much looser the second run of a certificate is."""

TIGHTEST = 1e-15
"""Below this no tolerance is tried: double precision ends."""

CLOSED = 1e-14
"""Fraction of the machine's size to which joints are closed at every step."""


@final
@dataclass(frozen=True, kw_only=True)
class MultibodyEngine(Engine):
    """Order 8 with error control, joints closed to rounding at every step; the reference.

    tolerance is the error of one step, chosen from the accuracy where it is left out. max_steps bounds one run.
    The error estimate is the difference from a run ten times looser.
    """

    name: ClassVar[str] = "multibody"
    effects: ClassVar[frozenset[type[Effect]]] = frozenset({Gravity, Centrifugal})
    joints: ClassVar[frozenset[type[Joint]]] = frozenset({Distance, Pin, Slider})

    tolerance: float | None = None
    max_steps: int = 1_000_000

    def __post_init__(self) -> None:
        if self.tolerance is not None and not TIGHTEST <= self.tolerance < 1:
            raise MechanismError(
                f"MultibodyEngine.tolerance must lie between {TIGHTEST:g} and 1; got {self.tolerance!r}"
            )
        if self.max_steps < 1:
            raise MechanismError(f"MultibodyEngine.max_steps must be at least 1; got {self.max_steps!r}")

    def _run(self, scene: Scene, task: Task) -> Trajectory:
        started = time.perf_counter()
        follower = Follower(self, scene, task)
        tolerance = self.tolerance or max(task.accuracy / MARGIN, TIGHTEST)
        best = follower.certified(tolerance) if task.certify else follower.followed(tolerance)
        while task.certify and self.tolerance is None and best.estimate is not None and best.estimate > task.accuracy:
            tolerance *= max(0.5 * task.accuracy / best.estimate, 1e-3)
            if tolerance < TIGHTEST:
                break
            better = follower.certified(tolerance)
            if better.estimate is None or better.estimate >= best.estimate:
                break  # rounding, not the step, sets the error now
            best = better
        return follower.trajectory(best, time.perf_counter() - started)


@dataclass(frozen=True)
class Followed:
    """States at the reported times, what they say, and why there are no more."""

    state: State
    report: Report
    ended: Outcome | None
    detail: str
    step: float
    errors: dict[str, float]
    estimate: float | None = None


class Follower:
    """Follows one scene at given tolerances."""

    def __init__(self, engine: MultibodyEngine, scene: Scene, task: Task) -> None:
        self.engine, self.scene, self.task = engine, scene, task
        self.reporter = Reporter(scene)
        self.system = make_system(scene)
        self.room = make_workspace(self.system)
        poses, velocities = from_centres(self.system, *starting_state(scene))
        project(self.system, self.room, poses, velocities, CLOSED * self.reporter.mechanism.size)
        self.start = np.concatenate([poses.ravel(), velocities.ravel(), [0.0]])
        breaks, longest = self.reporter.program.breaks, LONGEST_STATION * self.reporter.time_scale
        times = task.times[task.times <= longest * engine.max_steps]
        self.grid = make_grid(times, breaks, np.inf, longest)
        inner = breaks[(breaks > 0) & (breaks < self.grid.stations[-1])]
        self.knots = np.concatenate([[0.0], inner, self.grid.stations[-1:]])
        self.counts = np.zeros(COUNTS, dtype=np.int64)
        self.runs = 0

    def certified(self, tolerance: float) -> Followed:
        """Two runs, and the difference between them as the estimate of the better one's error."""
        worse, better = self.followed(LOOSER * tolerance), self.followed(tolerance)
        shared = min(len(worse.state.times), len(better.state.times))
        loose = self.reporter.report(_first(worse.state, shared))
        tight = self.reporter.report(_first(better.state, shared))
        errors = self.reporter.errors(tight, loose)
        estimate = self.reporter.relative(errors)
        return Followed(better.state, better.report, better.ended, better.detail, better.step, errors, estimate)

    def followed(self, tolerance: float) -> Followed:
        """One run."""
        self.runs += 1
        states, code, step = self._integrate(tolerance)
        count = len(self.system.mass)
        poses, velocities = (
            states[:, part * 3 * count : (part + 1) * 3 * count].reshape(-1, count, 3) for part in range(2)
        )
        poses, velocities = to_centres(self.system, poses, velocities)
        kept, ended, detail = len(poses), None, ""
        outside = self.reporter.first_outside(poses)
        if outside is not None:
            kept, ended = outside[0], Outcome.LEFT_RANGE
            detail = f"{outside[1]}, at about t = {self.grid.stations[kept]:.6g} s"
        elif code == STALLED:
            ended, detail = Outcome.STALLED, f"at t = {self.grid.stations[kept - 1]:.6g} s"
        elif code != DONE or len(self.grid.reported) < len(self.task.times):
            ended = Outcome.STEP_LIMIT
            detail = f"max_steps = {self.engine.max_steps} end at t = {self.grid.stations[kept - 1]:.6g} s"
        at = self.grid.first(kept).reported
        state = State(times=self.grid.stations[at], poses=poses[at], velocities=velocities[at], work=states[at, -1])
        return Followed(state, self.reporter.report(state), ended, detail, step, {})

    def trajectory(self, best: Followed, wall_time: float) -> Trajectory:
        """The result."""
        report, outcome = best.report, best.ended
        if outcome is None and best.estimate is None:
            outcome = Outcome.UNCERTIFIED
        if outcome is None:
            reached = best.estimate is not None and best.estimate <= self.task.accuracy
            outcome = Outcome.DONE if reached else Outcome.ACCURACY_MISSED
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
            outcome=outcome,
            detail=best.detail,
            cost=self._cost(best, wall_time),
            error_estimate=best.estimate,
            reading_errors=best.errors,
            settings={
                **asdict(self.engine),
                "asked_accuracy": self.task.accuracy,
                "certified": best.estimate is not None,
            },
        )

    def _integrate(self, tolerance: float) -> tuple[Array, int, float]:
        """States (stations reached, numbers), how the integration ended, and the last step (s)."""
        stations, state = self.grid.stations, self.start.copy()
        found = np.empty((len(stations), state.size))
        found[0], filled, code = state, 1, DONE
        step = 0.01 * self.reporter.time_scale
        counts = np.zeros(COUNTS, dtype=np.int64)
        for start, end in pairwise(self.knots):
            times = stations[(stations > start) & (stations <= end)]
            code, step, reached = integrate(
                self.system,
                self.room,
                self.reporter.program.cubic_from(start),
                (float(start), float(end)),
                times,
                state,
                self._scale(),
                tolerance,
                step,
                CLOSED * self.reporter.mechanism.size,
                self.engine.max_steps,
                found[filled:],
                counts,
            )
            filled += reached
            if code != DONE:
                break
            state[-1] += self._work_of_jump(end, state)
            found[filled - 1, -1] = state[-1]  # a knot is a station; there the speed is the one after the jump
        self.counts += counts
        return found[:filled], code, step

    def _work_of_jump(self, when: float, state: Array) -> float:
        """What a jump of the spindle's speed puts into the parts (J)."""
        program, count = self.reporter.program, len(self.system.mass)
        before, after = (float(program(np.array([when]), before=side)[0]) for side in (True, False))
        if after == before or not self.scene.centrifugal:
            return 0.0
        inertia = inertia_about_spindle(self.system, state[: 3 * count].reshape(count, 3))
        return 0.5 * inertia * (after**2 - before**2)

    def _scale(self) -> Array:
        size, second = self.reporter.mechanism.size, self.reporter.time_scale
        pose = np.tile([size, size, 1.0], len(self.system.mass))
        return np.concatenate([pose, pose / second, [self.reporter.energy_scale]])

    def _cost(self, best: Followed, wall_time: float) -> Cost:
        steps, rejected, evaluations, _ = (int(count) for count in self.counts)
        laws = Counter({"equations of motion": evaluations})
        bodies = len(self.system.mass)
        if self.scene.gravity:
            laws["gravity"] = bodies * evaluations
        if self.scene.centrifugal:
            laws["centrifugal"] = bodies * evaluations
        return Cost(
            engine=self.engine.name,
            reason=self.task.reason,
            step=best.step,
            steps=steps,
            rejected=rejected,
            runs=self.runs,
            evaluations=dict(laws),
            wall_time=wall_time,
        )


def _first(state: State, count: int) -> State:
    return State(
        times=state.times[:count],
        poses=state.poses[:count],
        velocities=state.velocities[:count],
        work=state.work[:count],
    )
