"""Steps of a run, and a second run that takes at most half of each of them; compiled."""

from typing import NamedTuple

import numpy as np

from governor_mechanism.integrators.stage_quality import STEERING_QUALITY
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray

INSIDE_STEP_TOLERANCE = 1e-9
"""Part of a step by which another run may go beyond its end: two halves of a step end there but for rounding."""


class StepRecord(NamedTuple):
    """Ends of the accepted steps of a run, in the order of time.

    Attributes
    ----------
    ends
        Times at which steps end, s; shape (capacity,).
    n_steps
        Number of recorded steps; shape (1,).
    largest_quality
        Largest quality of a step so far; shape (1,). It measures what is far from a singular configuration.
    singular_amplification
        Sum over the steps near singular configurations of their length over the cube of the smallest angle (rad) from it, s; shape (1,).
        A constraint violation d changes the rates by d times this.
    """

    ends: FloatArray
    n_steps: IntArray
    largest_quality: FloatArray
    singular_amplification: FloatArray


def make_step_record(capacity: int) -> StepRecord:
    """Return an empty record; what does not fit into its capacity is not recorded."""
    return StepRecord(np.empty(capacity), np.zeros(1, dtype=np.int64), np.zeros(1), np.zeros(1))


NO_STEPS = make_step_record(0)
"""Record that stays empty, and limits no step of another run."""


@jit_in_place
def record_step(record: StepRecord, end: float, h: float, quality: float) -> None:
    """Record a step of a length that ends at a time (s), with the lowest quality of its stages."""
    n = record.n_steps[0]
    if n < record.ends.size:
        record.ends[n] = end
        record.n_steps[0] = n + 1
        record.largest_quality[0] = max(record.largest_quality[0], quality)
        if 0.0 < quality < STEERING_QUALITY * record.largest_quality[0]:
            record.singular_amplification[0] += h / (quality / record.largest_quality[0]) ** 1.5


@jit_in_place
def find_step(record: StepRecord, t: float) -> int:
    """Return the index of the first recorded step that ends after a time (s), by bisection."""
    low, high = 0, record.n_steps[0]
    while low < high:
        middle = (low + high) // 2
        if record.ends[middle] > t:
            high = middle
        else:
            low = middle + 1
    return low


@jit_in_place
def _length_of(record: StepRecord, k: int) -> float:
    length: float = record.ends[k] - (record.ends[k - 1] if k > 0 else 0.0)
    return length


@jit_in_place
def limit_to_half_steps(record: StepRecord, k: int, t: float, h: float) -> tuple[float, int]:
    """Return a step length (s) from a time (s) on that is at most half of each recorded step which it overlaps.

    The second result is the index of the recorded step at the time; `k` is that of an earlier time.
    """
    n = record.n_steps[0]
    while k < n and record.ends[k] <= t + INSIDE_STEP_TOLERANCE * _length_of(record, k):
        k += 1
    if k >= n:
        return h, k
    length = _length_of(record, k)
    h = min(h, 0.5 * length)
    if k + 1 < n and t + h > record.ends[k] + INSIDE_STEP_TOLERANCE * length:
        h = min(h, max(record.ends[k] - t, 0.5 * _length_of(record, k + 1)))
    return h, k
