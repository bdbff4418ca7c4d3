"""Time functions as piecewise cubics, and the compiled evaluation of the local cubics of all inputs.

Each input is a row of `input_cubics` (inputs, 5 or more): the coefficients of a cubic in the local time since the start of a
time segment, highest power first, and the integral of the cubic up to that start; then amplitude, angular frequency (rad/s) and
phase at that start of each harmonic.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray, IntArray

DERIVATIVE_FACTORS = np.array([[1.0, 1.0, 1.0, 1.0], [3.0, 2.0, 1.0, 0.0], [6.0, 2.0, 0.0, 0.0], [6.0, 0.0, 0.0, 0.0]])
"""Factors on the coefficients, highest power first, in the derivative of each order up to the third."""

ANTIDERIVATIVE_FACTORS = np.array([1 / 4, 1 / 3, 1 / 2, 1.0])
"""Factors on the coefficients, highest power first, in the antiderivative."""


class PiecewiseCubic:
    """A function that is a cubic between breaks; the first piece extends to minus infinity, the last one to infinity.

    Parameters
    ----------
    breaks
        Where one piece ends and the next begins, ascending; shape (pieces - 1,).
    origins
        Zero of each piece's own argument; shape (pieces,).
    coefficients
        Coefficients of each piece, highest power first; shape (pieces, 4).
    """

    def __init__(self, breaks: FloatArray, origins: FloatArray, coefficients: FloatArray) -> None:
        self._breaks = breaks
        self._origins = origins
        self._coefficients = coefficients

    def derivative(self, arguments: FloatArray, order: int, *, left_limit: bool = False) -> FloatArray:
        """Return the derivative (n,) of an order from 0 to 3; at a break the right limit, or the left limit if requested."""
        pieces = self._find_pieces(arguments, left_limit)
        coefficients = (self._coefficients[:, : 4 - order] * DERIVATIVE_FACTORS[order, : 4 - order])[pieces]
        return _evaluate_polynomials(coefficients, arguments - self._origins[pieces])

    def shifted_coefficients(self, arguments: FloatArray) -> FloatArray:
        """Return the cubics right of each argument, in the argument's distance from it; shape (n, 4), highest power first."""
        pieces = self._find_pieces(arguments)
        own = arguments - self._origins[pieces]
        cubic, square, rate, value = self._coefficients[pieces].T
        steep = 3.0 * cubic * own
        return np.stack(
            [cubic, steep + square, (steep + 2.0 * square) * own + rate, ((cubic * own + square) * own + rate) * own + value], axis=1
        )

    def integrals(self, start: float, ends: FloatArray) -> FloatArray:
        """Return the integrals (n,) from a start to each end."""
        values = self._antiderivative(np.append(ends, start))
        integrals: FloatArray = values[:-1] - values[-1]
        return integrals

    def _find_pieces(self, arguments: FloatArray, left_limit: bool = False) -> IntArray:
        return np.searchsorted(self._breaks, arguments, side="left" if left_limit else "right")

    def _antiderivative(self, arguments: FloatArray) -> FloatArray:
        """Return an antiderivative (n,), which is continuous."""
        pieces = self._find_pieces(arguments)
        own = arguments - self._origins[pieces]
        values: FloatArray = self._integration_constants[pieces] + own * _evaluate_polynomials(
            self._antiderivative_coefficients[pieces], own
        )
        return values

    @cached_property
    def _antiderivative_coefficients(self) -> FloatArray:
        coefficients: FloatArray = self._coefficients * ANTIDERIVATIVE_FACTORS
        return coefficients

    @cached_property
    def _integration_constants(self) -> FloatArray:
        """Constants (pieces,) that make the antiderivative continuous at the breaks."""
        coefficients, steps = self._antiderivative_coefficients, []
        for side in (0, 1):
            pieces = slice(side, len(self._origins) - 1 + side)
            own = self._breaks - self._origins[pieces]
            steps.append(own * _evaluate_polynomials(coefficients[pieces], own))
        return np.append(0.0, np.cumsum(steps[0] - steps[1]))


def _evaluate_polynomials(coefficients: FloatArray, arguments: FloatArray) -> FloatArray:
    """Return polynomials with coefficients (n, terms), highest power first, at arguments (n,)."""
    values = coefficients[:, 0]
    for column in range(1, coefficients.shape[1]):
        values = values * arguments + coefficients[:, column]
    return values


VALUE_COLUMN = 3
"""Column of the value in the local cubic of an input; its derivatives stand before it."""

N_CUBIC_COLUMNS = 5
"""Number of columns of the local cubic of an input; those of its harmonics follow."""


def fluctuating_speed(
    amplitude: float, cycles_per_turn: float, mean_angle: Any, mean_speed: Any, mean_acceleration: Any
) -> tuple[Any, Any]:
    """Return speed (rad/s) and acceleration (rad/s2) by the mean, whose integral is an angle (rad), and an amplitude relative to it."""
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
        self._integral_before = function.integral_before if isinstance(function, InputFunction) else 0.0
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
            middles = 0.5 * angular_frequency * (ends + start) + phase
            halves = 0.5 * angular_frequency * (ends - start)
            integrals = integrals + 2 * amplitude / angular_frequency * np.sin(middles) * np.sin(halves)
        return integrals

    def _cubic_integrals(self, start: float, ends: FloatArray) -> FloatArray:
        return (ends - start) * self._first_value if self._cubic is None else self._cubic.integrals(start, ends)

    def local_cubics(self, times: FloatArray) -> FloatArray:
        """Return the function after each time, up to the next breakpoint, in the local time since then; shape (n, columns)."""
        # First four coefficients of a cubic, highest power first, then its integral up to the time;
        # then amplitude, angular frequency (rad/s) and phase of each harmonic at the time. A
        # spindle, whose integral counts, has no harmonics.
        cubics = np.zeros((len(times), N_CUBIC_COLUMNS))
        if self._cubic is None:
            cubics[:, 3] = self._first_value
        else:
            cubics[:, : VALUE_COLUMN + 1] = self._cubic.shifted_coefficients(times)
        cubics[:, 4] = self._integral_before + self._cubic_integrals(0.0, times)
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
    """Return rows of `input_cubics` (n, functions, columns) after each time; harmonics that a function does not have are zero."""
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
        angles = self._integral_before + self.integrals(0.0, times)
        return fluctuating_speed(self._fluctuation_amplitude, self._cycles_per_turn, angles, mean_speed, mean_acceleration)


fluctuating_speed_jit = jit_in_place(fluctuating_speed)


@jit_in_place
def evaluate_cubic(input_cubics: FloatArray, k: int, local_time: float) -> float:
    """Return the value of input k without its harmonics."""
    a = input_cubics[k, 0]
    b = input_cubics[k, 1]
    c = input_cubics[k, 2]
    d = input_cubics[k, 3]
    return float(((a * local_time + b) * local_time + c) * local_time + d)


@jit_in_place
def evaluate_input(input_cubics: FloatArray, k: int, local_time: float) -> float:
    """Return the value of input k, its cubic plus its harmonics."""
    value = evaluate_cubic(input_cubics, k, local_time)
    for column in range(N_CUBIC_COLUMNS, input_cubics.shape[1], 3):
        if input_cubics[k, column] != 0.0:
            value += input_cubics[k, column] * math.sin(input_cubics[k, column + 1] * local_time + input_cubics[k, column + 2])
    return value


@jit_in_place
def evaluate_input_derivative(input_cubics: FloatArray, k: int, local_time: float) -> float:
    """Return the time derivative of input k without its harmonics."""
    return float((3.0 * input_cubics[k, 0] * local_time + 2.0 * input_cubics[k, 1]) * local_time + input_cubics[k, 2])


@jit_in_place
def evaluate_input_integral(input_cubics: FloatArray, k: int, local_time: float) -> float:
    """Return the integral of input k since 0 s, without its harmonics."""
    a = input_cubics[k, 0]
    b = input_cubics[k, 1]
    c = input_cubics[k, 2]
    d = input_cubics[k, 3]
    return float(input_cubics[k, 4] + (((0.25 * a * local_time + b / 3.0) * local_time + 0.5 * c) * local_time + d) * local_time)


@jit_in_place
def evaluate_motion(input_cubics: FloatArray, k: int, local_time: float) -> tuple[float, float, float]:
    """Return the value, rate and acceleration of a prescribed motion: its cubic plus its harmonics."""
    value = evaluate_cubic(input_cubics, k, local_time)
    rate = evaluate_input_derivative(input_cubics, k, local_time)
    acceleration = 6.0 * input_cubics[k, 0] * local_time + 2.0 * input_cubics[k, 1]
    for column in range(N_CUBIC_COLUMNS, input_cubics.shape[1], 3):
        amplitude = input_cubics[k, column]
        angular_frequency = input_cubics[k, column + 1]
        if amplitude != 0.0:
            angle = angular_frequency * local_time + input_cubics[k, column + 2]
            displacement = amplitude * math.sin(angle)
            value += displacement
            rate += amplitude * angular_frequency * math.cos(angle)
            acceleration -= angular_frequency * angular_frequency * displacement
    return value, rate, acceleration


@jit_in_place
def evaluate_given_speed(
    input_cubics: FloatArray, k: int, local_time: float, fluctuation_amplitude: float, cycles_per_turn: float
) -> tuple[float, float]:
    """Return the given speed (rad/s) and acceleration (rad/s2) of a spindle, input k with the fluctuation of its speed."""
    speed = evaluate_cubic(input_cubics, k, local_time)
    acceleration = evaluate_input_derivative(input_cubics, k, local_time)
    if fluctuation_amplitude == 0.0:
        return speed, acceleration
    mean_angle = evaluate_input_integral(input_cubics, k, local_time)
    return fluctuating_speed_jit(fluctuation_amplitude, cycles_per_turn, mean_angle, speed, acceleration)
