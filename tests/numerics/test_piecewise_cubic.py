"""Piecewise cubics: values, derivatives and integrals as those of scipy."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from governor_mechanism.numerics.piecewise_cubic import PiecewiseCubic

SPLINE = CubicSpline([0.0, 0.5, 1.5, 4.0], [1.0, -2.0, 0.3, 5.0])
CUBIC = PiecewiseCubic(SPLINE.x, SPLINE.c)
POINTS = np.array([-1.0, 0.0, 0.2, 0.5, 1.0, 1.5, 3.9, 4.0, 6.0])


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_values_and_derivatives_at_knots_between_them_and_beyond_the_ends(order):
    assert CUBIC(POINTS, order) == pytest.approx(SPLINE(POINTS, order), rel=1e-13, abs=1e-13)  # rounding


@pytest.mark.parametrize("ends", [(0.1, 0.4), (0.0, 4.0), (-2.0, 7.0), (0.5, 1.5), (1.0, 1.0)])
def test_integrals_within_a_piece_across_knots_and_beyond_the_ends(ends):
    assert CUBIC.integrate(*ends) == pytest.approx(float(SPLINE.integrate(*ends)), rel=1e-13, abs=1e-13)  # rounding
