"""One scene stepped through its stations at given tolerances, explicitly, and implicitly from where it gets stiff."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.multibody.contact import AT_ONCE, Switching
from governor_mechanism.engines.multibody.event_integration import Crossing
from governor_mechanism.integrators.projected_dop853 import COUNTS, DONE, STIFF, integrate
from governor_mechanism.integrators.radau import Implicit
from governor_mechanism.integrators.time_grid import make_grid
from governor_mechanism.mechanics.contact.event_log import without_passing
from governor_mechanism.mechanics.dynamics.characteristic_scales import pace
from governor_mechanism.mechanics.dynamics.contacts import Mode, switches
from governor_mechanism.mechanics.dynamics.equations_of_motion import EXTRA, inertia_about_spindle, project
from governor_mechanism.mechanics.dynamics.lowering import (
    acts_of,
    from_centres,
    make_system,
    make_workspace,
    to_centres,
)
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.observables.evaluation import Reporter
from governor_mechanism.types import FloatArray, IntArray

LONGEST_STATION = 0.25
"""In time scales: how far apart the poses are at which limits are watched."""

LONGEST_STEP = 2.5
"""In the scene's pace: no step is longer, whatever the tolerance."""

FIRST_STEP = 0.004
"""Of the longest one."""

FEW_STEPS = 100
"""From one station to an event before the next one it takes a handful, but into a change point no end of them."""

CLOSED = 1e-14
"""Fraction of the machine's size to which joints are closed at every step."""


@dataclass(frozen=True)
class Passage:
    """States (stations reached, numbers), how the integration ended, the last step (s); where something sticks, strikes
    or goes slack, the mode at each station and the events.
    """

    rows: FloatArray
    code: int
    step: float
    modes: tuple[Mode, ...] = ()
    events: tuple[Event, ...] = ()


class Stepper:
    """Steps a scene that starts at poses and velocities `standing`, to stations that include the reported times."""

    def __init__(
        self,
        scene: Scene,
        reporter: Reporter,
        standing: tuple[FloatArray, FloatArray],
        times: FloatArray,
        max_steps: int,
    ) -> None:
        self.reporter, self.max_steps = reporter, max_steps
        self.system, self.curves = make_system(scene)
        self.room = make_workspace(self.system)
        self.closed = CLOSED * reporter.mechanism.size
        breaks = np.unique(np.concatenate([curve.breaks for curve in self.curves]))
        self._pace = pace(scene)
        longest = LONGEST_STATION * reporter.time_scale
        self.grid = make_grid(times[times <= longest * max_steps], breaks, np.inf, longest)
        inner = breaks[(breaks > 0) & (breaks < self.grid.stations[-1])]
        self.knots = np.concatenate([[0.0], inner, self.grid.stations[-1:]])
        self.counts = np.zeros(COUNTS, dtype=np.int64)
        self.implicit_steps, self.stiff_from = 0, np.inf
        self.acts = np.zeros(3, dtype=np.int64)
        """Evaluations of springs, brakes and sliding friction along readings."""
        self.start = self._start(*from_centres(self.system, *standing))
        self.switching = Switching(scene, reporter.time_scale, self.closed) if switches(scene) else None

    def compile(self) -> None:
        """Have the kernels compiled or loaded, by an integration over no time, so that no run's cost includes it."""
        none = np.empty((0, self.start.size))
        self._explicit(
            (0.0, 0.0), np.empty(0), self.start.copy(), 1.0, 1.0, 1.0, none, np.zeros(COUNTS, dtype=np.int64)
        )

    def stepped(self, tolerance: float, longest: float = LONGEST_STEP) -> Passage:
        """From the start through all stations; longest: of a step, in the scene's pace."""
        if self.switching is not None:
            return self._switched(self.switching, tolerance, longest)
        stations, state = self.grid.stations, self.start.copy()
        found = np.empty((len(stations), state.size))
        found[0], filled, code = state, 1, DONE
        seconds = longest * self._pace
        step = FIRST_STEP * seconds
        counts = np.zeros(COUNTS, dtype=np.int64)
        implicit: Implicit | None = None
        for start, end in pairwise(self.knots.tolist()):
            times, now = stations[(stations > start) & (stations <= end)], start
            if implicit is None:
                code, step, reached, now = self._explicit(
                    (start, end), times, state, tolerance, step, seconds, found[filled:], counts
                )
                filled += reached
                times = times[reached:]
            if code == STIFF:
                implicit = Implicit(self.system, self.room, self.scale(), self.closed)
                self.stiff_from, code = min(self.stiff_from, now), DONE
            if implicit is not None:
                cubics, most = self.cubics(start), self.max_steps
                code, step, reached = implicit.integrate(
                    cubics, (now, end), start, times, state, tolerance, most, found[filled:]
                )
                filled += reached
            if code != DONE:
                break
            self._pass_knot(end, state, found[filled - 1])
        if implicit is not None:
            self.implicit_steps += implicit.steps
            counts[2] += implicit.evaluations
        self.counts += counts
        self.acts += int(counts[2]) * acts_of(self.system)
        return Passage(found[:filled], code, step)

    def _switched(self, switching: Switching, tolerance: float, longest: float) -> Passage:
        """The same for a scene in which something sticks, strikes or goes slack."""
        stations, state, second = self.grid.stations, self.start.copy(), self.reporter.time_scale
        counts = np.zeros(COUNTS, dtype=np.int64)
        crossing = Crossing(self, switching, tolerance, second, longest, counts)
        switching.begin(state, self.cubics(0.0))
        found, modes = np.empty((len(stations), state.size)), [switching.mode]
        found[0], filled, code, step = state, 1, DONE, FIRST_STEP * longest * second
        for start, end in pairwise(self.knots.tolist()):
            times = stations[(stations > start) & (stations <= end)]
            code, step, reached = crossing.piece((start, end), times, state, step, found[filled:], modes)
            filled += reached
            if code != DONE:
                break
            self._pass_knot(end, state, found[filled - 1])
            crossing.resume(end, state)
        self.counts += counts
        self.acts += crossing.acts
        return Passage(found[:filled], code, step, tuple(modes), without_passing(switching.events, AT_ONCE * second))

    def _pass_knot(self, when: float, state: FloatArray, station: FloatArray) -> None:
        """Count the work of a jump of the speed; a knot is a station, and there the speed is the one after the jump."""
        state[-EXTRA] += self._work_of_jump(when, state)
        station[-EXTRA] = state[-EXTRA]

    def _explicit(
        self,
        span: tuple[float, float],
        times: FloatArray,
        state: FloatArray,
        tolerance: float,
        step: float,
        longest: float,
        found: FloatArray,
        counts: IntArray,
    ) -> tuple[int, float, int, float]:
        """`dop853.integrate` of a scene in which nothing is watched; longest in s."""
        return integrate(self.system, self.room, self.cubics(span[0]), span, times, state, self.scale(), tolerance,
                         step, longest, self.closed, self.max_steps, found, counts, np.empty(2))  # fmt: skip

    def state(self, states: FloatArray) -> State:
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
        work, lost = states[:, -EXTRA], states[:, 1 - EXTRA]
        return State(times=times, poses=poses, velocities=velocities, work=work, lost=lost, spindle=spindle)

    def outside(self, state: FloatArray) -> bool:
        """Whether a state lies outside the mechanism's limits."""
        origins, moving = state[:-EXTRA].reshape(2, len(self.system.bodies), 3)
        return self.reporter.first_outside(to_centres(self.system, origins, moving)[0][np.newaxis]) is not None

    def between(self, rows: FloatArray, tolerance: float, k: int, time: float) -> tuple[FloatArray, FloatArray] | None:
        """Poses and velocities of mass centres at a time (s) after station k, integrated from there, or None."""
        start = float(self.grid.stations[k])
        state, counts = rows[k].copy(), np.zeros(COUNTS, dtype=np.int64)
        step, none = 0.01 * self.reporter.time_scale, np.empty((0, rows.shape[1]))
        code, *_ = integrate(self.system, self.room, self.cubics(start), (start, time), np.empty(0), state,
                             self.scale(), tolerance, step, np.inf, self.closed, FEW_STEPS, none, counts,
                             np.empty(2))  # fmt: skip
        if code != DONE:
            return None
        origins, moving = state[:-EXTRA].reshape(2, len(self.system.bodies), 3)
        return to_centres(self.system, origins, moving)

    def _start(self, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """The state at the start, its joints closed to rounding."""
        project(self.system, self.room, self.cubics(0.0), 0.0, poses, velocities, self.closed)
        speed = self.reporter.program.start_speed
        momentum = (self.system.spindle_inertia + inertia_about_spindle(self.system, poses)) * speed
        extra = [0.0, 0.0, 0.0, momentum if self.system.free else 0.0]
        return np.concatenate([poses.ravel(), velocities.ravel(), extra])

    def cubics(self, start: float) -> FloatArray:
        """Speed, drives and loads in time, (programs, 4), until the next break."""
        return np.array([curve.cubics_from(np.array([start]))[0] for curve in self.curves])

    def _work_of_jump(self, when: float, state: FloatArray) -> float:
        """What a jump of the spindle's given speed puts into the parts (J)."""
        program, count = self.reporter.program, len(self.system.bodies)
        before, after = (float(program(np.array([when]), before=side)[0]) for side in (True, False))
        if after == before or not self.system.centrifugal:
            return 0.0
        inertia = inertia_about_spindle(self.system, state[: 3 * count].reshape(count, 3))
        return 0.5 * inertia * (after**2 - before**2)

    def scale(self) -> FloatArray:
        """What errors of a state are relative to."""
        size, second = self.reporter.mechanism.size, self.reporter.time_scale
        pose = np.tile([size, size, 1.0], len(self.system.bodies))
        momentum = abs(self.start[-1]) or 1.0
        return np.concatenate(
            [pose, pose / second, [self.reporter.energy_scale, self.reporter.energy_scale, 1.0, momentum]]
        )
