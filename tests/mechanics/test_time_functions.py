"""Prescribed motions as functions of time: tables and formulas against polynomials and sines."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import VALUE_COLUMN, CubicTimeFunction, SpindleSpeedFunction, stack_local_cubics
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.time_functions import Harmonic, InputFunction, PrescribedMotion

INSIDE = np.linspace(0.0, 1.6, 33)
KNOTS = (0.0, 0.3, 0.7, 1.2, 1.6)


@pytest.mark.parametrize(("degree", "n_points"), [(1, 2), (1, 3), (2, 3), (2, 4), (3, 4), (3, 5)])
def test_a_table_reproduces_polynomials_up_to_the_third_degree(degree, n_points):
    polynomial = np.polynomial.Polynomial((0.4, -1.3, 2.1, 0.9)[: degree + 1])
    times = (*KNOTS[: n_points - 1], KNOTS[-1])
    motion = CubicTimeFunction(PrescribedMotion(times=times, values=tuple(polynomial(np.array(times)).tolist())))
    # Rounding of values near 10, divided by squares of intervals of 0.3 s in second derivatives.
    np.testing.assert_allclose(motion(INSIDE), polynomial(INSIDE), atol=1e-13)
    np.testing.assert_allclose(motion.derivative(INSIDE[:-1]), polynomial.deriv()(INSIDE[:-1]), atol=1e-12)
    np.testing.assert_allclose(motion.second_derivative(INSIDE[:-1]), polynomial.deriv(2)(INSIDE[:-1]), atol=1e-11)
    # Taylor's coefficients, highest power first, as the equations of motion evaluate them; the third by cubes of the intervals.
    taylor = [polynomial.deriv(order)(INSIDE[:-1]) / factorial for order, factorial in ((3, 6), (2, 2), (1, 1), (0, 1))]
    np.testing.assert_allclose(motion.local_cubics(INSIDE[:-1])[:, : VALUE_COLUMN + 1], np.column_stack(taylor), atol=1e-10)


def test_a_formula_and_its_derivatives_have_no_interpolation_error():
    harmonics = (Harmonic(amplitude=0.3, frequency=2.0, phase=0.5), Harmonic(amplitude=-0.1, frequency=7.0))
    motion = CubicTimeFunction(PrescribedMotion.constant_rate(0.2, 1.5, harmonics))
    waves = 0.3 * np.exp(1j * (4 * np.pi * INSIDE + 0.5)), -0.1 * np.exp(14j * np.pi * INSIDE)
    derivatives = [sum((1j * w) ** k * wave for w, wave in zip((4 * np.pi, 14 * np.pi), waves, strict=True)).imag for k in range(3)]
    # Rounding of the values times the squared angular frequency of 44 rad/s in second derivatives.
    np.testing.assert_allclose(motion(INSIDE), 0.2 + 1.5 * INSIDE + derivatives[0], atol=1e-14)
    np.testing.assert_allclose(motion.derivative(INSIDE), 1.5 + derivatives[1], atol=1e-12)
    np.testing.assert_allclose(motion.second_derivative(INSIDE), derivatives[2], atol=1e-11)
    assert len(motion.breakpoints) == 0
    assert not motion.is_constant
    assert not CubicTimeFunction(InputFunction(values=(4.0,), harmonics=harmonics)).is_constant
    assert CubicTimeFunction(InputFunction(values=(4.0, 4.0), times=(0.0, 1.0))).is_constant


@pytest.mark.parametrize(
    ("times", "values"), [((1.0, 3.0), (0.5, -0.1)), ((1.0, 2.5, 3.0), (0.5, 0.2, 0.9)), ((-1.0, 0.0, 2.0, 2.5), (0, 1, 0, 3))]
)
def test_a_motion_goes_on_at_the_rates_of_its_ends(times, values):
    motion = CubicTimeFunction(PrescribedMotion(times=times, values=values))
    spline = CubicSpline(times, values)  # of two points a line, of three a parabola
    assert motion(np.array(times)) == pytest.approx(values, abs=1e-14)
    for end, beyond in ((times[0], times[0] - 2.0), (times[-1], times[-1] + 3.0)):
        rate = float(spline(end, 1))
        assert motion.derivative(np.array([beyond])) == pytest.approx([rate], abs=1e-13)
        assert motion(np.array([beyond])) == pytest.approx([float(spline(end)) + rate * (beyond - end)], abs=1e-13)


@pytest.mark.parametrize("start", [0.0, 0.35])
def test_the_integral_of_a_sine_is_its_cosine(start):
    wave = Harmonic(amplitude=0.3, frequency=2.0, phase=0.5)
    integrals = CubicTimeFunction(InputFunction(values=(4.0,), harmonics=(wave,))).integrals(start, INSIDE)
    cosine = lambda time: np.cos(4 * np.pi * time + 0.5)  # noqa: E731
    np.testing.assert_allclose(integrals, 4.0 * (INSIDE - start) + 0.3 / (4 * np.pi) * (cosine(start) - cosine(INSIDE)), atol=1e-14)


def test_rows_of_inputs_without_harmonics_are_filled_with_zeros():
    wave = PrescribedMotion.constant_rate(0.0, 0.0, (Harmonic(amplitude=0.3, frequency=2.0, phase=0.5),))
    rows = stack_local_cubics([CubicTimeFunction(InputFunction(values=(4.0,))), CubicTimeFunction(wave)], np.array([0.0, 0.25]))
    np.testing.assert_array_equal(rows[:, 0], [[0, 0, 0, 4, 0, 0, 0, 0], [0, 0, 0, 4, 1, 0, 0, 0]])
    np.testing.assert_allclose(rows[:, 1, 5:], [[0.3, 4 * np.pi, 0.5], [0.3, 4 * np.pi, 0.5 + np.pi]], rtol=1e-15)


@pytest.mark.parametrize("wrong", [{"frequency": 0.0}, {"frequency": -1.0}, {"frequency": 1.0, "phase": float("nan")}])
def test_a_harmonic_has_finite_values_and_a_positive_frequency(wrong):
    with pytest.raises(MechanismError, match=next(reversed(wrong))):
        Harmonic(amplitude=1.0, **wrong)


def test_a_motion_with_rests_is_monotone_and_its_rate_does_not_jump():
    times, values = (0.1, 0.5, 0.8, 1.5), (1.0, 1.0, 0.2, -0.4)
    motion = CubicTimeFunction(PrescribedMotion(times=times, values=values, has_rests=True))
    np.testing.assert_allclose(motion(np.array(times)), values, atol=1e-15)
    np.testing.assert_array_equal(motion(np.array([-3.0, 0.3, 9.0])), [1.0, 1.0, -0.4])  # rests before, between and after the points
    assert np.all(np.diff(motion(INSIDE)) <= 0.0)
    before, after = (motion.derivative(np.array(times) + shift) for shift in (-1e-9, 1e-9))
    np.testing.assert_allclose(before, after, atol=1e-6)  # accelerations of 30 over 2e-9 s
    np.testing.assert_allclose(after[[0, 1, 3]], 0.0, atol=1e-6)


def test_a_motion_of_two_rests_is_a_smooth_step():
    motion = CubicTimeFunction(PrescribedMotion(times=(0.2, 1.2), values=(3.0, -1.0), has_rests=True))
    part = np.clip(INSIDE - 0.2, 0.0, 1.0)
    np.testing.assert_allclose(motion(INSIDE), 3.0 - 4.0 * part**2 * (3.0 - 2.0 * part), atol=1e-14)


@pytest.mark.parametrize(("times", "values"), [((0.0, 0.0, 1.0), (1.0, 2.0, 4.0)), ((0.0, 1.0, 1.0), (2.0, 4.0, 9.0))])
def test_a_jump_may_be_the_first_or_the_last_point(times, values):
    load = CubicTimeFunction(InputFunction(times=times, values=values))
    np.testing.assert_allclose(load(np.array([0.25, 0.5, 0.75])), [2.5, 3.0, 3.5], rtol=1e-15)
    np.testing.assert_array_equal(load(np.array([-1.0, 0.0, 1.0, 2.0])), [values[0], 2.0, values[2], values[2]])


def test_the_speed_of_an_uneven_spindle_swings_with_its_angle():
    uneven = SpindleSpeedFunction(Spindle(speeds=(12.0,), speed_fluctuation=0.1, cycles_per_turn=3.0), ratio=-2.0)
    phases = 3.0 * 12.0 * INSIDE
    np.testing.assert_allclose(uneven(INSIDE), -2.0 * 12.0 * (1 + 0.05 * np.sin(phases)), rtol=1e-13)
    np.testing.assert_allclose(uneven.derivative(INSIDE), -2.0 * 12.0 * 0.05 * 36.0 * np.cos(phases), atol=1e-11)
    assert not uneven.is_constant
    assert uneven.start_speed == -24.0
    for even in (Spindle(speeds=(12.0,)), FreeSpindle(inertia=1.0, start_speed=12.0)):
        function = SpindleSpeedFunction(even)
        assert function.is_constant
        np.testing.assert_array_equal(function(INSIDE), np.full(INSIDE.shape, 12.0))
        np.testing.assert_array_equal(function.derivative(INSIDE), np.zeros(INSIDE.shape))
