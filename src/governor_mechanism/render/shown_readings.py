"""Readings of a run as figures and films show them."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.types import FloatArray

MAX_SHOWN_ANGLE = 4 * np.pi
"""Range of an angle (rad) beyond which a scene of several parts shows its rate."""


@dataclass(frozen=True, kw_only=True)
class ShownReading:
    """Values (n,) of a reading, SI, with their unit, the scale of relative errors and the error estimate; 0 if not known."""

    values: FloatArray
    unit: str
    scale: float
    error: float


def shown_readings(run: Trajectory) -> dict[str, ShownReading]:
    """Return the readings by name. In a scene of several parts, rates stand for angles of many turns, which look like straight lines."""
    shown = {}
    for name, values in run.readings.items():
        unit, scale, error = run.units.get(name, ""), run.scales.get(name, 0.0), run.reading_errors.get(name, 0.0)
        if len(run.scene.parts) > 1 and unit == "rad" and np.ptp(values) > MAX_SHOWN_ANGLE:
            if name.endswith(f".{SPINDLE_ANGLE}"):  # the spindle speed is a reading anyway
                continue
            error, scale = run.reading_errors.get(f"rate of {name}", 0.0), 0.0
            values, unit, name = run.rates[name], "rad/s", f"{name.removesuffix('_angle')}_rate"
        shown[name] = ShownReading(values=values, unit=unit, scale=scale, error=error)
    return shown
