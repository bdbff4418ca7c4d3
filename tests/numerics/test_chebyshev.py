"""Pieces of a Chebyshev table: polynomials up to degree eleven are exact."""

import numpy as np
import pytest

from governor_mechanism.numerics.interpolation import CHEBYSHEV_NODES, N_CHEBYSHEV_NODES, barycentric_weights


@pytest.mark.parametrize("t", [-1.0, -0.37, 0.9, *CHEBYSHEV_NODES[[0, 5]]])
def test_barycentric_weights_sum_the_values_at_the_nodes_to_the_polynomial(t):
    polynomial = np.polynomial.Polynomial(np.random.default_rng(2).normal(size=N_CHEBYSHEV_NODES))
    weights = np.empty(N_CHEBYSHEV_NODES)
    barycentric_weights(t, weights)
    assert weights @ polynomial(CHEBYSHEV_NODES) == pytest.approx(polynomial(t), rel=1e-12)
    assert np.sum(weights) == pytest.approx(1.0, rel=1e-14)
