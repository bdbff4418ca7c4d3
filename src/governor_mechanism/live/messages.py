"""What a page may ask for, checked before anything is done."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.quantities import format_value

MAX_MESSAGE_SIZE: Final = 32_768
"""Largest size of a message, bytes."""

MAX_VALUES: Final = 100
"""Largest number of quantities in a message."""

MAX_KEY_LENGTH: Final = 200
"""Largest length of a key."""

FILE_ENDINGS: Final = ("toml", "gif", "html", "csv", "svg", "png")
"""What a file can be that the browser saves: scene, film, page, table of the readings, and their figure."""

THEMES: Final = ("light", "dark")
"""Colours of a picture."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a page asks for.

    Attributes
    ----------
    action
        What is to be done, a key of `FIELDS`.
    values
        Numbers by key in their units, of a change.
    is_last
        Whether a change is the last one of a drag.
    key
        Key of a choice.
    value
        The word that is chosen, or whether something is on.
    time
        Time that the page shows, or from which the motion goes on, s.
    duration
        Time by which a motion goes on, s.
    tab
        Name of the tab to which a motion belongs.
    is_new
        Whether a motion goes on from the run of the document, and not from the motion before.
    number
        Number of the request, which its answer repeats.
    ending
        Kind of a file that the browser saves.
    name
        Name of a scene file that is written into the folder of the opened one.
    overwrites
        Whether a file may be replaced that is already there.
    theme
        Colours of a picture.
    assembly
        Number of the way in which the joints close.
    """

    action: str
    values: Mapping[str, float] = field(default_factory=dict)
    is_last: bool = True
    key: str = ""
    value: str | bool = False
    time: float = 0.0
    duration: float = 0.0
    tab: str = ""
    is_new: bool = False
    number: float = 0.0
    ending: str = ""
    name: str = ""
    overwrites: bool = False
    theme: str = "light"
    assembly: int = 1


def parse_message(text: str) -> Request:
    """Return what a message asks for; raise MechanismError for anything else."""
    if len(text.encode(errors="replace")) > MAX_MESSAGE_SIZE:
        raise MechanismError(f"a message has at most {MAX_MESSAGE_SIZE} bytes")
    try:
        message = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise MechanismError(f"a message is JSON: {error}") from None
    action = message.get("action") if isinstance(message, dict) else None
    if not isinstance(action, str) or action not in FIELDS:
        raise MechanismError(f"a message has an action, one of {', '.join(FIELDS)}")
    fields = FIELDS[action]
    if unknown := [key for key in message if key not in fields and key != "action"]:
        raise MechanismError(f"{action} takes no {format_value(unknown[0])}")
    return Request(action=action, **{_python_name(key): read(message[key]) for key, read in fields.items() if key in message})


def _python_name(key: str) -> str:
    """Return the name of an attribute for a key of a message, as "is_last" for "isLast"."""
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in key)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _read_values(values: Any) -> dict[str, float]:
    """Return the values of a change by key."""
    if not isinstance(values, dict) or not 0 < len(values) <= MAX_VALUES:
        raise MechanismError(f"values are 1 to {MAX_VALUES} numbers by key")
    for key, value in values.items():
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if len(key) > MAX_KEY_LENGTH or not is_number or not math.isfinite(value):
            raise MechanismError(f"{format_value(key[:MAX_KEY_LENGTH])} needs a finite number; found {format_value(value)}")
    return {key: float(value) for key, value in values.items()}


def _read_number(value: Any) -> float:
    """Return a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise MechanismError(f"a finite number is expected; found {format_value(value)}")
    return float(value)


def _read_flag(value: Any) -> bool:
    """Return true or false."""
    if not isinstance(value, bool):
        raise MechanismError(f"a switch is true or false; found {format_value(value)}")
    return value


def _read_choice(value: Any) -> str | bool:
    """Return a word, or true or false."""
    return value if isinstance(value, bool) else _read_text(value)


def _read_text(value: Any) -> str:
    """Return a short text."""
    if not isinstance(value, str) or len(value) > MAX_KEY_LENGTH:
        raise MechanismError(f"a name is a text of at most {MAX_KEY_LENGTH} letters; found {format_value(value)}")
    return value


def _read_whole_number(value: Any) -> int:
    """Return a number from 1."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise MechanismError(f"a whole number from 1 is expected; found {format_value(value)}")
    return value


def _one_of(words: tuple[str, ...]) -> Callable[[Any], str]:
    """Return what reads one of a few words."""

    def read(value: Any) -> str:
        if value not in words:
            raise MechanismError(f"one of {', '.join(words)} is expected; found {format_value(value)}")
        return str(value)

    return read


FIELDS: Final[Mapping[str, Mapping[str, Callable[[Any], Any]]]] = {
    "change": {"values": _read_values, "isLast": _read_flag, "time": _read_number},
    "choose": {"key": _read_text, "value": _read_choice},
    "hello": {},
    "undo": {},
    "redo": {},
    "reset": {},
    "extend": {"tab": _read_text, "time": _read_number, "duration": _read_number, "isNew": _read_flag, "number": _read_number},
    "export": {"ending": _one_of(FILE_ENDINGS), "theme": _one_of(THEMES)},
    "save": {"name": _read_text, "overwrites": _read_flag},
    "valve": {"theme": _one_of(THEMES)},
    "assemblies": {},
    "travel": {},
    "assemble": {"assembly": _read_whole_number},
}
"""What a message may ask for, with its fields and what reads them; what is left out has the default of `Request`."""
