"""Hermite interpolation through several nodes: exact for polynomials, and of the order of its number of nodes."""

import numpy as np
import pytest

from governor_mechanism.numerics.interpolation import MultipointHermite

NODES = np.array([[0.0, 0.3, 0.5, 1.0], [2.0, 2.2, 2.7, 3.0]])


def interpolate(function, nodes):
    """Return the interpolant of a function that gives a value and two derivatives."""
    return MultipointHermite(nodes, *function(nodes))


@pytest.mark.parametrize("n_nodes", [2, 3, 4])
def test_polynomials_up_to_the_degree_are_reproduced(n_nodes):
    polynomial = np.polynomial.Polynomial(np.random.default_rng(5).normal(size=3 * n_nodes))
    interpolant = interpolate(lambda x: (polynomial(x), polynomial.deriv()(x), polynomial.deriv(2)(x)), NODES[:, :n_nodes])
    at = np.array([0.1, 2.15])
    for found, exact in zip(interpolant.evaluate(at), (polynomial(at), polynomial.deriv()(at), polynomial.deriv(2)(at)), strict=True):
        np.testing.assert_allclose(found, exact, rtol=1e-8)  # rounding, as divided differences over 0.2 to the power 11 magnify it


@pytest.mark.parametrize(("n_nodes", "order"), [(2, 6), (3, 9), (4, 12)])
def test_the_error_falls_with_three_orders_a_node(n_nodes, order):
    errors = []
    for width in (1.0, 0.5):
        nodes = 0.4 + width * np.linspace(0.0, 1.5, n_nodes)[np.newaxis]
        interpolant = interpolate(lambda x: (np.exp(2 * x), 2 * np.exp(2 * x), 4 * np.exp(2 * x)), nodes)
        at = 0.4 + width * np.array([0.11])
        errors.append(abs(float(interpolant.evaluate(at)[0][0]) - float(np.exp(2 * at)[0])))
    # The next derivative grows by e at most over twice the width: less than an order and a half more.
    assert order < np.log2(errors[0] / errors[1]) < order + 1.5
