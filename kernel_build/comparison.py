"""Compare the library of kernels with numba, bit by bit, in every call of a kernel that runs of scenes make.

Usage: python kernel_build/comparison.py [--scenes NAME ...] [--kernels NAME ...] [--duration SECONDS]. Without names: all shipped scenes in
the three engines, and all kernels. Each call is made twice with the same arguments. It ends with status 1 if a bit differs, if a call has
types that the library does not know, or if a kernel keeps memory.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

import governor_mechanism as gm
from governor_mechanism.numerics.jit import Kernel
from governor_mechanism.numerics.kernel_library import count_live_blocks
from uses import USES

ENGINES = ("reduced", "multibody", "impulse")


class ComparedCalls:
    """Calls of kernels, each made in the library and by numba.

    Attributes
    ----------
    names
        Names of the kernels that are compared; all if empty.
    n_calls, n_different
        Number of calls by kernel, and of those with another result.
    missing
        Names of kernels that the library has not, or not for the types with which Python called them.
    """

    def __init__(self, names: list[str]) -> None:
        self.names, self.missing = frozenset(names), set[str]()
        self.n_calls, self.n_different = Counter[str](), Counter[str]()

    def add_missing(self, kernel: Any, *arguments: Any) -> Any:
        """Note a call with types that the library does not know, and let numba compile it."""
        self.missing.add(kernel.__name__)
        return kernel._dispatcher(*arguments)

    def call(self, kernel: Any, *arguments: Any) -> Any:
        """Call a kernel twice, compare all that it returns and changes, and return the result."""
        name = kernel.__name__
        call_library = kernel._machine_code
        is_missing = call_library is vars(kernel).get("_dispatcher")
        if is_missing:
            self.missing.add(name)
        if is_missing or (self.names and name not in self.names):
            return call_library(*arguments)
        arrays = list(arrays_in(arguments))
        before = [array.copy() for array in arrays]
        found = call_library(*arguments)
        after = [array.copy() for array in arrays]
        for array, values in zip(arrays, before, strict=True):
            if array.flags.writeable:
                array[...] = values
        expected = kernel._dispatcher(*arguments)
        self.n_calls[name] += 1
        changed = [array.tobytes() for array in arrays] != [array.tobytes() for array in after]
        self.n_different[name] += changed or bits_of(found) != bits_of(expected)
        return found


def arrays_in(value: Any) -> Iterator[np.ndarray]:
    """Yield the arrays in nested tuples."""
    if isinstance(value, tuple):
        for entry in value:
            yield from arrays_in(entry)
    elif isinstance(value, np.ndarray):
        yield value


def bits_of(value: Any) -> bytes:
    """Return type and bits of a result."""
    if isinstance(value, tuple):
        return type(value).__name__.encode() + b"".join(map(bits_of, value))
    kind = type(value).__name__.encode()
    if isinstance(value, np.ndarray):
        return kind + str((value.shape, value.dtype)).encode() + value.tobytes()
    return kind + (b"" if value is None else np.float64(value).tobytes())


def run_scenes(names: list[str], duration: float) -> None:
    """Run scenes with all engines that can, and compute what is read only later."""
    for name in names:
        for engine in ENGINES:
            start_time = time.process_time()
            try:
                run = gm.run(name, engine=engine, times=np.linspace(0.0, duration, 5), accuracy=1e-4)
            except gm.UnsupportedEffect:
                continue
            run.events, run.reactions, run.energy  # noqa: B018 -- reading computes them
            print(f"{name:26s} {engine:10s} {run.outcome.name}, {time.process_time() - start_time:.1f} s", flush=True)


def main() -> None:
    """Run, compare, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", nargs="*", default=[])
    parser.add_argument("--kernels", nargs="*", default=[])
    parser.add_argument("--duration", type=float, default=0.3)
    options = parser.parse_args()
    calls = ComparedCalls(options.kernels)
    Kernel.__call__ = lambda kernel, *arguments: calls.call(kernel, *arguments)
    Kernel._call_with_other_types = lambda kernel, *arguments: calls.add_missing(kernel, *arguments)
    run_scenes(options.scenes or gm.list_models(), options.duration)
    if not options.scenes:
        for calculate in USES.values():
            calculate()
    for name, n_calls in sorted(calls.n_calls.items()):
        print(f"{name:34s} {n_calls:7d} calls, {calls.n_different[name]} different")
    n_calls, n_different, n_kept = calls.n_calls.total(), calls.n_different.total(), count_live_blocks()
    print(f"{len(calls.n_calls)} kernels, {n_calls} calls, {n_different} different; {n_kept} blocks of memory kept")
    if calls.missing:
        print(f"not in the library: {', '.join(sorted(calls.missing))}")
    sys.exit(bool(n_different or calls.missing or n_kept or n_calls == 0))


if __name__ == "__main__":
    main()
