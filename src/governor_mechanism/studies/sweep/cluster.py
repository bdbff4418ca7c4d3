"""Rows of a sweep computed on a cluster of dask.distributed, through joblib."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from typing import Any, Protocol

from governor_mechanism.errors import MechanismError, RunFailed
from governor_mechanism.files.results import package_versions
from governor_mechanism.numerics.kernel_library import digest_sources
from governor_mechanism.studies.sweep.rows import SweepRow
from governor_mechanism.studies.sweep.workers import (
    RowComputer,
    RowFunction,
    compute_alone,
    compute_chunk,
    compute_in_parallel,
    make_chunks,
    record_interrupts,
)
from governor_mechanism.units.quantities import format_value

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
    """Return a sentence for each mistake in where rows are to be computed.

    Result: sentences; none if a sweep can be computed there.
    """
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
) -> Iterator[RowComputer[SweepRow]]:
    """Provide the function that computes the rows: in this process, in several ones, or on a cluster.

    Raises MechanismError if dask.distributed is missing, no scheduler with a worker answers, or a worker has
    other versions of the packages.
    """
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
    return {**package_versions(), "kernels": digest_sources()[:16]}


def require_same_versions(client: Any) -> None:
    """Raise MechanismError unless a cluster has workers, and all of them have the versions that this process has.

    Raises MechanismError with a sentence for each worker that differs.
    """
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
