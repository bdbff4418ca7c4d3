"""Inputs and prescribed motions as functions of time, piecewise cubic plus harmonics: values, derivatives, integrals."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.numerics.piecewise_cubic import PiecewiseCubic
from governor_mechanism.types import FloatArray

N_CUBIC_COLUMNS = 5
"""Number of columns of the local cubic of an input; those of its harmonics follow."""


def fluctuating_speed(
    amplitude: float, cycles_per_turn: float, mean_angle: Any, mean_speed: Any, mean_acceleration: Any
) -> tuple[Any, Any]:
    """Return the speed (rad/s) and acceleration (rad/s2) of a spindle whose speed fluctuates about its mean.

    `amplitude` is relative to the mean speed; `mean_angle` (rad) is the integral of the mean speed.
    """
    phase = cycles_per_turn * mean_angle
    speed_ratio = 1.0 + amplitude * np.sin(phase)
    fluctuation_rate = amplitude * cycles_per_turn * mean_speed * mean_speed * np.cos(phase)
    return mean_speed * speed_ratio, mean_acceleration * speed_ratio + fluctuation_rate


class CubicTimeFunction:
    """An input or a prescribed motion as a function of time (s).

    An input is a monotone piecewise cubic through its points; two points at one time are a jump; outside its points it is
    constant. At a jump, the value is the right limit unless the left limit is requested. A prescribed motion is a not-a-knot cubic
    spline that continues at its end rates; one with rests is monotone as an input, and its rate never jumps. Both add their harmonics.

    Parameters
    ----------
    function
        Times and values.

    Attributes
    ----------
    is_constant
        Whether the value never changes.
    breakpoints
        Times at which the value or a derivative jumps, s; integration steps must end there.
    """

    def __init__(self, function: InputFunction | PrescribedMotion) -> None:
        times, values = np.array(function.times), np.array(function.values)
        motion = function if isinstance(function, PrescribedMotion) else None
        if motion is not None and motion.has_rests:  # the curve ends as it rests, with a rate of zero
            times = np.array([2 * times[0] - times[1], *times, 2 * times[-1] - times[-2]])
            values = np.concatenate([values[:1], values, values[-1:]])
        harmonics = [(item.amplitude, 2 * np.pi * item.frequency, item.phase) for item in function.harmonics]
        self._harmonics: FloatArray = np.array(harmonics).reshape(-1, 3)
        self._is_level, self._first_value = all(value == function.values[0] for value in function.values), float(values[0])
        self.is_constant = self._is_level and not harmonics
        is_spline = motion is not None and not motion.has_rests
        self._cubic = None if self._is_level else _make_piecewise_cubic(times, values, is_spline)
        is_single_cubic = self._is_level or (is_spline and len(times) == 2)
        self.breakpoints: FloatArray = np.array([]) if is_single_cubic else np.unique(times)

    def __call__(self, times: FloatArray, *, left_limit: bool = False) -> FloatArray:
        """Return values (n,); at a jump the right limit, or the left limit if requested."""
        return self._evaluate(times, 0, left_limit=left_limit)

    def derivative(self, times: FloatArray) -> FloatArray:
        """Return time derivatives (n,); at a breakpoint the right limit."""
        return self._evaluate(times, 1)

    def second_derivative(self, times: FloatArray) -> FloatArray:
        """Return second time derivatives (n,); at a breakpoint the right limit."""
        return self._evaluate(times, 2)

    def integrals(self, start: float, ends: FloatArray) -> FloatArray:
        """Return the integrals over time (n,) from a start to each end (s)."""
        integrals = self._cubic_integrals(start, ends)
        for amplitude, angular_frequency, phase in self._harmonics:
            # The product of sines has no cancellation over a short time.
            middles, halves = 0.5 * angular_frequency * (ends + start) + phase, 0.5 * angular_frequency * (ends - start)
            integrals = integrals + 2 * amplitude / angular_frequency * np.sin(middles) * np.sin(halves)
        return integrals

    def _cubic_integrals(self, start: float, ends: FloatArray) -> FloatArray:
        return (ends - start) * self._first_value if self._cubic is None else self._cubic.integrals(start, ends)

    def local_cubics(self, times: FloatArray) -> FloatArray:
        """Return the function after each time, up to the next breakpoint, in the local time since then; shape (n, columns).

        First four coefficients of a cubic, highest power first, then its integral from 0 s to the time; then amplitude, angular
        frequency (rad/s) and phase of each harmonic at the time. A spindle, whose integral counts, has no harmonics.
        """
        cubics = np.zeros((len(times), N_CUBIC_COLUMNS))
        if self._cubic is None:
            cubics[:, 3] = self._first_value
        else:
            for column, (order, factorial) in enumerate(((3, 6), (2, 2), (1, 1), (0, 1))):
                cubics[:, column] = self._cubic.derivative(times, order) / factorial
        cubics[:, 4] = self._cubic_integrals(0.0, times)
        if not len(self._harmonics):
            return cubics
        harmonics = np.tile(self._harmonics, (len(times), 1, 1))
        harmonics[:, :, 2] += np.multiply.outer(times, self._harmonics[:, 1])
        return np.hstack([cubics, harmonics.reshape(len(times), self._harmonics.size)])

    def _evaluate(self, times: FloatArray, derivative_order: int, *, left_limit: bool = False) -> FloatArray:
        """Return the derivative of the given order (n,); at a breakpoint the right limit, or the left limit if requested."""
        if self._cubic is None:
            result = np.full(times.shape, 0.0 if derivative_order else self._first_value)
        else:
            result = self._cubic.derivative(times, derivative_order, left_limit=left_limit)
        for amplitude, angular_frequency, phase in self._harmonics:
            sine_or_cosine = np.cos if derivative_order == 1 else np.sin
            factor = amplitude * angular_frequency**derivative_order * (-1.0 if derivative_order == 2 else 1.0)
            result += factor * sine_or_cosine(angular_frequency * times + phase)
        return result


def _make_piecewise_cubic(times: FloatArray, values: FloatArray, is_spline: bool) -> PiecewiseCubic:
    """Return a piecewise cubic that continues beyond its ends: a monotone one at its value, a spline at its rate there."""
    jumps = np.flatnonzero(np.diff(times) == 0.0) + 1
    segments = [(t, v) for t, v in zip(np.split(times, jumps), np.split(values, jumps), strict=True) if len(t) > 1]
    coefficients = np.concatenate([np.zeros((0, 4)), *(_interpolate(t, v, is_spline) for t, v in segments)])
    rates = [0.0, 0.0]
    if is_spline:
        length, (cubic, square, rate, _) = times[-1] - times[-2], coefficients[-1]
        rates = [coefficients[0, 2], rate + length * (2 * square + length * 3 * cubic)]
    before, after = ([[0.0, 0.0, rate, value]] for rate, value in zip(rates, values[[0, -1]], strict=True))
    breaks = np.concatenate([*(t[:-1] for t, _ in segments), times[-1:]])
    return PiecewiseCubic(breaks, np.append(times[0], breaks), np.concatenate([before, coefficients, after]))


def _interpolate(times: FloatArray, values: FloatArray, is_spline: bool) -> FloatArray:
    """Return the cubics (intervals, 4) between points: of a spline, or monotone."""
    if len(times) == 2:
        return np.array([[0.0, 0.0, (values[1] - values[0]) / (times[1] - times[0]), values[0]]])
    from scipy.interpolate import CubicSpline, PchipInterpolator  # slow to import

    coefficients: FloatArray = (CubicSpline if is_spline else PchipInterpolator)(times, values).c.T
    return coefficients


def stack_local_cubics(
    functions: Sequence[CubicTimeFunction],
    times: FloatArray,  # times, s; shape (n,)
) -> FloatArray:
    """Return the local cubics of several functions after each time.

    Result: rows as in `input_kernels`; harmonics that a function does not have are zero; shape (n, functions,
    columns).
    """
    cubics = [function.local_cubics(times) for function in functions]
    result = np.zeros((len(times), len(cubics), max((one.shape[1] for one in cubics), default=N_CUBIC_COLUMNS)))
    for index, one in enumerate(cubics):
        result[:, index, : one.shape[1]] = one
    return result


class SpindleSpeedFunction(CubicTimeFunction):
    """The given spindle speed (rad/s) as a function of time (s), with its fluctuation.

    For a free spindle it is constant at the start speed.

    Parameters
    ----------
    spindle
        Spindle with a given speed, or a free spindle.
    ratio
        Factor on the speed.

    Attributes
    ----------
    is_constant
        Whether the speed never changes.
    start_speed
        Speed at 0 s, rad/s.
    """

    def __init__(self, spindle: Spindle | FreeSpindle, ratio: float = 1.0) -> None:
        function = spindle.speed_function if isinstance(spindle, Spindle) else InputFunction(values=(spindle.start_speed or 0.0,))
        super().__init__(function)
        self._ratio = ratio
        self._fluctuation_amplitude = 0.5 * spindle.speed_fluctuation if isinstance(spindle, Spindle) else 0.0
        self._cycles_per_turn = spindle.cycles_per_turn if isinstance(spindle, Spindle) else 1.0
        self.is_constant = self._is_level and not self._fluctuation_amplitude
        self.start_speed = float(self(np.array([0.0]))[0])

    def __call__(self, times: FloatArray, *, left_limit: bool = False) -> FloatArray:
        """Return speeds (n,), rad/s; at a jump the right limit, or the left limit if requested."""
        mean_speed = super().__call__(times, left_limit=left_limit)
        return self._ratio * self._add_fluctuation(times, mean_speed, np.zeros_like(times))[0]

    def derivative(self, times: FloatArray) -> FloatArray:
        """Return accelerations (n,), rad/s2; at a breakpoint the right limit."""
        return self._ratio * self._add_fluctuation(times, super().__call__(times), super().derivative(times))[1]

    def limits_at(self, time: float) -> tuple[float, float]:
        """Return the speeds, rad/s, just before and after a time, s."""
        before, after = (float(self(np.array([time]), left_limit=side)[0]) for side in (True, False))
        return before, after

    def _add_fluctuation(self, times: FloatArray, mean_speed: FloatArray, mean_acceleration: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return speeds and accelerations (n,) with the fluctuation, if any."""
        if not self._fluctuation_amplitude:
            return mean_speed, mean_acceleration
        angles = self.integrals(0.0, times)
        return fluctuating_speed(self._fluctuation_amplitude, self._cycles_per_turn, angles, mean_speed, mean_acceleration)
