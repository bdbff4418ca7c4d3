"""Dataclass fields with a unit, and their validation."""

import dataclasses
from typing import Any

from governor_mechanism.errors import require_finite, require_positive


def measured(unit: str, *, positive: bool = False, default: Any = dataclasses.MISSING) -> Any:
    """Declare a finite or positive dataclass field with a unit."""
    return dataclasses.field(default=default, metadata={"unit": unit, "positive": positive})


def require_valid_fields(instance: Any, owner: str) -> None:
    """Raise MechanismError unless the measured fields of a dataclass instance are finite or positive as declared."""
    for field in dataclasses.fields(instance):
        if "unit" in field.metadata:
            check = require_positive if field.metadata["positive"] else require_finite
            check(getattr(instance, field.name), field.metadata["unit"], f"{field.name.replace('_', ' ')} of {owner}")
