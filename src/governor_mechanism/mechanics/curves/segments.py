"""Guide curves as polynomial segments."""

import math

import numpy as np

from governor_mechanism.model.curves import HARMONIC, Curve, Lift, LiftCurve, PolarHarmonics, PolarSpline, PolynomialCurve, SplineCurve
from governor_mechanism.types import FloatArray


def make_curve_segments(
    curve: Curve,  # polynomial or spline curve y = f(x), m, or closed curve r = f(angle), m and rad
) -> FloatArray:
    """Return a guide curve as polynomial segments.

    Result: start of each segment along x (m) or of the angle (rad), then its coefficients, highest power
    first; shape (segments, columns). Raises TypeError if there are no segments for this type of curve.
    """
    if isinstance(curve, PolynomialCurve):
        return np.array([[0.0, *reversed(curve.coefficients)]])
    if isinstance(curve, SplineCurve):
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(curve.x, curve.y)
        return np.column_stack([spline.x[:-1], spline.c.T])
    if isinstance(curve, PolarSpline):
        from scipy.interpolate import CubicSpline

        angles, radii = (
            np.append(values, end) for values, end in ((curve.angles, curve.angles[0] + math.tau), (curve.radii, curve.radii[0]))
        )
        spline = CubicSpline(angles, radii, bc_type="periodic")
        return np.column_stack([spline.x[:-1], spline.c.T])
    if isinstance(curve, PolarHarmonics):
        return _harmonic_segments(curve)
    if isinstance(curve, LiftCurve):
        return _lift_segments(curve)
    raise TypeError(f"no segments are defined for curves of type {type(curve).__name__}")


SEGMENTS_PER_CYCLE, TAYLOR_DEGREE = 16, 13
"""Segments per cycle of the highest harmonic of a closed curve, and degree of its Taylor polynomial in each: radius and second
derivative are exact to 2e-17 and 3e-14 of the amplitude and its second derivative."""


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
        parts.append(_segments_of_lift(one, start, radius))
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


def concatenate_segments(parts: list[FloatArray]) -> FloatArray:
    """Return all curve segments with as many coefficients as the highest degree needs; the others are zero."""
    if len(parts) == 1:
        return parts[0]
    n_columns = max(part.shape[1] for part in parts)
    return np.concatenate([np.insert(part, [1] * (n_columns - part.shape[1]), 0.0, axis=1) for part in parts])
