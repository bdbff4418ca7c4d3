"""What a page may ask for, checked before anything is done."""

import json
import math
from dataclasses import dataclass
from typing import Any, Final, Literal

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import format_value

MAX_MESSAGE_SIZE: Final = 32_768
"""Largest size of a message, bytes."""

MAX_VALUES: Final = 100
"""Largest number of quantities in a message."""

MAX_KEY_LENGTH: Final = 200
"""Largest length of a key."""

ACTIONS: Final = ("change", "undo", "redo", "reset")
"""What a message may ask for."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a page asks for; `values` by key in their units, and `is_last` of a drag, belong to a change."""

    action: Literal["change", "undo", "redo", "reset"]
    values: dict[str, float]
    is_last: bool = True


def parse_message(text: str) -> Request:
    """Return what a message asks for; raise MechanismError for anything else."""
    if len(text.encode()) > MAX_MESSAGE_SIZE:
        raise MechanismError(f"a message has at most {MAX_MESSAGE_SIZE} bytes")
    try:
        message = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise MechanismError(f"a message is JSON: {error}") from None
    if not isinstance(message, dict) or message.get("action") not in ACTIONS:
        raise MechanismError(f"a message has an action, one of {', '.join(ACTIONS)}")
    known = ("action", "values", "isLast") if message["action"] == "change" else ("action",)
    if unknown := [key for key in message if key not in known]:
        raise MechanismError(f"{message['action']} takes no {format_value(unknown[0])}")
    if message["action"] != "change":
        return Request(action=message["action"], values={})
    return Request(action="change", values=_parse_values(message.get("values")), is_last=message.get("isLast", True) is not False)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _parse_values(values: Any) -> dict[str, float]:
    """Return the values of a change by key."""
    if not isinstance(values, dict) or not 0 < len(values) <= MAX_VALUES:
        raise MechanismError(f"values are 1 to {MAX_VALUES} numbers by key")
    for key, value in values.items():
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if len(key) > MAX_KEY_LENGTH or not is_number or not math.isfinite(value):
            raise MechanismError(f"{format_value(key[:MAX_KEY_LENGTH])} needs a finite number; found {format_value(value)}")
    return {key: float(value) for key, value in values.items()}
