"""Curves through values and rates: as near to the motion as cubics are, and straight where values and rates do not belong together."""

import math

import numpy as np

from governor_mechanism.render.range_bands import POINTS_BETWEEN_SAMPLES, PlotSize, refine_curve

SIZE = PlotSize(width=400.0, height=100.0, line_width=2.0, limits=(-1.2, 1.2))


def sampled(n_samples):
    times = np.linspace(0.0, 10.0, n_samples)
    return times, np.sin(math.tau * times + 0.4), math.tau * np.cos(math.tau * times + 0.4)


def test_a_coarsely_sampled_sine_gets_its_peaks_back():
    times, values, rates = sampled(81)
    assert np.abs(values).max() < 0.94
    finer, curve = refine_curve(times, values, rates, SIZE)
    assert set(times) <= set(finer)
    # The error of a cubic through values and rates: h^4 / 384 times the fourth derivative.
    step = math.tau / 8
    assert np.abs(curve - np.sin(math.tau * finer + 0.4)).max() <= step**4 / 384
    # A peak lies at most a sixteenth of a step from a point.
    assert np.abs(curve).max() > 1.0 - step**4 / 384 - (step / 16) ** 2 / 2


def test_a_curve_without_visible_corners_stays_as_it_is():
    times, values, rates = sampled(1001)
    assert refine_curve(times, values, rates, SIZE)[0] is times


def test_nothing_is_put_across_a_jump_or_a_kink():
    times = np.linspace(0.0, 1.0, 11)
    jumping = np.where(times < 0.45, 0.0, 1.0), np.zeros(11)
    bouncing = np.abs(times - 0.45), np.where(times < 0.45, -1.0, 1.0)
    for values, rates in (jumping, bouncing):
        finer, _ = refine_curve(times, values, rates, SIZE)
        if values is bouncing[0]:
            # The corner lies within a sample interval whose ends are alike: there alone a cubic may replace it.
            assert len(finer) <= len(times) + POINTS_BETWEEN_SAMPLES
        else:
            assert finer is times
