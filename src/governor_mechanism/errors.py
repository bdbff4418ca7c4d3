"""Exceptions for the user's mistakes and failed runs, and checks that raise them.

A message says what is wrong, where, what was found, what is allowed and, if known, the cure.
"""

import difflib
import math
import re
from collections.abc import Iterable, Sequence
from itertools import pairwise

_LONG_WORD = re.compile(r"\S{301,}")
"""What no name of a key is, and nearly no path of a file: shortened, since a message of pages is not read."""

_CONTROL_CHARACTER = re.compile("[\x01-\x1f\x7f-\x9f]")


def escape_control_characters(text: str) -> str:
    """Return a text with control characters as escape sequences: in a terminal they would act; a null character, a placeholder, stays."""
    return _CONTROL_CHARACTER.sub(lambda match: f"\\x{ord(match[0]):02x}", text) if _CONTROL_CHARACTER.search(text) else text


def make_legible(text: str) -> str:
    """Return a message in one line, without control characters, and with very long words shortened in their middle."""
    escaped = escape_control_characters(text)
    if len(escaped) <= 300:
        return escaped
    return _LONG_WORD.sub(lambda match: f"{match[0][:60]}...{match[0][-20:]}", escaped)


class GovernorMechanismError(Exception):
    """Base class of all exceptions that this package raises on purpose."""


class MechanismError(GovernorMechanismError, ValueError):
    """A mistake in a description, a file or an argument.

    Attributes
    ----------
    problems
        All mistakes found, one sentence each.
    """

    def __init__(self, *problems: str) -> None:
        self.problems: tuple[str, ...] = tuple(map(make_legible, problems))
        super().__init__("\n".join(self.problems))


class UnknownName(MechanismError, KeyError):  # noqa: N818 - reads as a sentence
    """A name that a table of results does not have."""

    def __str__(self) -> str:
        """Return the sentences; a KeyError alone would put quotation marks around them."""
        return "\n".join(self.problems)


class UnsupportedEffect(GovernorMechanismError):  # noqa: N818 - the name users see
    """The engine cannot model an effect or joint of the scene."""


class RunFailed(GovernorMechanismError, RuntimeError):  # noqa: N818 - the name users see
    """A run ended early or missed its accuracy. Raised only by `Trajectory.raise_if_failed`."""


def require_finite(value: float, unit: str, what: str) -> None:
    """Raise MechanismError unless a value is finite; `unit` and `what`, the quantity with its owner, are for the message."""
    if not -math.inf < value < math.inf:
        raise MechanismError(f"{what} must be a finite number; got {value!r} {unit}".rstrip())


def require_positive(value: float, unit: str, what: str) -> None:
    """Raise MechanismError unless a value is finite and positive; `unit` and `what` are for the message."""
    if not 0 < value < math.inf:
        raise MechanismError(f"{what} must be positive; got {value:g} {unit}".rstrip())


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return " Did you mean ...?" with the nearest known name; empty if none is close."""
    matches = difflib.get_close_matches(word, list(known), n=1) if isinstance(word, str) else []
    return f" Did you mean {str(matches[0])!r}?" if matches else ""


def require_not_negative(value: float, unit: str, what: str) -> None:
    """Raise MechanismError unless a value is finite and not negative; `unit` and `what` are for the message."""
    require_finite(value, unit, what)
    if value < 0:
        raise MechanismError(f"{what} must not be negative; got {value:g} {unit}".rstrip())


def require_rising(values: Sequence[float], what: str, unit: str = "", *, strictly: bool = True, hint: str = "") -> None:
    """Raise MechanismError unless the numbers of a series rise, or at least do not fall; `unit` begins with a space."""
    for before, after in pairwise(values):
        if after < before or (strictly and after == before):
            raise MechanismError(f"{what} must {'rise' if strictly else 'not fall'}; {after:g}{unit} follows {before:g}{unit}{hint}")
