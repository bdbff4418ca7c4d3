"""What a march is like at one time, what a step shows at its end, and what it may go beyond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.model.events import EventKind
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class StepState:
    """Time (s), poses and velocities (bodies, 3) of the carriers at it, values and rates of all readings acted along,
    and what was added up until then.
    """

    time: float
    poses: FloatArray
    velocities: FloatArray
    values: FloatArray
    rates: FloatArray
    accumulators: tuple[float, float, float, float, float]
    dissipated_energy: float


@dataclass(frozen=True)
class StepObservation:
    """Values and rates of all readings acted along at the end of a step, their rates right after its kick, and what
    each friction bears then.
    """

    values: FloatArray
    rates: FloatArray
    rates_after_kick: FloatArray
    friction_limits: tuple[float, ...]


@dataclass(frozen=True)
class DetectedEvent:
    """Something that a step goes beyond, about a keeper or a one-sided spring: by how much, nought where it happens.

    before: how much that was where the step began; way: the sign of the motion it leads to.
    """

    kind: EventKind
    index: int
    event_function: Callable[[StepObservation], float]
    initial_value: float
    direction: int = 0


def make_reversal_function(output: int, direction: int) -> Callable[[StepObservation], float]:
    """How fast a reading moves against the sign of its motion."""
    return lambda sight: -direction * float(sight.rates[output])


def make_level_function(output: int, direction: int, level: float) -> Callable[[StepObservation], float]:
    """How far a reading is beyond a value, that way."""
    return lambda sight: direction * (float(sight.values[output]) - level)
