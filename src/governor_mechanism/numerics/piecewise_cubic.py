"""Piecewise cubic functions of one variable."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.types import FloatArray


@dataclass(frozen=True, eq=False)
class PiecewiseCubic:
    """A piecewise cubic; its first and last piece continue beyond its ends.

    Attributes
    ----------
    knots
        Ends of the pieces, ascending; shape (m + 1,).
    coefficients
        Coefficients of the powers of the distance from the start of each piece, highest power first; shape (4, m).
    """

    knots: FloatArray
    coefficients: FloatArray

    def __call__(self, x: FloatArray, derivative_order: int = 0) -> FloatArray:
        """Return values or derivatives (n,) at x (n,); at a knot those of the following piece."""
        pieces = np.searchsorted(self.knots[1:-1], x, side="right")
        coefficients = self.coefficients[:, pieces]
        for degree in range(3, 3 - derivative_order, -1):
            coefficients = coefficients[:-1] * np.arange(degree, 0, -1)[:, np.newaxis]
        return _horner(coefficients, x - self.knots[pieces])

    def integrate(self, start: float, end: float) -> float:
        """Return the integral from start to end."""
        antiderivatives = np.vstack([self.coefficients / np.array([[4.0], [3.0], [2.0], [1.0]]), np.zeros(self.coefficients.shape[1])])
        inner_knots = self.knots[1:-1]
        limits = np.concatenate([[start], inner_knots[(inner_knots > start) & (inner_knots < end)], [end]])
        pieces = np.searchsorted(inner_knots, limits[:-1], side="right")
        upper, lower = (_horner(antiderivatives[:, pieces], ends - self.knots[pieces]) for ends in (limits[1:], limits[:-1]))
        return float(np.sum(upper - lower))


def _horner(coefficients: FloatArray, x: FloatArray) -> FloatArray:
    """Return the values (n,) of polynomials with coefficients (degree + 1, n), highest power first, at x (n,)."""
    values: FloatArray = coefficients[0].copy()
    for row in coefficients[1:]:
        values = values * x + row
    return values
