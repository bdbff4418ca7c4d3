"""What sticks, strikes and goes slack in one scene: in which mode it goes on after something has happened.

A keeper is a reading that friction or stops may hold. At rest it is held while the force that this takes is within what
friction bears and a stop can push; else it slides the way it is drawn. At a stop its speed is thrown back.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.mechanics.contact.tolerances import SMALLEST_BOUNCE, STANDING, STILL, TOUCHING, bounces_left
from governor_mechanism.mechanics.dynamics.contacts import Mode, first_mode, keepers_of, springs_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import EXTRA, marks_of, project
from governor_mechanism.mechanics.dynamics.lowering import (
    System,
    Workspace,
    acted_on,
    make_system,
    make_workspace,
    moved_hold,
)
from governor_mechanism.mechanics.dynamics.output_forces import FORCE
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.constraint_kernels import bends_of, gradients_of, openings_of
from governor_mechanism.model.events import LEAVES, PULLS, RESTS, SLACKENS, SLIPS, STICKS, STRIKES, Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray, RecordArray

AT_ONCE = 1e-12
"""Of a time scale: what happens closer together happens at once."""

DOUBT = 1e-9
"""Of the scales of force and acceleration: what a check of a mode may be wrong by."""

CARRIED = 1e-6
"""Machine sizes, or rad, in the square of a time scale: what is held is accelerated by less than this, by rounding."""


Kind = tuple[tuple[int | None, ...], tuple[int, ...], tuple[bool, ...], bool]
"""What modes have in common whose systems differ only in where something is held."""


@dataclass(frozen=True)
class Seen:
    """Values, rates, and gradients (gauges, bodies, 3) of all gauges at a state."""

    values: FloatArray
    rates: FloatArray
    gradients: FloatArray


class Switching:
    """The mode of one scene as it moves on, and the events it passed."""

    def __init__(self, scene: Scene, second: float, closed: float) -> None:
        self.scene, self._second, self._closed = scene, second, closed
        self.keepers, names = keepers_of(scene), acted_on(scene)
        self.springs = [spring for spring in springs_of(scene) if spring.one_sided]
        self._gauges = [names.index(keeper.reading) for keeper in self.keepers]
        self._slack_gauges = [names.index(spring.reading) for spring in self.springs]
        mechanism = scene.part.mechanism
        self._sizes = [1.0 if mechanism.reading(name).quantity == "angle" else mechanism.size for name in names]
        self._joints = make_system(scene)[0].rows
        assembler = Assembler(mechanism)
        self._mobility, self._driven = assembler.mobility, bool(assembler.equations.driven.any())
        self._built: dict[Kind, tuple[Mode, System, Workspace]] = {}
        self.mode, self.events = first_mode(scene), list[Event]()
        self._left_at, self._left = -math.inf, set[int]()

    def built(self, mode: Mode) -> tuple[System, Workspace]:
        """The system of a mode, and room for it."""
        kind = tuple(self._where(k, held) for k, held in enumerate(mode.held)), mode.sliding, mode.taut, mode.still
        if kind not in self._built:
            system = make_system(self.scene, mode)[0]
            self._built[kind] = mode, system, make_workspace(system)
        other, system, room = self._built[kind]
        if other != mode:
            self._built[kind] = mode, moved_hold(system, self._gauges, mode), room
        return self._built[kind][1:]

    def _where(self, k: int, held: float | None) -> int | None:
        """How a keeper holds: at a stop (1, -1), in between (0), or not."""
        if held is None:
            return None
        return 1 if held >= self.keepers[k].high else -1 if held <= self.keepers[k].low else 0

    @property
    def system(self) -> System:
        """That of the present mode."""
        return self.built(self.mode)[0]

    @property
    def room(self) -> Workspace:
        """For the system of the present mode."""
        return self.built(self.mode)[1]

    def begin(self, state: FloatArray, cubics: FloatArray) -> None:
        """The mode at the start; nothing has happened yet."""
        self.mode, self.events = first_mode(self.scene), []
        self._left_at, self._left = -math.inf, set[int]()
        self.go_on(0.0, state, cubics)
        self.events = []

    def go_on(self, time: float, state: FloatArray, cubics: FloatArray, about: Sequence[int] = ()) -> None:
        """Choose the mode after what was watched about some keepers or springs happened; state changes in place.

        cubics count from `time`, at which state is.
        """
        before = self.mode
        self._tighten(time, state)
        left = self._leaving(time, {k for k in about if k < len(self.keepers) and before.held[k] is not None})
        rest_at = self._strike(time, state, cubics)
        seen = self._seen(state)
        options = [list(self._options(k, seen, k in left)) for k in range(len(self.keepers))]
        best, least = None, math.inf
        for choice in itertools.product(*options):
            many = sum(held is not None for held, _ in choice)
            if many > self._mobility:
                continue  # more holds than freedoms: one of them at its bound says the same, and settles the forces
            still = many == self._mobility and not self._driven
            mode = Mode(tuple(held for held, _ in choice), tuple(sign for _, sign in choice), self.mode.taut, still)
            wrong = self._doubt(mode, state, cubics)
            if wrong < least:
                best, least = mode, wrong
            if least <= DOUBT:
                break
        if best is not None:
            self.mode = best
        self._hold(state, cubics)
        self._tell(time, state, before, rest_at)

    def _leaving(self, time: float, left: set[int]) -> set[int]:
        """Those that let go now, and those that did at this same time: between two that hold one thing, each would hand
        it to the other without end."""
        if time - self._left_at <= AT_ONCE * self._second:
            left = left | self._left
        self._left_at, self._left = time, left
        return left

    def _tighten(self, time: float, state: FloatArray) -> None:
        """One-sided springs that begin to pull, or go slack."""
        if not self.springs:
            return
        seen, taut = self._seen(state), list(self.mode.taut)
        for k, (spring, gauge) in enumerate(zip(self.springs, self._slack_gauges, strict=True)):
            off = float(seen.values[gauge]) - spring.free
            near = abs(off) < TOUCHING * self._sizes[gauge]
            taut[k] = bool(seen.rates[gauge] > 0 if near else off > 0)
            if taut[k] != self.mode.taut[k]:
                self.events.append(Event(time=time, kind=PULLS if taut[k] else SLACKENS, subject=spring.reading))
        self.mode = replace(self.mode, taut=tuple(taut))

    def _strike(self, time: float, state: FloatArray, cubics: FloatArray) -> dict[int, float]:
        """Throw back what runs into a stop; when the bounces of those that come to rest there will be over (s)."""
        rest_at: dict[int, float] = {}
        for _ in range(2 * len(self.keepers)):
            seen = self._seen(state)
            hitting = [
                k
                for k, keeper in enumerate(self.keepers)
                if self._side(k, seen) * float(seen.rates[self._gauges[k]]) > self._still(k)
            ]
            if not hitting:
                break
            resting = [k for k, held in enumerate(self.mode.held) if held is not None and k not in hitting
                       and self._side(k, seen)]  # fmt: skip
            rates = {k: -self.keepers[k].restitution * float(seen.rates[self._gauges[k]]) for k in hitting}
            self._throw(state, seen, rates | dict.fromkeys(resting, 0.0))
            for k in hitting:
                self.events.append(Event(time=time, kind=STRIKES, subject=self.keepers[k].reading))
            rest_at |= self._last_bounces(time, state, cubics, hitting)
        return rest_at

    def _last_bounces(self, time: float, state: FloatArray, cubics: FloatArray, hit: Sequence[int]) -> dict[int, float]:
        """Those of the hit that rise no more: their speed is taken away, and the time (s) told at which they rest."""
        found: dict[int, float] = {}
        seen = self._seen(state)
        onward, returning = (self._bends_sliding(state, cubics, seen, hit, way) for way in (1, -1))
        for k in hit:
            gauge, side, restitution = self._gauges[k], self._side(k, seen), self.keepers[k].restitution
            away, back = -side * float(seen.rates[gauge]), side * float(onward[gauge])
            if restitution < 1 and back > 0 and away > 0 and away**2 < 2 * back * SMALLEST_BOUNCE * self._sizes[gauge]:
                found[k] = time + bounces_left(away, back, side * float(returning[gauge]), restitution)
        if found:
            self._throw(state, seen, dict.fromkeys(found, 0.0))
        return found

    def _bends_sliding(
        self, state: FloatArray, cubics: FloatArray, seen: Seen, hit: Sequence[int], way: int
    ) -> FloatArray:
        """Second derivatives of what the gauges tell while what was hit moves on (way 1), or back (-1), and friction
        opposes that; with one freedom all else goes back with it."""
        signs = []
        for k, keeper in enumerate(self.keepers):
            rate = float(seen.rates[self._gauges[k]])
            rubs = keeper.friction is not None and (k in hit or self.mode.held[k] is None)
            turns = way if k in hit or self._mobility == 1 else 1
            signs.append(turns * int(math.copysign(1.0, rate)) if rubs and rate else 0)
        held = tuple(None if k in hit else value for k, value in enumerate(self.mode.held))
        slope = marks_of(*self.built(Mode(held, tuple(signs), self.mode.taut)), cubics, 0.0, state)[1]
        return self._bends(state, slope)

    def _throw(self, state: FloatArray, seen: Seen, rates: dict[int, float]) -> None:
        """Change the velocities by impulses of joints and stops until some keepers have these rates."""
        system = self.system
        count = 3 * len(system.bodies)
        joints = gradients_of(self._joints, state[:count].reshape(1, -1, 3))[0]
        stops = seen.gradients[[self._gauges[k] for k in rates]]
        rows = np.concatenate([joints, stops]).reshape(-1, count)
        wanted = [rate - float(seen.rates[self._gauges[k]]) for k, rate in rates.items()]
        right = np.concatenate([np.zeros(len(joints)), wanted])
        weight = system.inverse_mass.ravel()
        velocities = state[count : 2 * count]
        mass = np.divide(1.0, weight, out=np.zeros_like(weight), where=weight > 0)
        before = 0.5 * float(np.sum(mass * velocities**2))
        velocities += weight * (rows.T @ np.linalg.lstsq((rows * weight) @ rows.T, right, rcond=1e-13)[0])
        lost = before - 0.5 * float(np.sum(mass * velocities**2))
        state[-EXTRA] += lost
        state[-EXTRA + 1] += lost

    def _options(self, k: int, seen: Seen, left: bool) -> Iterator[tuple[float | None, int]]:
        """How a keeper may go on: the value it is held at, or the sign of its sliding."""
        keeper = self.keepers[k]
        value, rate = float(seen.values[self._gauges[k]]), float(seen.rates[self._gauges[k]])
        rubs, side = keeper.friction is not None, self._side(k, seen)
        if abs(rate) > self._still(k):
            yield None, int(math.copysign(1.0, rate)) if rubs else 0
            return
        if (rubs or side) and not left:
            yield (keeper.high if side > 0 else keeper.low if side < 0 else value), 0
        for sign in (1, -1):
            if rubs and sign != side:
                yield None, sign
        if not rubs:
            yield None, 0

    def _doubt(self, mode: Mode, state: FloatArray, cubics: FloatArray) -> float:
        """By how much a mode contradicts itself, in units of the scales; nought where it does not."""
        system, room = self.built(mode)
        trial = state.copy()
        _project(system, room, cubics, trial, self._closed)
        marks, slope = marks_of(system, room, cubics, 0.0, trial)
        forces = system.watch["kind"] == FORCE
        unit = np.where(system.watch["tiny"] > 0, system.watch["tiny"], 1.0) * 1e12
        worst = float(np.max(marks[forces] / unit[forces], initial=0.0))
        seen, bends = self._seen(trial), self._bends(trial, slope)
        for k, held in enumerate(mode.held):
            gauge = self._gauges[k]
            if held is not None:
                # At the dead centre of a reading no force along it holds it: the mechanism carries it on.
                carried = abs(float(bends[gauge])) * self._second**2 / self._sizes[gauge]
                worst = max(worst, carried if carried > CARRIED else 0.0)
                continue
            if abs(float(seen.rates[gauge])) > self._still(k):
                continue
            away = mode.sliding[k] or -self._side(k, seen)
            worst = max(worst, -away * float(bends[gauge]) * self._second**2 / self._sizes[gauge])
        return worst

    def _hold(self, state: FloatArray, cubics: FloatArray) -> None:
        """Close joints, and what is held, to rounding; a speed that this takes away is rounding too."""
        system, room = self.built(self.mode)
        _project(system, room, cubics, state, self._closed)

    def _tell(self, time: float, state: FloatArray, before: Mode, rest_at: dict[int, float]) -> None:
        """Note what has begun or ceased to stand still; which of several holds does the holding is not told."""
        seen = self._seen(state)
        for k, keeper in enumerate(self.keepers):
            was, now = (self._keeps(k, mode, seen) for mode in (before, self.mode))
            if was != now:
                begun, ended = (RESTS, LEAVES) if self._side(k, seen) else (STICKS, SLIPS)
                self.events.append(
                    Event(time=rest_at.get(k, time), kind=begun if now else ended, subject=keeper.reading)
                )

    def _keeps(self, k: int, mode: Mode, seen: Seen) -> bool:
        """Whether a keeper stands still in a mode, by its own hold or because nothing moves."""
        holds = self.keepers[k].friction is not None or self._side(k, seen) != 0
        return mode.held[k] is not None or (mode.still and holds)

    def _seen(self, state: FloatArray) -> Seen:
        gauges: RecordArray = self.system.gauges
        count = 3 * len(self.system.bodies)
        poses, velocities = (part.reshape(1, -1, 3) for part in (state[:count], state[count : 2 * count]))
        values = openings_of(gauges, poses, np.zeros((1, len(gauges.table), 3)))[0]
        gradients = gradients_of(gauges, poses)[0]
        return Seen(values, np.sum(gradients * velocities[0], axis=(-2, -1)), gradients)

    def _bends(self, state: FloatArray, slope: FloatArray) -> FloatArray:
        """Second derivatives (gauges,) of what the gauges tell, at a state and its slope."""
        system = self.system
        count = 3 * len(system.bodies)
        poses, velocities = (part.reshape(1, -1, 3) for part in (state[:count], state[count : 2 * count]))
        asked = np.zeros((1, len(system.gauges.table), 3))
        needed = bends_of(system.gauges, poses, velocities, asked)[0]
        gradients = gradients_of(system.gauges, poses)[0]
        bends: FloatArray = np.sum(gradients * slope[count : 2 * count].reshape(-1, 3), axis=(-2, -1)) - needed
        return bends

    def _side(self, k: int, seen: Seen) -> int:
        """At which of its stops a keeper is: 1 the high one, -1 the low one, 0 neither."""
        keeper, gauge = self.keepers[k], self._gauges[k]
        stands = abs(float(seen.rates[gauge])) <= self._still(k)
        near, value = (STANDING if stands else TOUCHING) * self._sizes[gauge], float(seen.values[gauge])
        return 1 if value >= keeper.high - near else -1 if value <= keeper.low + near else 0

    def _still(self, k: int) -> float:
        return STILL * self._sizes[self._gauges[k]] / self._second


def _project(system: System, room: Workspace, cubics: FloatArray, state: FloatArray, closed: float) -> None:
    count = 3 * len(system.bodies)
    poses, velocities = state[:count].reshape(-1, 3), state[count : 2 * count].reshape(-1, 3)
    project(system, room, cubics, 0.0, poses, velocities, closed)
