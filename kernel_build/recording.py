"""The types with which Python calls each kernel, recorded from short calculations that run the kernels as Python.

Import it before every other module of the package but `numerics.jit`: kernels that are made before cannot be observed.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any

os.environ["GOVERNOR_MECHANISM_JIT"] = "0"  # records have attributes that Python reads

import numba
import numpy as np

from governor_mechanism.numerics import jit

Signature = tuple[Any, ...]
"""Types of numba of the arguments of one call."""


class ObservedKernel(jit.Kernel):
    """A kernel that runs as Python and records the types of its arguments when no kernel calls it."""

    signatures: dict["ObservedKernel", set[Signature]] = {}  # noqa: RUF012 -- shared by all kernels on purpose
    typed: list["ObservedKernel"] = []  # noqa: RUF012
    is_inside_kernel = False

    @cached_property
    def _dispatcher(self) -> Any:
        """What types the function; nothing calls it."""
        self.typed.append(self)
        return numba.njit(no_cpython_wrapper=True, **self._options)(self.__wrapped__)

    def __call__(self, *arguments: Any) -> Any:
        """Call the function of Python."""
        if ObservedKernel.is_inside_kernel:
            return self.__wrapped__(*arguments)
        self.signatures.setdefault(self, set()).add(tuple(map(type_of, arguments)))
        ObservedKernel.is_inside_kernel = True
        try:
            return self.__wrapped__(*arguments)
        finally:
            ObservedKernel.is_inside_kernel = False


def type_of(value: Any) -> Any:
    """Return numba's type of an argument; an array that is only read counts as one that may be written."""
    if isinstance(value, np.ndarray):
        return numba.typeof(value).copy(readonly=False)
    if isinstance(value, tuple):
        types = tuple(map(type_of, value))
        if hasattr(value, "_fields"):
            return numba.types.BaseTuple.from_types(types, type(value))
        return numba.types.Tuple(types)
    return numba.typeof(value)


def observe_kernels() -> None:
    """Make every kernel that is defined from now on an observed one."""
    jit.jit = lambda function: ObservedKernel(function, _nrt=True)
    jit.jit_in_place = lambda function: ObservedKernel(function, _nrt=False)
    jit.jit_inlined = lambda function: ObservedKernel(function, _nrt=False, forceinline=True)


def record_signatures(calculations: Mapping[str, Callable[[], object]]) -> dict[ObservedKernel, Signature]:
    """Do calculations, and return the signature of each kernel that Python called; a kernel with two is an error."""
    with np.errstate(all="ignore"):  # as in machine code
        for calculate in calculations.values():
            calculate()
    for kernel, signatures in ObservedKernel.signatures.items():
        if len(signatures) > 1:
            found = "\n".join(map(str, signatures))
            raise SystemExit(f"kernel {kernel.__name__} is called with {len(signatures)} sets of types, but may have one only:\n{found}")
    return {kernel: next(iter(signatures)) for kernel, signatures in ObservedKernel.signatures.items()}


def definitions_in_use() -> set[tuple[str, str]]:
    """Return modules and names of all that was typed: functions of kernels, and the named tuples and enums of their arguments."""
    functions = {(one.__wrapped__.__module__, one.__wrapped__.__qualname__) for one in ObservedKernel.typed}
    signatures = [signature for kernel in ObservedKernel.typed for signature in kernel._dispatcher.signatures]
    classes = {(one.__module__, one.__qualname__) for signature in signatures for kind in signature for one in classes_in(kind)}
    return {(module, name.partition(".")[0]) for module, name in functions | classes}


def classes_in(kind: Any) -> Iterator[type]:
    """Yield the classes of named tuples and enums in a type of numba."""
    if hasattr(kind, "instance_class"):
        yield kind.instance_class
    if isinstance(kind, numba.types.BaseTuple):
        for entry in kind:
            yield from classes_in(entry)
