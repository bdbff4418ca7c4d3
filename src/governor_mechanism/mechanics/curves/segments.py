"""Guide curves as polynomial segments, and their values and derivatives in kernels."""

import math

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.curves import (
    FLAT,
    HARMONIC,
    Curve,
    Lift,
    LiftCurve,
    PolarHarmonics,
    PolarSpline,
    PolynomialCurve,
    SplineCurve,
)
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
    local_x = x - curve_segments[k, 0]
    value = 0.0
    derivative = 0.0
    half_second_derivative = 0.0
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


def make_curve_segments(
    curve: Curve,  # polynomial or spline curve y = f(x), m, or closed curve r = f(angle), m and rad
) -> FloatArray:
    """Return a guide curve as segments: start (m, or rad of an angle), then coefficients, highest power first; TypeError without any."""
    if isinstance(curve, PolynomialCurve):
        return np.array([[0.0, *reversed(curve.coefficients)]])
    if isinstance(curve, SplineCurve):
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(curve.x, curve.y)
        return np.ascontiguousarray(np.column_stack([spline.x[:-1], spline.c.T]))  # in the order that the kernels take
    if isinstance(curve, PolarSpline):
        from scipy.interpolate import CubicSpline

        angles, radii = (
            np.append(values, end) for values, end in ((curve.angles, curve.angles[0] + math.tau), (curve.radii, curve.radii[0]))
        )
        spline = CubicSpline(angles, radii, bc_type="periodic")
        return np.ascontiguousarray(np.column_stack([spline.x[:-1], spline.c.T]))
    if isinstance(curve, PolarHarmonics):
        return _harmonic_segments(curve)
    if isinstance(curve, LiftCurve):
        return _lift_segments(curve)
    raise TypeError(f"no segments are defined for curves of type {type(curve).__name__}")


SEGMENTS_PER_CYCLE, TAYLOR_DEGREE = 16, 13
"""Segments per cycle of the highest harmonic of a closed curve, and degree of its Taylor polynomial in each: radius and second
derivative are exact to 2e-17 and 3e-14 of the amplitude and its second derivative."""


INVERSION_STEPS = 60
"""Steps from the direction of a point of a cam to its normal: Newton's take 5, and bisections bring the others to rounding."""


def _harmonic_segments(curve: PolarHarmonics) -> FloatArray:
    """Return a closed curve of harmonics as Taylor polynomials, exact to rounding."""
    n_segments = SEGMENTS_PER_CYCLE * int(max((one.order for one in curve.harmonics), default=1))
    starts = math.tau * np.arange(n_segments) / n_segments
    coefficients = _constants(np.full(n_segments, curve.radius))
    for one in curve.harmonics:
        coefficients = coefficients + _expand_sine(one.amplitude, one.order, one.order * starts + one.phase)
    return np.column_stack([starts, coefficients])


def _constants(values: FloatArray) -> FloatArray:
    """Return polynomials that are constant (n, powers)."""
    return np.where(np.arange(TAYLOR_DEGREE, -1, -1) == 0, values[:, np.newaxis], 0.0)


def _expand_sine(amplitude: float, order: float, phases: FloatArray) -> FloatArray:
    """Return the Taylor polynomials (n, powers) of amplitude * sin(order * u + phase)."""
    powers = np.arange(TAYLOR_DEGREE, -1, -1)
    factorials = np.array([math.factorial(power) for power in powers])
    terms: FloatArray = amplitude * order**powers / factorials * np.sin(phases[:, np.newaxis] + powers * math.pi / 2)
    return terms


def _lift_segments(curve: LiftCurve) -> FloatArray:
    """Return the curve of a cam as Taylor polynomials, exact to rounding."""
    parts, start = [], 0.0
    for one, radius in zip(curve.lifts, curve.radii_at_starts, strict=True):
        make_segments = _segments_under_flat if curve.follower == FLAT else _segments_of_lift
        parts.append(make_segments(one, start, radius))
        start += one.over
    return np.concatenate(parts)


def _segments_of_lift(one: Lift, start: float, radius: float) -> FloatArray:
    """Return the Taylor polynomials of a part of a turn of a cam that begins at an angle (rad) with a radius (m)."""
    if one.lift == 0.0:
        return np.column_stack([[start], _constants(np.array([radius]))])
    n_segments = SEGMENTS_PER_CYCLE // 2 if one.law == HARMONIC else SEGMENTS_PER_CYCLE
    shares = np.arange(n_segments) / n_segments
    if one.law == HARMONIC:
        coefficients = _constants(np.full(n_segments, radius + one.lift / 2))
        coefficients = coefficients + _expand_sine(-one.lift / 2, math.pi / one.over, math.pi * (shares + 0.5))
    else:
        coefficients = _constants(radius + one.lift * shares)
        coefficients[:, -2] = one.lift / one.over
        coefficients = coefficients + _expand_sine(-one.lift / math.tau, math.tau / one.over, math.tau * shares)
    return np.column_stack([start + one.over * shares, coefficients])


def _segments_under_flat(one: Lift, start: float, height: float) -> FloatArray:
    """Return a part of a turn of a cam whose law is the height h of a flat follower, as polynomials of the radius over its direction.

    The normal of the cam has the angle a where the flat lies, and the point of contact is h' beside it: its direction is a + atan(h' / h),
    and the radius of curvature h + h''. The second derivative of the radius is interpolated, and its value and slope are exact at the start
    of each segment.
    """
    if one.lift == 0.0:
        return _segments_of_lift(one, start, height)
    ends = start + one.over * np.arange(SEGMENTS_PER_CYCLE + 1) / SEGMENTS_PER_CYCLE
    directions = _contact_under_flat(one, start, height, ends)[0]
    powers = np.arange(TAYLOR_DEGREE - 2, -1, -1)
    nodes = (1 - np.cos(math.pi * (np.arange(len(powers)) + 0.5) / len(powers))) / 2
    widths = np.diff(directions)
    normals = _normals_under_flat(one, start, height, directions[:-1, np.newaxis] + widths[:, np.newaxis] * nodes)
    bends = _contact_under_flat(one, start, height, normals)[3]
    _, radii, slopes, _ = _contact_under_flat(one, start, height, ends[:-1])
    scaled = np.linalg.solve(nodes[:, np.newaxis] ** powers, bends.T).T / widths[:, np.newaxis] ** powers
    return np.column_stack([directions[:-1], scaled / ((powers + 1) * (powers + 2)), slopes, radii])


def _contact_under_flat(
    one: Lift, start: float, height: float, normals: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return direction (rad), radius, slope and second derivative of a cam where its normal has some angles (rad)."""
    turn = (math.pi if one.law == HARMONIC else math.tau) / one.over
    angles = normals - start
    if one.law == HARMONIC:
        lift = one.lift * (1 - np.cos(turn * angles)) / 2
        rate = one.lift * turn * np.sin(turn * angles) / 2
        bend = one.lift * turn**2 * np.cos(turn * angles) / 2
    else:
        lift = one.lift * (angles / one.over - np.sin(turn * angles) / math.tau)
        rate = one.lift / one.over * (1 - np.cos(turn * angles))
        bend = one.lift / one.over * turn * np.sin(turn * angles)
    h, curvature_radius = height + lift, height + lift + bend
    if np.min(curvature_radius) <= 0.0:
        place = math.degrees(float(normals.flat[int(np.argmin(curvature_radius))]))
        raise MechanismError(
            f"the cam would have an edge or a hollow at {place:.4g} deg, on which a flat follower does not rest: its radius of curvature, "
            f"radius + lift + its second derivative, is {float(np.min(curvature_radius)):.4g} m there; give it a larger radius"
        )
    radius, slope = np.hypot(h, rate), np.hypot(h, rate) * rate / h
    length_squared = radius**2 + slope**2
    second_derivative = (radius**2 + 2 * slope**2 - length_squared**1.5 / curvature_radius) / radius
    return normals + np.arctan2(rate, h), radius, slope, second_derivative


def _normals_under_flat(one: Lift, start: float, height: float, directions: FloatArray) -> FloatArray:
    """Return the angles (rad) of the normals at points of a cam in some directions (rad), by bisection and Newton's method."""
    low = np.full(directions.shape, start)
    high = np.full(directions.shape, start + one.over)
    normals = directions
    for _ in range(INVERSION_STEPS):
        normals = np.where((normals > low) & (normals < high), normals, (low + high) / 2)
        reached, radius, slope, second_derivative = _contact_under_flat(one, start, height, normals)
        low = np.where(reached <= directions, normals, low)
        high = np.where(reached >= directions, normals, high)
        # the normal turns by the curvature times the length, of which there are hypot(radius, slope) a radian
        turning = (radius**2 + 2 * slope**2 - radius * second_derivative) / (radius**2 + slope**2)
        normals = normals + (directions - reached) * turning
    return normals


def concatenate_segments(parts: list[FloatArray]) -> FloatArray:
    """Return all curve segments with as many coefficients as the highest degree needs; the others are zero."""
    n_columns = max((part.shape[1] for part in parts), default=2)
    filled = (np.insert(part, [1] * (n_columns - part.shape[1]), 0.0, axis=1) for part in parts)
    return np.concatenate([np.zeros((0, n_columns)), *filled])
