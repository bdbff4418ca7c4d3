"""Dataclass fields with a unit, series of numbers, and their validation."""

import dataclasses
import re
from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from typing import Any

from governor_mechanism.errors import MechanismError, require_finite, require_positive


def measured(unit: str, *, positive: bool = False, default: Any = dataclasses.MISSING) -> Any:
    """Declare a finite or positive dataclass field with a unit."""
    return dataclasses.field(default=default, metadata={"unit": unit, "positive": positive})


def require_valid_fields(instance: Any, owner: str) -> None:
    """Raise MechanismError unless the measured fields of a dataclass instance are finite or positive as declared."""
    for name, unit, check in _measured_fields(instance.__class__):
        check(getattr(instance, name), unit, f"{name.replace('_', ' ')} of {owner}")


@cache
def _measured_fields(owner_class: Any) -> tuple[tuple[str, str, Callable[[float, str, str], None]], ...]:
    """Return name, unit and check of each measured field of a dataclass."""
    fields = [field for field in dataclasses.fields(owner_class) if "unit" in field.metadata]
    checks = {True: require_positive, False: require_finite}
    return tuple((field.name, field.metadata["unit"], checks[field.metadata["positive"]]) for field in fields)


def class_words(instance: object) -> str:
    """Return the name of a class in words, as "arc slot"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(instance).__name__).lower()


def require_rising(values: Sequence[float], what: str, unit: str = "", *, strictly: bool = True, hint: str = "") -> None:
    """Raise MechanismError unless the numbers of a series rise, or at least do not fall; `unit` begins with a space."""
    for before, after in pairwise(values):
        if after < before or (strictly and after == before):
            raise MechanismError(f"{what} must {'rise' if strictly else 'not fall'}; {after:g}{unit} follows {before:g}{unit}{hint}")
