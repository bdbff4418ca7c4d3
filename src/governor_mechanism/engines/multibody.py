"""The multibody engine: bodies and joints, index-reduced and projected, stepped by DOP853 in compiled code."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import pairwise
from typing import ClassVar, final

import numpy as np

from governor_mechanism.effects import Centrifugal, Effect, Gravity
from governor_mechanism.engines.base import Engine, Task
from governor_mechanism.engines.dop853 import COUNTS, DONE, STALLED, STIFF, integrate
from governor_mechanism.engines.grid import make_grid
from governor_mechanism.engines.independent import Implicit
from governor_mechanism.engines.report import Finding, Report, Reporter
from governor_mechanism.engines.state import State
from governor_mechanism.equations.compiled import announce
from governor_mechanism.equations.motion import EXTRA, inertia_about_spindle, project
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.system import from_centres, make_system, make_workspace, to_centres
from governor_mechanism.errors import MechanismError
from governor_mechanism.joints import ALL_JOINTS, Joint
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

FEW_STEPS = 100
"""From one station to an event before the next one it takes a handful, but into a change point no end of them."""

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
    joints: ClassVar[frozenset[type[Joint]]] = ALL_JOINTS

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
        announce("integrate", 12)
        follower = Follower(self, scene, task)
        follower.compile()
        started = time.perf_counter()
        tolerance = self.tolerance or max(task.accuracy / MARGIN, TIGHTEST)
        best = follower.certified(tolerance) if task.certify else follower.followed(tolerance)
        while task.certify and self.tolerance is None and best.estimate is not None and best.estimate > task.accuracy:
            # Tightened by less, a certificate may come out no better for no reason but the luck of its steps.
            tolerance *= min(max(0.5 * task.accuracy / best.estimate, 1e-3), 1 / LOOSER)
            if tolerance < TIGHTEST:
                break
            better = follower.certified(tolerance)
            if better.estimate is None or better.estimate >= best.estimate:
                break  # rounding, not the step, sets the error now
            best = better
        return follower.trajectory(best, time.perf_counter() - started)


@dataclass(frozen=True)
class Followed:
    """States at the reported times and at all stations, what they say, and why there are no more."""

    state: State
    stations: State
    rows: Array
    tolerance: float
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
        standing = starting_state(scene)
        self.reporter = Reporter(scene, standing[0])
        self.system, self.curves = make_system(scene)
        self.room = make_workspace(self.system)
        self.closed = CLOSED * self.reporter.mechanism.size
        self.breaks = np.unique(np.concatenate([curve.breaks for curve in self.curves]))
        longest = LONGEST_STATION * self.reporter.time_scale
        times = task.times[task.times <= longest * engine.max_steps]
        self.grid = make_grid(times, self.breaks, np.inf, longest)
        inner = self.breaks[(self.breaks > 0) & (self.breaks < self.grid.stations[-1])]
        self.knots = np.concatenate([[0.0], inner, self.grid.stations[-1:]])
        self.counts = np.zeros(COUNTS, dtype=np.int64)
        self.runs, self.implicit_steps, self.stiff_from = 0, 0, np.inf
        self.start = self._start(*from_centres(self.system, *standing))

    def compile(self) -> None:
        """Have the kernels compiled or loaded, by an integration over no time, so that no run's cost includes it."""
        state, none = self.start.copy(), np.empty(0)
        found, counts = np.empty((0, state.size)), np.zeros(COUNTS, dtype=np.int64)
        integrate(self.system, self.room, self._cubics(0.0), (0.0, 0.0), none, state, self._scale(), 1.0, 1.0, 1.0, 1,
                  found, counts)  # fmt: skip

    def certified(self, tolerance: float) -> Followed:
        """Two runs, and the difference between them as the estimate of the better one's error."""
        worse, better = self.followed(LOOSER * tolerance), self.followed(tolerance)
        shared = min(len(worse.state.times), len(better.state.times))
        loose = self.reporter.report(worse.state.first(shared))
        tight = self.reporter.report(better.state.first(shared))
        errors = self.reporter.errors(tight, loose)
        return replace(better, errors=errors, estimate=self.reporter.relative(errors))

    def followed(self, tolerance: float) -> Followed:
        """One run."""
        self.runs += 1
        states, code, step = self.stepped(tolerance)
        every = self._state(states)
        kept, ended, detail = len(every.times), None, ""
        outside = self.reporter.first_outside(every.poses)
        if outside is not None:
            kept, ended = outside[0], Outcome.LEFT_RANGE
            detail = f"{outside[1]}, at about t = {self.grid.stations[kept]:.6g} s"
        elif code == STALLED:
            ended, detail = Outcome.STALLED, f"at t = {self.grid.stations[kept - 1]:.6g} s"
        elif code != DONE or len(self.grid.reported) < len(self.task.times):
            ended = Outcome.STEP_LIMIT
            detail = f"max_steps = {self.engine.max_steps} end at t = {self.grid.stations[kept - 1]:.6g} s"
        state = every.at(self.grid.first(kept).reported)
        report = self.reporter.report(state)
        return Followed(state, every.first(kept), states, tolerance, report, ended, detail, step, {})

    def trajectory(self, best: Followed, wall_time: float) -> Trajectory:
        """The result."""
        outcome = best.ended
        if outcome is None and best.estimate is None:
            outcome = Outcome.UNCERTIFIED
        if outcome is None:
            reached = best.estimate is not None and best.estimate <= self.task.accuracy
            outcome = Outcome.DONE if reached else Outcome.ACCURACY_MISSED
        settings = {
            **asdict(self.engine),
            "asked_accuracy": self.task.accuracy,
            "certified": best.estimate is not None,
        }
        return self.reporter.trajectory(
            Finding(
                state=best.state,
                stations=best.stations,
                report=best.report,
                outcome=outcome,
                detail=best.detail,
                estimate=best.estimate,
                errors=best.errors,
                between=partial(self._between, best) if self.stiff_from == np.inf else None,
            ),
            cost=self._cost(best, wall_time),
            settings=settings,
        )

    def _start(self, poses: Array, velocities: Array) -> Array:
        """The state at the start, its joints closed to rounding."""
        project(self.system, self.room, self._cubics(0.0), 0.0, poses, velocities, self.closed)
        speed = self.reporter.program.start_speed
        momentum = (self.system.spindle_inertia + inertia_about_spindle(self.system, poses)) * speed
        extra = [0.0, 0.0, momentum if self.system.free else 0.0]
        return np.concatenate([poses.ravel(), velocities.ravel(), extra])

    def _between(self, best: Followed, k: int, time: float) -> tuple[Array, Array] | None:
        """Poses and velocities of mass centres at a time (s) after station k, integrated from there, or None."""
        start = float(self.grid.stations[k])
        state, counts = best.rows[k].copy(), np.zeros(COUNTS, dtype=np.int64)
        step, none = 0.01 * self.reporter.time_scale, np.empty((0, best.rows.shape[1]))
        code, *_ = integrate(self.system, self.room, self._cubics(start), (start, time), np.empty(0), state,
                             self._scale(), best.tolerance, step, self.closed, FEW_STEPS, none, counts)  # fmt: skip
        if code != DONE:
            return None
        origins, moving = state[:-EXTRA].reshape(2, len(self.system.bodies), 3)
        return to_centres(self.system, origins, moving)

    def _cubics(self, start: float) -> Array:
        """Speed, drives and loads in time, (programs, 4), until the next break."""
        return np.array([curve.cubics_from(np.array([start]))[0] for curve in self.curves])

    def _state(self, states: Array) -> State:
        """What the rows (stations, numbers) say of mass centres and spindle."""
        bodies = len(self.system.bodies)
        parts = (states[:, : 3 * bodies], states[:, 3 * bodies : 6 * bodies])
        origins, moving = (part.reshape(-1, bodies, 3) for part in parts)
        poses, velocities = to_centres(self.system, origins, moving)
        times = self.grid.stations[: len(states)]
        speed = self.reporter.program(times)
        if self.system.free:
            own = self.system.spindle_inertia
            speed = states[:, -1] / np.array([own + inertia_about_spindle(self.system, pose) for pose in origins])
        spindle = np.stack([states[:, -2], speed], axis=-1)
        return State(times=times, poses=poses, velocities=velocities, work=states[:, -EXTRA], spindle=spindle)

    def stepped(self, tolerance: float) -> tuple[Array, int, float]:
        """States (stations reached, numbers), how the integration ended, and the last step (s)."""
        stations, state = self.grid.stations, self.start.copy()
        found = np.empty((len(stations), state.size))
        found[0], filled, code = state, 1, DONE
        step, scale = 0.01 * self.reporter.time_scale, self._scale()
        counts = np.zeros(COUNTS, dtype=np.int64)
        implicit: Implicit | None = None
        for start, end in pairwise(self.knots):
            times = stations[(stations > start) & (stations <= end)]
            cubics, now = self._cubics(float(start)), float(start)
            if implicit is None:
                code, step, reached, now = integrate(
                    self.system,
                    self.room,
                    cubics,
                    (float(start), float(end)),
                    times,
                    state,
                    scale,
                    tolerance,
                    step,
                    self.closed,
                    self.engine.max_steps,
                    found[filled:],
                    counts,
                )
                filled += reached
                times = times[reached:]
            if code == STIFF:
                implicit = Implicit(self.system, self.room, scale, self.closed)
                self.stiff_from, code = min(self.stiff_from, now), DONE
            if implicit is not None:
                code, step, reached = implicit.integrate(
                    cubics,
                    (now, float(end)),
                    float(start),
                    times,
                    state,
                    tolerance,
                    self.engine.max_steps,
                    found[filled:],
                )
                filled += reached
            if code != DONE:
                break
            state[-EXTRA] += self._work_of_jump(end, state)
            found[filled - 1, -EXTRA] = state[-EXTRA]  # a knot is a station; there the speed is the one after the jump
        if implicit is not None:
            self.implicit_steps += implicit.steps
            counts[2] += implicit.evaluations
        self.counts += counts
        return found[:filled], code, step

    def _work_of_jump(self, when: float, state: Array) -> float:
        """What a jump of the spindle's given speed puts into the parts (J)."""
        program, count = self.reporter.program, len(self.system.bodies)
        before, after = (float(program(np.array([when]), before=side)[0]) for side in (True, False))
        if after == before or not self.system.centrifugal:
            return 0.0
        inertia = inertia_about_spindle(self.system, state[: 3 * count].reshape(count, 3))
        return 0.5 * inertia * (after**2 - before**2)

    def _scale(self) -> Array:
        size, second = self.reporter.mechanism.size, self.reporter.time_scale
        pose = np.tile([size, size, 1.0], len(self.system.bodies))
        momentum = abs(self.start[-1]) or 1.0
        return np.concatenate([pose, pose / second, [self.reporter.energy_scale, 1.0, momentum]])

    def _cost(self, best: Followed, wall_time: float) -> Cost:
        steps, rejected, evaluations, _ = (int(count) for count in self.counts)
        laws = Counter({"equations of motion": evaluations})
        bodies = len(self.system.bodies)
        if self.system.gravity:
            laws["gravity"] = bodies * evaluations
        if self.system.centrifugal:
            laws["centrifugal"] = bodies * evaluations
        if self.scene.part.mechanism.loads:
            laws["springs, dampers, forces"] = len(self.scene.part.mechanism.loads) * evaluations
        return Cost(
            engine=self.engine.name,
            reason=self.task.reason,
            step=best.step,
            steps=steps + self.implicit_steps,
            rejected=rejected,
            runs=self.runs,
            evaluations=dict(laws),
            wall_time=wall_time,
            method=self._method(),
        )

    def _method(self) -> str:
        if self.stiff_from == np.inf:
            return "explicit (DOP853)"
        return f"stiff from t = {self.stiff_from:.4g} s: implicit (Radau) in independent coordinates from there"
