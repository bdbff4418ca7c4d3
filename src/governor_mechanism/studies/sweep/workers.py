"""Where the rows of a sweep are computed: in this process, or in several ones; Ctrl-C ends them cleanly."""

import hashlib
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from operator import itemgetter
from types import FrameType
from typing import Any, Protocol, TypeVar

from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.files.results import package_versions
from governor_mechanism.numerics.kernel_library import PACKAGE_ROOT
from governor_mechanism.numerics.kernel_sources import read_texts
from governor_mechanism.studies.sweep.rows import SweepRow
from governor_mechanism.units.quantities import format_value

Row = TypeVar("Row")
"""What a function returns for an index."""

RowFunction = Callable[[int], Row]
"""Function that computes the row of an index; it can be pickled."""

RowComputer = Callable[[RowFunction[Row], Sequence[int]], Generator[Sequence[Row], None, None]]
"""Function that yields the rows of indices as they are finished, several at once."""

TRIAL_TIME = 0.1
"""Time for which this process computes rows before others may start, s: it shows how long a row takes."""

PROCESS_START_TIME = 1.0
"""Time that a process takes to start and to import the package, s."""

IDLE_TIME = 300
"""Time after which an idle process ends, s."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment of the processes, which share the cores."""

LONG_ROW_TIME = 5.0
"""Time of a first row from which it counts, though it may have loaded kernels, s."""

CHUNKS_PER_WORKER = 16
"""Number of chunks for each worker, so that all end at about the same time."""

CHUNKS_AHEAD = 2
"""Number of chunks that a process has at once, so that it need not wait for the next."""

MAX_CHUNK_ROWS = 1000
"""Largest number of rows of a chunk: more would keep them from the disk too long."""


def compute_alone(function: RowFunction[Row], indices: Sequence[int]) -> Generator[Sequence[Row], None, None]:
    """Yield rows computed in this process, one by one; an interrupted row is dropped."""
    with record_interrupts() as was_interrupted:
        for index in indices:
            row = function(index)
            if was_interrupted():
                raise KeyboardInterrupt
            yield [row]


def compute_all(compute: RowComputer[tuple[int, Row]], function: RowFunction[Row], count: int) -> list[Row]:
    """Return the rows of the indices below a count, in their order."""
    with closing(compute(partial(_number_row, function), range(count))) as computed:
        numbered = [one for some in computed for one in some]
    return [row for _, row in sorted(numbered, key=itemgetter(0))]


def _number_row(function: RowFunction[Row], index: int) -> tuple[int, Row]:
    return index, function(index)


def compute_in_parallel(function: RowFunction[Row], indices: Sequence[int], n_workers: int) -> Generator[Sequence[Row], None, None]:
    """Yield rows of this process, and of others beside it as soon as they are ready, if they save more than they cost."""
    # The first row compiles or loads the kernels; the processes find them in the cache.
    from joblib import cpu_count  # slow to import

    n_others = min(n_workers, cpu_count()) - 1
    n_done = 0
    started = time.perf_counter()
    with closing(compute_alone(function, indices)) as alone:
        for rows in alone:
            yield rows
            n_done += 1
            if n_done == 1 and time.perf_counter() - started < LONG_ROW_TIME:
                started = time.perf_counter()  # kernels are loaded
            elif n_others > 0 and _pays_to_share(time.perf_counter() - started, max(n_done - 1, 1), len(indices) - n_done):
                break
    if n_done < len(indices):
        yield from _share_with_processes(function, make_chunks(indices[n_done:], n_others + 1), n_others)


def _pays_to_share(elapsed: float, n_done: int, n_left: int) -> bool:
    """Return whether the rest takes so long alone that others are ready before half of it, after some rows in a time, s."""
    return elapsed >= TRIAL_TIME and elapsed / n_done * n_left > 2.0 * PROCESS_START_TIME


def make_chunks(indices: Sequence[int], n_workers: int) -> Iterator[Sequence[int]]:
    """Yield the indices in chunks of a size that keeps a number of workers busy."""
    size = max(1, min(MAX_CHUNK_ROWS, len(indices) // (CHUNKS_PER_WORKER * n_workers)))
    for first in range(0, len(indices), size):
        yield indices[first : first + size]


def compute_chunk(function: RowFunction[Row], indices: Sequence[int]) -> list[Row]:
    """Return the rows of a chunk."""
    return [function(index) for index in indices]


def _share_with_processes(function: RowFunction[Row], chunks: Iterator[Sequence[int]], n_others: int) -> Iterator[Sequence[Row]]:
    """Yield finished rows, this process from the last chunks on and others from the first; RunFailed if one is terminated."""
    # Nothing waits for a process that starts.
    from joblib.externals.loky import get_reusable_executor, wait  # slow to import
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    executor = get_reusable_executor(max_workers=n_others, timeout=IDLE_TIME, env=ONE_THREAD)
    left = deque(chunks)
    own = deque[int]()
    running = set[Any]()
    with record_interrupts(only_first=True) as was_interrupted:
        try:
            while left or own or running:
                while left and len(running) < CHUNKS_AHEAD * n_others:
                    with _interrupt_handler(signal.SIG_IGN):  # inherited by the processes: only the main process handles Ctrl-C
                        running.add(executor.submit(compute_chunk, function, left.popleft()))
                for future in [one for one in running if one.done()]:
                    running.remove(future)
                    yield future.result()
                if left and not own:
                    own.extend(left.pop())
                if own:
                    row = function(own.popleft())
                    if was_interrupted():
                        raise KeyboardInterrupt
                    yield [row]
                elif running:
                    wait(running, return_when="FIRST_COMPLETED")
        except TerminatedWorkerError as error:
            raise RunFailed(
                "a process was terminated from outside, for example for lack of memory; use fewer workers; finished rows on disk are kept"
            ) from error
        finally:
            if running:
                executor.shutdown(kill_workers=True)


@contextmanager
def record_interrupts(*, only_first: bool = False) -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C was pressed; with `only_first` later ones are ignored, in new processes too."""
    # The interrupted code may swallow KeyboardInterrupt or replace it by another exception. Ignored, it
    # lets the processes of a sweep be ended.
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


CONNECTION_TIMEOUT = 10.0
"""Time within which a scheduler must answer and have a worker, s."""


class ClusterClient(Protocol):
    """A client of dask.distributed, an optional package, as far as a type checker needs to know it."""

    def scheduler_info(self) -> object:
        """Return what the scheduler knows of its workers."""


_MISSING_EXTRA = "a sweep on a cluster needs dask.distributed; install it with pip install 'governor-mechanism[cluster]'"


def find_computer_problems(
    workers: object,
    cluster: object,  # client or address of a scheduler, or None
) -> list[str]:
    """Return a sentence for each mistake in where rows are to be computed; none if a sweep can be computed there."""
    problems = []
    if not isinstance(workers, int) or isinstance(workers, bool) or workers < 1:
        problems.append(f"workers must be a whole number of at least 1; got {format_value(workers)}")
    elif cluster is not None and workers > 1:
        problems.append("workers are processes of this computer, and cluster computes the rows elsewhere; leave one of the two out")
    if cluster is not None and not _is_cluster(cluster):
        problems.append(
            "cluster must be the address of a scheduler, as tcp://host:8786, or a client of dask.distributed; "
            f"found {format_value(cluster)}"
        )
    return problems


def _is_cluster(cluster: object) -> bool:
    if isinstance(cluster, str):
        return "://" in cluster
    return type(cluster).__module__.partition(".")[0] == "distributed" and hasattr(cluster, "scheduler_info")


@contextmanager
def row_computer(
    workers: int,
    cluster: Any,  # client or address of a scheduler; None computes the rows on this computer
) -> Iterator[RowComputer[Any]]:
    """Provide the function that computes the rows: in this process, in several ones, or on a cluster."""
    if cluster is None:
        yield compute_alone if workers == 1 else partial(compute_in_parallel, n_workers=workers)
        return
    try:
        import distributed  # an optional package
    except ImportError as error:
        raise MechanismError(_MISSING_EXTRA) from error
    connect: Any = distributed.Client
    if not isinstance(cluster, str):
        require_same_versions(cluster)
        yield partial(_compute_on_cluster, client=cluster)
        return
    try:
        client = connect(cluster, timeout=CONNECTION_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        text = f"cluster: no scheduler answers at {cluster} within {CONNECTION_TIMEOUT:g} s"
        raise MechanismError(f"{text}; start one with `dask scheduler`, or correct the address") from error
    with client:
        require_same_versions(client)
        yield partial(_compute_on_cluster, client=client)


def find_versions() -> dict[str, str]:
    """Return the versions of everything that the digits of a table depend on."""
    texts = sorted(read_texts(PACKAGE_ROOT).items())
    return {**package_versions(), "source files": hashlib.sha256(repr(texts).encode()).hexdigest()[:16]}


def require_same_versions(client: Any) -> None:
    """Raise MechanismError unless a cluster has workers, and all of them have the versions that this process has."""
    try:
        client.wait_for_workers(1, timeout=CONNECTION_TIMEOUT)
    except TimeoutError as error:
        text = f"cluster: the scheduler has no workers after {CONNECTION_TIMEOUT:g} s"
        raise MechanismError(f"{text}; start some with `dask worker` and its address") from error
    own_versions, problems = find_versions(), []
    for worker, versions in client.run(find_versions, on_error="return").items():
        if isinstance(versions, BaseException):
            problems.append(f"cluster: worker {worker} cannot import this package ({versions}); install it there")
            continue
        differing = [name for name, own in own_versions.items() if versions.get(name) != own]
        found = ", ".join(f"{name} {versions.get(name, 'not installed')} instead of {own_versions[name]}" for name in differing)
        if differing:
            problems.append(f"cluster: worker {worker} has {found}; install there what is installed here, or the table would differ")
    if problems:
        raise MechanismError(*problems)


def _compute_on_cluster(function: RowFunction[SweepRow], indices: Sequence[int], client: Any) -> Generator[Sequence[SweepRow], None, None]:
    """Yield the rows of chunks in the order in which they are finished; the scheduler repeats those of a worker that is lost."""
    # Packages of the extra `cluster`, and joblib, which is slow to import.
    from distributed import CancelledError, KilledWorker
    from distributed.comm.core import CommClosedError
    from joblib import Parallel, delayed, parallel_config

    chunks = make_chunks(indices, max(1, sum(client.ncores().values())))
    with parallel_config(backend="dask", client=client):
        parallel = Parallel(n_jobs=-1, return_as="generator_unordered", batch_size=1)
    with record_interrupts(only_first=True):
        try:
            with closing(parallel(delayed(partial(compute_chunk, function))(one) for one in chunks)) as results:
                yield from results
        except (KilledWorker, CancelledError, CommClosedError) as error:
            raise RunFailed(f"the cluster was lost: {error}; finished rows on disk are kept") from error
