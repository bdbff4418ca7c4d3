"""The three kinds of failure a user can meet, and the checks that raise them.

A message always says what, where, what was found, what is allowed, and, where one is known, the cure.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable


class GovernorMechanismError(Exception):
    """Base of every error this package raises on purpose."""


class MechanismError(GovernorMechanismError, ValueError):
    """A description, a file or an argument is wrong; `problems` holds every mistake found, one sentence each."""

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems


class UnsupportedEffect(GovernorMechanismError):  # noqa: N818 - the name users see
    """The chosen engine cannot model something the scene asks for."""


class RunFailed(GovernorMechanismError, RuntimeError):  # noqa: N818 - the name users see
    """A run ended early or missed its accuracy; raised only when the caller asks for exceptions."""


def require_finite(value: float, unit: str, what: str) -> None:
    """Refuse NaN and infinities; `what` names the quantity and its owner."""
    if not math.isfinite(value):
        raise MechanismError(f"{what} must be a finite number; got {value!r} {unit}".rstrip())


def require_positive(value: float, unit: str, what: str) -> None:
    """Refuse zero, negative numbers, NaN and infinities."""
    if not (value > 0 and math.isfinite(value)):
        raise MechanismError(f"{what} must be positive; got {value:g} {unit}".rstrip())


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The sentence ' Did you mean ...?' for the nearest known name, or an empty string."""
    matches = difflib.get_close_matches(word, list(known), n=1)
    return f" Did you mean {matches[0]!r}?" if matches else ""


def require_not_negative(value: float, unit: str, what: str) -> None:
    """Raise MechanismError unless a value is finite and at least zero."""
    require_finite(value, unit, what)
    if value < 0:
        raise MechanismError(f"{what} must not be negative; got {value:g} {unit}".rstrip())
