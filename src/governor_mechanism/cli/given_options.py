"""What the user gave on the command line: options by the words that were typed, and the refusal of those that do nothing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextvars import ContextVar
from typing import Final

from governor_mechanism.errors import MechanismError

_typed_options: ContextVar[Mapping[str, str]] = ContextVar("typed_options")
"""Options of the command that is parsed, as typed, by the names of their parameters."""

_NONE: Final[Mapping[str, str]] = {}
"""The options of a function that is called without a command line."""

_ARGUMENT_WORDS: Final = {"seconds": "run.duration", "case": "names"}
"""How messages name what an option gives, where that is not the name of its parameter."""


def remember_options(options: Mapping[str, str]) -> None:
    """Remember how options are typed, by the names of their parameters."""
    _typed_options.set(dict(options))


def is_given(name: str) -> bool:
    """Return whether the option of a parameter stands on the command line."""
    return name in _typed_options.get(_NONE)


def refuse_idle_options(*names: str, condition: str) -> None:
    """Raise MechanismError if options, by the names of their parameters, are given that do nothing; call it where they have no effect."""
    idle = [_typed_options.get(_NONE)[name] for name in names if is_given(name)]
    if not idle:
        return
    verb, pronoun = ("does", "it") if len(idle) == 1 else ("do", "them")
    needed = condition.removeprefix("without ")
    cure = f"give {needed} too, or leave {pronoun} out" if needed != condition else f"leave {pronoun} out"
    raise MechanismError(f"{' and '.join(idle)} {verb} nothing {condition}; {cure}")


def in_typed_words(problem: str) -> str:
    """Return a sentence with options, as typed, in the place of the names of arguments.

    A name of one word stands for an argument where the sentence begins; elsewhere it may be a word like others.
    """
    for name, option in _typed_options.get(_NONE).items():
        word = _ARGUMENT_WORDS.get(name, name)
        start = "^" if "_" not in word else r"(?<![\w.-])"
        problem = re.sub(rf"{start}{re.escape(word)}(?![\w.])", option, problem)
    return problem
