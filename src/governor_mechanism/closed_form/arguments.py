"""Arguments of the closed forms, floats or arrays that broadcast, checked with the value shown, and results: a float for floats."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


def raise_where(invalid: Any, message: str, *arguments: tuple[str, FloatOrArray, str], hint: str = "") -> None:
    """Raise MechanismError where `invalid` holds, with the first offending value of each (name, value, unit) and a hint at the cure."""
    if not np.asarray(invalid).any():
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
    """Return the value as a float array; it must be finite, at least `minimum` and above `greater_than`."""
    if isinstance(value, float) and minimum <= value < math.inf and value > greater_than:
        return np.asarray(value)  # a valid number, the case of every step of an integration
    try:
        raw = np.asarray(value)
    except ValueError:  # a ragged list
        raw = np.asarray(None)
    if raw.dtype.kind not in "iuf":
        expected = f"a number or an array of numbers in {unit}" if unit else "a number or an array of numbers"
        raise MechanismError(f"{name} must be {expected}; got {value!r}")
    array = raw.astype(np.float64)
    raise_where(~np.isfinite(array), f"{name} must be finite", (name, array, unit))
    if max(minimum, greater_than) > -math.inf:
        raise_where(array < minimum, f"{name} must be {minimum:g} {unit}".rstrip() + " or more", (name, array, unit))
        raise_where(array <= greater_than, f"{name} must be above {greater_than:g} {unit}".rstrip(), (name, array, unit))
    return array


def validate_angle(value: FloatOrArray, name: str, below: float, *, positive: bool = False) -> FloatArray:
    """Return the angle (rad); its magnitude is below `below` (deg), and it is above 0 if it must be positive."""
    angle = validate_argument(value, name, "rad", greater_than=0.0 if positive else -math.inf)
    sentence = f"{name} must be below {below:g} deg" + ("" if positive else f" and above -{below:g} deg")
    raise_where(np.abs(angle) >= math.radians(below), sentence, (name, np.degrees(angle), "deg"))
    return angle


def validate_fields(owner: object, units: Mapping[str, str], *, minimum: float = -math.inf, greater_than: float = -math.inf) -> None:
    """Validate the attributes named in `units` against their unit and the bounds; an attribute may be None."""
    for name, unit in units.items():
        if getattr(owner, name) is not None:
            validate_argument(getattr(owner, name), name, unit, minimum=minimum, greater_than=greater_than)


def as_scalar_or_array(result: FloatOrArray) -> FloatOrArray:
    """Return a float for a single number, the array otherwise; raise MechanismError for a result that is not finite."""
    array = np.asarray(result, dtype=np.float64)
    if not np.isfinite(array).all():
        raise MechanismError("the result is too large or too small for double precision; check the units of the input")
    return float(array) if array.ndim == 0 else array
