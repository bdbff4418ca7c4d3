"""Roots of scalar functions."""

from __future__ import annotations

from collections.abc import Callable

from scipy.optimize import brentq


def find_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return a root of a continuous function in a bracket, to about 1e-14, by Brent's method.

    Parameters
    ----------
    function
        Function with values of opposite sign at the ends of the bracket.
    low, high
        Ends of the bracket, in either order.

    Returns
    -------
    float
        The root. If rounding at a root at one end hides the change of sign, that end.
    """
    at_low, at_high = function(low), function(high)
    if at_low * at_high > 0.0:
        return low if abs(at_low) < abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-14, rtol=1e-14))
