"""Programs and motions as functions of time: values and slopes, and the cubics the compiled kernels step through."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly

from governor_mechanism.model.scene import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import Motion, Program
from governor_mechanism.types import FloatArray


def uneven_speed(uneven: float, waves: float, turned: Any, mean: Any, growth: Any) -> tuple[Any, Any]:
    """Speed (rad/s) and its slope (rad/s2) of a spindle that swings by `uneven` of its mean speed, which grows.

    turned (rad) is the angle that the mean speed has turned.
    """
    phase = waves * turned
    swing = uneven * np.sin(phase)
    return mean * (1.0 + swing), growth * (1.0 + swing) + uneven * waves * mean * mean * np.cos(phase)


class TimeCurve:
    """A Program or a Motion against time (s).

    Programs are monotone cubics through the points, with a step where two share a time, held outside; a motion is a
    spline that goes on straight. Values at the time of a step are those after it, unless asked otherwise.
    """

    def __init__(self, program: Program | Motion) -> None:
        times, values = np.array(program.times), np.array(program.values)
        self.moving = isinstance(program, Motion)
        self._level = len(set(program.values)) == 1
        self.constant = self._level
        """Whether the value never changes."""
        cuts = np.flatnonzero(np.diff(times) == 0.0) + 1
        pieces = list(zip(np.split(times, cuts), np.split(values, cuts), strict=True))
        self._curves = [_curve(t, v, self.moving) for t, v in pieces]
        self._starts = np.array([t[0] for t, _ in pieces])
        self.breaks: FloatArray = np.unique(times) if not self.constant else np.array([])
        """Times (s) at which the value or one of its slopes jumps; steps of an engine must end there."""
        if self.moving and len(times) == 2:
            self.breaks = np.array([])

    def __call__(self, times: FloatArray, *, before: bool = False) -> FloatArray:
        """Values (n,); at a step the value after it, or before it."""
        return self._evaluate(times, before, 0)

    def slope(self, times: FloatArray) -> FloatArray:
        """Time derivative (n,); at a break the one after it."""
        return self._evaluate(times, False, 1)

    def bend(self, times: FloatArray) -> FloatArray:
        """Second time derivative (n,); at a break the one after it."""
        return self._evaluate(times, False, 2)

    def integral(self, start: float, end: float) -> float:
        """The integral over time from start to end (s)."""
        knots = [start, *(float(at) for at in self._starts if start < at < end), end]
        return sum(float(self._curves[self._which(a)].integrate(a, b)) for a, b in pairwise(knots))

    def _which(self, time: float) -> int:
        return max(int(np.searchsorted(self._starts, time, side="right")) - 1, 0)

    def cubics_from(self, times: FloatArray) -> FloatArray:
        """The curve after each time, up to the next break, as cubics (n, 5) of the time since, highest power first.

        The fifth number is what the curve has integrated to from 0 s.
        """
        if self._level and not self.moving:
            level = float(self._curves[0](0.0))
            return np.multiply.outer(np.ones_like(times), [0.0, 0.0, 0.0, level, 0.0]) + np.multiply.outer(
                times, [0.0, 0.0, 0.0, 0.0, level]
            )
        orders = ((3, 6), (2, 2), (1, 1), (0, 1))
        cubics = [self._evaluate(times, False, order) / factor for order, factor in orders]
        return np.stack([*cubics, self.integrals(times)], axis=-1)

    def integrals(self, times: FloatArray) -> FloatArray:
        """The integral (n,) from 0 s to each time."""
        if self._level and not self.moving:
            level: FloatArray = times * float(self._curves[0](0.0))
            return level
        return np.array([self.integral(0.0, float(time)) for time in times])

    def _evaluate(self, times: FloatArray, before: bool, order: int) -> FloatArray:
        which = np.searchsorted(self._starts, times, side="left" if before else "right") - 1
        result = np.empty_like(times)
        for index, curve in enumerate(self._curves):
            mine = np.maximum(which, 0) == index
            result[mine] = curve(times[mine], order)
        return result


def _curve(times: FloatArray, values: FloatArray, moving: bool) -> PPoly:
    """A piecewise cubic that goes on beyond its ends: a program level, a motion at the speed it has there."""
    if len(times) == 1:
        return PPoly(np.array([[0.0], [values[0]]]), np.array([times[0], times[0] + 1.0]))
    inner = CubicSpline(times, values, bc_type="natural") if moving else PchipInterpolator(times, values)
    first, last = times[0] - 1.0, times[-1] + 1.0
    slopes = [float(inner(time, 1)) if moving else 0.0 for time in (times[0], times[-1])]
    ends = np.array([[0.0, 0.0], [0.0, 0.0], slopes, [values[0] - slopes[0], values[-1]]])
    return PPoly(np.hstack([ends[:, :1], inner.c, ends[:, 1:]]), np.concatenate([[first], inner.x, [last]]))


class SpeedProgram(TimeCurve):
    """The spindle's given speed (rad/s) against time (s), uneven where it is; of a free spindle, the speed it starts
    with."""

    def __init__(self, spindle: Spindle | FreeSpindle) -> None:
        given = spindle.program if isinstance(spindle, Spindle) else Program(values=(spindle.start_speed,))
        super().__init__(given)
        self._uneven = 0.5 * spindle.unevenness if isinstance(spindle, Spindle) else 0.0
        self._waves = spindle.waves if isinstance(spindle, Spindle) else 1.0
        self.constant = self._level and not self._uneven
        self.start_speed = float(self(np.array([0.0]))[0])

    def __call__(self, times: FloatArray, *, before: bool = False) -> FloatArray:
        """Values (n,); at a step the value after it, or before it."""
        mean = super().__call__(times, before=before)
        if not self._uneven:
            return mean
        swung: FloatArray = uneven_speed(self._uneven, self._waves, self.integrals(times), mean, 0.0)[0]
        return swung

    def slope(self, times: FloatArray) -> FloatArray:
        """Time derivative (n,); at a break the one after it."""
        growth = super().slope(times)
        if not self._uneven:
            return growth
        mean = super().__call__(times)
        slope: FloatArray = uneven_speed(self._uneven, self._waves, self.integrals(times), mean, growth)[1]
        return slope
