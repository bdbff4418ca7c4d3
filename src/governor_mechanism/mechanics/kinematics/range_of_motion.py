"""How far a mechanism of mobility one can go: its travel, what ends it on either side, and the track along it.

Where the description sets no limit to the leading coordinate, the motion is followed from the sketch both ways, as
`walking` does; else it is laid out between those limits, and cut where another reading meets one of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.batched_assembly import Closing
from governor_mechanism.mechanics.kinematics.continuation import FAR, End, Walk
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.mechanics.kinematics.path_interpolant import Track, laid_track
from governor_mechanism.model.mechanism import Limit, LineAngle, Mechanism
from governor_mechanism.types import FloatArray

HAIR = 1e-5
"""Fraction of the travel left out at each end, where the linkage may stand at a dead centre."""

LOOKED = 257
"""At so many values it is seen whether other readings are within their limits."""

KEPT = 16
"""The travels of so many mechanisms are remembered: one question about a scene asks for its travel several times."""


@dataclass(frozen=True, eq=False)
class Travel:
    """The range of the leading coordinate (SI) and a sentence on what happens at each end.

    low and high lie a hair inside `ends`; of a motion that comes round they are one `period` (else 0) apart and the
    same place. `turn` is what may be added to a value without changing the poses (else 0). track leads along it, and of
    a motion that comes round beyond both ends.
    """

    low: float
    high: float
    below: str
    above: str
    ends: tuple[float, float]
    track: Track
    period: float = 0.0
    turn: float = 0.0

    def counted(self, values: FloatArray) -> FloatArray:
        """Values (n,) of the coordinate with whole turns added that bring them into the travel, where any do."""
        if not self.turn:
            return values
        low, high = (self.low, self.high) if self.period else self.ends
        turned = values + self.turn * np.ceil((low - values) / self.turn)
        left = ((low <= values) & (values <= high)) | (turned > high) | (np.abs(turned - values) > FAR)
        counted: FloatArray = np.where(left, values, turned)
        return counted

    def holds(self, values: FloatArray) -> NDArray[np.bool_]:
        """Which values (n,) lie in the travel."""
        if self.period:
            inside: NDArray[np.bool_] = (self.low <= values) & (values <= self.high)
            return inside
        inside = (self.ends[0] < values) & (values < self.ends[1])
        return inside


@lru_cache(maxsize=KEPT)
def find_travel(mechanism: Mechanism, *, turning: bool) -> Travel:
    """The travel of a mechanism of mobility one, in a plane that turns with the spindle or in a fixed one.

    A limit that the description sets to the leading coordinate is taken as it stands; without one the motion is
    followed from the sketch. Raises MechanismError for another mobility, where the coordinate stands still, and where
    the limits of other readings leave nothing.
    """
    for limit in mechanism.limits:
        if limit.reading == mechanism.coordinate:
            return _between(mechanism, limit)
    return followed_travel(mechanism, turning=turning)


def followed_travel(mechanism: Mechanism, *, turning: bool) -> Travel:
    """The travel found by following the motion from the sketch both ways, whatever limit the coordinate itself has."""
    walk = Walk(mechanism, turning=turning)
    up = walk.end(1.0)
    if up.round:
        return _all_round(walk, up)
    down = walk.end(-1.0)
    if not up.value > down.value:
        raise MechanismError(
            f"{mechanism.coordinate!r} stands still while the mechanism moves; name another coordinate"
        )
    track = Track.of([*down.stations[:0:-1], *up.stations])
    return _inside(mechanism, (down.value, up.value), (down.words, up.words), track)


def _all_round(walk: Walk, up: End) -> Travel:
    """The travel of a motion that comes round: half its way to either side of the sketch."""
    begin, turns = walk.start.value, round((up.value - walk.start.value) / math.tau)
    period = math.tau * turns
    way = "half a turn from the sketch" if turns == 1 else f"after {turns} turns: {turns / 2:g} turns from the sketch"
    words = f"it turns all the way round: {way}" if turns == 1 else f"it comes round {way}"
    low, high = begin - 0.5 * period, begin + 0.5 * period
    track = Track.of(up.stations).twice_round(walk.turned(up), period)
    return Travel(low, high, words, words, (low, high), track, period, period)


def _inside(mechanism: Mechanism, ends: tuple[float, float], words: tuple[str, str], track: Track) -> Travel:
    hair = HAIR * (ends[1] - ends[0])
    turn = math.tau if isinstance(mechanism.reading(mechanism.coordinate), LineAngle) else 0.0
    return Travel(ends[0] + hair, ends[1] - hair, *words, ends, track, turn=turn)


def _between(mechanism: Mechanism, given: Limit) -> Travel:
    """The travel between the limits of the coordinate, as far as those of other readings leave it."""
    ends, words = (given.low, given.high), (given.below, given.above)
    whole = _inside(mechanism, ends, words, laid_track(mechanism, *_shrunk(*ends)))
    others = [limit for limit in mechanism.limits if limit is not given]
    return _cut(mechanism, whole, others) if others else whole


def _shrunk(low: float, high: float) -> tuple[float, float]:
    hair = HAIR * (high - low)
    return low + hair, high - hair


def _cut(mechanism: Mechanism, whole: Travel, others: list[Limit]) -> Travel:
    """The part of a travel within the limits of other readings: that of the sketch, or the longest without it."""
    closing = Closing(mechanism)
    values = np.linspace(whole.low, whole.high, LOOKED)
    excesses = np.array([found for found, _ in _excesses(closing, whole.track, others, values)])
    inside = np.all(excesses < 0.0, axis=0)
    if inside.all():
        return whole
    if not inside.any():
        raise MechanismError(
            f"the mechanism has no travel: over the whole range of {mechanism.coordinate!r}, {whole.ends[0]:.6g} to "
            f"{whole.ends[1]:.6g}, other readings are outside theirs: {others[0].reading!r} must lie within "
            f"{others[0].low:.6g} to {others[0].high:.6g}; change the dimensions"
        )
    first, last = _run(inside, values, _sketched(mechanism))
    ends, words = list(whole.ends), [whole.below, whole.above]
    for side, index, beyond in ((0, first, first - 1), (1, last, last + 1)):
        if 0 <= beyond < LOOKED:
            ends[side], words[side] = _met(closing, whole.track, others, values[index], values[beyond])
    return _inside(mechanism, (ends[0], ends[1]), (words[0], words[1]), whole.track)


def _excesses(
    closing: Closing, track: Track, limits: list[Limit], values: FloatArray
) -> Iterator[tuple[FloatArray, str]]:
    """How far (n,) readings are beyond each of their limits at values (n,), and what happens there."""
    poses = closing.at(track.expected(values), values)
    for limit in limits:
        value = reading_value(closing.mechanism, limit.reading, poses)
        yield limit.low - value, limit.below
        yield value - limit.high, limit.above


def _run(inside: NDArray[np.bool_], values: FloatArray, sketch: float) -> tuple[int, int]:
    """First and last index of the run of values that holds the sketch's, else of the longest one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
    runs = list(zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True))
    around = [run for run in runs if values[run[0]] <= sketch <= values[run[1]]]
    first, last = max(around or runs, key=lambda run: run[1] - run[0])
    return int(first), int(last)


def _sketched(mechanism: Mechanism) -> float:
    return float(reading_value(mechanism, mechanism.coordinate, np.array(mechanism.sketch, dtype=np.float64)))


def _met(closing: Closing, track: Track, limits: list[Limit], inside: float, outside: float) -> tuple[float, str]:
    """The first value on the way from inside to outside at which a reading meets a limit, and what happens there."""

    def excess(value: float, which: int) -> float:
        return float(list(_excesses(closing, track, limits, np.array([value])))[which][0][0])

    beyond = list(_excesses(closing, track, limits, np.array([outside])))
    met = [
        (float(brentq(excess, inside, outside, args=(which,), xtol=1e-14, rtol=1e-14)), words)
        for which, (found, words) in enumerate(beyond)
        if found[0] >= 0.0
    ]
    return min(met, key=lambda one: abs(one[0] - inside))
