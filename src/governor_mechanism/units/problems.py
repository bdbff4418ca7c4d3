"""Mistakes of a scene file: sentences with a code and a key, collected until the whole file is checked."""

from __future__ import annotations

import functools
import inspect
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from enum import StrEnum
from itertools import repeat
from numbers import Integral, Real
from types import TracebackType
from typing import Any, Final, ParamSpec, TypeVar

from governor_mechanism.errors import MechanismError, did_you_mean, make_legible
from governor_mechanism.units.quantities import format_value

_Parsed = TypeVar("_Parsed")

KEY: Final = "\0"
"""Placeholder in a message for the key path of the value; `Problem.at` replaces it."""


class ProblemCode(StrEnum):
    """Kind of a mistake in a scene file."""

    UNREADABLE = "unreadable"
    UNKNOWN_KEY = "unknown key"
    MISSING_KEY = "missing key"
    WRONG_TYPE = "wrong type"
    WRONG_QUANTITY = "wrong quantity"
    OUT_OF_RANGE = "out of range"
    UNKNOWN_NAME = "unknown name"
    DUPLICATE = "duplicate"
    CONFLICT = "conflict"
    INCONSISTENT = "inconsistent"


class Problem(str):
    """One mistake of a scene file as a sentence.

    Attributes
    ----------
    code
        Kind of the mistake.
    key
        Path of the key at which it is, for example "dimensions.arm".
    """

    code: ProblemCode
    key: str

    def __new__(cls, text: str, code: ProblemCode = ProblemCode.INCONSISTENT, key: str = KEY) -> Problem:
        """Return the sentence; a `Problem` keeps its own code and key."""
        problem = super().__new__(cls, make_legible(text))
        problem.code, problem.key = (text.code, text.key) if isinstance(text, Problem) else (code, key)
        return problem

    def at(self, path: str) -> Problem:
        """Return the problem at a key path; a path that ends with ":" or "]" is the start of a sentence."""
        text = _replace_key(self, path)
        if KEY not in self and path not in ("", KEY):
            text = f"{path} {self}" if path.endswith((":", "]")) else f"{path}: {self}"
        return Problem(text, self.code, _replace_key(self.key, path))


def _replace_key(text: str, path: str) -> str:
    joint = f"{path} " if path.endswith(":") else f"{path}." if path else ""
    return re.sub(rf"{KEY}(\.?)", lambda match: joint if match[1] else path.rstrip(":"), text)


def mistake(code: ProblemCode, *messages: str, key: str = KEY) -> MechanismError:
    """Return the error of one or more messages with a code at a key."""
    return MechanismError(*(Problem(message, code, key) for message in messages))


def wrong_value(
    value: object, requirement: str, hint: str = "", *, code: ProblemCode = ProblemCode.WRONG_TYPE, path: str = KEY
) -> MechanismError:
    """Return the error of a value that does not meet a requirement; `path` is where a message finds it."""
    return mistake(code, f"{path} {requirement}; found {format_value(value)}{hint}")


def unknown_name(start: str, word: object, known: Iterable[str], end: str = "") -> MechanismError:
    """Return the error of a name that is not known; the known names stand between the start and the end of the sentence."""
    names = list(known)
    return mistake(ProblemCode.UNKNOWN_NAME, f"{start} {', '.join(names)}{end}.{did_you_mean(word, names)}")


class ProblemCollector:
    """The problems found so far; errors raised in the context `at` are collected instead of ending the check."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self.has_failed = False

    def add(self, code: ProblemCode, *messages: str, key: str = KEY) -> None:
        """Add messages with a code at a key."""
        self.problems += [Problem(message, code, key) for message in messages]
        self.has_failed |= bool(messages)

    def at(self, path: str = KEY) -> AbstractContextManager[None]:
        """Collect the problems of a MechanismError at a key path and continue after the context."""
        return _Collection(self, path)

    def collect(self, error: MechanismError, path: str) -> None:
        """Add the problems of an error at a key path."""
        self.has_failed = True
        self.problems += [Problem(problem).at(path) for problem in error.problems]

    def attempt(self, path: str, function: Callable[..., _Parsed], *arguments: Any) -> _Parsed | None:
        """Return the result of a function, or None if it fails; its problems are collected at a key path."""
        try:
            return function(*arguments)
        except MechanismError as error:
            self.collect(error, path)
        return None

    def parse_tables(self, heading: str, tables: object, parse: Callable[[str, Any], _Parsed]) -> list[_Parsed]:
        """Return the results, for the tables without a mistake, of a function of name and table; nothing for anything but tables."""
        items = tables.items() if isinstance(tables, Mapping) else ()
        results = [self.attempt(f"{heading}.{name}", parse, name, table) for name, table in items]
        return [result for result in results if result is not None]

    def raise_if_failed(self) -> None:
        """Raise MechanismError with all problems, if any check has failed."""
        if self.has_failed:
            raise MechanismError(*self.problems)


class _Collection(AbstractContextManager[None]):
    """Context whose MechanismError a collector takes; one that a generator makes costs four times as much, and a file has many."""

    def __init__(self, collector: ProblemCollector, path: str) -> None:
        self._collector, self._path = collector, path

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> bool:
        """Collect the error and continue after the context, if it is a MechanismError."""
        if not isinstance(error, MechanismError):
            return False
        self._collector.collect(error, self._path)
        return True


def parse_each(parse: Callable[..., _Parsed], *arguments: Iterable[Any], paths: Iterable[str] = repeat(KEY)) -> list[_Parsed]:
    """Return the results of a function like `map`, and raise the problems of all calls together, each at its path."""
    collector, results = ProblemCollector(), list[_Parsed]()
    for path, *items in zip(paths, *arguments, strict=False):
        with collector.at(path):
            results.append(parse(*items))
    collector.raise_if_failed()
    return results


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
QUANTITY: Final[Requirement] = "a finite number, or text with a unit", lambda value: isinstance(value, str) or NUMBER[1](value)
QUANTITIES: Final[Requirement] = (
    "a list of finite numbers, or of texts with units",
    lambda value: _is_numeric([0.0 if isinstance(one, str) else one for one in value] if isinstance(value, list | tuple) else value),
)
TEXTS: Final[Requirement] = (
    "a list of texts",
    lambda value: isinstance(value, list | tuple) and all(isinstance(one, str) for one in value),
)
LIST: Final[Requirement] = "a list", lambda value: isinstance(value, list | tuple)
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
    """Return a decorator that checks arguments, by name, in words and as a predicate, before each call; defaults are always allowed."""

    def decorate(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
        parameters = inspect.signature(function).parameters
        positional = [name for name, one in parameters.items() if one.kind is one.POSITIONAL_OR_KEYWORD]
        defaults = {name: parameters[name].default for name in requirements}

        @functools.wraps(function)
        def checked(*arguments: _Parameters.args, **options: _Parameters.kwargs) -> _Result:
            given = dict(zip(positional, arguments, strict=False)) | options  # the call itself refuses what does not fit
            for name, (description, is_met) in requirements.items():
                value = given.get(name, defaults[name])
                if value is not defaults[name] and not is_met(value):
                    raise MechanismError(f"{name} must be {description}; found {format_value(value)}")
            return function(*arguments, **options)

        return checked

    return decorate
