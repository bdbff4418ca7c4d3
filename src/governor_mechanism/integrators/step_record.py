"""How steps and integrations end: return codes, the quality of the stages of a step, and the record of a step; compiled."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray


class IntegrationStatus(IntEnum):
    """Return code of an integrator."""

    DONE = 0
    """The end of the interval is reached."""
    STALLED = 1
    """The step size fell to rounding."""
    STEP_LIMIT = 2
    """The allowed number of steps is used up."""
    BELOW_TABLE = 3
    """The coordinate is below the tabulated range."""
    ABOVE_TABLE = 4
    """The coordinate is above the tabulated range."""
    STIFF = 5
    """The equation is too stiff for an explicit method."""
    OUT_OF_RANGE = 6
    """The mechanism leaves the range in which its description holds."""
    EVENT = 7
    """An event function crosses zero within the last step."""
    TABLE_ENDED = 8
    """The table cannot be extended to where the motion leads."""
    ENDLESS_EVENTS = 9
    """Events follow each other at one time without end."""
    TURNED_BACK = 10
    """A shaft that must not turn back does."""
    SINGULAR_COORDINATES = 11
    """The independent coordinates become unsuitable: others are needed."""
    LEFT_LIMITS = 12
    """A reading leaves its limits within the last step, or comes so near that a finer look must tell."""
    UNDETERMINED = 13
    """Rigid bodies with friction do not determine how the motion goes on."""
    TWO_ROLLERS = 14
    """Two of the rollers that stand round a body touch at once."""


NEAR_SINGULAR_QUALITY, MIN_STAGE_QUALITY = 1e-3, 1e-6
"""Quality of a stage below which it is near a singular state, and below which a step is retried.

At an angle e from a change point, a constraint violation d causes an acceleration error of order d / e^3. The step is
therefore placed so that the change point falls into the widest gap between stages. A step with a stage too close to
the change point is repeated with another length, unless it starts so close that no step does better.
"""

CROSSING_QUALITY_RATIO = 0.04
"""Quality of the stages nearest to a change point relative to that of the start, in a step that has the change point in its widest gap.

The gap reaches from 0.333 to 0.6 of the step. With the change point in its middle, the nearest stages are 0.134 / 0.466 of the angle of
the start away, and the quality is the square of an angle: 0.08. Half of it is required, because the angle is extrapolated.
"""

BELOW_DOMAIN = -1.0
ABOVE_DOMAIN = -2.0
FAR_OUTSIDE_DOMAIN = -3.0
OUT_OF_RANGE = -4.0
TURNED_BACK = -5.0
LEFT_LIMITS = -6.0
UNDETERMINED = -7.0
"""Qualities of a stage that leaves the domain of the equation, of one so far outside that a shorter step may stay inside, and of ends of
a step at which the integration ends.
"""

STAGE_GAP_FRACTION = 0.466
"""Middle of the widest gap between the stage nodes, as a fraction of the step."""

STEERING_QUALITY = 0.1
"""Quality below which step sizes are steered so that the change point falls into the gap between stages."""

MAX_SINGULAR_RETRIES = 60
"""Largest number of other step lengths tried at one change point."""


@jit_in_place
def domain_status(quality: float) -> IntegrationStatus:
    """Return how an integration ends at a stage outside the domain."""
    if quality == OUT_OF_RANGE:
        return IntegrationStatus.OUT_OF_RANGE
    if quality == LEFT_LIMITS:
        return IntegrationStatus.LEFT_LIMITS
    if quality == UNDETERMINED:
        return IntegrationStatus.UNDETERMINED
    if quality == TURNED_BACK:
        return IntegrationStatus.TURNED_BACK
    return IntegrationStatus.BELOW_TABLE if quality == BELOW_DOMAIN else IntegrationStatus.ABOVE_TABLE


@jit_in_place
def steer_step_over_singularity(angle: float, previous_angle: float, h: float, step: float) -> float:
    """Return the next step size that places the change point in the gap between stages, from its angles one step h apart."""
    time_to_singularity = angle * h / (previous_angle - angle)
    time_to_step_start = time_to_singularity - STAGE_GAP_FRACTION * step
    if time_to_step_start > step:  # at least two steps away
        return step
    if time_to_step_start > 0.0:  # end this step where the next one has the singularity in its gap
        return max(time_to_step_start, 0.02 * step)
    return time_to_singularity / STAGE_GAP_FRACTION if time_to_singularity > 0.1 * step else step


INSIDE_STEP_TOLERANCE = 1e-9
"""Part of a step by which another run may go beyond its end: two halves of a step end there but for rounding."""


class StepRecord(NamedTuple):
    """Ends of the accepted steps of a run, in the order of time."""

    ends: FloatArray  # times at which steps end, s; shape (capacity,)
    n_steps: IntArray  # number of recorded steps; shape (1,)
    # largest quality of a step so far; shape (1,). It measures what is far from a singular configuration.
    largest_quality: FloatArray
    # sum over the steps near singular configurations of their length over the cube of the smallest angle
    # (rad) from it, s; shape (1,). A constraint violation d changes the rates by d times this.
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
    """Return a step (s) from a time (s) of at most half of each recorded one it overlaps, and the record there, from an earlier k on."""
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
