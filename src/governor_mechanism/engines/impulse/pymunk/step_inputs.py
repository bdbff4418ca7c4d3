"""What holds at the end of one step."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StepInputs:
    """What a step of h seconds ends with, where its kick acts; `following` (s) is the length of the next step.

    square: the spindle's speed squared (rad2/s2). scale lengthens the kick where the next step has another length.
    programs: the loads' programs now; motions: where drives are to be at the end of the next step (rad, m); frictions:
    what friction bears on each reading that may be held (N, or N m).
    """

    h: float
    next_h: float
    spindle_speed_squared: float
    kick_scale: float = 1.0
    load_values: tuple[float, ...] = ()
    drive_values: tuple[float, ...] = ()
    friction_limits: tuple[float, ...] = ()
