"""Inputs as functions of time, evaluated by compiled kernels.

Each input is a row of `input_cubics` (inputs, 5 or more): the coefficients of a cubic in the local time since the start of a
time segment, highest power first, and the integral of the cubic up to that start; then amplitude, angular frequency (rad/s) and
phase at that start of each harmonic.
"""

import math

from governor_mechanism.mechanics.kinematics import time_functions
from governor_mechanism.mechanics.kinematics.time_functions import N_CUBIC_COLUMNS
from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray

fluctuating_speed_jit = jit_in_place(time_functions.fluctuating_speed)


@jit_in_place
def evaluate_cubic(input_cubics: FloatArray, k: int, local_time: float) -> float:
    """Return the value of input k without its harmonics."""
    a, b, c, d = input_cubics[k, 0], input_cubics[k, 1], input_cubics[k, 2], input_cubics[k, 3]
    return float(((a * local_time + b) * local_time + c) * local_time + d)


@jit_in_place
def evaluate_input(input_cubics: FloatArray, k: int, local_time: float) -> float:
    """Return the value of input k, its cubic plus its harmonics, or 0 for k = NO_INDEX."""
    if k < 0:
        return 0.0
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
    a, b, c, d = input_cubics[k, 0], input_cubics[k, 1], input_cubics[k, 2], input_cubics[k, 3]
    return float(input_cubics[k, 4] + (((0.25 * a * local_time + b / 3.0) * local_time + 0.5 * c) * local_time + d) * local_time)


@jit_in_place
def evaluate_motion(input_cubics: FloatArray, k: int, local_time: float) -> tuple[float, float, float]:
    """Return the value, rate and acceleration of a prescribed motion: its cubic plus its harmonics."""
    value, rate = evaluate_cubic(input_cubics, k, local_time), evaluate_input_derivative(input_cubics, k, local_time)
    acceleration = 6.0 * input_cubics[k, 0] * local_time + 2.0 * input_cubics[k, 1]
    for column in range(N_CUBIC_COLUMNS, input_cubics.shape[1], 3):
        amplitude, angular_frequency = input_cubics[k, column], input_cubics[k, column + 1]
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
    speed, acceleration = evaluate_cubic(input_cubics, k, local_time), evaluate_input_derivative(input_cubics, k, local_time)
    if fluctuation_amplitude == 0.0:
        return speed, acceleration
    mean_angle = evaluate_input_integral(input_cubics, k, local_time)
    return fluctuating_speed_jit(fluctuation_amplitude, cycles_per_turn, mean_angle, speed, acceleration)
