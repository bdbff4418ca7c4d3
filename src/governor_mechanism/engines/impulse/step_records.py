"""Records of a fixed-step run: state at one time, observation of one step, and events detected in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.engines.impulse.time_inputs import SpindleState
from governor_mechanism.model.events import EventKind
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class StepState:
    """State of a run at one time (s).

    Poses and velocities (bodies, 3) of the body proxies, values and rates (outputs,), state of the spindle and dissipated energy (J).
    """

    time: float
    poses: FloatArray
    velocities: FloatArray
    values: FloatArray
    rates: FloatArray
    spindle: SpindleState
    dissipated_energy: float


@dataclass(frozen=True)
class StepObservation:
    """Output values and rates (outputs,) at the end of a step, the rates right after its kick, and the inputs (inputs,) there."""

    values: FloatArray
    rates: FloatArray
    rates_after_kick: FloatArray
    inputs: FloatArray


@dataclass(frozen=True)
class OutputCrossing:
    """Event function of the contact or one-sided spring `index`: `sign` times an output, less a threshold; the rate where it sticks."""

    kind: EventKind
    index: int
    output: int
    sign: float
    threshold: float

    def __call__(self, motion: StepState | StepObservation) -> float:
        """Return the event function, positive after the event."""
        return self.sign * float((motion.rates if self.kind is EventKind.STICK else motion.values)[self.output]) - self.threshold


@dataclass(frozen=True)
class DetectedEvent:
    """An event within a step, of the contact or one-sided spring `index`; its event function is zero at the event.

    `initial_value` is the event function at the start of the step; `direction` is the sign of the motion after the event.
    """

    kind: EventKind
    index: int
    event_function: Callable[[StepObservation], float]
    initial_value: float
    direction: int
