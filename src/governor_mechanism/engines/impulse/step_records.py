"""Records of a fixed-step run: state at one time, observation of one step, and events detected in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.model.events import EventKind
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class StepState:
    """State of a run at one time (s).

    Poses and velocities (bodies, 3) of the body proxies, values and rates (outputs,), spindle accumulators and dissipated energy (J).
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
    """Output values and rates (outputs,) at the end of a step, the rates right after its kick, and the friction limits there."""

    values: FloatArray
    rates: FloatArray
    rates_after_kick: FloatArray
    friction_limits: tuple[float, ...]


@dataclass(frozen=True)
class DetectedEvent:
    """An event within a step, of the contact or one-sided spring `index`; its event function is zero at the event.

    `initial_value` is the event function at the start of the step; `direction` is the sign of the motion after the event.
    """

    kind: EventKind
    index: int
    event_function: Callable[[StepObservation], float]
    initial_value: float
    direction: int = 0


def make_reversal_function(output: int, direction: int) -> Callable[[StepObservation], float]:
    """Return an event function: the rate of an output variable against the sign of its motion."""
    return lambda observation: -direction * float(observation.rates[output])


def make_level_function(output: int, direction: int, level: float) -> Callable[[StepObservation], float]:
    """Return an event function: the distance of an output variable past a level, positive in `direction`."""
    return lambda observation: direction * (float(observation.values[output]) - level)
