"""The way of a mechanism of mobility one, as stations along it: where poses are to be expected at any value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.kinematics.batched_assembly import Closing
from governor_mechanism.mechanics.kinematics.output_variables import reading_value
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

HALVINGS = 24
"""Halvings that bring a place on the way near enough for Newton's iteration."""

STATIONS = 16
"""So many stations, or more, are laid over a range."""

SMOOTH = 1e-3
"""Machine sizes, and rad: stations are laid so near that their slopes lead from one to the next but for this."""

SHORTEST = 1e-9
"""Of the longest distance of two stations: nearer they are not laid."""


@dataclass(frozen=True, eq=False)
class Station:
    """A place on the way, the leading coordinate there, its slope along the way, poses and theirs (bodies, 3)."""

    place: float
    value: float
    slope: float
    poses: FloatArray
    ahead: FloatArray


@dataclass(frozen=True, eq=False)
class Track:
    """Stations in ascending order of the coordinate, as arrays (m,) and (m, bodies, 3)."""

    places: FloatArray
    values: FloatArray
    slopes: FloatArray
    poses: FloatArray
    ahead: FloatArray

    @classmethod
    def of(cls, stations: Sequence[Station]) -> Track:
        """The track through stations; those that the coordinate does not come to in ascending order are left out."""
        kept = [stations[0]]
        kept += [there for here, there in pairwise(stations) if there.value > here.value]
        columns = ("place", "value", "slope", "poses", "ahead")
        return cls(*(np.array([getattr(one, name) for one in kept]) for name in columns))

    def expected(self, values: FloatArray) -> FloatArray:
        """Poses (n, bodies, 3) at values (n,) of the coordinate, by cubics along the way; beyond its ends, those there.

        The coordinate may turn back at an end: along the way itself all is smooth.
        """
        k = np.clip(np.searchsorted(self.values, values) - 1, 0, len(self.values) - 2)
        length = self.places[k + 1] - self.places[k]
        low, high = np.zeros(len(values)), np.ones(len(values))
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            under = _cubic(self.values, self.slopes, k, length, middle) < values
            low, high = np.where(under, middle, low), np.where(under, high, middle)
        part = 0.5 * (low + high)[:, np.newaxis, np.newaxis]
        return _cubic(self.poses, self.ahead, k, length[:, np.newaxis, np.newaxis], part)

    def twice_round(self, turned: FloatArray, period: float) -> Track:
        """This track, which comes round, with itself one period before; turned (bodies, 3) is what a period adds."""
        return Track(
            np.concatenate([self.places[:-1] - (self.places[-1] - self.places[0]), self.places]),
            np.concatenate([self.values[:-1] - period, self.values]),
            np.concatenate([self.slopes[:-1], self.slopes]),
            np.concatenate([self.poses[:-1] - turned, self.poses]),
            np.concatenate([self.ahead[:-1], self.ahead]),
        )


def _cubic(
    values: FloatArray, slopes: FloatArray, k: NDArray[np.integer], length: FloatArray, part: FloatArray
) -> FloatArray:
    """The cubic through values and slopes at both ends of intervals k of so much length, at a part (0 to 1) of each."""
    a, b, c, d = values[k], length * slopes[k], values[k + 1], length * slopes[k + 1]
    found: FloatArray = a + part * (b + part * (3 * (c - a) - 2 * b - d + part * (b + d - 2 * (c - a))))
    return found


@dataclass(frozen=True, eq=False)
class _Laid(Station):
    """A station laid at a value of the coordinate, its own place, with the second derivative of poses (bodies, 3)."""

    bend: FloatArray


def laid_track(mechanism: Mechanism, low: float, high: float) -> Track:
    """The track over a range of the coordinate, each station from its neighbour, outward from the sketch.

    Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
    """
    closing = Closing(mechanism)
    sketch = np.array(mechanism.sketch, dtype=np.float64)
    begin = min(max(float(reading_value(mechanism, mechanism.coordinate, sketch)), low), high)
    first = _laid(closing, begin, closing.assembler.poses(begin))
    longest = (high - low) / STATIONS
    down, up = (_outward(closing, first, end, longest) for end in (low, high))
    return Track.of([*down[::-1], first, *up])


def _outward(closing: Closing, first: _Laid, end: float, longest: float) -> list[_Laid]:
    """The stations from the first one, left out, to an end; none jumps to another branch that meets its own there."""
    found, here, step = list[_Laid](), first, longest
    while here.value != end:
        step = min(step, longest)
        value = end if abs(end - here.value) <= step else here.value + math.copysign(step, end - here.value)
        there, stray = _next(closing, here, value)
        last = step <= SHORTEST * longest
        if not last and (there is None or stray > SMOOTH):
            step /= 2
            continue
        here = _laid(closing, value, closing.assembler.poses(value, here.poses)) if there is None else there
        found.append(here)
        step = 2 * step if stray < SMOOTH / 8 else step
    return found


def _next(closing: Closing, here: _Laid, value: float) -> tuple[_Laid | None, float]:
    """The station at a value near by, if one closes there, and how far its slopes are from having led to it."""
    way = value - here.value
    expected = here.poses + way * here.ahead + 0.5 * way**2 * here.bend
    poses, sure = closing.near(expected[np.newaxis], np.array([value]))
    if not sure[0]:
        return None, math.inf
    there = _laid(closing, value, poses[0])
    stray = (there.poses - here.poses - 0.5 * way * (here.ahead + there.ahead)) / closing.sizes
    return there, float(np.max(np.abs(stray)))


def _laid(closing: Closing, value: float, poses: FloatArray) -> _Laid:
    ahead, bend = closing.path(poses[np.newaxis])
    return _Laid(value, value, 1.0, poses, ahead[0], bend[0])
