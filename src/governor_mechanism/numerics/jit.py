"""Decorators of the kernels: each is called in the library of `make kernels`, or compiled by numba into a cache on disk."""

import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property, update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from governor_mechanism.numerics.compilation_progress import has_moving_line
from governor_mechanism.numerics.kernel_library import PACKAGE_ROOT, digest_sources, find_kernel

CompiledFunction = TypeVar("CompiledFunction", bound=Callable[..., object])

USES_COMPILER = os.environ.get("GOVERNOR_MECHANISM_JIT") != "0"
"""Whether kernels are compiled. With GOVERNOR_MECHANISM_JIT=0 they run as Python, some 100 times slower, for a debugger."""

USES_LIBRARY = os.environ.get("GOVERNOR_MECHANISM_JIT") != "1"
"""Whether kernels of the library are called. With GOVERNOR_MECHANISM_JIT=1 numba compiles all."""


class Kernel:
    """A function, with options of numba's compiler, that is compiled: beforehand, into the library, or when it is first called.

    Called by Python, it is compiled with all that it calls; called by a compiled function, it becomes a part of that one.
    A division by zero gives infinity or NaN, as in numpy; callers check the results.
    """

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        self._options: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, **options}
        self.__wrapped__ = function
        update_wrapper(self, function)

    def __call__(self, *args: Any) -> Any:
        """Call the machine code."""
        return self._machine_code(*args)

    @property
    def is_loaded(self) -> bool:
        """Whether Python has called the function in this process."""
        return "_machine_code" in self.__dict__

    @property
    def is_compiled(self) -> bool:
        """Whether the machine code is loaded, in the library, or in the cache."""
        if self.is_loaded or self._library_code is not None:
            return True
        return any(kernel_cache_folder().rglob(f"*.{self.__wrapped__.__name__}-*.nbi"))

    @cached_property
    def _machine_code(self) -> Callable[..., Any]:
        """What calls the machine code: in the library, or compiled by numba."""
        return self._library_code or self._dispatcher

    @cached_property
    def _library_code(self) -> Callable[..., Any] | None:
        """What calls the machine code in the library; None if it has none."""
        return find_kernel(self.__wrapped__, self._call_with_other_types) if USES_LIBRARY else None

    def _call_with_other_types(self, *args: Any) -> Any:
        """Let numba compile the function for arguments of types that the library does not know."""
        if "_dispatcher" not in self.__dict__:
            text = f"kernels: {self.__wrapped__.__name__} is called with other types than in the library; numba compiles it"
            print(text, file=sys.stderr, flush=True)
        return self._dispatcher(*args)

    def signature_of(self, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return the types of arguments, for which the function is compiled."""
        return tuple(map(self._dispatcher.typeof_pyval, arguments))

    def compile_signature(self, signature: tuple[Any, ...]) -> None:
        """Compile or load the machine code for types of arguments."""
        self._dispatcher.compile(signature)

    @cached_property
    def _dispatcher(self) -> Any:
        """Dispatcher of the calls by Python, whose machine code is kept in the cache."""
        from numba import njit
        from numba.core import config  # numba creates its settings at run time; type checkers do not know them

        from governor_mechanism.numerics.kernel_linking import KernelCompiler

        settings: Any = config
        previous_folder, settings.CACHE_DIR = settings.CACHE_DIR, str(kernel_cache_folder())  # other users of numba keep their folder
        try:
            return njit(pipeline_class=KernelCompiler, cache=True, **self._options)(self.__wrapped__)
        finally:
            settings.CACHE_DIR = previous_folder

    @cached_property
    def _linked_dispatcher(self) -> Any:
        """Dispatcher of the calls by compiled functions."""
        from numba import njit

        from governor_mechanism.numerics.kernel_linking import LinkedFunctionCompiler

        options = {"no_cpython_wrapper": True, **self._options}
        return njit(pipeline_class=LinkedFunctionCompiler, **options)(self.__wrapped__)

    @property
    def _numba_type_(self) -> Any:
        """Type of this function in functions that call it; numba looks for this name."""
        return self._linked_dispatcher._numba_type_


def jit(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that may allocate arrays and return them; references to arrays are counted."""
    return cast(CompiledFunction, Kernel(function, _nrt=True)) if USES_COMPILER else function


def jit_in_place(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that only changes its arguments, without reference counts.

    Counting the references to the arrays of its arguments would cost several times the arithmetic of a short function. Such a function
    must not allocate arrays (the compiler refuses it), nor return any, nor call a function that returns one.
    """
    return cast(CompiledFunction, Kernel(function, _nrt=False)) if USES_COMPILER else function


def record_dtype(*fields: tuple[str, str] | tuple[str, str, tuple[int, ...]]) -> np.dtype[np.void]:
    """Return the type of records that kernels read and write as attributes, compiled or not."""
    # Records of numpy alone have no attributes; numba gives any records some, and takes longer for the types of `np.record`.
    return np.dtype(list(fields)) if USES_COMPILER else np.dtype((np.record, list(fields)))


@cache
def kernel_cache_folder() -> Path:
    """Return the cache folder of this version: in the package, else in the user's cache, else in a temporary folder.

    Its name contains a hash of the text of all kernels. Numba checks only the file that defines a kernel, and would keep a
    kernel that calls a changed kernel of another file.
    """
    name = f"kernels-{digest_sources()[:16]}"
    package_cache = PACKAGE_ROOT / "__pycache__"
    if "NUMBA_CACHE_DIR" in os.environ:
        return Path(os.environ["NUMBA_CACHE_DIR"]) / "governor-mechanism" / name
    if _is_writable(package_cache / name):
        _remove_older_caches(package_cache, name)
        return package_cache / name
    with suppress(RuntimeError):  # no home folder
        user_cache = Path.home() / ".cache" / "governor-mechanism" / name
        if _is_writable(user_cache):
            return user_cache
    return Path(tempfile.gettempdir()) / f"governor-mechanism-{os.getuid()}" / name


def _remove_older_caches(base: Path, name: str) -> None:
    """Delete the caches of earlier versions, which are never read again."""
    for folder in base.glob("kernels-*"):
        if folder.name != name:
            shutil.rmtree(folder, ignore_errors=True)


def _is_writable(folder: Path) -> bool:
    """Return whether files can be created in a folder, which is created if it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def must_be_compiled(kernel: Callable[..., object]) -> bool:
    """Return whether a kernel is neither loaded nor in the cache."""
    return not getattr(kernel, "is_compiled", True)  # a function of Python has nothing to compile


def warn_before_compiling(kernel: Callable[..., object], seconds: int) -> None:
    """Print a notice on standard error if a kernel is neither loaded nor in the cache and has to be compiled.

    A terminal shows a moving line instead while kernels are compiled; see `show_compilation`.

    Parameters
    ----------
    kernel
        The kernel that is compiled last.
    seconds
        Approximate compile time, s.
    """
    if must_be_compiled(kernel) and sys.stderr is not None and not has_moving_line():
        print(f"compiling kernels, once for this version: about {seconds} s", file=sys.stderr, flush=True)
