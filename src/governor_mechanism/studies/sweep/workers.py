"""Work on many things by several processes, ended cleanly by Ctrl-C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from types import FrameType
from typing import Any, TypeVar

from governor_mechanism.errors import RunFailed

Given = TypeVar("Given")
Made = TypeVar("Made")


def by_processes(make: Callable[[Given], Made], given: Iterable[Given], processes: int) -> Iterator[Made]:
    """What `make`, which can be pickled, makes of each, in the order in which it comes.

    `given` is asked for a few at a time. Raises RunFailed where a process is ended from outside.
    """
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    parallel = Parallel(n_jobs=processes, batch_size=1, pre_dispatch=2 * processes, return_as="generator_unordered")
    with interrupts_noted(one=True):
        try:
            with _interrupts_ignored():  # inherited by the processes: a Ctrl-C is for the one that started them
                made = parallel(delayed(make)(one) for one in given)
            with closing(made):
                yield from made
        except TerminatedWorkerError as error:
            raise RunFailed(
                "a process was ended from outside, as for want of memory; take fewer workers; what is on disk is kept"
            ) from error


@contextmanager
def interrupts_noted(*, one: bool = False) -> Iterator[Callable[[], bool]]:
    """Tells whether a Ctrl-C has struck, for what it strikes may swallow it or make another exception of it.

    With `one` no second is taken, nor given to what is started then: such as ends the processes of a sweep.
    """
    struck: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    before: Any = signal.getsignal(signal.SIGINT)

    def strike(number: int, frame: FrameType | None) -> None:
        struck.append(number)
        if one:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        before(number, frame)

    if callable(before):
        signal.signal(signal.SIGINT, strike)
    try:
        yield lambda: bool(struck)
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
