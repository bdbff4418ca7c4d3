"""The library of kernels that were compiled beforehand: one file for a platform, and an index of its kernels."""

import ctypes
import hashlib
import json
import re
import sys
import sysconfig
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

PACKAGE_ROOT = Path(__file__).parents[1]
"""Folder of this package."""

LIBRARY_FOLDER = PACKAGE_ROOT / "_kernels"
"""Folder of the library and its index; `make kernels` writes it."""

SUFFIX = ".dll" if sys.platform == "win32" else ".so"

KERNEL_IMPORT_PATTERN = re.compile(rb"numerics\.jit import")
"""Import that marks a file with kernels."""

KERNEL_FOLDERS = {"numerics", "effects", "mechanics", "integrators", "engines"}
"""Folders whose files all enter the digest: kernels there use constants and compile functions of modules without kernels."""


@cache
def digest_sources() -> str:
    """Return a digest of the text of all kernels."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE_ROOT.glob("**/*.py")):
        source = path.read_bytes()
        if KERNEL_IMPORT_PATTERN.search(source) or KERNEL_FOLDERS & set(path.relative_to(PACKAGE_ROOT).parts):
            digest.update(source)
    return digest.hexdigest()


def platform_name() -> str:
    """Return the name of the platform for which a library is built."""
    return sysconfig.get_platform()


def read_index() -> dict[str, Any] | None:
    """Return the index of the library; None if there is none."""
    try:
        index: dict[str, Any] = json.loads((LIBRARY_FOLDER / "index.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return index


def find_obstacle(index: Mapping[str, Any]) -> str:
    """Return why a library cannot be used on this platform for the present kernels; empty if it can."""
    if index.get("platform") != platform_name():
        return f"it is for {index.get('platform')}"
    return "" if index.get("sources") == digest_sources() else "its kernels were changed since"


@cache
def _open_library() -> tuple[Any, Mapping[str, Any]] | None:
    """Load the library; None if there is none, or it is of other sources, which standard error says."""
    if sysconfig.get_config_var("Py_GIL_DISABLED"):
        return None  # the caller of kernels holds the global lock
    index = read_index()
    if index is None:
        return None
    try:
        if obstacle := find_obstacle(index):
            raise OSError(obstacle)
        return ctypes.PyDLL(str(LIBRARY_FOLDER / index["library"])), index["kernels"]
    except OSError as error:
        text = f"kernels: the library is not used ({error}); numba compiles them, and `make kernels` builds it again"
        print(text, file=sys.stderr, flush=True)
        return None


def find_kernel(function: Callable[..., Any], fallback: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return what calls a kernel of the library; None if it is not in it.

    Parameters
    ----------
    function
        The function of Python.
    fallback
        What is called with arguments of other types.

    Returns
    -------
    Callable[..., Any] or None
        A function with the same arguments.
    """
    opened = _open_library()
    if opened is None:
        return None
    library, kernels = opened
    name = f"{function.__module__}:{function.__qualname__}"  # a function inside another one is never in the library
    if name not in kernels:
        return None
    kernel = kernels[name]
    make_caller = library.make_caller
    make_caller.restype = ctypes.py_object
    text, address, objects = ctypes.c_char_p, ctypes.c_void_p, ctypes.py_object
    make_caller.argtypes = [text, address, text, text, ctypes.c_int, objects, objects, objects]
    entry = ctypes.cast(getattr(library, kernel["entry"]), ctypes.c_void_p)
    classes = tuple(map(_find_class, kernel["classes"]))
    arguments, result = kernel["arguments"].encode(), kernel["result"].encode()
    caller: Callable[..., Any] = make_caller(name.encode(), entry, arguments, result, kernel["slots"], classes, fallback, np.ndarray)
    return caller


def count_live_blocks() -> int:
    """Return the number of blocks of memory that kernels of the library hold: 0 between calls."""
    opened = _open_library()
    return ctypes.c_int64.in_dll(opened[0], "n_live_blocks").value if opened else 0


def _find_class(name: str) -> type:
    module, _, qualified_name = name.partition(":")
    found: Any = import_module(module)
    for part in qualified_name.split("."):
        found = getattr(found, part)
    return found  # type: ignore[no-any-return]
