"""Numba decorators for the kernels, and their compile cache on disk."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

CompiledFunction = TypeVar("CompiledFunction", bound=Callable[..., object])

PACKAGE_ROOT = Path(__file__).parents[1]
"""Folder of this package."""

KERNEL_IMPORT_PATTERN = re.compile(rb"numerics\.jit import")
"""Import that marks a file with kernels."""

KERNEL_FOLDERS = {"numerics", "effects", "mechanics", "integrators"}
"""Folders whose files all enter the cache key: kernels there use constants of modules without kernels."""


def jit(function: CompiledFunction) -> CompiledFunction:
    """Compile a function at its first call and keep it in the cache; without fast-math.

    A division by zero gives infinity or NaN, as in numpy; callers check the results.

    Parameters
    ----------
    function
        Function to compile.

    Returns
    -------
    CompiledFunction
        Dispatcher with the signature of `function`.
    """
    return _jit_with_options(function, {"cache": True})


def jit_internal(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that only compiled functions call.

    It has no wrapper for calls from Python, which halves the compile time.

    Parameters
    ----------
    function
        Function to compile.

    Returns
    -------
    CompiledFunction
        Dispatcher with the signature of `function`, not callable from Python.
    """
    return _jit_with_options(function, {"cache": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True})


def jit_inline(function: CompiledFunction) -> CompiledFunction:
    """Compile a function that is inlined in each caller, because a call with many arrays costs as much as a joint.

    Parameters
    ----------
    function
        Function to compile.

    Returns
    -------
    CompiledFunction
        Dispatcher with the signature of `function`.
    """
    return _jit_with_options(function, {"cache": True, "inline": "always"})


def jit_closure(function: CompiledFunction) -> CompiledFunction:
    """Compile a closure over compiled functions that only compiled functions call.

    The cache cannot hold it, but holds its callers, which contain it.

    Parameters
    ----------
    function
        Function to compile.

    Returns
    -------
    CompiledFunction
        Dispatcher with the signature of `function`, not callable from Python.
    """
    return _jit_with_options(function, {"no_cpython_wrapper": True, "no_cfunc_wrapper": True})


def jit_inline_closure(function: CompiledFunction) -> CompiledFunction:
    """Compile a closure over compiled functions that is inlined in its only caller.

    Each compiled function contains the machine code of all that it calls, so that every level of calls costs the time to compile them.

    Parameters
    ----------
    function
        Closure to compile.

    Returns
    -------
    CompiledFunction
        Dispatcher with the signature of `function`, not callable from Python.
    """
    return _jit_with_options(function, {"inline": "always", "no_cpython_wrapper": True, "no_cfunc_wrapper": True})


def _jit_with_options(function: CompiledFunction, options: dict[str, Any]) -> CompiledFunction:
    from numba import njit

    with _numba_cache_folder(kernel_cache_folder()):
        return cast(CompiledFunction, njit(error_model="numpy", **options)(function))


@cache
def kernel_cache_folder() -> Path:
    """Return the cache folder of this version: in the package, else in the user's cache, else in a temporary folder.

    Its name contains a hash of the text of all kernels. Numba checks only the file that defines a kernel, and would keep a
    kernel that calls a changed kernel of another file.
    """
    digest = hashlib.sha256()
    for path in sorted(PACKAGE_ROOT.glob("**/*.py")):
        source = path.read_bytes()
        if KERNEL_IMPORT_PATTERN.search(source) or KERNEL_FOLDERS & set(path.relative_to(PACKAGE_ROOT).parts):
            digest.update(source)
    name = f"kernels-{digest.hexdigest()[:16]}"
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


@contextmanager
def _numba_cache_folder(folder: Path) -> Iterator[None]:
    """Let numba cache what is declared in this context in `folder`; other users of numba keep their folder."""
    from numba.core import config  # numba creates its settings at run time; type checkers do not know them

    settings: Any = config
    previous_folder = settings.CACHE_DIR
    settings.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        settings.CACHE_DIR = previous_folder


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


def warn_before_compiling(kernel_name: str, seconds: int) -> None:
    """Print a notice on standard error if a kernel is not in the cache and has to be compiled.

    Parameters
    ----------
    kernel_name
        Name of the kernel function that is compiled last.
    seconds
        Approximate compile time, s.
    """
    try:
        _require_cached_kernel(kernel_cache_folder(), kernel_name)
    except FileNotFoundError:
        if sys.stderr is not None:
            print(f"compiling kernels, once for this version: about {seconds} s", file=sys.stderr, flush=True)


@cache
def _require_cached_kernel(folder: Path, kernel_name: str) -> None:
    """Raise FileNotFoundError if a kernel is not in the cache; a folder that contains it is searched only once."""
    if not any(folder.rglob(f"*.{kernel_name}-*.nbi")):
        raise FileNotFoundError(kernel_name)
