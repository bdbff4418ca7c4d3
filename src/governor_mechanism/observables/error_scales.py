"""Scales to which the errors of a run are relative: they follow its motion, not the stiffest spring."""

from collections.abc import Iterable, Mapping

import numpy as np

from governor_mechanism.mechanics.dynamics.characteristic_scales import loading_rate, time_scale
from governor_mechanism.model.coupling.coupled_system import SPINDLE_ANGLE, SPINDLE_SPEED, SPINDLE_TORQUE
from governor_mechanism.model.output_variables import CylinderPressure
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

JOINT_GAP = "joint_gap"
"""Name of the largest joint gap among errors and scales."""

EVENT_TIMES = "event times"
"""Name of the times of contact events among errors and scales."""


def name_of_rate(reading: str) -> str:
    """Return the name of the rate of a reading among errors and scales."""
    return f"rate of {reading}"


class MotionScales:
    """Scales of rates, energies and errors in a given motion; a stiff spring sets them only as far as the motion follows it."""

    def __init__(self, scene: Scene) -> None:
        self._mechanism, self._planes = scene.mechanism, scene.system.planes
        self._time_scale, self._loading_rate = time_scale(scene), loading_rate(scene)
        self.mass = sum(body.mass for body in scene.mechanism.bodies)  # mass of all bodies, kg

    def motion_rate(self, rates: Mapping[str, FloatArray]) -> float:
        """Return the rate (1/s) that a scale per second is multiplied by, from the rates (n,) of all readings."""
        return self._follow([np.abs(values) / self._mechanism.output_scale(name) for name, values in rates.items()])

    def spindle_rate(self, readings: Mapping[str, FloatArray]) -> float:
        """Return the scale (rad/s) of spindle speeds, from the readings (n,)."""
        names = [f"{plane.prefix}{SPINDLE_SPEED}" for plane in self._planes]
        return self._follow([np.abs(readings[name]) for name in names if name in readings])

    def _follow(self, rates: list[FloatArray]) -> float:
        """Return the largest rate (1/s) of a motion, or of what moves it; at most that of the stiffest spring."""
        largest = max([self._loading_rate, *(float(values.max(initial=0.0)) for values in rates)])
        return min(largest, 1 / self._time_scale) if self._loading_rate else 1 / self._time_scale

    def energy_scale(self, motion_rate: float) -> float:
        """Return the scale (J) of energies and moments at a rate (1/s) of the motion."""
        return self.mass * (self._mechanism.length_scale * motion_rate) ** 2

    def error_scales(self, readings: Mapping[str, FloatArray], rates: Iterable[str], motion_rate: float) -> dict[str, float]:
        """Return the scale of each reading and rate, of the joint gap and of the event times, from readings (n,), in SI."""
        # A reading has 1 rad or its length scale, its rate that per second of the motion; what
        # belongs to a spindle has a scale of its own. The torque of a spindle has at least its
        # largest value: where a body flies away, it grows with the square of the distance.
        mechanism = self._mechanism
        rate = motion_rate
        energy_scale = self.energy_scale(motion_rate)
        scales = {reading.name: mechanism.output_scale(reading.name) for reading in mechanism.readings}
        scales |= {name_of_rate(name): rate * scales[name] for name in rates}
        length = mechanism.length_scale
        unit_scales = {"m": length, "N": energy_scale / length, "N m": energy_scale, "J": energy_scale, "rad/s": rate, "1": 1.0}
        unit_scales |= {"rad": 1.0, "m/s": length * rate, "m/s2": length * rate**2}
        for output in mechanism.derived_readings:
            scales[output.name] = output.scale if isinstance(output, CylinderPressure) else unit_scales[output.unit]
        for plane in self._planes:
            largest_torque = float(np.max(np.abs(readings.get(f"{plane.prefix}{SPINDLE_TORQUE}", np.zeros(1))), initial=0.0))
            torque_scale = max(energy_scale, largest_torque)
            spindle_scales = {SPINDLE_SPEED: self.spindle_rate(readings), SPINDLE_TORQUE: torque_scale, SPINDLE_ANGLE: 1.0}
            named_scales = {f"{plane.prefix}{name}": scale for name, scale in spindle_scales.items()}
            scales |= {name: scale for name, scale in named_scales.items() if name in readings}
        return scales | {JOINT_GAP: mechanism.length_scale, EVENT_TIMES: self._time_scale}
