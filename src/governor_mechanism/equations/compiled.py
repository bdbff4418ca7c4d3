"""How the kernels are compiled: once, by numba, kept on disk for later processes."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """The function compiled on its first call, without fast-math, and kept in a cache that can be written."""
    from numba import njit

    return cast(Function, njit(cache=True)(function))


def _find_cache() -> None:
    """Point numba to a temporary folder where neither the package's nor the user's own can be written."""
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    beside = Path(__file__).parent / "__pycache__"
    if _writable(beside) or _writable(Path.home() / ".cache" / "numba"):
        return
    os.environ["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / f"governor-mechanism-{os.getuid()}")


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


_find_cache()
