"""Roots of functions in brackets."""

from collections.abc import Callable

import numpy as np

from governor_mechanism.types import FloatArray

MAX_NEWTON_STEPS = 60
"""Largest number of safeguarded Newton steps; about a dozen are usual, and bisection alone needs about 50."""


def find_root(
    function: Callable[[float], float],  # function with values of opposite sign at the ends of the bracket
    low: float,
    high: float,  # the other ends of the brackets; shape as low
) -> float:
    """Return a root of a continuous function in a bracket, to about 1e-14, by Brent's method.

    Result: the root. If rounding at a root at one end hides the change of sign, that end.
    """
    from scipy.optimize import brentq  # slow to import

    at_low, at_high = function(low), function(high)
    if at_low * at_high > 0.0:
        return low if abs(at_low) < abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-14, rtol=1e-14))


def find_roots(
    # function of n arguments (n,) that returns n values and n derivatives
    function: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    low: FloatArray,  # ends of the brackets; shape (n,)
    high: FloatArray,  # ends of the brackets; shape (n,)
    tolerance: float,
) -> FloatArray:
    """Return the roots of n functions in n brackets by Newton's method, safeguarded by bisection.

    It suits functions that are expensive but can be evaluated together.

    Result: the roots; shape (n,).
    """
    is_rising = function(high)[0] > 0
    roots: FloatArray = 0.5 * (low + high)
    for _ in range(MAX_NEWTON_STEPS):
        values, derivatives = function(roots)
        is_past_root = (values > 0) == is_rising
        low, high = np.where(is_past_root, low, roots), np.where(is_past_root, roots, high)
        steps = np.divide(-values, derivatives, out=np.full_like(values, np.inf), where=derivatives != 0)
        if np.all(np.abs(steps) < tolerance):
            break
        candidates = roots + steps
        is_accepted = (candidates > low) & (candidates < high) | (np.abs(steps) < tolerance)
        roots = np.where(is_accepted, candidates, 0.5 * (low + high))
    return roots
