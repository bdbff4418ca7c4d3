"""Checks of the types of the arguments of public functions."""

from __future__ import annotations

import functools
import inspect
import os
import sys
from collections.abc import Callable, Mapping
from numbers import Integral, Real
from typing import Any, Final, ParamSpec, TypeVar

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import format_value

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")
Requirement = tuple[str, Callable[[Any], bool]]
"""What an argument must be, in words and as a predicate."""


def _is_numeric(value: Any) -> bool:
    """Return whether NumPy reads a value as a list of numbers."""
    import numpy as np  # slow to import

    try:
        return bool(np.asarray(value, dtype=np.float64).ndim == 1)
    except (TypeError, ValueError, OverflowError):
        return False


TEXT: Final[Requirement] = "text", lambda value: isinstance(value, str)
FLAG: Final[Requirement] = "true or false", lambda value: isinstance(value, bool)
NUMBER: Final[Requirement] = (
    "a finite number",
    lambda value: isinstance(value, Real) and not isinstance(value, bool) and bool(abs(value) <= sys.float_info.max),  # type: ignore[operator]
)
NUMBERS: Final[Requirement] = "a list of finite numbers", _is_numeric
QUANTITY: Final[Requirement] = "a finite number, or text with a unit", lambda value: isinstance(value, str) or NUMBER[1](value)
QUANTITIES: Final[Requirement] = (
    "a list of finite numbers, or of texts with units",
    lambda value: _is_numeric([0.0 if isinstance(one, str) else one for one in value] if isinstance(value, list | tuple) else value),
)
TEXTS: Final[Requirement] = (
    "a list of texts",
    lambda value: isinstance(value, list | tuple) and all(isinstance(one, str) for one in value),
)
VARIED: Final[Requirement] = (
    'values by key, as {"dimensions.arm": ["200 mm", "300 mm"]}, or a list of texts',
    lambda value: isinstance(value, Mapping | str) or TEXTS[1](value),
)
FUNCTION: Final[Requirement] = "a function", callable
PATH: Final[Requirement] = "a path", lambda value: isinstance(value, str | os.PathLike)
BY_NAME: Final[Requirement] = "values by name, as a mapping", lambda value: isinstance(value, Mapping)
TEXTS_BY_NAME: Final[Requirement] = (
    "texts by name, as a mapping",
    lambda value: isinstance(value, Mapping) and all(isinstance(text, str) for pair in value.items() for text in pair),
)


def whole_number(least: int) -> Requirement:
    """Return the requirement of a whole number of at least `least`."""
    return (
        f"a whole number of at least {least}",
        lambda value: isinstance(value, Integral) and not isinstance(value, bool) and int(value) >= least,
    )


def check_arguments(**requirements: Requirement) -> Callable[[Callable[_Parameters, _Result]], Callable[_Parameters, _Result]]:
    """Return a decorator that checks arguments before each call; the default of an argument is always allowed.

    What each argument must be, in words and as a predicate, is given by its name.

    Result: the decorator; the function that it returns raises MechanismError.
    """

    def decorate(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def checked(*arguments: _Parameters.args, **options: _Parameters.kwargs) -> _Result:
            given = signature.bind(*arguments, **options).arguments
            for name, (description, is_met) in requirements.items():
                if name in given and given[name] is not signature.parameters[name].default and not is_met(given[name]):
                    raise MechanismError(f"{name} must be {description}; found {format_value(given[name])}")
            return function(*arguments, **options)

        return checked

    return decorate
