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

Function = TypeVar("Function", bound=Callable[..., object])

PACKAGE = Path(__file__).parents[1]

KERNELS = re.compile(rb"numerics\.jit import")
"""What stands in a file that has kernels."""


KERNEL_FOLDERS = {"numerics", "mechanics", "integrators"}
"""Kernels there use constants of their neighbours that have no kernels."""


def compiled(function: Function) -> Function:
    """The function compiled on its first call, without fast-math, and kept in a cache that can be written.

    A division by zero gives infinity or NaN, as in numpy: the callers look at what comes out.
    """
    return _compiled(function, {})


def kernel(function: Function) -> Function:
    """The same for a function that only compiled ones call: without a way in from Python, which is half the work."""
    return _compiled(function, {"no_cpython_wrapper": True, "no_cfunc_wrapper": True})


def inlined(function: Function) -> Function:
    """The same for a function that is written into each that calls it: a call with many arrays costs like a joint."""
    return _compiled(function, {"inline": "always"})


def _compiled(function: Function, options: dict[str, Any]) -> Function:
    from numba import njit

    with _cached_in(cache_folder()):
        return cast(Function, njit(cache=True, error_model="numpy", **options)(function))


@cache
def cache_folder() -> Path:
    """Where this version's kernels are kept: beside the package, else with the user, else in a temporary folder.

    The folder is named after the text of all kernels: numba itself looks only at the file a kernel stands in, and would
    keep one that calls a changed kernel of another file.
    """
    text = hashlib.sha256()
    for path in sorted(PACKAGE.glob("**/*.py")):
        lines = path.read_bytes()
        if KERNELS.search(lines) or KERNEL_FOLDERS & set(path.relative_to(PACKAGE).parts):
            text.update(lines)
    name = f"kernels-{text.hexdigest()[:16]}"
    beside = PACKAGE / "__pycache__"
    if "NUMBA_CACHE_DIR" in os.environ:
        return Path(os.environ["NUMBA_CACHE_DIR"]) / "governor-mechanism" / name
    if _writable(beside / name):
        _remove_older(beside, name)
        return beside / name
    with suppress(RuntimeError):  # a user without a home
        users = Path.home() / ".cache" / "governor-mechanism" / name
        if _writable(users):
            return users
    return Path(tempfile.gettempdir()) / f"governor-mechanism-{os.getuid()}" / name


@contextmanager
def _cached_in(folder: Path) -> Iterator[None]:
    """Let numba keep what is declared meanwhile in that folder; other users of numba keep theirs."""
    from numba.core import config  # its settings are made at run time, and no checker knows them

    settings: Any = config
    before = settings.CACHE_DIR
    settings.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        settings.CACHE_DIR = before


def _remove_older(base: Path, name: str) -> None:
    """Kernels of earlier versions are never read again."""
    for folder in base.glob("kernels-*"):
        if folder.name != name:
            shutil.rmtree(folder, ignore_errors=True)


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def announce(kernel: str, seconds: int) -> None:
    """Say on standard error that kernels up to this one are about to be compiled, where it is not kept yet."""
    try:
        _require_kept(cache_folder(), kernel)
    except FileNotFoundError:
        if sys.stderr is not None:
            print(f"compiling kernels, once for this version: about {seconds} s", file=sys.stderr, flush=True)


@cache
def _require_kept(folder: Path, kernel: str) -> None:
    """Raise FileNotFoundError where it is not kept; once it is, no folder is searched again."""
    if not any(folder.rglob(f"*.{kernel}-*.nbi")):
        raise FileNotFoundError(kernel)
