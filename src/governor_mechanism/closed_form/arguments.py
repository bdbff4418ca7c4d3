"""The domain of the closed forms: what they take as a number, what they refuse, and how they hand results back.

Numbers are floats or arrays that broadcast; floats give a float. A refusal is a MechanismError that shows the value.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray

FloatOrArray = float | FloatArray


def raise_where(invalid: Any, message: str, *arguments: tuple[str, FloatOrArray, str], hint: str = "") -> None:
    """Raise MechanismError where `bad` holds, showing the first offending (name, value, unit) of each one found."""
    if not np.any(invalid):
        return
    first_index = np.argwhere(invalid)[0]
    shown = []
    for name, value, unit in arguments:
        array = np.asarray(value)
        array_index = first_index[first_index.size - array.ndim :] * (np.array(array.shape, dtype=np.intp) > 1)
        index_label = f"[{', '.join(str(i) for i in array_index)}]" if array.ndim else ""
        shown.append(f"{name}{index_label} = {array[tuple(array_index)]:.12g} {unit}".rstrip())
    raise MechanismError(f"{message}; got {' and '.join(shown)}" + (f"; {hint}" if hint else ""))


def validate_argument(
    value: FloatOrArray, name: str, unit: str, *, minimum: float = -math.inf, greater_than: float = -math.inf
) -> FloatArray:
    """The value as a float array, refused unless it is finite, at least `least` and above `above`."""
    try:
        raw = np.asarray(value)
    except ValueError:  # a ragged list
        raw = np.asarray(None)
    if raw.dtype.kind not in "iuf":
        expected = f"a number or an array of numbers in {unit}" if unit else "a number or an array of numbers"
        raise MechanismError(f"{name} must be {expected}; got {value!r}")
    array = raw.astype(np.float64)
    raise_where(~np.isfinite(array), f"{name} must be finite", (name, array, unit))
    raise_where(array < minimum, f"{name} must be {minimum:g} {unit}".rstrip() + " or more", (name, array, unit))
    raise_where(array <= greater_than, f"{name} must be above {greater_than:g} {unit}".rstrip(), (name, array, unit))
    return array


def as_scalar_or_array(result: FloatOrArray) -> FloatOrArray:
    """A float for a single number, the array otherwise; refuses what double precision cannot hold."""
    array = np.asarray(result, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise MechanismError("the result is too large or too small for double precision; check the units of the input")
    return float(array) if array.ndim == 0 else array
