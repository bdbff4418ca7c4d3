"""Calls that must be refused."""

from collections.abc import Callable
from typing import Any

import pytest

from governor_mechanism.errors import MechanismError


def refusal(call: Callable[..., Any], *arguments: Any, **options: Any) -> str:
    """Return the message with which the package refuses a call."""
    with pytest.raises(MechanismError) as caught:
        call(*arguments, **options)
    return str(caught.value)


def refuses(pattern: str, call: Callable[..., Any], *arguments: Any, **options: Any) -> None:
    """Check that a call raises the package's error, with a message in which the pattern is found."""
    with pytest.raises(MechanismError, match=pattern):
        call(*arguments, **options)
