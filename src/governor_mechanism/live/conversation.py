"""What a page hears back: the same answers by a web socket and by the messages of a notebook."""

from base64 import b64encode
from collections.abc import Callable, Mapping
from typing import Any, Final

from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.live.describing import describe_assemblies, describe_valve
from governor_mechanism.live.messages import Request, parse_message
from governor_mechanism.live.saving import export_run, write_scene
from governor_mechanism.live.session import Session

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
    ending, run, document = request.ending, session.run, session.document
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
