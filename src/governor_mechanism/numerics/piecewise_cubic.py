"""Piecewise cubics with jumps, evaluated at many points at once."""

from functools import cached_property

import numpy as np

from governor_mechanism.types import FloatArray, IntArray

DERIVATIVE_FACTORS = np.array([[1.0, 1.0, 1.0, 1.0], [3.0, 2.0, 1.0, 0.0], [6.0, 2.0, 0.0, 0.0], [6.0, 0.0, 0.0, 0.0]])
"""Factors on the coefficients, highest power first, in the derivative of each order up to the third."""

ANTIDERIVATIVE_FACTORS = np.array([1 / 4, 1 / 3, 1 / 2, 1.0])
"""Factors on the coefficients, highest power first, in the antiderivative."""


class PiecewiseCubic:
    """A function that is a cubic between breaks; the first piece extends to minus infinity, the last one to infinity.

    Parameters
    ----------
    breaks
        Where one piece ends and the next begins, ascending; shape (pieces - 1,).
    origins
        Zero of each piece's own argument; shape (pieces,).
    coefficients
        Coefficients of each piece, highest power first; shape (pieces, 4).
    """

    def __init__(self, breaks: FloatArray, origins: FloatArray, coefficients: FloatArray) -> None:
        self._breaks, self._origins, self._coefficients = breaks, origins, coefficients

    def derivative(self, arguments: FloatArray, order: int, *, left_limit: bool = False) -> FloatArray:
        """Return the derivative (n,) of an order from 0 to 3; at a break the right limit, or the left limit if requested."""
        pieces = self._find_pieces(arguments, left_limit)
        coefficients = (self._coefficients[:, : 4 - order] * DERIVATIVE_FACTORS[order, : 4 - order])[pieces]
        return _evaluate_polynomials(coefficients, arguments - self._origins[pieces])

    def integrals(self, start: float, ends: FloatArray) -> FloatArray:
        """Return the integrals (n,) from a start to each end."""
        values = self._antiderivative(np.append(ends, start))
        integrals: FloatArray = values[:-1] - values[-1]
        return integrals

    def _find_pieces(self, arguments: FloatArray, left_limit: bool = False) -> IntArray:
        return np.searchsorted(self._breaks, arguments, side="left" if left_limit else "right")

    def _antiderivative(self, arguments: FloatArray) -> FloatArray:
        """Return an antiderivative (n,), which is continuous."""
        pieces = self._find_pieces(arguments)
        own = arguments - self._origins[pieces]
        values: FloatArray = self._integration_constants[pieces] + own * _evaluate_polynomials(
            self._antiderivative_coefficients[pieces], own
        )
        return values

    @cached_property
    def _antiderivative_coefficients(self) -> FloatArray:
        coefficients: FloatArray = self._coefficients * ANTIDERIVATIVE_FACTORS
        return coefficients

    @cached_property
    def _integration_constants(self) -> FloatArray:
        """Constants (pieces,) that make the antiderivative continuous at the breaks."""
        coefficients, steps = self._antiderivative_coefficients, []
        for side in (0, 1):
            pieces = slice(side, len(self._origins) - 1 + side)
            own = self._breaks - self._origins[pieces]
            steps.append(own * _evaluate_polynomials(coefficients[pieces], own))
        return np.append(0.0, np.cumsum(steps[0] - steps[1]))


def _evaluate_polynomials(coefficients: FloatArray, arguments: FloatArray) -> FloatArray:
    """Return polynomials with coefficients (n, terms), highest power first, at arguments (n,)."""
    values = coefficients[:, 0]
    for column in range(1, coefficients.shape[1]):
        values = values * arguments + coefficients[:, column]
    return values
