"""How a command speaks and ends: sentences, JSON, signs of life, exit statuses, Ctrl-C."""

from __future__ import annotations

import functools
import json
import math
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from governor_mechanism.errors import GovernorMechanismError, MechanismError

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

AGAIN = 1.0
"""Seconds after which an interrupt that was swallowed strikes again: long beside the clearing away of half a file."""


class Answered(SystemExit):
    """The end of a command that has said all it has to say."""


def guarded_command(command: Callable[..., int]) -> Callable[..., None]:
    """Turn a command's failures into one sentence each and an exit status."""

    @functools.wraps(command)
    def guarded(*args: Any, **options: Any) -> None:
        as_json = bool(options.get("as_json"))
        interrupts = Interrupts()
        try:
            with interrupts:
                status = command(*args, **options)
        except (Exception, KeyboardInterrupt) as error:
            status = _interrupted() if interrupts.struck else _failed(error, as_json=as_json)
        raise Answered(status)

    return guarded


def _interrupted() -> int:
    say("interrupted; files already complete were kept, no half-written one was left")
    return INTERRUPTED


def _failed(error: BaseException, *, as_json: bool) -> int:
    """Say what a user can mend, and the status; anything else is a fault of ours and goes on up."""
    if isinstance(error, MechanismError):
        return _refuse(list(error.problems), as_json=as_json)
    if isinstance(error, GovernorMechanismError):
        return _refuse([str(error)], as_json=as_json)
    if isinstance(error, BrokenPipeError):  # whoever read our output has seen enough
        sys.stdout = None
        return OK
    if isinstance(error, OSError):
        what = error.filename or "the results"
        return _refuse([f"cannot read or write {what}: {error.strerror or error}"], as_json=as_json)
    raise error


class Interrupts:
    """While it is open, a Ctrl-C is sure to end the command.

    Where it strikes within a finaliser or an import, Python or a library swallows the exception or turns it into
    another; so it strikes again every second, and `struck` tells what the end of the command was.
    """

    def __init__(self) -> None:
        self.struck = False
        self._again = hasattr(signal, "setitimer")
        self._kinds = [signal.SIGINT, *([signal.SIGALRM] if self._again else [])]
        self._before: list[Any] = []

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            self._before = [signal.signal(kind, self._strike) for kind in self._kinds]

    def __exit__(self, *_: object) -> None:
        if self._before:
            if self._again:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
            for kind, handler in zip(self._kinds, self._before, strict=True):
                signal.signal(kind, handler)
        if self.struck:
            raise KeyboardInterrupt

    def _strike(self, number: int, frame: FrameType | None) -> None:
        self.struck = True
        if self._again:
            signal.setitimer(signal.ITIMER_REAL, AGAIN)
        raise KeyboardInterrupt


@contextmanager
def working(what: str) -> Iterator[None]:
    """A sign of life on a terminal, nothing in a pipe."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield


def number(value: float) -> float | None:
    """JSON has no NaN."""
    return value if math.isfinite(value) else None


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar on a terminal, nothing in a pipe."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _refuse(problems: list[str], *, as_json: bool) -> int:
    for problem in problems:
        say(problem)
    if as_json:
        print_json({"outcome": "bad_input", "problems": problems})
    return BAD_INPUT


def say(message: str) -> None:
    print(message, file=sys.stderr)


def print_json(value: dict[str, Any]) -> None:
    print(json.dumps(value, indent=2, allow_nan=False))
