"""Values along a travel, denser where the forces curve: what lies between two of them is known from both.

The travel is taken in parts. Where cubics through the slopes of the potential and of the spindle's inertia at both ends
of a part do not say what they are in its middle, the part is halved. A feature shows if it reaches an end or a middle
of some part, or bends what is there; one narrower than a part of PARTS, of which nothing is felt farther away, does
not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.reduction.lagrangian import Along, Reduction
from governor_mechanism.types import FloatArray

Which = NDArray[np.bool_]
Parts = NDArray[np.int64]

PARTS = 160
"""The travel is first taken in so many parts."""

OFF = 1e-4
"""A middle off by this fraction of what is largest there makes a part be halved."""

FINEST = 2.0**-24
"""Parts narrower than this fraction of the travel are not halved."""

MOST = 20_000
"""So many values are enough."""

NEUTRAL = 1e-11
"""A force, or a stiffness, below this fraction of its parts is rounding and dimensions of twelve digits: astatic."""


@dataclass(frozen=True, eq=False)
class Scan:
    """Values along a travel in any order, and the parts (p, 3) that they make: low end, middle and high end of each."""

    reduction: Reduction
    along: Along
    parts: Parts

    @property
    def ordered(self) -> Along:
        """All values in ascending order."""
        return self.along.chosen(np.argsort(self.along.coordinate, kind="stable"))

    def refined(self, bent: Callable[[Along, Parts], Which]) -> Scan:
        """With the parts halved in which something bends, and their halves, until nothing does."""
        along, settled, left = self.along, [np.zeros((0, 3), dtype=np.int64)], self.parts
        finest = FINEST * float(np.ptp(along.coordinate))
        while left.size:
            width = along.coordinate[left[:, 2]] - along.coordinate[left[:, 0]]
            chosen = bent(along, left) & (width > finest) & (len(along.coordinate) < MOST)
            settled.append(left[~chosen])
            along, left = _halved(self.reduction, along, left[chosen])
        return replace(self, along=along, parts=np.concatenate(settled))

    def halved(self, ranges: list[tuple[float, float]]) -> Scan:
        """With all parts halved that lie in some of these ranges of the coordinate."""
        low, high = (self.along.coordinate[self.parts[:, k]] for k in (0, 2))
        chosen = np.zeros(len(self.parts), dtype=np.bool_)
        for begin, end in ranges:
            chosen |= (low < end) & (high > begin)
        along, more = _halved(self.reduction, self.along, self.parts[chosen])
        return replace(self, along=along, parts=np.concatenate([self.parts[~chosen], more]))


def scan(reduction: Reduction) -> Scan:
    """A travel in parts in which potential and spindle's inertia are known from their ends.

    Of a motion that comes round one part more is taken at each end: what lies at the seam lies within.
    """
    travel = reduction.travel
    more = 1 if travel.period else 0
    width = (travel.high - travel.low) / PARTS
    values = np.linspace(travel.low - more * width, travel.high + more * width, 2 * (PARTS + 2 * more) + 1)
    begins = np.arange(0, len(values) - 1, 2)
    parts = np.stack([begins, begins + 1, begins + 2], axis=-1)
    return Scan(reduction, reduction.at(values), parts).refined(_unknown)


def off(along: Along, parts: Parts, value: FloatArray, slope: FloatArray, floor: FloatArray | float) -> Which:
    """Where a quantity (n,) with this slope is not in the middle what the ends of parts say, by more than a floor.

    A slope that is not what they say counts by what it makes of the value.
    """
    expected, steeply = _foreseen(along, parts, value, slope)
    low, middle, high = parts.T
    width = along.coordinate[high] - along.coordinate[low]
    astray = np.abs(expected - value[middle]) + 0.125 * width * np.abs(steeply - slope[middle])
    found: Which = astray > np.maximum(OFF * np.max(np.abs(value[parts]), axis=1), floor)
    return found


def _unknown(along: Along, parts: Parts) -> Which:
    """Where V', J', or V'' J' - V' J'' (what says whether the speed of rest rises), are not what the ends say."""
    pull, grip = (along.potential_slope, along.potential_bend), (along.spindle_slope, along.spindle_bend)
    floors = [1e-12 * np.max(np.abs(one[0]), initial=0.0) for one in (pull, grip)]
    found = off(along, parts, *pull, floors[0]) | off(along, parts, *grip, floors[1])
    (pulls, pulling), (grips, gripping) = (_foreseen(along, parts, *one) for one in (pull, grip))
    rising, size = rise(along)
    large = np.max(np.abs(rising[parts]), axis=1)
    floor = NEUTRAL * np.max(size[parts], axis=1)
    found |= np.abs(pulling * grips - pulls * gripping - rising[parts[:, 1]]) > np.maximum(100 * OFF * large, floor)
    return found


def rise(along: Along) -> tuple[FloatArray, FloatArray]:
    """V'' J' - V' J'' (n,), which has the sign of d(w^2)/dq at rest, and the sum of its parts without their signs."""
    one, other = along.potential_bend * along.spindle_slope, along.potential_slope * along.spindle_bend
    return one - other, np.abs(one) + np.abs(other)


def _foreseen(along: Along, parts: Parts, value: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Value and slope in the middle of parts, by the cubics through both at their ends."""
    low, _, high = parts.T
    width = along.coordinate[high] - along.coordinate[low]
    middle = 0.5 * (value[low] + value[high]) + 0.125 * width * (slope[low] - slope[high])
    return middle, 1.5 * (value[high] - value[low]) / width - 0.25 * (slope[low] + slope[high])


def _halved(reduction: Reduction, along: Along, parts: Parts) -> tuple[Along, Parts]:
    """With the halves of parts in place of them, and the values in the middles of these."""
    if not parts.size:
        return along, parts
    low, middle, high = parts.T
    q, count = along.coordinate, len(parts)
    more = reduction.at(np.concatenate([0.5 * (q[low] + q[middle]), 0.5 * (q[middle] + q[high])]))
    first = len(q) + np.arange(count)
    halves = [np.stack([low, first, middle], axis=-1), np.stack([middle, first + count, high], axis=-1)]
    return along.joined(more), np.concatenate(halves)
