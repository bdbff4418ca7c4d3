"""How the kernels are compiled: once, by numba, kept on disk for later processes."""

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

KERNEL_IMPORT_PATTERN = re.compile(rb"numerics\.jit import")
"""What stands in a file that has kernels."""


KERNEL_FOLDERS = {"numerics", "mechanics", "integrators"}
"""Kernels there use constants of their neighbours that have no kernels."""


def jit(function: CompiledFunction) -> CompiledFunction:
    """The function compiled on its first call, without fast-math, and kept in a cache that can be written.

    A division by zero gives infinity or NaN, as in numpy: the callers look at what comes out.
    """
    return _jit_with_options(function, {})


def jit_internal(function: CompiledFunction) -> CompiledFunction:
    """The same for a function that only compiled ones call: without a way in from Python, which is half the work."""
    return _jit_with_options(function, {"no_cpython_wrapper": True, "no_cfunc_wrapper": True})


def jit_inline(function: CompiledFunction) -> CompiledFunction:
    """The same for a function that is written into each that calls it: a call with many arrays costs like a joint."""
    return _jit_with_options(function, {"inline": "always"})


def _jit_with_options(function: CompiledFunction, options: dict[str, Any]) -> CompiledFunction:
    from numba import njit

    with _numba_cache_folder(kernel_cache_folder()):
        return cast(CompiledFunction, njit(cache=True, error_model="numpy", **options)(function))


@cache
def kernel_cache_folder() -> Path:
    """Where this version's kernels are kept: beside the package, else with the user, else in a temporary folder.

    The folder is named after the text of all kernels: numba itself looks only at the file a kernel stands in, and would
    keep one that calls a changed kernel of another file.
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
    with suppress(RuntimeError):  # a user without a home
        user_cache = Path.home() / ".cache" / "governor-mechanism" / name
        if _is_writable(user_cache):
            return user_cache
    return Path(tempfile.gettempdir()) / f"governor-mechanism-{os.getuid()}" / name


@contextmanager
def _numba_cache_folder(folder: Path) -> Iterator[None]:
    """Let numba keep what is declared meanwhile in that folder; other users of numba keep theirs."""
    from numba.core import config  # its settings are made at run time, and no checker knows them

    settings: Any = config
    previous_folder = settings.CACHE_DIR
    settings.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        settings.CACHE_DIR = previous_folder


def _remove_older_caches(base: Path, name: str) -> None:
    """Kernels of earlier versions are never read again."""
    for folder in base.glob("kernels-*"):
        if folder.name != name:
            shutil.rmtree(folder, ignore_errors=True)


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def warn_before_compiling(kernel_name: str, seconds: int) -> None:
    """Say on standard error that kernels up to this one are about to be compiled, where it is not kept yet."""
    try:
        _require_cached_kernel(kernel_cache_folder(), kernel_name)
    except FileNotFoundError:
        if sys.stderr is not None:
            print(f"compiling kernels, once for this version: about {seconds} s", file=sys.stderr, flush=True)


@cache
def _require_cached_kernel(folder: Path, kernel_name: str) -> None:
    """Raise FileNotFoundError where it is not kept; once it is, no folder is searched again."""
    if not any(folder.rglob(f"*.{kernel_name}-*.nbi")):
        raise FileNotFoundError(kernel_name)
