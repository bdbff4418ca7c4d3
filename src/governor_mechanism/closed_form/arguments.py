"""The domain of the closed forms: what they take as a number, what they refuse, and how they hand results back.

Numbers are floats or arrays that broadcast; floats give a float. A refusal is a MechanismError that shows the value.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray

Number = float | FloatArray


def refuse_where(bad: Any, sentence: str, *found: tuple[str, Number, str], cure: str = "") -> None:
    """Raise MechanismError where `bad` holds, showing the first offending (name, value, unit) of each one found."""
    if not np.any(bad):
        return
    where = np.argwhere(bad)[0]
    shown = []
    for name, value, unit in found:
        array = np.asarray(value)
        own = where[where.size - array.ndim :] * (np.array(array.shape, dtype=np.intp) > 1)
        index = f"[{', '.join(str(i) for i in own)}]" if array.ndim else ""
        shown.append(f"{name}{index} = {array[tuple(own)]:.12g} {unit}".rstrip())
    raise MechanismError(f"{sentence}; got {' and '.join(shown)}" + (f"; {cure}" if cure else ""))


def checked(value: Number, name: str, unit: str, *, least: float = -math.inf, above: float = -math.inf) -> FloatArray:
    """The value as a float array, refused unless it is finite, at least `least` and above `above`."""
    try:
        plain = np.asarray(value)
    except ValueError:  # a ragged list
        plain = np.asarray(None)
    if plain.dtype.kind not in "iuf":
        kind = f"a number or an array of numbers in {unit}" if unit else "a number or an array of numbers"
        raise MechanismError(f"{name} must be {kind}; got {value!r}")
    array = plain.astype(np.float64)
    refuse_where(~np.isfinite(array), f"{name} must be finite", (name, array, unit))
    refuse_where(array < least, f"{name} must be {least:g} {unit}".rstrip() + " or more", (name, array, unit))
    refuse_where(array <= above, f"{name} must be above {above:g} {unit}".rstrip(), (name, array, unit))
    return array


def as_given(result: Number) -> Number:
    """A float for a single number, the array otherwise; refuses what double precision cannot hold."""
    array = np.asarray(result, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise MechanismError("the result is too large or too small for double precision; check the units of the input")
    return float(array) if array.ndim == 0 else array
