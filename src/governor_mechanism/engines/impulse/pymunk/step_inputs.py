"""Values of all time functions at the end of one step."""

from dataclasses import dataclass

from governor_mechanism.types import FloatArray


@dataclass(frozen=True, slots=True)
class StepInputs:
    """Inputs of a step of `h` seconds, where its kick acts; `next_h` (s) is the length of the following step.

    `spindle_speed_squared` is in rad2/s2. `values` (inputs,) are the inputs of the multibody model: loads and friction limits, and the
    prescribed drives at the end of the next step. `kick_scale` lengthens the kick if the next step has another length.
    """

    h: float
    next_h: float
    spindle_speed_squared: float
    values: FloatArray
    kick_scale: float = 1.0
