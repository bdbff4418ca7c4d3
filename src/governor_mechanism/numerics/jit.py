"""Numba decorators for the kernels, and their compile cache on disk."""

import hashlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
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


def _make_decorator(**options: Any) -> Callable[[CompiledFunction], CompiledFunction]:
    """Return a decorator that compiles a function at its first call, without fast-math.

    A division by zero gives infinity or NaN, as in numpy; callers check the results. Other users of numba keep their cache folder.
    """

    def decorate(function: CompiledFunction) -> CompiledFunction:
        """Return the dispatcher of a function."""
        from numba import njit
        from numba.core import config  # numba creates its settings at run time; type checkers do not know them

        settings: Any = config
        previous_folder, settings.CACHE_DIR = settings.CACHE_DIR, str(kernel_cache_folder())
        try:
            return cast(CompiledFunction, njit(error_model="numpy", **options)(function))
        finally:
            settings.CACHE_DIR = previous_folder

    return decorate


jit = _make_decorator(cache=True, _nrt=True)
"""Compile a function and keep it in the cache."""
jit_in_place = _make_decorator(cache=True, _nrt=False)
"""Compile a function that Python calls and that only changes its arguments, under the conditions of `jit_internal`."""
jit_internal = _make_decorator(cache=True, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""Compile a function that only compiled functions call, without a wrapper for Python and without reference counts.

Counting the references to the arrays of its arguments would cost several times the arithmetic of a short function. Such a function
must not allocate arrays (the compiler refuses it), nor return any, nor call a function that returns one.
"""
jit_allocating = _make_decorator(cache=True, _nrt=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""The same with reference counts, for a function that allocates arrays or gets them from other functions.

They are requested explicitly, because numba lets a function inherit the setting of its first caller.
"""
jit_inline = _make_decorator(cache=True, inline="always")
"""Compile a function that is inlined in each caller."""
jit_closure = _make_decorator(_nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""Compile a closure over compiled functions like `jit_internal`.

The cache cannot hold it, but holds its callers, which contain it.
"""
jit_allocating_closure = _make_decorator(_nrt=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""The same for a closure that allocates arrays."""
jit_inline_closure = _make_decorator(inline="always", no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""The same for a closure that is inlined in its only caller.

Each compiled function contains the machine code of all that it calls, so that every level of calls costs the time to compile them.
"""


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
