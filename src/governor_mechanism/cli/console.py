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

EXIT_OK, EXIT_FAILED, EXIT_BAD_INPUT, EXIT_INTERRUPTED = 0, 1, 2, 130

INTERRUPT_REPEAT_INTERVAL = 1.0
"""Seconds after which an interrupt that was swallowed strikes again: long beside the clearing away of half a file."""


class CommandExit(SystemExit):
    """The end of a command that has said all it has to say."""


def guarded_command(command: Callable[..., int]) -> Callable[..., None]:
    """Turn a command's failures into one sentence each and an exit status."""

    @functools.wraps(command)
    def guarded(*args: Any, **options: Any) -> None:
        as_json = bool(options.get("as_json"))
        interrupt_handler = InterruptHandler()
        try:
            with interrupt_handler:
                status = command(*args, **options)
        except (Exception, KeyboardInterrupt) as error:
            status = _report_interrupt() if interrupt_handler.was_interrupted else _report_failure(error, as_json=as_json)
        raise CommandExit(status)

    return guarded


def _report_interrupt() -> int:
    print_to_stderr("interrupted; files already complete were kept, no half-written one was left")
    return EXIT_INTERRUPTED


def _report_failure(error: BaseException, *, as_json: bool) -> int:
    """Say what a user can mend, and the status; anything else is a fault of ours and goes on up."""
    if isinstance(error, MechanismError):
        return _report_problems(list(error.problems), as_json=as_json)
    if isinstance(error, GovernorMechanismError):
        return _report_problems([str(error)], as_json=as_json)
    if isinstance(error, BrokenPipeError):  # whoever read our output has seen enough
        sys.stdout = None
        return EXIT_OK
    if isinstance(error, OSError):
        file_name = error.filename or "the results"
        return _report_problems([f"cannot read or write {file_name}: {error.strerror or error}"], as_json=as_json)
    raise error


class InterruptHandler:
    """While it is open, a Ctrl-C is sure to end the command.

    Where it strikes within a finaliser or an import, Python or a library swallows the exception or turns it into
    another; so it strikes again every second, and `struck` tells what the end of the command was.
    """

    def __init__(self) -> None:
        self.was_interrupted = False
        self._can_repeat = hasattr(signal, "setitimer")
        self._signals = [signal.SIGINT, *([signal.SIGALRM] if self._can_repeat else [])]
        self._previous_handlers: list[Any] = []

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            self._previous_handlers = [signal.signal(kind, self._handle_signal) for kind in self._signals]

    def __exit__(self, *_: object) -> None:
        if self._previous_handlers:
            if self._can_repeat:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
            for signal_number, handler in zip(self._signals, self._previous_handlers, strict=True):
                signal.signal(signal_number, handler)
        if self.was_interrupted:
            raise KeyboardInterrupt

    def _handle_signal(self, signal_number: int, frame: FrameType | None) -> None:
        self.was_interrupted = True
        if self._can_repeat:
            signal.setitimer(signal.ITIMER_REAL, INTERRUPT_REPEAT_INTERVAL)
        raise KeyboardInterrupt


@contextmanager
def show_status(message: str) -> Iterator[None]:
    """A sign of life on a terminal, nothing in a pipe."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(message):
        yield


def finite_or_none(value: float) -> float | None:
    """JSON has no NaN."""
    return value if math.isfinite(value) else None


@contextmanager
def show_progress_bar(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar on a terminal, nothing in a pipe."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _report_problems(problems: list[str], *, as_json: bool) -> int:
    for problem in problems:
        print_to_stderr(problem)
    if as_json:
        print_json({"outcome": "bad_input", "problems": problems})
    return EXIT_BAD_INPUT


def print_to_stderr(message: str) -> None:
    print(message, file=sys.stderr)


def print_json(value: dict[str, Any]) -> None:
    print(json.dumps(value, indent=2, allow_nan=False))
