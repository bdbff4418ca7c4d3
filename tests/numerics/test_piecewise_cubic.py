"""Piecewise cubics: values, derivatives and integrals as those of scipy, and jumps."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from governor_mechanism.mechanics.kinematics.time_functions import PiecewiseCubic

SPLINE = CubicSpline([0.0, 0.5, 1.5, 4.0], [1.0, -2.0, 0.3, 5.0])
CUBIC = PiecewiseCubic(SPLINE.x[1:-1], SPLINE.x[:-1], SPLINE.c.T)
POINTS = np.array([-1.0, 0.0, 0.2, 0.5, 1.0, 1.5, 3.9, 4.0, 6.0])


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_values_and_derivatives_at_breaks_between_them_and_beyond_the_ends(order):
    assert CUBIC.derivative(POINTS, order) == pytest.approx(SPLINE(POINTS, order), rel=1e-13, abs=1e-13)  # rounding


@pytest.mark.parametrize("start", [-2.0, 0.0, 0.1, 0.5, 1.5, 5.0])
def test_integrals_within_a_piece_across_breaks_and_beyond_the_ends(start):
    exact = [float(SPLINE.integrate(start, end)) for end in POINTS]
    assert CUBIC.integrals(start, POINTS) == pytest.approx(exact, rel=1e-13, abs=1e-13)  # rounding


def test_at_a_jump_the_right_limit_is_the_value_and_the_left_limit_is_given_on_request():
    # 2 before 1, then 5 + (x - 1).
    function = PiecewiseCubic(np.array([1.0]), np.array([0.0, 1.0]), np.array([[0, 0, 0, 2.0], [0, 0, 1.0, 5.0]]))
    jump = np.array([1.0])
    assert function.derivative(jump, 0) == 5.0
    assert function.derivative(jump, 0, left_limit=True) == 2.0
    assert function.integrals(0.0, np.array([3.0])) == pytest.approx(2.0 + 2 * 5.0 + 2.0)
