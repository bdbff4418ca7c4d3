"""The coefficients of DOP853 are those of scipy, to the bit."""

import numpy as np
from scipy.integrate import DOP853

from governor_mechanism.integrators import tableau


def test_the_coefficients_are_those_of_scipy():
    assert np.array_equal(tableau.NODES, [*DOP853.C, 1.0, *DOP853.C_EXTRA])
    assert np.array_equal(tableau.STAGES[:12], np.pad(DOP853.A, ((0, 0), (0, 4))))
    assert np.array_equal(tableau.STAGES[12], np.pad(DOP853.B, (0, 4)))
    assert np.array_equal(tableau.STAGES[13:], DOP853.A_EXTRA)
    assert np.array_equal(tableau.ERROR_5, DOP853.E5)
    assert np.array_equal(tableau.ERROR_3, DOP853.E3)
    assert np.array_equal(tableau.DENSE_WEIGHTS, DOP853.D)
