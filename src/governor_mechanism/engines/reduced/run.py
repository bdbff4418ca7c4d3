"""One scene ridden along its way, through its reported times, at a tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.multibody.contact import AT_ONCE
from governor_mechanism.engines.reduced.integration import ABOVE, BELOW, DONE, advance, resume
from governor_mechanism.integrators.reduced_dop853 import make_stages
from governor_mechanism.mechanics.contact.event_log import without_passing
from governor_mechanism.mechanics.dynamics.characteristic_scales import pace
from governor_mechanism.mechanics.dynamics.contacts import Mode, keepers_of, springs_of
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.mechanics.reduction.equation_of_motion import FLOWS, make_line
from governor_mechanism.mechanics.reduction.lowering import SPINDLE_INERTIA
from governor_mechanism.mechanics.reduction.motion_table import Way
from governor_mechanism.model.events import LEAVES, PULLS, RESTS, SLACKENS, SLIPS, STICKS, STRIKES, Event
from governor_mechanism.model.state_history import State
from governor_mechanism.observables.evaluation import Reporter
from governor_mechanism.types import FloatArray, IntArray

LONGEST_STEP = 2.5
"""In the scene's pace: no step is longer, whatever the tolerance."""

WATCHED = 0.2
"""Of that where something is watched, which is looked at five times a step."""

FIRST_STEP = 0.004
"""Of the longest one."""

NEARER, AT_END = 0.25, 1e-12
"""A step that leads beyond the way is taken again so much shorter, down to this part of what is left."""

NO_WAY = 1e-14
"""Of the coordinate's unit, and of itself: nearer to the way's end than this, rounding alone is left of it."""

KINDS = (STRIKES, STICKS, SLIPS, RESTS, LEAVES, SLACKENS, PULLS)
"""As `happening` numbers them."""

FEW_STEPS = 100
"""From one station to a time before the next one it takes a handful."""

EVENTS = 4096
"""So many events have room at first."""

LEFT = 100
"""How a ride ended: where the way does."""


@dataclass(frozen=True)
class Ridden:
    """Coordinate, rate and flows (n, 2 + FLOWS) at the times reached, the modes there, events; how it ended, when (s)
    and on which side; the last step (s).
    """

    rows: FloatArray
    modes: IntArray
    events: tuple[Event, ...]
    code: int
    ended: float
    side: int
    step: float


class Rider:
    """Rides one scene through times (n,) s from coordinate and rate `start`, along a way."""

    def __init__(self, way: Way, reporter: Reporter, start: tuple[float, float], times: FloatArray, most: int) -> None:
        self.way, self.reporter, self.times, self.most = way, reporter, times, most
        self.start, self.counts = start, np.zeros(4, dtype=np.int64)
        scene = way.scene
        self.keepers = keepers_of(scene)
        self.slack = [spring for spring in springs_of(scene) if spring.one_sided]
        self.switching = bool(self.keepers or self.slack)
        breaks = np.unique(np.concatenate([curve.breaks for curve in way.curves]))
        end = float(times[-1]) if len(times) else 0.0
        self._knots = np.concatenate([[0.0], breaks[(breaks > 0) & (breaks < end)], [end]])
        self._momentum = 0.0
        if way.free:
            own = reporter.inertia(way.places(np.array([start[0]]))[0])[0] + way.acts.numbers[SPINDLE_INERTIA]
            self._momentum = own * reporter.program.start_speed

    def ridden(self, tolerance: float, longest: float = LONGEST_STEP) -> Ridden:
        """Through all times; longest: of a step, in the scene's pace."""
        room = EVENTS if self.switching else 0
        while True:
            found, told = self._ridden(tolerance, longest, room)
            if told <= room:
                return found
            room = 2 * told

    def _ridden(self, tolerance: float, longest: float, room: int) -> tuple[Ridden, int]:
        way, second = self.way, self.reporter.time_scale
        longest *= pace(way.scene) * (WATCHED if self.switching else 1.0)
        state = np.array([*self.start, *(0.0,) * FLOWS])
        found, modes = np.empty((len(self.times), 2 + FLOWS)), self._no_modes()
        mode, stages = np.zeros(modes.shape[1], dtype=np.int64), make_stages()
        events, told = np.empty((room, 3)), np.zeros(2, dtype=np.int64)
        counts = np.zeros_like(self.counts)
        if self.switching:
            resume(make_line(way.laid, way.acts, self.cubics(0.0), mode), 0.0, state, events, told)
            told[:] = 0
        filled, step, code = int(len(self.times) > 0 and self.times[0] == 0.0), FIRST_STEP * longest, DONE
        now, side = 0.0, 0
        found[:filled], modes[:filled] = state, mode
        for start, end in pairwise(self._knots.tolist()):
            now = start
            while now < end:
                limits = (tolerance, step, longest, self.most)
                last = int(np.searchsorted(self.times, end, side="right"))
                line = make_line(way.laid, way.acts, self.cubics(now), mode)
                code, step, reached, now = advance(
                    line, (now, end), self.times[filled:last], state, limits, stages, found[filled:], modes[filled:],
                    events, told, counts,
                )  # fmt: skip
                filled += reached
                if code not in (BELOW, ABOVE):
                    break
                side = code - BELOW
                if not way.extended(side):
                    step *= NEARER
                    left = abs(way.end(side) - state[0])
                    no_way = NO_WAY * max(way.plan.unit, abs(state[0]))
                    if step < AT_END * max(second, end - now) or left < no_way:
                        now += max((way.end(side) - state[0]) / state[1], 0.0) if state[1] else 0.0
                        code = LEFT
                        break
            if code != DONE:
                break
            at_knot = filled - 1 if filled and self.times[filled - 1] == end else None
            self._pass_knot(end, state, found, at_knot)
            if self.switching:
                resume(make_line(way.laid, way.acts, self.cubics(end), mode), end, state, events, told)
        self.counts += counts
        happened = self._events(events[: min(told[0], room)])
        return Ridden(found[:filled], modes[:filled], happened, code, now, side, step), int(told[0])

    def between(self, rows: FloatArray, tolerance: float, k: int, time: float) -> tuple[FloatArray, FloatArray] | None:
        """Poses and velocities (bodies, 3) at a time (s) after that of row k, ridden from there, or None."""
        begin, mode = float(self.times[k]), np.zeros(1, dtype=np.int64)
        state, nothing = rows[k].copy(), np.zeros((0, 1), dtype=np.int64)
        second = self.reporter.time_scale
        code, *_ = advance(
            make_line(self.way.laid, self.way.acts, self.cubics(begin), mode), (begin, time), np.empty(0), state,
            (tolerance, 0.01 * second, LONGEST_STEP * second, FEW_STEPS), make_stages(), np.empty((0, 2 + FLOWS)),
            nothing, np.empty((0, 3)), np.zeros(2, dtype=np.int64), np.zeros(4, dtype=np.int64),
        )  # fmt: skip
        if code != DONE:
            return None
        poses, ahead = self.way.places(state[:1])
        return poses[0], ahead[0] * state[1]

    def cubics(self, start: float) -> FloatArray:
        """Speed or torque, loads and frictions in time (programs, 5), until the next break; of a torque the integral
        counts from the momentum at the start.
        """
        found = np.array([curve.cubics_from(np.array([start]))[0] for curve in self.way.curves])
        found[0, 4] += self._momentum
        return found

    def state(self, ridden: Ridden) -> State:
        """What the rows say of mass centres and spindle."""
        times, rows = self.times[: len(ridden.rows)], ridden.rows
        poses, ahead = self.way.places(rows[:, 0])
        speeds = self.reporter.spindle_speeds(times, poses)
        plain = self.way.plan.plain
        angle = speeds * times if plain else rows[:, 4]
        work, lost = (np.zeros(len(times)),) * 2 if plain else (rows[:, 2], rows[:, 3])
        return State(
            times=times,
            poses=poses,
            velocities=ahead * rows[:, 1, np.newaxis, np.newaxis],
            work=work,
            lost=lost,
            spindle=np.stack([angle, speeds], axis=-1),
        )

    def modes(self, ridden: Ridden, poses: FloatArray) -> tuple[Mode, ...]:
        """How everything that may be held stood at each time, where there is anything."""
        if not self.switching:
            return ()
        mechanism, many = self.way.scene.part.mechanism, len(self.keepers)
        values = [reading_value(mechanism, keeper.reading, poses) for keeper in self.keepers]
        found = []
        for at, row in enumerate(ridden.modes.tolist()):
            held: list[float | None] = [None] * many
            if row[0]:
                holding = [k for k, keeper in enumerate(self.keepers)
                           if keeper.friction is not None or not keeper.low < values[k][at] < keeper.high]  # fmt: skip
                held[(holding or [0])[0]] = float(values[(holding or [0])[0]][at])
            found.append(Mode(tuple(held), tuple(row[1 : 1 + many]), tuple(map(bool, row[1 + many :])), bool(row[0])))
        return tuple(found)

    def _no_modes(self) -> IntArray:
        return np.zeros((len(self.times), 1 + len(self.keepers) + len(self.slack)), dtype=np.int64)

    def _events(self, rows: FloatArray) -> tuple[Event, ...]:
        subjects = [keeper.reading for keeper in self.keepers], [spring.reading for spring in self.slack]
        told = [
            Event(time=time, kind=KINDS[int(kind)], subject=subjects[KINDS[int(kind)] in (SLACKENS, PULLS)][int(whom)])
            for time, kind, whom in rows.tolist()
        ]
        return without_passing(told, AT_ONCE * self.reporter.time_scale)

    def _pass_knot(self, when: float, state: FloatArray, found: FloatArray, at: int | None) -> None:
        """Count the work that a jump of the given speed puts into the parts; a time there is the one after it."""
        program = self.reporter.program
        if program.constant:
            return
        before, after = (float(program(np.array([when]), before=side)[0]) for side in (True, False))
        if after == before or self.way.free or not self.way.plan.centrifugal:
            return
        inertia = self.reporter.inertia(self.way.places(state[:1])[0])[0]
        state[2] += 0.5 * inertia * (after**2 - before**2)
        if at is not None:
            found[at, 2] = state[2]
