"""Roots of functions in brackets, and derivatives by nine-point central differences with an estimate of their error."""

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
    """Return a root in a bracket, to about 1e-14, by Brent's method, or the end where rounding at a root hides the change of sign."""
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
    """Return the roots (n,) of costly functions, evaluated together, in n brackets by Newton's method, safeguarded by bisection."""
    is_rising = function(high)[0] > 0
    roots: FloatArray = 0.5 * (low + high)
    for _ in range(MAX_NEWTON_STEPS):
        values, derivatives = function(roots)
        is_past_root = (values > 0) == is_rising
        low = np.where(is_past_root, low, roots)
        high = np.where(is_past_root, roots, high)
        steps = np.divide(-values, derivatives, out=np.full_like(values, np.inf), where=derivatives != 0)
        if np.all(np.abs(steps) < tolerance):
            return np.clip(roots + steps, low, high)
        candidates = roots + steps
        is_accepted = (candidates > low) & (candidates < high) | (np.abs(steps) < tolerance)
        roots = np.where(is_accepted, candidates, 0.5 * (low + high))
    return roots


VectorFunction = Callable[[FloatArray], FloatArray]
"""Function of vectors (k, n) that returns a vector for each, (k, m); NaN where it is not defined."""

# Orders of accuracy 8, 8 and 6. B. Fornberg, Mathematics of Computation 51 (1988), pp. 699-706.
_POSITIVE_WEIGHTS = {
    1: (0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280),
    2: (-205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560),
    3: (0.0, -61 / 30, 169 / 120, -3 / 10, 7 / 240),
}
"""Weights at the centre and at 1 to 4 steps; odd derivatives have the opposite sign on the other side."""

# The large ones suit functions that are nearly polynomials, the small ones functions with a singularity
# nearby.
STEP_RATIOS = tuple(0.16 / 2**k for k in range(8))
"""Steps that are tried, relative to the given direction."""

MAX_ROUNDING_RATIO = 10.0
"""Derivative relative to its rounding below which a function does not depend on a variable, where a tolerance is enough."""


def directional_derivative(
    function: VectorFunction,
    point: FloatArray,  # where to differentiate; shape (n,)
    # direction, as long as the function can be expected to change considerably; shape (n,)
    direction: FloatArray,
    order: int = 1,
    *,
    tolerance: float = 0.0,  # error relative to the largest component at which no further step is tried
) -> tuple[FloatArray, float]:
    """Return a derivative along a direction, NaN if there is none, and its error, the difference of steps and rounding, infinite then."""
    # Of two successive steps the pair whose results agree best is taken.
    positive = np.array(_POSITIVE_WEIGHTS[order])
    weights = np.concatenate([(-1) ** order * positive[:0:-1], positive])
    values = dict[float, FloatArray]()  # by the offset: half the points of a step are also points of the next one, which is half as long
    best = np.array(np.nan)
    best_error = np.inf
    previous = None
    for ratio in STEP_RATIOS:
        offsets = [k * ratio for k in range(-4, 5)]
        new = [offset for offset in offsets if offset not in values]
        values |= zip(new, function(point + np.multiply.outer(new, direction)), strict=True)
        samples = np.array([values[offset] for offset in offsets])
        derivative = weights @ samples / ratio**order
        if previous is not None:
            difference = float(np.max(np.abs(derivative - previous), initial=0.0))
            rounding = np.finfo(np.float64).eps * float(np.max(np.abs(weights) @ np.abs(samples), initial=0.0)) / ratio**order
            size = float(np.max(np.abs(derivative), initial=0.0))
            if difference + rounding < best_error:
                best, best_error = derivative, difference + rounding
            if difference <= tolerance * size or (tolerance and size + difference <= MAX_ROUNDING_RATIO * rounding):
                break
        previous = derivative
    return np.broadcast_to(best, samples.shape[1:]), best_error


def jacobian(
    function: VectorFunction,
    point: FloatArray,  # where to differentiate; shape (n,)
    # change of each variable that can be expected to change the function considerably; shape (n,)
    scales: FloatArray,
    *,
    tolerance: float = 0.0,  # error of a column relative to its largest component that is good enough
) -> tuple[FloatArray, FloatArray]:
    """Return the Jacobian (m, n) of a function, and the estimated error (n,) of each column."""
    columns = [directional_derivative(function, point, direction, tolerance=tolerance) for direction in np.diag(scales)]
    if not columns:
        return np.zeros((function(point[np.newaxis]).shape[1], 0)), np.zeros(0)
    return (
        np.stack([column / scale for (column, _), scale in zip(columns, scales, strict=True)], axis=-1),
        np.array([error for _, error in columns]) / scales,
    )
