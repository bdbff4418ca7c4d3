"""What a march is like at one time, what a step shows at its end, and what it may go beyond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class Instant:
    """Time (s), poses and velocities (bodies, 3) of the carriers at it, values and rates of all readings acted along,
    and what was added up until then.
    """

    time: float
    poses: FloatArray
    velocities: FloatArray
    values: FloatArray
    rates: FloatArray
    added: tuple[float, float, float, float, float]
    lost: float


@dataclass(frozen=True)
class Sight:
    """Values and rates of all readings acted along at the end of a step, their rates right after its kick, and what
    each friction bears then.
    """

    values: FloatArray
    rates: FloatArray
    after: FloatArray
    bears: tuple[float, ...]


@dataclass(frozen=True)
class Happening:
    """Something that a step goes beyond, about a keeper or a one-sided spring: by how much, nought where it happens.

    before: how much that was where the step began; way: the sign of the motion it leads to.
    """

    kind: str
    which: int
    excess: Callable[[Sight], float]
    before: float
    way: int = 0


def turned(at: int, sign: int) -> Callable[[Sight], float]:
    """How fast a reading moves against the sign of its motion."""
    return lambda sight: -sign * float(sight.rates[at])


def beyond(at: int, way: int, end: float) -> Callable[[Sight], float]:
    """How far a reading is beyond a value, that way."""
    return lambda sight: way * (float(sight.values[at]) - end)
