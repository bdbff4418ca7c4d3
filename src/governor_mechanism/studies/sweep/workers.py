"""Work on many items in several processes, ended cleanly by Ctrl-C."""

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from types import FrameType
from typing import Any, TypeVar

from governor_mechanism.errors import RunFailed

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


def map_in_processes(function: Callable[[_Item], _Result], items: Iterable[_Item], n_processes: int) -> Iterator[_Result]:
    """Yield the results of a function for each item, in the order in which they are finished.

    The function must be picklable; a process gets as many items at once as take it up to about a second. Raises RunFailed if a process is
    terminated from outside.
    """
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    parallel = Parallel(n_jobs=n_processes, return_as="generator_unordered")
    with record_interrupts(only_first=True):
        try:
            with _interrupt_handler(signal.SIG_IGN):  # inherited by the processes: only the main process handles Ctrl-C
                results = parallel(delayed(function)(one) for one in items)
            with closing(results):
                yield from results
        except TerminatedWorkerError as error:
            raise RunFailed(
                "a process was terminated from outside, for example for lack of memory; use fewer workers; finished rows on disk are kept"
            ) from error


@contextmanager
def record_interrupts(*, only_first: bool = False) -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C was pressed.

    The interrupted code may swallow KeyboardInterrupt or replace it by another exception. With `only_first` later interrupts
    are ignored, here and in processes started afterwards, so that the processes of a sweep can be ended.
    """
    signals: list[int] = []
    previous_handler: Any = signal.getsignal(signal.SIGINT)

    def record_signal(signal_number: int, frame: FrameType | None) -> None:
        """Record the signal and call the previous handler."""
        signals.append(signal_number)
        if only_first:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        previous_handler(signal_number, frame)

    with _interrupt_handler(record_signal if callable(previous_handler) else previous_handler):
        yield lambda: bool(signals)


@contextmanager
def _interrupt_handler(handler: Any) -> Iterator[None]:
    """Set the handler of SIGINT within the context; only the main thread can do so."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous_handler = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous_handler)
