"""Compilation of a kernel in a second process, while this process compiles others; the kernel cache on disk hands it over.

The second process is a help only: if it cannot start or fails, this process compiles the kernel itself when it calls it.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, cast

from governor_mechanism.numerics.compilation_progress import show_compilation
from governor_mechanism.numerics.jit import Kernel, must_be_compiled

MAX_COMPILATION_TIME = 300.0
"""Time after which the second process counts as stuck, s; it needs about 10 s."""


@contextmanager
def compiled_beside(kernel: Callable[..., Any], make_arguments: Callable[[], tuple[Any, ...]]) -> Iterator[None]:
    """Compile a kernel in a second process while the body of the with statement runs; its end waits for that process.

    Nothing happens if the kernel is loaded or in the cache, or with a single processor.

    Parameters
    ----------
    kernel
        The kernel, a global function of its module.
    make_arguments
        Return arguments of the types for which it is compiled; their values do not matter.

    Yields
    ------
    None
        While the body runs.
    """
    process = None
    if must_be_compiled(kernel) and _has_free_processor():
        process = _start_compilation(cast(Kernel, kernel), make_arguments())
    if process is None:
        yield
        return
    try:
        yield
        with show_compilation(kernel.__name__), suppress(subprocess.TimeoutExpired):
            process.wait(MAX_COMPILATION_TIME)
    finally:
        process.kill()
        process.wait()


def _has_free_processor() -> bool:
    """Return whether this process may use more than one processor."""
    n_processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return n_processors is not None and n_processors > 1


def _start_compilation(kernel: Kernel, arguments: tuple[Any, ...]) -> subprocess.Popen[bytes] | None:
    """Start the second process with the same packages as this one; None if that is impossible."""
    function = kernel.__wrapped__
    request = pickle.dumps((function.__module__, function.__name__, kernel.signature_of(arguments)))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    try:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
        )
        with cast(Any, process.stdin) as pipe:
            pipe.write(request)
    except OSError:
        return None
    return process


def compile_requested_kernel() -> None:
    """Compile the kernel that the starting process names on standard input into the cache."""
    module, name, signature = pickle.load(sys.stdin.buffer)
    getattr(import_module(module), name).compile_signature(signature)


if __name__ == "__main__":
    with suppress(KeyboardInterrupt):  # the starting process reports it
        compile_requested_kernel()
