"""What counts as a crossing, of a value known at points between which it is monotonic."""

import math
from itertools import pairwise

import numpy as np

from governor_mechanism.types import FloatArray, IntArray

_SIGNS = {"up": (1.0,), "down": (-1.0,), "both": (1.0, -1.0)}
"""Signs of the deviation behind a crossing, by direction."""


def find_crossing_intervals(
    # deviations from the value that is passed, at points in the order of time; shape (n,)
    deviations: FloatArray,
    direction: str,
    tolerance: float,
) -> IntArray:
    """Return the points before which a value lies beyond a tolerance on one side, and after which on the other.

    Result: index of the last point before each passage; shape (crossings,).
    """
    low_indices = list[int]()
    for before, after in pairwise(np.flatnonzero(np.abs(deviations) > tolerance).tolist()):
        sign = math.copysign(1.0, deviations[after])
        if sign in _SIGNS[direction] and deviations[before] * sign < 0:
            # Between two neighbouring points the value is monotonic. After a rest at it the last pair counts.
            low_indices.append(before + int(np.flatnonzero(deviations[before:after] * sign <= 0)[-1]))
    return np.array(low_indices, dtype=np.int64)
