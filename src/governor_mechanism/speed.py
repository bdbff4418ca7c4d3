"""The spindle's given speed as a function of time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from governor_mechanism.scene import Spindle

Array = NDArray[np.float64]


class SpeedProgram:
    """Speed (rad/s) against time (s): monotone cubics through the points, steps where two share a time, held outside.

    Two points alone make a straight ramp. Speeds at the time of a step are those after it, unless asked otherwise.
    """

    def __init__(self, spindle: Spindle) -> None:
        self.constant = spindle.constant
        self.start_speed = 0.0
        times, speeds = np.array(spindle.times), np.array(spindle.speeds)
        cuts = np.flatnonzero(np.diff(times) == 0.0) + 1
        self._pieces = [(t, s) for t, s in zip(np.split(times, cuts), np.split(speeds, cuts), strict=True) if t.size]
        self._curves = [PchipInterpolator(t, s) if t.size > 1 else None for t, s in self._pieces]
        self._starts = np.array([t[0] for t, _ in self._pieces])
        self.breaks: Array = np.unique(times) if not self.constant else np.array([])
        """Times (s) at which the speed or one of its slopes jumps; steps of an engine must end there."""
        self.start_speed = float(self(np.array([0.0]))[0])

    def __call__(self, times: Array, *, before: bool = False) -> Array:
        """Speed (n,) in rad/s; at a step the speed after it, or before it."""
        return self._evaluate(times, before, slope=False)

    def slope(self, times: Array) -> Array:
        """Angular acceleration (n,) in rad/s2 of the spindle; at a break the one after it."""
        return self._evaluate(times, False, slope=True)

    def cubic_from(self, start: float) -> Array:
        """Speed after `start`, up to the next break, as a cubic (4,) of the time since, highest power first."""
        which = max(int(np.searchsorted(self._starts, start, side="right")) - 1, 0)
        (times, speeds), curve = self._pieces[which], self._curves[which]
        if curve is None or not times[0] <= start < times[-1]:
            return np.array([0.0, 0.0, 0.0, speeds[0] if start < times[0] else speeds[-1]])
        return np.array([float(curve(start, order)) / factor for order, factor in ((3, 6), (2, 2), (1, 1), (0, 1))])

    def _evaluate(self, times: Array, before: bool, *, slope: bool) -> Array:
        which = np.searchsorted(self._starts, times, side="left" if before else "right") - 1
        result = np.empty_like(times)
        for index, ((points, speeds), curve) in enumerate(zip(self._pieces, self._curves, strict=True)):
            mine = np.maximum(which, 0) == index
            inside = np.clip(times[mine], points[0], points[-1])
            if slope:
                moving = (times[mine] >= points[0]) & (times[mine] < points[-1])
                result[mine] = np.where(moving, curve.derivative()(inside), 0.0) if curve is not None else 0.0
            else:
                result[mine] = curve(inside) if curve is not None else speeds[0]
        return result
