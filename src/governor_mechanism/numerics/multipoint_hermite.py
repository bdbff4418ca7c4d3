"""Hermite interpolation through values and two derivatives at several nodes, for many functions at once."""

import numpy as np

from governor_mechanism.types import FloatArray

N_CONDITIONS = 3
"""Conditions at each node: value, first and second derivative."""


class MultipointHermite:
    """Polynomials through values and two derivatives at their nodes, in Newton's form.

    With k nodes the degree is 3 k - 1.

    Parameters
    ----------
    nodes
        Nodes of each function; shape (functions, k).
    values
        Values at the nodes; same shape.
    rates
        First derivatives; same shape.
    accelerations
        Second derivatives; same shape.
    """

    def __init__(self, nodes: FloatArray, values: FloatArray, rates: FloatArray, accelerations: FloatArray) -> None:
        self._nodes = np.repeat(nodes, N_CONDITIONS, axis=1)
        derivatives = [np.repeat(one, N_CONDITIONS, axis=1) for one in (values, rates, 0.5 * accelerations)]
        differences, coefficients = derivatives[0], [derivatives[0][:, 0]]
        for order in range(1, self._nodes.shape[1]):
            intervals = self._nodes[:, order:] - self._nodes[:, :-order]
            quotients = np.diff(differences, axis=1) / np.where(intervals == 0.0, 1.0, intervals)
            # Differences over one node alone are derivatives there.
            differences = np.where(intervals == 0.0, derivatives[min(order, 2)][:, order:], quotients)
            coefficients.append(differences[:, 0])
        self._coefficients = coefficients

    def evaluate(self, arguments: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return value and first two derivatives of each function at an argument of its own; shape (functions,) each."""
        value, rate, acceleration = self._coefficients[-1], np.zeros_like(arguments), np.zeros_like(arguments)
        for order in range(len(self._coefficients) - 2, -1, -1):
            distance = arguments - self._nodes[:, order]
            acceleration = acceleration * distance + 2.0 * rate
            rate = rate * distance + value
            value = value * distance + self._coefficients[order]
        return value, rate, acceleration
