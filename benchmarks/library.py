"""Whole runs with the library of kernels against runs with the machine code of numba, in one process; and what a call of a kernel costs.

Numba first compiles all kernels, which takes minutes, and keeps them in NUMBA_CACHE_DIR if that is set.

Usage: python benchmarks/library.py
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

import governor_mechanism as gm
from governor_mechanism.numerics import kernel_library
from governor_mechanism.numerics.jit import Kernel

WORKLOADS = {
    "porter": "reduced",
    "porter_dry_friction": "reduced",
    "slide_valve_30": "multibody",
    "andrews_squeezer": "auto",
    "stiff_flyball": "auto",
    "governed_engine": "auto",
    "porter_clearance": "auto",
    "porter_cyclic": "impulse",
}
"""Engines by scene."""

MIN_REPEATS, MAX_REPEATS, TIME_LIMIT = 3, 30, 8.0
"""Number of runs of each kind, and the time in which they end unless there are too few, s."""

CALLED = ("project_state", "integrate_multibody")
"""Kernels with many arguments."""


def main() -> None:
    """Print both tables."""
    call_library = Kernel.__call__
    try:
        print_runs(call_library)
    finally:
        Kernel.__call__ = call_library
    print_calls()


def call_numba(kernel: Any, *arguments: Any) -> Any:
    """Call a kernel as numba compiles it, as with GOVERNOR_MECHANISM_JIT=1."""
    return kernel._dispatcher(*arguments)


def print_runs(call_library: Callable[..., Any]) -> None:
    """Print processor times of whole runs: the shortest of several, taken in turn."""
    print("| whole run | numba, ms | library, ms | library / numba (target 1.0; median 0.9) |\n|---|---|---|---|")
    ratios = []
    for name, engine in WORKLOADS.items():
        scene = gm.load(name)
        times: dict[Callable[..., Any], list[float]] = {call_numba: [], call_library: []}
        for call in times:
            run_with(call, scene, engine)
        started = time.perf_counter()
        while len(times[call_numba]) < MIN_REPEATS or (len(times[call_numba]) < MAX_REPEATS and time.perf_counter() - started < TIME_LIMIT):
            for call, taken in times.items():
                taken.append(run_with(call, scene, engine))
        numba, library = (1e3 * min(taken) for taken in times.values())
        ratios.append(library / numba)
        print(f"| {name}, {engine} | {numba:.2f} | {library:.2f} | {ratios[-1]:.2f} |", flush=True)
    print(f"| median | | | {median(ratios):.2f} |\n")


def run_with(call: Callable[..., Any], scene: gm.Scene, engine: str) -> float:
    """Return the processor time of a run whose kernels are called in one of both ways, s."""
    Kernel.__call__ = call
    start = time.process_time()
    gm.run(scene, engine=engine)
    return time.process_time() - start


def print_calls() -> None:
    """Print what a call costs beside the kernel: with the same arguments, an entry that does nothing."""
    recorded: dict[str, tuple[Any, ...]] = {}
    call_library = Kernel.__call__

    def record(kernel: Any, *arguments: Any) -> Any:
        recorded.setdefault(kernel.__name__, arguments)
        return call_library(kernel, *arguments)

    Kernel.__call__ = record
    try:
        gm.run("porter", engine="multibody", times=[0.0, 0.1])
    finally:
        Kernel.__call__ = call_library
    index = kernel_library.read_index() or {}
    described = {name.partition(":")[2]: one for name, one in index["kernels"].items()}
    print("| call of a kernel that does nothing | slots | arrays | µs (target 10 for 500 slots) |\n|---|---|---|---|")
    for name in (name for name in CALLED if name in recorded):
        arguments, slots = described[name]["arguments"], described[name]["slots"]
        caller = make_idle_caller(name, arguments, slots)
        duration = time_call(caller, recorded[name])
        print(f"| {name} | {slots} | {arguments.count('a')} | {duration:.2f} |")


def make_idle_caller(name: str, arguments: str, slots: int) -> Callable[..., Any]:
    """Return a caller with the arguments of a kernel, whose entry is a function of Python's library that does nothing and returns 0."""
    entry = ctypes.cast(ctypes.pythonapi.PyErr_CheckSignals, ctypes.c_void_p)
    make = kernel_library._open_library().code.make_caller
    caller: Callable[..., Any] = make(name.encode(), entry, arguments.encode(), b"n", slots, (), refuse, np.ndarray)
    return caller


def refuse(*arguments: Any) -> None:
    """Take the place of numba, which must not be needed."""
    raise AssertionError(f"{len(arguments)} arguments are of other types than in the library")


def time_call(caller: Callable[..., Any], arguments: tuple[Any, ...], n_calls: int = 200, n_repeats: int = 30) -> float:
    """Return the time of a call, the shortest of several mean times, µs."""
    best = np.inf
    for _ in range(n_repeats):
        start = time.perf_counter()
        for _ in range(n_calls):
            caller(*arguments)
        best = min(best, time.perf_counter() - start)
    return 1e6 * best / n_calls


if __name__ == "__main__":
    main()
