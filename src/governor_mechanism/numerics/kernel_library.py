"""The library of kernels that were compiled beforehand: one file for a platform, and an index of its kernels."""

import ctypes
import json
import os
import sys
import sysconfig
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

PACKAGE_ROOT = Path(__file__).parents[1]
"""Folder of this package."""

LIBRARY_FOLDER = PACKAGE_ROOT / "_kernels"
"""Folder of the library and its index; `make kernels` writes it."""

SUFFIXES = {"win32": ".dll", "darwin": ".dylib"}
"""Ending of a library by system; `.so` on others."""


@cache
def digest_sources() -> str:
    """Return a digest of the definitions that kernels come from; it is kept beside the library until a file of the package changes."""
    note, stamp = LIBRARY_FOLDER / "sources.json", _stamp_files()
    kept = _read_json(note) or {}
    if kept.get("stamp") == stamp:
        return str(kept["digest"])
    from governor_mechanism.numerics.kernel_sources import KernelSources, read_texts

    digest = KernelSources(read_texts(PACKAGE_ROOT)).digest()
    with suppress(OSError):  # there is no folder before the first build, and it may be one that cannot be written
        temporary = note.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps({"stamp": stamp, "digest": digest}), encoding="utf-8")
        os.replace(temporary, note)
    return digest


def _stamp_files() -> str:
    """Return a text that changes when a file of the package does."""
    import hashlib  # not before: a wheel needs no digest

    stamps = []
    waiting = [str(PACKAGE_ROOT)]
    while waiting:
        for entry in os.scandir(waiting.pop()):
            if entry.name.endswith(".py"):
                status = entry.stat()
                stamps.append((entry.path, status.st_size, status.st_mtime_ns, status.st_ctime_ns))
            elif entry.is_dir() and not entry.name.startswith("_"):
                waiting.append(entry.path)
    return hashlib.sha256(repr(sorted(stamps)).encode()).hexdigest()


def platform_name() -> str:
    """Return the name of this platform: system and processor."""
    machine = os.uname().machine if hasattr(os, "uname") else os.environ.get("PROCESSOR_ARCHITECTURE", "unknown")
    return f"{sys.platform}-{machine.lower()}"


def read_index(folder: Path | None = None) -> dict[str, Any] | None:
    """Return the index of the library in a folder, or of this package; None if there is none."""
    return _read_json((folder or LIBRARY_FOLDER) / "index.json")


def _read_json(path: Path) -> dict[str, Any] | None:
    """Return the table in a file; None if there is none."""
    try:
        table: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return table


def find_obstacle(index: Mapping[str, Any], wanted_platform: str) -> str:
    """Return why a library cannot be used on a platform for the present kernels; empty if it can."""
    if index.get("platform") != wanted_platform:
        return f"it is for {index.get('platform')}"
    if "sources" in index and index["sources"] != digest_sources():  # a wheel has no digest: nobody changes its sources
        return "its kernels were changed since"
    return ""


@dataclass(frozen=True)
class _Library:
    """The library, if it can be used."""

    obstacle: str = ""  # why it cannot be used; empty if it can
    code: Any = None  # the loaded file
    kernels: Mapping[str, Any] = field(default_factory=dict)  # what the index says of each kernel, by module and name


@cache
def _open_library() -> _Library:
    """Load the library."""
    if sysconfig.get_config_var("Py_GIL_DISABLED"):
        return _Library("it needs a Python with a global lock")
    index = read_index()
    if index is None:
        return _Library("there is none")
    if obstacle := find_obstacle(index, platform_name()):
        return _Library(obstacle)
    try:
        code = ctypes.PyDLL(str(LIBRARY_FOLDER / index["library"]))
        code.make_caller.restype = ctypes.py_object
        text = ctypes.c_char_p
        address = ctypes.c_void_p
        objects = ctypes.py_object
        code.make_caller.argtypes = [text, address, text, text, ctypes.c_int, objects, objects, objects]
        return _Library(code=code, kernels=index["kernels"])
    except (OSError, AttributeError, KeyError) as error:
        return _Library(f"it is damaged: {error}")


def library_obstacle() -> str:
    """Return why the library is not used; empty if it is."""
    return _open_library().obstacle


def find_kernel(function: Callable[..., Any], fallback: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return what calls a kernel of the library, or `fallback` for arguments of other types; None if it is not in it."""
    import numpy as np

    library = _open_library()
    name = f"{function.__module__}:{function.__qualname__}"  # a function inside another one is never in the library
    if name not in library.kernels:
        return None
    kernel = library.kernels[name]
    entry = ctypes.cast(getattr(library.code, kernel["entry"]), ctypes.c_void_p)
    classes = tuple(map(_find_class, kernel["classes"]))
    arguments, result = kernel["arguments"].encode(), kernel["result"].encode()
    caller: Callable[..., Any] = library.code.make_caller(
        name.encode(), entry, arguments, result, kernel["slots"], classes, fallback, np.ndarray
    )
    return caller


def count_live_blocks() -> int:
    """Return the number of blocks of memory that kernels of the library hold: 0 between calls."""
    code = _open_library().code
    return ctypes.c_int64.in_dll(code, "n_live_blocks").value if code else 0


def _find_class(name: str) -> type:
    module, _, qualified_name = name.partition(":")
    found: Any = import_module(module)
    for part in qualified_name.split("."):
        found = getattr(found, part)
    return found  # type: ignore[no-any-return]
