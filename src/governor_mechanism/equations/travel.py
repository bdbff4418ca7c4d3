"""How far a mechanism of mobility one can go: its travel, and what ends it on either side.

Where the description sets no limit to the leading coordinate, the motion is followed from the sketch both ways, by the
direction that the joints leave free, until a limit of another reading is met, the coordinate turns back (a dead
centre: beyond it some joint would stay open), the joints leave a second way to go (a change point), a body comes to the
spindle axis, or a crank has come all the way round.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.equations.assembly import INDEPENDENT, Assembler
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import measure, reading_value
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanism import LineAngle, Mechanism

HAIR = 1e-5
"""Fraction of the travel left out at each end, where the linkage may stand at a dead centre."""

STEP, SHORTEST = 0.02, 1e-5
"""Longest and shortest step along the motion, in machine sizes and rad together."""

STRAY = 0.2
"""A step whose joints close farther from where it aimed than this part of it is taken again, shorter."""

SECOND_WAY = 1e-6
"""Least singular value of the joints' equations, of its largest, that counts as none: there the motion may fork."""

ROUND = "the motion was followed a whole turn from the sketch"
HALF = "it turns all the way round: half a turn from the sketch"

FAR = 50.0
"""Machine sizes, and rad: a motion without end is followed so far."""


@dataclass(frozen=True)
class Travel:
    """The range of the leading coordinate (SI), a hair inside its ends, and a sentence on what happens at each."""

    low: float
    high: float
    below: str
    above: str


@dataclass(frozen=True)
class _Station:
    """Poses along the motion, the free direction there (unit length, onward), and the joints' independence.

    `value` is the leading coordinate, counted on over half turns; `place` the way gone to here.
    """

    poses: Array
    ahead: Array
    independence: float
    value: float
    place: float


def find_travel(mechanism: Mechanism, *, turning: bool) -> Travel:
    """The travel of a mechanism of mobility one, in a plane that turns with the spindle or in a fixed one.

    A limit that the description sets to the leading coordinate is taken as it stands; without one the motion is
    followed from the sketch. Raises MechanismError for another mobility, and where the coordinate stands still.
    """
    for limit in mechanism.limits:
        if limit.reading == mechanism.coordinate:
            return _inside(limit.low, limit.high, limit.below, limit.above)
    return followed_travel(mechanism, turning=turning)


def followed_travel(mechanism: Mechanism, *, turning: bool) -> Travel:
    """The travel found by following the motion from the sketch both ways, whatever limit the coordinate itself has."""
    walk = _Walk(mechanism, turning)
    up, above = walk.end(1.0)
    if above == ROUND:
        return _inside(walk.start.value - math.pi, walk.start.value + math.pi, HALF, HALF)
    down, below = walk.end(-1.0)
    if not up > down:
        raise MechanismError(
            f"{mechanism.coordinate!r} stands still while the mechanism moves; name another coordinate"
        )
    return _inside(down, up, below, above)


def _inside(low: float, high: float, below: str, above: str) -> Travel:
    hair = HAIR * (high - low)
    return Travel(low + hair, high - hair, below, above)


def _beyond_axis(body: int, side: float, poses: Array) -> float:
    """How far (m) a body has come beyond the spindle axis from its side of it (1 or -1)."""
    return -side * float(poses[body, 0])


class _Walk:
    """Follows one mechanism from its sketch."""

    def __init__(self, mechanism: Mechanism, turning: bool) -> None:
        self.mechanism, self.assembler = mechanism, Assembler(mechanism)
        sketch = self.assembler.at({})
        if self.assembler.freedoms(sketch) != 1:
            raise MechanismError(
                f"a travel has one coordinate; this mechanism has mobility {self.assembler.freedoms(sketch)}"
            )
        self.scale = 1.0 if mechanism.reading(mechanism.coordinate).quantity == "angle" else mechanism.size
        unit = self.assembler.unit
        values, ways = np.linalg.svd(self.assembler.joint_rows(sketch), full_matrices=True)[1:]
        self.rank = int(np.sum(values > INDEPENDENT * values[0])) if values.size else 0
        slope = float(np.sum(self._gradient(sketch) * unit * ways[-1]))
        if abs(slope) < INDEPENDENT * self.scale:
            raise MechanismError(
                f"{mechanism.coordinate!r} stands at a dead centre in the sketch; sketch it a little further on"
            )
        value = float(reading_value(mechanism, mechanism.coordinate, sketch))
        self.start = self._station(sketch, ways[-1] * math.copysign(1.0, slope), value, 0.0)
        self.crossing = [k for k in range(len(mechanism.bodies)) if turning and self._crosses_axis(k)]

    def end(self, sign: float) -> tuple[float, str]:
        """Value of the coordinate at the end that lies this way, and what happens there."""
        here = replace(self.start, ahead=sign * self.start.ahead)
        trail = [here]
        while here.place < FAR:
            there = self._next(here)
            trail = [*trail[-2:], there]
            end = self._end_within(trail, sign)
            if end is not None:
                return end
            here = there
        return here.value, f"the motion was followed no farther than {FAR:g} machine sizes or rad"

    def _next(self, here: _Station) -> _Station:
        step = STEP
        while True:
            aim = here.poses + self.assembler.spread(step * self.assembler.unit * here.ahead)
            try:
                poses = self.assembler.at({}, aim)
            except MechanismError:
                poses = np.full_like(aim, np.nan)
            stray = (poses - aim).ravel()[self.assembler.free] / self.assembler.unit
            if np.linalg.norm(stray) < STRAY * step or step < SHORTEST:
                break
            step /= 2
        if not np.all(np.isfinite(poses)):
            raise MechanismError(f"the motion cannot be followed beyond {self.mechanism.coordinate} = {here.value:.6g}")
        return self._station(poses, here.ahead, self._counted(poses, here.value), here.place + step)

    def _station(self, poses: Array, onward: Array, value: float = 0.0, place: float = 0.0) -> _Station:
        """The station at assembled poses; its direction is the free one that goes on as `onward` does."""
        values, ways = np.linalg.svd(self.assembler.joint_rows(poses), full_matrices=True)[1:]
        independence = float(values[self.rank - 1] / values[0]) if self.rank else 1.0
        # Where the joints leave a second way to go, the one that goes straight on is taken.
        free = ways[self.rank - (1 if independence < SECOND_WAY else 0) :]
        ahead = free.T @ (free @ onward)
        return _Station(poses, ahead / np.linalg.norm(ahead), independence, value, place)

    def _end_within(self, trail: list[_Station], sign: float) -> tuple[float, str] | None:
        """The end that lies within the last steps, if one does: value of the coordinate, and words."""
        here, there = trail[-2:]
        found = [
            (self._crossed(here, there, excess), words)
            for excess, words in self._conditions(here, sign)
            if excess(there.poses) >= 0.0
        ]
        if self._slope(here, sign) > 0.0 >= self._slope(there, sign) and there.independence > SECOND_WAY:
            turning = self._crossed(here, there, lambda poses: -self._slope(self._station(poses, here.ahead), sign))
            found.append((turning, self._turning_back(turning, sign)))
        around = [trail] if len(trail) == 3 else []
        if found:  # a change point may lie in the same step, before the end
            around.append([here, there, self._next(there)])
        for first, middle, last in around:
            if middle.independence < min(first.independence, last.independence):
                fork = self._fork([first, middle, last])
                found += [] if fork is None else [(fork, "the joints leave a second way to go there: a change point")]
        ends = [(self._counted(poses, here.value), words) for poses, words in found]
        return min(ends, key=lambda end: sign * end[0], default=None)

    def _conditions(self, here: _Station, sign: float) -> Iterator[tuple[Callable[[Array], float], str]]:
        """What must stay below zero on the way, and what is said where it does not."""
        mechanism, begin = self.mechanism, self.start.value
        for limit in mechanism.limits:
            if limit.reading != mechanism.coordinate:
                yield self._excess(limit.reading, -1.0, limit.low), limit.below
                yield self._excess(limit.reading, 1.0, limit.high), limit.above
        for k in self.crossing:
            side = math.copysign(1.0, self.start.poses[k, 0])
            words = f"the mass centre of {mechanism.bodies[k].name!r} comes to the spindle axis"
            yield partial(_beyond_axis, k, side), words
        if mechanism.reading(mechanism.coordinate).quantity == "angle":
            yield lambda poses: sign * (self._counted(poses, here.value) - begin) - math.tau, ROUND

    def _excess(self, name: str, sign: float, limit: float) -> Callable[[Array], float]:
        return lambda poses: sign * (self._reading(name, poses) - limit)

    def _crossed(self, here: _Station, there: _Station, excess: Callable[[Array], float]) -> Array:
        """Poses between two stations at which an excess vanishes."""
        length = there.place - here.place
        if excess(here.poses) >= 0.0:
            return here.poses
        part = brentq(lambda s: excess(self._between(here, s)), 0.0, length, xtol=1e-13, rtol=1e-13)
        return self._between(here, float(part))

    def _between(self, here: _Station, way: float) -> Array:
        return self.assembler.at({}, here.poses + self.assembler.spread(way * self.assembler.unit * here.ahead))

    def _fork(self, trail: list[_Station]) -> Array | None:
        """Poses at which the joints depend on each other, between the stations around the least independent one."""
        first = trail[0]

        def independence(way: float) -> float:
            return self._station(self._between(first, way), first.ahead).independence

        ways = [station.place - first.place for station in trail]
        least = minimize_scalar(independence, bounds=(ways[0], ways[2]), method="bounded", options={"xatol": 1e-12})
        return self._between(first, float(least.x)) if least.fun < SECOND_WAY else None

    def _slope(self, station: _Station, sign: float) -> float:
        """How fast the coordinate goes its way (sign) along the motion."""
        return sign * float(np.sum(self._gradient(station.poses) * self.assembler.unit * station.ahead))

    def _turning_back(self, poses: Array, sign: float) -> str:
        """Why the coordinate goes no farther: the joint that would stay open beyond."""
        name, value = self.mechanism.coordinate, self._reading(self.mechanism.coordinate, poses)
        try:
            self.assembler.poses(value + sign * 1e-3 * self.scale, poses)
        except MechanismError as error:
            return f"dead centre: {name} turns back; beyond, {error.problems[0].partition(': ')[2]}"
        return f"dead centre: {name} turns back there"

    def _crosses_axis(self, k: int) -> bool:
        """Whether a body moves off the spindle axis and on to it, in the sketch."""
        across = self.assembler.spread(self.assembler.unit * self.start.ahead)[k, 0]
        off = abs(self.start.poses[k, 0]) > INDEPENDENT * self.mechanism.size
        return bool(off and abs(across) > INDEPENDENT * self.mechanism.size)

    def _gradient(self, poses: Array) -> Array:
        gradient: Array = measure(self.mechanism, self.mechanism.coordinate, poses).gradient.ravel()
        return gradient[self.assembler.free]

    def _counted(self, poses: Array, near: float) -> float:
        """The coordinate at poses; one that jumps at half a turn is counted on from a value near by."""
        value = self._reading(self.mechanism.coordinate, poses)
        if isinstance(self.mechanism.reading(self.mechanism.coordinate), LineAngle):
            return near + math.remainder(value - near, math.tau)
        return value

    def _reading(self, name: str, poses: Array) -> float:
        return float(reading_value(self.mechanism, name, poses))
