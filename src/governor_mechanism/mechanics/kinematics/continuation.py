"""Follow a mechanism of mobility one from its sketch, the way that its joints leave free, to where that ends.

An end is a limit of a reading, a dead centre where the coordinate turns back (beyond it some joint would stay open), a
change point where the joints leave a second way to go, a body that comes to the spindle axis, or the sketch itself
again, come all the way round.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import measure, reading_value
from governor_mechanism.mechanics.kinematics.path_interpolant import Station
from governor_mechanism.model.mechanism import LineAngle, Mechanism
from governor_mechanism.numerics.least_squares import INDEPENDENT
from governor_mechanism.types import FloatArray

STEP, SHORTEST, LONGEST = 0.02, 1e-5, 1.0
"""First, shortest and longest step along the motion, in machine sizes and rad together."""

AIM = 0.2
"""A step whose joints close farther from where it aimed than this part of it is taken again, shorter."""

STRAIGHT = 0.02
"""Where joints and readings bend by less than this part of a step, the next one is twice as long."""

FORKING = 0.5
"""A step on which the joints' independence falls below this part of itself is taken again, shorter."""

SECOND_WAY = 1e-6
"""Least singular value of the joints' equations, of its largest, that counts as none: there the motion may fork."""

LOOSE = 1e-3
"""Joints less independent than this leave poses open by some roots of rounding."""

RECURS = 1e-6
"""Machine sizes, and rad: poses so near the sketch's, but for whole turns, are the sketch's again."""

FAR = 50.0
"""Machine sizes, and rad: a motion without end is followed so far."""


@dataclass(frozen=True, eq=False)
class Passed(Station):
    """A station with the joints' independence there; `ahead` is the free direction, of unit length, onward."""

    independence: float


@dataclass(frozen=True, eq=False)
class End:
    """Where a way ends: value of the coordinate, what happens there, the stations up to it, whether it came round."""

    value: float
    words: str
    stations: tuple[Station, ...]
    round: bool = False


class Walk:
    """Follows one mechanism from its sketch. Raises MechanismError where that cannot be done."""

    def __init__(self, mechanism: Mechanism, *, turning: bool) -> None:
        self.mechanism, self.assembler = mechanism, Assembler(mechanism)
        sketch = self.assembler.at({})
        if self.assembler.freedoms(sketch) != 1:
            raise MechanismError(
                f"a travel has one coordinate; this mechanism has mobility {self.assembler.freedoms(sketch)}"
            )
        self._angle = mechanism.reading(mechanism.coordinate).quantity == "angle"
        self._scale = 1.0 if self._angle else mechanism.size
        values, ways = np.linalg.svd(self.assembler.joint_rows(sketch), full_matrices=True)[1:]
        self._rank = int(np.sum(values > INDEPENDENT * values[0])) if values.size else 0
        slope = float(np.sum(self._gradient(mechanism.coordinate, sketch) * self.assembler.unit * ways[-1]))
        if abs(slope) < INDEPENDENT * self._scale:
            raise MechanismError(
                f"{mechanism.coordinate!r} stands at a dead centre in the sketch; sketch it a little further on"
            )
        value = self._reading(mechanism.coordinate, sketch)
        self.start = self._station(sketch, ways[-1] * math.copysign(1.0, slope), value, 0.0)
        self._crossing = [k for k in range(len(mechanism.bodies)) if turning and self._crosses_axis(k)]
        self._watched = list(dict.fromkeys([mechanism.coordinate, *(limit.reading for limit in mechanism.limits)]))

    def end(self, sign: float) -> End:
        """The end that lies this way (1 or -1) and the stations to it, the sketch first."""
        here, step = replace(self.start, ahead=sign * self.start.ahead, slope=sign * self.start.slope), STEP
        trail, turns = [here], 1
        while FAR - here.place > SHORTEST:
            there, step = self._next(here, min(step, FAR - here.place))
            found = self._end_within([*trail[-2:], there], sign, turns)
            while found is not None and not found[1] and not self._recurs(found[0].poses):
                turns += 1
                found = self._end_within([*trail[-2:], there], sign, turns)
            if found is not None:
                return self._ended(trail, *found, sign)
            trail.append(there)
            here = there
        words = f"the motion was followed no farther than {FAR:g} machine sizes or rad"
        return self._ended(trail, here, words, sign)

    def turned(self, end: End) -> FloatArray:
        """What the way adds to the poses (bodies, 3) that come round: whole turns of bodies."""
        turned = np.zeros_like(self.start.poses)
        turned[:, 2] = math.tau * np.round((end.stations[-1].poses - self.start.poses)[:, 2] / math.tau)
        return turned

    def _ended(self, trail: list[Passed], last: Passed, words: str, sign: float) -> End:
        """An end with its stations as a track counts them: places and slopes onward in the coordinate."""
        every = [
            Station(sign * one.place, one.value, self._slope(one, sign), one.poses, sign * self._moving(one))
            for one in (*(one for one in trail if one.place < last.place), last)
        ]
        return End(last.value, words, tuple(every), not words)

    def _moving(self, station: Passed) -> FloatArray:
        return self.assembler.spread(self.assembler.unit * station.ahead)

    def _next(self, here: Passed, step: float) -> tuple[Passed, float]:
        """The next station, and how long a step to try from there."""
        while True:
            there, stray = self._stepped(here, step)
            near = there is not None and stray < AIM * step
            forking = there is not None and there.independence < FORKING * here.independence and step > STEP
            if (near and not forking) or step < SHORTEST:
                break
            step /= 2
        if there is None:
            raise MechanismError(f"the motion cannot be followed beyond {self.mechanism.coordinate} = {here.value:.6g}")
        bent = max(stray, *(self._bent(name, here, there) for name in self._watched)) / step
        if bent < STRAIGHT and there.independence > (1 - STRAIGHT) * here.independence:
            return there, min(2 * step, LONGEST)
        return there, step if bent < 2 * STRAIGHT else max(step / 2, min(step, STEP))

    def _stepped(self, here: Passed, step: float) -> tuple[Passed | None, float]:
        """The station so far on, if the joints close there, and how far (machine sizes, rad) from where it aimed."""
        aim = here.poses + step * self._moving(here)
        try:
            poses = self.assembler.at({}, aim)
        except MechanismError:
            return None, math.inf
        stray = float(np.linalg.norm((poses - aim).ravel()[self.assembler.free] / self.assembler.unit))
        return self._station(poses, here.ahead, self._counted(poses, here.value), here.place + step), stray

    def _bent(self, name: str, here: Passed, there: Passed) -> float:
        """How far (machine sizes, rad) a reading strays from going on as it goes."""
        one = self.mechanism.reading(name)
        gone = self._reading(name, there.poses) - self._reading(name, here.poses)
        gone = math.remainder(gone, math.tau) if isinstance(one, LineAngle) else gone
        straight = float(np.sum(self._gradient(name, here.poses) * self.assembler.unit * here.ahead))
        scale = 1.0 if one.quantity == "angle" else self.mechanism.size
        return abs(gone - (there.place - here.place) * straight) / scale

    def _station(self, poses: FloatArray, onward: FloatArray, value: float = 0.0, place: float = 0.0) -> Passed:
        """The station at assembled poses; its direction is the free one that goes on as `onward` does."""
        values, ways = np.linalg.svd(self.assembler.joint_rows(poses), full_matrices=True)[1:]
        independence = float(values[self._rank - 1] / values[0]) if self._rank else 1.0
        # Where the joints leave a second way to go, the one that goes straight on is taken.
        free = ways[self._rank - (1 if independence < SECOND_WAY else 0) :]
        ahead = free.T @ (free @ onward)
        ahead = ahead / np.linalg.norm(ahead)
        slope = float(np.sum(self._gradient(self.mechanism.coordinate, poses) * self.assembler.unit * ahead))
        return Passed(place, value, slope, poses, ahead, independence)

    def _end_within(self, trail: list[Passed], sign: float, turns: int) -> tuple[Passed, str] | None:
        """The end that lies within the last step, if one does, and words; none where so many turns have been gone."""
        here, there = trail[-2:]
        found = [
            (self._crossed(here, there, excess), words)
            for excess, words in self._conditions(here, sign, turns)
            if excess(there.poses) >= 0.0
        ]
        if self._slope(here, sign) > 0.0 >= self._slope(there, sign) and there.independence > SECOND_WAY:
            turned = self._crossed(here, there, lambda poses: -self._slope(self._station(poses, here.ahead), sign))
            found.append((turned, self._turning_back(turned.poses, sign)))
        around = [trail] if len(trail) == 3 else []
        if found:  # a change point may lie in the same step, before the end
            around.append([here, there, self._next(there, min(STEP, there.place - here.place))[0]])
        for first, middle, last in around:
            if middle.independence < min(first.independence, last.independence):
                fork = self._fork([first, middle, last])
                words = "the joints leave a second way to go there: a change point"
                found += [] if fork is None else [(fork, words)]
        return min(found, key=lambda end: sign * end[0].value, default=None)

    def _passed(self, before: Passed, way: float) -> Passed:
        """The station so far beyond another."""
        return self._at(self._between(before, way), before, way)

    def _at(self, poses: FloatArray, before: Passed, way: float) -> Passed:
        return self._station(poses, before.ahead, self._counted(poses, before.value), before.place + way)

    def _conditions(self, here: Passed, sign: float, turns: int) -> Iterator[tuple[Callable[[FloatArray], float], str]]:
        """What must stay below zero on the way, and what is said where it does not; nothing for a whole turn."""
        mechanism, begin = self.mechanism, self.start.value
        for limit in mechanism.limits:
            if limit.reading != mechanism.coordinate:
                yield self._excess(limit.reading, -1.0, limit.low), limit.below
                yield self._excess(limit.reading, 1.0, limit.high), limit.above
        for k in self._crossing:
            side = math.copysign(1.0, self.start.poses[k, 0])
            words = f"the mass centre of {mechanism.bodies[k].name!r} comes to the spindle axis"
            yield partial(_beyond_axis, k, side), words
        if self._angle:
            yield lambda poses: sign * (self._counted(poses, here.value) - begin) - turns * math.tau, ""

    def _recurs(self, poses: FloatArray) -> bool:
        """Whether poses are the sketch's again, but for whole turns of bodies."""
        off = poses - self.start.poses
        off[:, 2] -= math.tau * np.round(off[:, 2] / math.tau)
        return bool(np.all(np.abs(off) < RECURS * np.array([self.mechanism.size, self.mechanism.size, 1.0])))

    def _excess(self, name: str, sign: float, limit: float) -> Callable[[FloatArray], float]:
        return lambda poses: sign * (self._reading(name, poses) - limit)

    def _crossed(self, here: Passed, there: Passed, excess: Callable[[FloatArray], float]) -> Passed:
        """The station between two at which an excess vanishes."""
        if excess(here.poses) >= 0.0:
            return self._passed(here, 0.0)
        length = there.place - here.place
        way = float(brentq(lambda s: excess(self._between(here, s)), 0.0, length, xtol=1e-13, rtol=1e-13))
        found = self._passed(here, way)
        if found.independence > LOOSE:
            return found
        way = float(brentq(lambda s: excess(self._led(here, there, s)), 0.0, length, xtol=1e-13, rtol=1e-13))
        return self._at(self._led(here, there, way), here, way)

    def _led(self, here: Passed, there: Passed, way: float) -> FloatArray:
        """Poses on the cubic from one station to the next: where the joints hardly settle them, better than closed."""
        length = there.place - here.place
        part, begin, end = way / length, length * self._moving(here), length * self._moving(there)
        a, c = here.poses, there.poses
        led: FloatArray = a + part * (
            begin + part * (3 * (c - a) - 2 * begin - end + part * (begin + end - 2 * (c - a)))
        )
        return led

    def _between(self, here: Passed, way: float) -> FloatArray:
        return self.assembler.at({}, here.poses + way * self._moving(here))

    def _fork(self, trail: list[Passed]) -> Passed | None:
        """The station between three at which the joints depend on each other, if they do."""
        for here, there in pairwise(trail):
            least = minimize_scalar(
                lambda way, here=here, there=there: self._at(self._led(here, there, way), here, way).independence,
                bounds=(0.0, there.place - here.place),
                method="bounded",
                options={"xatol": 1e-12},
            )
            if least.fun < SECOND_WAY:
                return self._at(self._led(here, there, float(least.x)), here, float(least.x))
        return None

    def _slope(self, station: Passed, sign: float) -> float:
        """How fast the coordinate goes its way (sign) along the motion."""
        return sign * station.slope

    def _turning_back(self, poses: FloatArray, sign: float) -> str:
        """Why the coordinate goes no farther: the joint that would stay open beyond."""
        name, value = self.mechanism.coordinate, self._reading(self.mechanism.coordinate, poses)
        try:
            with np.errstate(invalid="ignore"):  # a distance that vanishes has no direction
                self.assembler.poses(value + sign * 1e-3 * self._scale, poses)
        except MechanismError as error:
            return f"dead centre: {name} turns back; beyond, {error.problems[0].partition(': ')[2]}"
        return f"dead centre: {name} turns back there"

    def _crosses_axis(self, k: int) -> bool:
        """Whether a body moves off the spindle axis and on to it, in the sketch."""
        across = self._moving(self.start)[k, 0]
        off = abs(self.start.poses[k, 0]) > INDEPENDENT * self.mechanism.size
        return bool(off and abs(across) > INDEPENDENT * self.mechanism.size)

    def _gradient(self, name: str, poses: FloatArray) -> FloatArray:
        """By the free coordinates; a distance that vanishes has no direction, and none is taken."""
        with np.errstate(invalid="ignore"):
            gradient = measure(self.mechanism, name, poses).gradient.ravel()[self.assembler.free]
        return np.nan_to_num(gradient)

    def _counted(self, poses: FloatArray, near: float) -> float:
        """The coordinate at poses; one that jumps at half a turn is counted on from a value near by."""
        value = self._reading(self.mechanism.coordinate, poses)
        if isinstance(self.mechanism.reading(self.mechanism.coordinate), LineAngle):
            return near + math.remainder(value - near, math.tau)
        return value

    def _reading(self, name: str, poses: FloatArray) -> float:
        with np.errstate(invalid="ignore"):  # a distance that vanishes: its value is sound
            return float(reading_value(self.mechanism, name, poses))


def _beyond_axis(body: int, side: float, poses: FloatArray) -> float:
    """How far (m) a body has come beyond the spindle axis from its side of it (1 or -1)."""
    return -side * float(poses[body, 0])
