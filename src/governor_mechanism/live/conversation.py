"""What a page may ask for, checked before anything is done, and what it hears back, by a web socket or by the messages of a notebook."""

import json
import math
from base64 import b64encode
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.live.describing import describe_assemblies, describe_valve
from governor_mechanism.live.session import Session, export_run, write_scene
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
    """What a page asks for."""

    action: str  # what is to be done, a key of `FIELDS`
    values: Mapping[str, float] = field(default_factory=dict)  # numbers by key in their units, of a change
    is_last: bool = True  # whether a change is the last one of a drag
    key: str = ""  # key of a choice
    value: str | bool = False  # the word that is chosen, or whether something is on
    time: float = 0.0  # time that the page shows, or from which the motion goes on, s
    duration: float = 0.0  # time by which a motion goes on, s
    tab: str = ""  # name of the tab to which a motion belongs
    is_new: bool = False  # whether a motion goes on from the run of the document, and not from the motion before
    number: float = 0.0  # number of the request, which its answer repeats
    ending: str = ""  # kind of a file that the browser saves
    name: str = ""  # name of a scene file that is written into the folder of the opened one
    overwrites: bool = False  # whether a file may be replaced that is already there
    theme: str = "light"  # colours of a picture
    assembly: int = 1  # number of the way in which the joints close


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


MEDIA_TYPES: Final = {
    "toml": "application/toml",
    "gif": "image/gif",
    "html": "text/html",
    "csv": "text/csv",
    "svg": "image/svg+xml",
    "png": "image/png",
}
"""Media types by the ending of a name."""

Answer = dict[str, Any]
"""Values that JSON knows."""

Later = Callable[[], Answer]
"""What computes an answer that takes so long that the page goes on meanwhile."""


def respond(session: Session, text: str) -> Answer | Later | None:
    """Do what a message asks for, and return what only the page that asked hears; a change is heard by all, through their listeners."""
    try:
        request = parse_message(text)
        return ACTIONS[request.action](session, request)
    except MechanismError as error:
        return refuse(error)


def refuse(error: GovernorMechanismError) -> Answer:
    """Return the answer to what cannot be done."""
    return {"refused": "; ".join(error.problems) if isinstance(error, MechanismError) else str(error)}


def attempt(compute: Callable[[], Answer | Later | None]) -> Answer | Later | None:
    """Return an answer; whatever fails, the page hears of it and goes on."""
    try:
        return compute()
    except Exception as error:  # mistakes of a scene have their sentences already: this one is a mistake of the program
        return {"refused": f"this state cannot be shown, by a mistake of the program ({type(error).__name__}: {error})"}


def describe_present(session: Session) -> Answer:
    """Return what a page shows that hears one answer to each state: while a hand holds something, a moment of it."""
    if session.is_held:
        return session.describe_moment(session.solve(is_brief=True))
    return session.describe(session.solve())


def _hello(session: Session, request: Request) -> None:
    session.notify()


def _change(session: Session, request: Request) -> None:
    session.shown_time = request.time
    session.change(request.values, is_last=request.is_last)


def _choose(session: Session, request: Request) -> None:
    session.choose(request.key, request.value)


def _undo(session: Session, request: Request) -> None:
    session.undo()


def _redo(session: Session, request: Request) -> None:
    session.redo()


def _reset(session: Session, request: Request) -> None:
    session.reset()


def _extend(session: Session, request: Request) -> Later:
    """Return what lets a motion go on."""

    def extend() -> Answer:
        try:
            motion = session.extend_motion(request.tab, request.time, request.duration, is_new=request.is_new)
        except GovernorMechanismError as error:
            motion = {"refused": refuse(error)["refused"]}
        return {"motion": motion | {"number": request.number}}

    return extend


def _export(session: Session, request: Request) -> Later:
    """Return what makes a file of the present scene, or of the last run: a film, a page, a table or a figure."""
    ending = request.ending
    run = session.run
    document = session.document
    name = f"{session.file.name.rpartition('.')[0]}.{ending}"

    def export() -> Answer:
        is_scene = ending == "toml"
        content = write_scene(session.file.opened_text, document).encode() if is_scene else export_run(run, ending, request.theme)
        return {"file": {"name": name, "type": MEDIA_TYPES[ending], "content": b64encode(content).decode()}}

    return _or_refuse(export)


def _or_refuse(compute: Later) -> Later:
    """Return what computes an answer, or says why there is none."""

    def answer() -> Answer:
        try:
            return compute()
        except MechanismError as error:
            return refuse(error)

    return answer


def _valve(session: Session, request: Request) -> Later:
    return _or_refuse(lambda: {"valve": describe_valve(session.solve().run, request.theme)})


def _assemblies(session: Session, request: Request) -> Later:
    return _or_refuse(lambda: {"assemblies": describe_assemblies(session.solve().run)})


def _travel(session: Session, request: Request) -> Later:
    return _or_refuse(session.find_travel)


def _assemble(session: Session, request: Request) -> None:
    session.assemble(request.assembly)


def _save(session: Session, request: Request) -> Answer:
    """Write the present scene into the folder of the opened one, or ask."""
    name = request.name or session.file.name
    said, question = session.file.save(name, session.document, overwrites=request.overwrites)
    return {"saved": said, "question": question, "name": name}


ACTIONS: Final[Mapping[str, Callable[[Session, Request], Answer | Later | None]]] = {
    "hello": _hello,
    "change": _change,
    "choose": _choose,
    "undo": _undo,
    "redo": _redo,
    "reset": _reset,
    "extend": _extend,
    "export": _export,
    "save": _save,
    "valve": _valve,
    "assemblies": _assemblies,
    "travel": _travel,
    "assemble": _assemble,
}
"""What each action does."""
