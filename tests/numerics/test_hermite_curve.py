"""Curves through samples with two derivatives: exact for polynomials, of the order of the number of samples, and their roots."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from governor_mechanism.numerics.hermite_curve import HermiteCurve

PLACES = np.array([0.0, 0.3, 0.5, 1.0, 1.2, 1.7, 2.0])


def curve_of(function, places):
    """Return the curve through a function that gives a value and two derivatives."""
    return HermiteCurve(places, *function(places))


def sine(x):
    return np.sin(x), np.cos(x), -np.sin(x)


@pytest.mark.parametrize("n_samples", [2, 3, 4])
def test_polynomials_up_to_the_degree_are_reproduced(n_samples):
    polynomial = np.polynomial.Polynomial(np.random.default_rng(5).normal(size=3 * n_samples))
    curve = curve_of(lambda x: (polynomial(x), polynomial.deriv()(x), polynomial.deriv(2)(x)), PLACES)
    at = np.array([0.1, 1.15])
    found = curve.evaluate(np.array([0, 3]), n_samples, at)
    for one, exact in zip(found, (polynomial(at), polynomial.deriv()(at), polynomial.deriv(2)(at)), strict=True):
        np.testing.assert_allclose(one, exact, rtol=1e-8)  # rounding, as divided differences over 0.2 to the power 11 magnify it


@pytest.mark.parametrize(("n_samples", "order"), [(2, 6), (3, 9), (4, 12)])
def test_the_error_falls_with_three_orders_a_sample(n_samples, order):
    errors = []
    for width in (1.0, 0.5):
        places = 0.4 + width * np.linspace(0.0, 1.5, n_samples)
        curve = curve_of(lambda x: (np.exp(2 * x), 2 * np.exp(2 * x), 4 * np.exp(2 * x)), places)
        at = 0.4 + width * np.array([0.11])
        errors.append(abs(float(curve.evaluate(np.array([0]), n_samples, at)[0, 0]) - float(np.exp(2 * at)[0])))
    # The next derivative grows by e at most over twice the width: less than an order and a half more.
    assert order < np.log2(errors[0] / errors[1]) < order + 1.5


@pytest.mark.parametrize("direction", [1, -1])  # a law may be followed backwards
@given(level=st.floats(-0.99, 0.99))
def test_crossings_and_extremes_of_a_sine(direction, level):
    places = np.linspace(0.0, 6.0, 61)[::direction]
    curve = curve_of(sine, places)
    values = np.sin(places) - level
    first = np.flatnonzero(values[:-1] * values[1:] < 0)
    ends = places[first], places[first + 1]
    found = curve.find_crossings(level, first, 2, np.minimum(*ends), np.maximum(*ends), 1e-9)
    np.testing.assert_allclose(np.sin(found), level, atol=1e-10)
    rates = np.cos(places)
    first = np.clip(np.flatnonzero(rates[:-1] * rates[1:] < 0) - 1, 0, 57)
    ends = places[first + 1], places[first + 2]
    turns = curve.find_extremes(first, 4, np.minimum(*ends), np.maximum(*ends), 1e-9)
    np.testing.assert_allclose(np.sort(turns), [np.pi / 2, 3 * np.pi / 2], rtol=1e-13)


def test_a_bracket_is_halved_where_newton_would_leave_it():
    places = np.array([-1.0, 3.0])
    # x^5 - 0.01 is flat in between: from the middle, 1, Newton creeps, and at 0 its slope is nothing
    curve = curve_of(lambda x: (x**5 - 0.01, 5 * x**4, 20 * x**3), places)
    for low, high in ((-1.0, 3.0), (-1.0, 1.0), (0.0, 0.5)):
        found = curve.find_crossings(0.0, np.array([0]), 2, np.array([low]), np.array([high]), 1e-9)
        np.testing.assert_allclose(found, 0.01**0.2, rtol=1e-12)


def test_no_brackets_no_roots():
    curve = curve_of(sine, PLACES)
    nothing = np.zeros(0)
    assert curve.find_extremes(np.zeros(0, dtype=np.intp), 2, nothing, nothing, 1e-9).size == 0
