"""Dataclass fields with a unit, series of numbers, and their validation."""

import dataclasses
import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from governor_mechanism.errors import MechanismError, require_finite, require_positive


def measured(unit: str, *, positive: bool = False, default: Any = dataclasses.MISSING) -> Any:
    """Declare a finite or positive dataclass field with a unit."""
    return dataclasses.field(default=default, metadata={"unit": unit, "positive": positive})


def require_valid_fields(instance: Any, owner: str) -> None:
    """Raise MechanismError unless the measured fields of a dataclass instance are finite or positive as declared."""
    for field in dataclasses.fields(instance):
        if "unit" in field.metadata:
            check = require_positive if field.metadata["positive"] else require_finite
            check(getattr(instance, field.name), field.metadata["unit"], f"{field.name.replace('_', ' ')} of {owner}")


def class_words(instance: object) -> str:
    """Return the name of a class in words, as "arc slot"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(instance).__name__).lower()


def require_rising(values: Sequence[float], what: str, unit: str = "", *, strictly: bool = True, hint: str = "") -> None:
    """Raise MechanismError unless the numbers of a series rise, or at least do not fall; `unit` begins with a space."""
    for before, after in pairwise(values):
        if after < before or (strictly and after == before):
            raise MechanismError(f"{what} must {'rise' if strictly else 'not fall'}; {after:g}{unit} follows {before:g}{unit}{hint}")
