"""Calls of a user's kernel: arguments by name, arrays or single numbers, and what a kernel must not do."""

import inspect
import math
import traceback
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value
from governor_mechanism.verification.user_kernel.simulated import Column
from governor_mechanism.verification.user_kernel.units import unit_factor

AGREEMENT = 1e-9
"""Relative difference of a result in an array and the same result alone below which it is rounding."""

Kernel = Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class KernelResults:
    """What a kernel returned at n points.

    Attributes
    ----------
    values
        Results; NaN where there is none; shape (n,).
    problems
        Sentences by the index of the point at which the kernel gave no real, finite number.
    defects
        Sentences on what the kernel must not do at all.
    is_vectorised
        Whether it was called with arrays.
    """

    values: FloatArray
    problems: Mapping[int, str]
    defects: tuple[str, ...]
    is_vectorised: bool


def name_of_kernel(kernel: Kernel) -> str:
    """Return the name of a function, also of one with some arguments fixed."""
    inner = getattr(kernel, "func", kernel)
    return str(getattr(inner, "__name__", "kernel"))


def match_arguments(
    kernel: Kernel,
    available: Mapping[str, Column],  # what it may take, by our names, SI
    # our name by its name, with a unit if it is not SI, as {"alpha": "arm_angle in deg"}
    names: Mapping[str, str],
) -> dict[str, Column]:
    """Return the arguments of a kernel by its own names, in the units that it wants.

    Raises MechanismError if a parameter without a default has no value, or a name or unit is wrong.
    """
    parameters = _parameters_of(kernel)
    for theirs in names:
        if theirs not in parameters:
            known = ", ".join(parameters) or "none"
            raise MechanismError(
                f"names gives {theirs!r}, which is no parameter of the kernel; it has {known}.{did_you_mean(theirs, parameters)}"
            )
    selected = {}
    for name, parameter in parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
            raise MechanismError(f"the kernel's parameter {name!r} cannot be matched by name; use plain named parameters")
        ours, _, unit = (part.strip() for part in str(names.get(name, name)).partition(" in "))
        if ours in available:
            column = available[ours]
            factor = unit_factor(unit, column.unit, f"argument {name!r}") if unit else 1.0
            selected[name] = Column(column.values / factor, unit or column.unit)
        elif name in names or parameter.default is parameter.empty:
            known = ", ".join(sorted(available))
            remedy = "" if name in names else f'; another name is given by names={{"{name}": "..."}} or --map {name}=...'
            raise MechanismError(
                f"the kernel has an unknown parameter {ours!r}; available: {known}{remedy}.{did_you_mean(ours, available)}"
            )
    return selected


def _parameters_of(kernel: Kernel) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(kernel).parameters
    except (TypeError, ValueError):
        raise MechanismError(
            f"the parameters of {name_of_kernel(kernel)!r} cannot be read; wrap it in a function with named parameters"
        ) from None


def call_kernel(
    kernel: Kernel,
    arguments: Mapping[str, Column],
    count: int,
    *,
    # whether the points are times, so that a result may depend on those before; otherwise a result in an
    # array must be that of its point alone
    is_history: bool = False,
) -> KernelResults:
    """Call a kernel at all points, with arrays if it takes them.

    Result: results and problems.
    """
    defects: list[str] = []
    values = _call_with_arrays(kernel, arguments, count, defects) if count > 1 else None
    if values is not None and not is_history:
        values = _confirm(kernel, arguments, values, defects)
    if values is None:
        outcomes = [_call_at(kernel, arguments, index) for index in range(count)]
        problems = {index: outcome for index, outcome in enumerate(outcomes) if isinstance(outcome, str)}
        numbers = np.array([math.nan if isinstance(outcome, str) else outcome for outcome in outcomes])
        return KernelResults(values=numbers, problems=problems, defects=tuple(defects), is_vectorised=False)
    wrong = np.flatnonzero(~np.isfinite(values)).tolist()
    problems = {index: _not_finite(float(values[index]), arguments, index) for index in wrong}
    return KernelResults(
        values=np.where(np.isfinite(values), values, math.nan), problems=problems, defects=tuple(defects), is_vectorised=True
    )


def _call_with_arrays(kernel: Kernel, arguments: Mapping[str, Column], count: int, defects: list[str]) -> FloatArray | None:
    """Return the results (n,) of one call; None if the kernel does not take arrays or does not return one number for each point."""
    given: dict[str, Any] = {
        name: column.values.copy()
        if np.any(column.values != column.values[0]) or name == next(iter(arguments))
        else float(column.values[0])
        for name, column in arguments.items()
    }
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            result = np.asarray(kernel(**given))
    except Exception:  # a kernel for single numbers raises anything; the calls with numbers tell what is really wrong
        result = np.empty(0)
    for name, value in given.items():
        if isinstance(value, np.ndarray) and not np.array_equal(value, arguments[name].values):
            first = int(np.argmax(value != arguments[name].values)) if value.shape == arguments[name].values.shape else 0
            defects.append(f"the kernel changes its argument {name!r} in place, called with {_format_call(arguments, first)} and others")
    if result.shape != (count,) or result.dtype.kind not in "iuf":
        return None
    return np.array(result, dtype=np.float64)


def _confirm(kernel: Kernel, arguments: Mapping[str, Column], values: FloatArray, defects: list[str]) -> FloatArray | None:
    """Return results (n,) of a call with arrays if the first and the last are those of a call with numbers; else None and a defect."""
    for index in (0, len(values) - 1):
        alone = _call_at(kernel, arguments, index)
        if isinstance(alone, str):
            continue  # it takes arrays only
        if not abs(alone - values[index]) <= AGREEMENT * max(abs(alone), abs(float(values[index]))):
            defects.append(
                f"the kernel returns {values[index]:.12g} in an array and {alone:.12g} alone for {_format_call(arguments, index)}; "
                "its results must not depend on one another"
            )
            return None
    return values


def _call_at(kernel: Kernel, arguments: Mapping[str, Column], index: int) -> float | str:
    """Return the kernel's number at a point, or a sentence on what it gave instead."""
    given = {name: float(column.values[index]) for name, column in arguments.items()}
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            returned = kernel(**given)
    except Exception as error:
        return f"the kernel raised {_describe(error)}, called with {_format_call(arguments, index)}"
    try:
        result = np.asarray(returned)
    except Exception:
        result = np.empty(0, dtype=object)
    if result.size != 1 or result.dtype.kind not in "iuf":
        shape = f", an array of shape {result.shape}" if result.ndim and result.dtype.kind in "iufc" else ""
        what = f"the complex number {result.item()}" if result.size == 1 and result.dtype.kind == "c" else format_value(returned)
        return f"the kernel must return one real number; it returned {what}{shape}, called with {_format_call(arguments, index)}"
    number = float(result.ravel()[0])
    return number if math.isfinite(number) else _not_finite(number, arguments, index)


def _not_finite(number: float, arguments: Mapping[str, Column], index: int) -> str:
    what = "NaN" if math.isnan(number) else f"{number}"
    return f"the kernel must return a finite number; it returned {what}, called with {_format_call(arguments, index)}"


def _describe(error: Exception) -> str:
    """Return an exception with the line of the kernel that raised it."""
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename != __file__]
    own = [frame for frame in frames if frame.filename == frames[0].filename]  # not in a library that it calls
    return f"{text} (line {own[-1].lineno} of {Path(own[-1].filename).name})" if own else text


def _format_call(arguments: Mapping[str, Column], index: int) -> str:
    """Return the arguments of a call in a phrase."""
    return ", ".join(f"{name} = {format_number(column.values[index], column.unit)}" for name, column in arguments.items()) or "no argument"


def format_number(value: float, unit: str) -> str:
    """Return a number with its unit; "1" is the unit of a bare number."""
    return f"{value:.12g}" if unit in ("", "1") else f"{value:.12g} {unit}"
