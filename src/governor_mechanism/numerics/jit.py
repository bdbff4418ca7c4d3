"""Decorators of the kernels: each is called in the library that was built beforehand, or compiled by numba, or runs as Python."""

import os
import sys
from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.numerics.kernel_library import PACKAGE_ROOT, digest_sources, find_kernel, library_obstacle

CompiledFunction = TypeVar("CompiledFunction", bound=Callable[..., object])

USES_COMPILER = os.environ.get("GOVERNOR_MECHANISM_JIT") != "0"
"""Whether kernels are compiled. With GOVERNOR_MECHANISM_JIT=0 they run as Python, some 100 times slower, for a debugger."""

USES_LIBRARY = os.environ.get("GOVERNOR_MECHANISM_JIT") != "1"
"""Whether kernels of the library are called. With GOVERNOR_MECHANISM_JIT=1 numba compiles all."""

NUMBA_CURE = "pip install 'governor-mechanism[jit]'"
"""Command that installs numba."""


class Kernel:
    """A function compiled beforehand, into the library, or by numba at its first call; callers check for the infinity or NaN of 1 / 0."""

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        # What a kernel calls is compiled with the kernel's options where it has none of its own.
        self._options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, "forceinline": False, **options}
        self.__wrapped__ = function
        update_wrapper(self, function)

    def __call__(self, *args: Any) -> Any:
        """Call the machine code."""
        return self._machine_code(*args)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: machine code cannot be copied, and numba copies the kernels that a kernel calls for its cache."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_machine_code", "_dispatcher")}

    @cached_property
    def _machine_code(self) -> Callable[..., Any]:
        """What calls the machine code: in the library, or compiled by numba."""
        found = find_kernel(self.__wrapped__, self._call_with_other_types) if USES_LIBRARY else None
        return found or self._dispatcher

    def _call_with_other_types(self, *args: Any) -> Any:
        """Let numba compile the function for arguments of types that the library does not know."""
        if "_dispatcher" not in self.__dict__:
            text = f"kernels: {self.__wrapped__.__name__} is called with other types than in the library; numba compiles it"
            cure = "where they are right, `python kernel_build/build.py --again` builds the library for them"
            print(f"{text}; {cure}", file=sys.stderr, flush=True)
        return self._dispatcher(*args)

    @cached_property
    def _dispatcher(self) -> Any:
        """What numba calls, and compiles when it meets new types of arguments."""
        return _decorate_by_numba(self.__wrapped__, cache=True, **self._options)

    @property
    def _numba_type_(self) -> Any:
        """Type of this function in functions that call it; numba looks for this name."""
        return self._dispatcher._numba_type_


def jit(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that may allocate arrays and return them; references to arrays are counted."""
    return cast(CompiledFunction, Kernel(function, _nrt=True)) if USES_COMPILER else function


def jit_in_place(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that only changes its arguments, without reference counts."""
    # Counting the references to the arrays of its arguments would cost several times the arithmetic of
    # a short function. Such a function must not allocate arrays (the compiler refuses it), nor return
    # any, nor call a function that returns one.
    return cast(CompiledFunction, Kernel(function, _nrt=False)) if USES_COMPILER else function


def jit_inlined(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that only changes its arguments, as a part of each function that calls it."""
    # Named tuples of arrays are flattened into hundreds of values. Passing them takes as long as the arithmetic of one evaluation.
    return cast(CompiledFunction, Kernel(function, _nrt=False, forceinline=True)) if USES_COMPILER else function


def record_dtype(*fields: tuple[str, str] | tuple[str, str, tuple[int, ...]]) -> np.dtype[np.void]:
    """Return the type of records that kernels read and write as attributes, compiled or not."""
    # Records of numpy alone have no attributes; numba gives any records some, and takes longer for the types of `np.record`.
    return np.dtype(list(fields)) if USES_COMPILER else np.dtype((np.record, list(fields)))


def _decorate_by_numba(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function that numba compiles when it is called."""
    numba = _import_numba()
    previous_folder = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(_cache_folder())
    try:
        return numba.njit(**options)(function)
    finally:
        numba.config.CACHE_DIR = previous_folder  # other users of numba keep their folder


@cache
def _import_numba() -> Any:
    """Import numba, and say why it takes the place of the library."""
    obstacle = library_obstacle() if USES_LIBRARY else ""
    try:
        import numba
    except ImportError as error:
        text = f"the library of kernels is not used ({obstacle})" if obstacle else "these kernels are not in a library"
        cure = f"`make kernels` builds it in a clone, and a new installation elsewhere; or install numba: {NUMBA_CURE}"
        if not USES_LIBRARY:
            text = "GOVERNOR_MECHANISM_JIT=1 asks for kernels that numba compiles"
            cure = f"remove that variable, or {NUMBA_CURE}"
        raise GovernorMechanismError(f"{text}, and numba cannot be imported ({error}); {cure}") from None
    if obstacle:
        text = f"kernels: the library is not used ({obstacle}); numba compiles them, and `make kernels` builds it again"
        print(text, file=sys.stderr, flush=True)
    return numba


@cache
def _cache_folder() -> Path:
    """Return the folder where numba keeps machine code: one for each text of the kernels, and only the newest stays."""
    # Numba checks only the file that defines a kernel, and would keep a kernel that calls a changed one
    # of another file.
    base = Path(os.environ.get("NUMBA_CACHE_DIR") or PACKAGE_ROOT / "__pycache__")
    folder = base / f"kernels-{digest_sources()[:16]}"
    if base.parent == PACKAGE_ROOT:
        import shutil

        for other in set(base.glob("kernels-*")) - {folder}:
            shutil.rmtree(other, ignore_errors=True)
    return folder
