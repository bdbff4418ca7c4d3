"""Where the rows of a sweep are computed: in this process, or in several ones; Ctrl-C ends them cleanly."""

import signal
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing, contextmanager
from types import FrameType
from typing import Any, Protocol, TypeVar

from governor_mechanism.errors import RunFailed

Row = TypeVar("Row")
"""What a function returns for an index."""

Row_co = TypeVar("Row_co", covariant=True)


class RowFunction(Protocol[Row_co]):
    """Function that computes the rows of indices; it can be pickled."""

    @property
    def rows_at_once(self) -> int:
        """Largest number of rows that it computes at once; 1 if each row takes as long alone."""

    def __call__(self, indices: Sequence[int], /) -> Sequence[Row_co]:
        """Return the rows of indices."""


RowComputer = Callable[[RowFunction[Row], Sequence[int]], Generator[Sequence[Row], None, None]]
"""Function that yields the rows of indices as they are finished, several at once."""

TRIAL_TIME = 0.5
"""Time for which this process computes rows before processes may start, s: it shows how long a row takes."""

PROCESS_START_TIME = 3.0
"""Time that processes take to start, import the package and load its kernels, s."""

MAX_CHUNK_TIME = 0.1
"""Time that rows computed at once should take at most, s: an interrupt or a report of progress waits as long."""

MAX_CHUNK_GROWTH = 8
"""Factor by which the number of rows computed at once grows at most: the first ones may be quicker than the others."""

MIN_ELAPSED_TIME = 1e-6
"""Smallest time that the clock is trusted to tell apart, s."""

CHUNKS_PER_WORKER = 16
"""Number of chunks for each worker, so that all end at about the same time."""

MAX_CHUNK_ROWS = 1000
"""Largest number of rows of a chunk: fewer would repeat what rows share too often, and more would keep them from the disk too long."""


def compute_alone(function: RowFunction[Row], indices: Sequence[int]) -> Generator[Sequence[Row], None, None]:
    """Yield rows computed in this process; interrupted rows are dropped."""
    n_done, n_rows = 0, 1
    with record_interrupts() as was_interrupted:
        while n_done < len(indices):
            started = time.perf_counter()
            rows = function(indices[n_done : n_done + n_rows])
            if was_interrupted():
                raise KeyboardInterrupt
            yield rows
            n_done, n_rows = n_done + len(rows), _choose_chunk_size(function, len(rows), time.perf_counter() - started)


def _choose_chunk_size(function: RowFunction[Any], n_rows: int, elapsed: float) -> int:
    """Return the number of rows to compute next after some rows took a time, s: no more than within reasonable patience."""
    return max(1, min(function.rows_at_once, MAX_CHUNK_GROWTH * n_rows, int(MAX_CHUNK_TIME * n_rows / max(elapsed, MIN_ELAPSED_TIME))))


def compute_in_parallel(function: RowFunction[Row], indices: Sequence[int], n_workers: int) -> Generator[Sequence[Row], None, None]:
    """Yield rows computed in this process as long as others would take longer to start than they save, and then by several workers.

    Rows that are computed at once are shared among threads, which start at once, others among processes. The first row compiles or loads
    the kernels; processes find them in the cache.
    """
    from joblib import cpu_count

    n_useful, n_done, started = min(n_workers, cpu_count()), 0, 0.0
    has_threads = function.rows_at_once > 1
    with closing(compute_alone(function, indices)) as alone:
        for rows in alone:
            yield rows
            n_done += len(rows)
            if n_done == len(rows):
                n_first, started = n_done, time.perf_counter()
            elif n_useful > 1 and (
                has_threads or _pays_to_share(time.perf_counter() - started, n_done - n_first, len(indices) - n_done, n_useful)
            ):
                break
    if n_done == len(indices):
        return
    if has_threads:
        yield from _map_in_threads(function, indices[n_done:], n_useful)
    else:
        yield from _map_in_processes(function, make_chunks(indices[n_done:], n_useful), n_useful)


def _map_in_threads(function: RowFunction[Row], indices: Sequence[int], n_threads: int) -> Generator[Sequence[Row], None, None]:
    """Yield the rows of indices in the order in which threads finish them; after an interrupt these finish what they have begun."""
    chunk_size, n_begun = 1, 0
    with ThreadPoolExecutor(n_threads) as executor, record_interrupts() as was_interrupted:
        running: set[Future[tuple[Sequence[Row], float]]] = set()
        while n_begun < len(indices) or running:
            while n_begun < len(indices) and len(running) < n_threads + 1:
                chunk = indices[n_begun : n_begun + chunk_size]
                running.add(executor.submit(_compute_timed, function, chunk))
                n_begun += len(chunk)
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            for one in finished:
                rows, elapsed = one.result()
                chunk_size = _choose_chunk_size(function, len(rows), elapsed)
                yield rows
            if was_interrupted():
                raise KeyboardInterrupt


def _compute_timed(function: RowFunction[Row], indices: Sequence[int]) -> tuple[Sequence[Row], float]:
    """Return rows, and the time that they took, s."""
    started = time.perf_counter()
    return function(indices), time.perf_counter() - started


def _pays_to_share(elapsed: float, n_done: int, n_left: int, n_processes: int) -> bool:
    """Return whether several processes, once started, save more time than their start takes, after some rows in a time, s."""
    saved_time = elapsed / n_done * n_left * (1.0 - 1.0 / n_processes)
    return elapsed >= TRIAL_TIME and saved_time > 2.0 * PROCESS_START_TIME


def make_chunks(indices: Sequence[int], n_workers: int) -> Iterator[Sequence[int]]:
    """Yield the indices in chunks of a size that keeps a number of workers busy."""
    size = max(1, min(MAX_CHUNK_ROWS, len(indices) // (CHUNKS_PER_WORKER * n_workers)))
    for first in range(0, len(indices), size):
        yield indices[first : first + size]


def _map_in_processes(function: RowFunction[Row], chunks: Iterator[Sequence[int]], n_processes: int) -> Iterator[Sequence[Row]]:
    """Yield the rows of chunks in the order in which they are finished. Raise RunFailed if a process is terminated from outside."""
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    parallel = Parallel(n_jobs=n_processes, return_as="generator_unordered", batch_size=1)
    with record_interrupts(only_first=True):
        try:
            with _interrupt_handler(signal.SIG_IGN):  # inherited by the processes: only the main process handles Ctrl-C
                results = parallel(delayed(function)(one) for one in chunks)
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
