"""Value and derivatives of guide curves, as compiled kernels."""

import math

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray


@jit_in_place
def evaluate_curve(
    # polynomial segments: start (m), then coefficients, highest power first; shape (segments, columns)
    curve_segments: FloatArray,
    first_segment: int,
    n_segments: int,
    x: float,  # abscissa, m
) -> tuple[float, float, float]:
    """Return the value (m) of a guide curve, its first derivative and its second one (1/m)."""
    k, end = first_segment, first_segment + n_segments
    while end - k > 1:
        middle = (k + end) // 2
        if x >= curve_segments[middle, 0]:
            k = middle
        else:
            end = middle
    local_x, value, derivative, half_second_derivative = x - curve_segments[k, 0], 0.0, 0.0, 0.0
    for column in range(1, curve_segments.shape[1]):
        half_second_derivative = half_second_derivative * local_x + derivative
        derivative = derivative * local_x + value
        value = value * local_x + curve_segments[k, column]
    return value, derivative, 2.0 * half_second_derivative


@jit_in_place
def evaluate_polar_curve(
    # polynomial segments of one turn: start (rad), then coefficients, highest power first; shape (segments, columns)
    curve_segments: FloatArray,
    first_segment: int,
    n_segments: int,
    angle: float,  # direction, rad, of any turn
) -> tuple[float, float, float]:
    """Return the radius (m) of a closed curve in a direction, and its first (m/rad) and second (m/rad2) derivative by the angle."""
    n_turns = math.floor((angle - curve_segments[first_segment, 0]) / (2.0 * math.pi))
    return evaluate_curve(curve_segments, first_segment, n_segments, angle - 2.0 * math.pi * n_turns)
