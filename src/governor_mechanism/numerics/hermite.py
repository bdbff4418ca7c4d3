"""What lies between samples: cubic and quintic Hermite interpolation, polynomials through nodes, integrals of straight lines."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from governor_mechanism.numerics.jit import jit_in_place
from governor_mechanism.types import FloatArray


def cubic_hermite(start: Any, end: Any, start_derivative: Any, end_derivative: Any, length: Any, fraction: Any) -> Any:
    """Interpolate by the cubic through values and derivatives at both ends; arguments broadcast."""
    d0, d1, change = length * start_derivative, length * end_derivative, end - start
    return start + fraction * (d0 + fraction * (3 * change - 2 * d0 - d1 + fraction * (d0 + d1 - 2 * change)))


cubic_hermite_jit = jit_in_place(cubic_hermite)


def interpolate_samples(positions: FloatArray, values: FloatArray, derivatives: FloatArray, at: ArrayLike) -> FloatArray:
    """Return values (m, ...) at positions (m,) by cubics through values and derivatives (n, ...) at positions (n,), beyond them too."""
    points = np.asarray(at, dtype=float)
    start = np.clip(np.searchsorted(positions, points, side="right") - 1, 0, len(positions) - 2)
    end = start + 1
    lengths = positions[end] - positions[start]
    fractions = (points - positions[start]) / lengths
    shape = (*points.shape, *[1] * (values.ndim - 1))
    interpolated: FloatArray = cubic_hermite(
        values[start], values[end], derivatives[start], derivatives[end], lengths.reshape(shape), fractions.reshape(shape)
    )
    return interpolated


def integrate_samples(positions: FloatArray, values: FloatArray) -> FloatArray:
    """Return the integrals (n,) from the first position (n,) to each of the straight lines between values (n,)."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(positions))])


def cubic_hermite_derivative(start: Any, end: Any, start_derivative: Any, end_derivative: Any, length: Any, fraction: Any) -> Any:
    """Return the derivative of `cubic_hermite` by the position, for the same arguments."""
    d0, d1, change = length * start_derivative, length * end_derivative, end - start
    return (d0 + fraction * (2 * (3 * change - 2 * d0 - d1) + fraction * 3 * (d0 + d1 - 2 * change))) / length


def quintic_hermite(
    start: Any,
    start_rate: Any,
    start_acceleration: Any,
    end: Any,
    end_rate: Any,
    end_acceleration: Any,
    h: Any,  # length of the interval, s
    fraction: Any,
) -> tuple[Any, Any]:
    """Return value and rate of the quintic through values, rates and accelerations at both ends; arguments broadcast."""
    c1, c2, p = h * start_rate, h * h * start_acceleration, fraction
    value_residual, rate_residual = end - start - c1 - 0.5 * c2, h * end_rate - c1 - c2
    acceleration_residual = h * h * end_acceleration - c2
    c3 = 10 * value_residual - 4 * rate_residual + 0.5 * acceleration_residual
    c4 = -15 * value_residual + 7 * rate_residual - acceleration_residual
    c5 = 6 * value_residual - 3 * rate_residual + 0.5 * acceleration_residual
    value = start + p * (c1 + p * (0.5 * c2 + p * (c3 + p * (c4 + p * c5))))
    return value, (c1 + p * (c2 + p * (3 * c3 + p * (4 * c4 + p * 5 * c5)))) / h


quintic_hermite_jit = jit_in_place(quintic_hermite)


N_CONDITIONS = 3
"""Conditions at each node: value, first and second derivative."""


class MultipointHermite:
    """Polynomials of degree 3 k - 1 through values and two derivatives at their k nodes, (functions, k) each, in Newton's form."""

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
