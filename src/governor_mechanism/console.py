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


class Answered(SystemExit):
    """The end of a command that has said all it has to say."""


def guarded_command(command: Callable[..., int]) -> Callable[..., None]:
    """Turn a command's failures into one sentence each and an exit status."""

    @functools.wraps(command)
    def guarded(*args: Any, **options: Any) -> None:
        try:
            with _interruptible():
                status = command(*args, **options)
        except MechanismError as error:
            status = _refuse(list(error.problems), as_json=bool(options.get("as_json")))
        except GovernorMechanismError as error:
            status = _refuse([str(error)], as_json=bool(options.get("as_json")))
        except BrokenPipeError:  # whoever read our output has seen enough
            sys.stdout = None
            status = OK
        except OSError as error:
            status = _refuse(
                [f"cannot write {error.filename or 'the results'}: {error.strerror or error}"], as_json=False
            )
        except KeyboardInterrupt:
            say("interrupted; files already complete were kept, no half-written one was left")
            status = INTERRUPTED
        raise Answered(status)

    return guarded


@contextmanager
def _interruptible() -> Iterator[None]:
    """Make sure of a Ctrl-C: Python swallows the exception where it strikes within a finaliser."""
    struck = False

    def strike(number: int, frame: FrameType | None) -> None:
        nonlocal struck
        struck = True
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, strike)
    try:
        yield
        if struck:
            raise KeyboardInterrupt
    finally:
        signal.signal(signal.SIGINT, before)


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
