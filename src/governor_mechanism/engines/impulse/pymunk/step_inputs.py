"""Values of all time functions at the end of one step."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StepInputs:
    """Inputs of a step of `h` seconds, where its kick acts; `next_h` (s) is the length of the following step.

    `spindle_speed_squared` is in rad2/s2. `kick_scale` lengthens the kick if the next step has another length. `load_values` are the time
    functions of the force elements (N, N m); `drive_values` are the prescribed drives at the end of the next step (rad, m);
    `friction_limits` are the largest friction forces of the contacts (N, or N m).
    """

    h: float
    next_h: float
    spindle_speed_squared: float
    kick_scale: float = 1.0
    load_values: tuple[float, ...] = ()
    drive_values: tuple[float, ...] = ()
    friction_limits: tuple[float, ...] = ()
