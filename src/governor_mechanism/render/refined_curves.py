"""Points of a smooth curve between reported times that are far apart: the line through the values and rates of a reading."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.render.range_bands import PlotSize
from governor_mechanism.types import FloatArray

MIN_DEVIATION = 0.25
"""Deviation of a curve from the straight line between two samples, in widths of the line, up to which nobody sees it."""
MAX_RATE_MISMATCH = 0.3
"""Largest difference of a step of the values from that by the mean of both rates, relative to the larger rate: a sine with 4 samples in a
period has up to 0.2, and a reading that jumps or has a kink about 1."""
POINTS_BETWEEN_SAMPLES = 7
"""Number of points that are put between two samples."""


def refine_curve(
    times: FloatArray,  # times of the samples, s; shape (n,)
    values: FloatArray,  # values; shape (n,)
    rates: FloatArray,  # their rates, 1/s; shape (n,)
    size: PlotSize,
) -> tuple[FloatArray, FloatArray]:
    """Return a curve with further points where straight lines between its samples would be seen as corners.

    The points lie on the cubic with the values and rates of both samples. None are put where rates and values do not belong together, as
    at an impact.

    Results: times, times with those of the further points, s; shape (m,); values, values there; shape (m,).
    """
    steps = np.diff(times)
    low, high = size.limits
    largest = np.maximum(np.abs(rates[:-1]), np.abs(rates[1:]))
    mismatch = np.abs(np.diff(values) - 0.5 * steps * (rates[:-1] + rates[1:]))
    # In the middle between two samples, the cubic is that far from the straight line.
    deviation = 0.125 * steps * np.abs(rates[:-1] - rates[1:]) * size.height / (high - low)
    is_refined = (deviation > MIN_DEVIATION * size.line_width) & (mismatch <= MAX_RATE_MISMATCH * steps * largest)
    if not is_refined.any():
        return times, values
    shares = np.arange(1, POINTS_BETWEEN_SAMPLES + 1) / (POINTS_BETWEEN_SAMPLES + 1)
    between = (times[:-1][is_refined, None] + steps[is_refined, None] * shares).ravel()
    order = np.argsort(all_times := np.concatenate([times, between]), kind="stable")
    all_values = np.concatenate([values, CubicHermiteSpline(times, values, rates)(between)])
    return all_times[order], all_values[order]
