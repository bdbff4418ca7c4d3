"""Atomic writing: a temporary file is renamed to the final name, so an interrupted run leaves no partial file."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from pathlib import Path

from governor_mechanism.errors import MechanismError

_Unfinished = dict[Path, Path]
_UNFINISHED: ContextVar[_Unfinished | None] = ContextVar("unfinished", default=None)
"""Final names of temporary files, by their names, within `write_all_or_none`."""


@contextmanager
def write_all_or_none() -> Iterator[_Unfinished]:
    """Rename all files that `atomic_write` provides within the context to their final names at its end, and only if all are complete.

    On any exception, also on Ctrl-C, all temporary files are removed, and what has their final names stays as it was.

    Result: final names by temporary names.
    """
    unfinished: _Unfinished = {}
    token = _UNFINISHED.set(unfinished)
    try:
        yield unfinished
        for temporary, path in unfinished.items():
            os.replace(temporary, path)
    finally:
        _UNFINISHED.reset(token)
        for temporary in unfinished:
            temporary.unlink(missing_ok=True)


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Provide a temporary file name and rename the file to its final name at the end.

    On any exception, also on Ctrl-C, the temporary file is removed and `path` stays as it was.

    Result: temporary name in the same folder with the same suffix. Raises MechanismError if the folder does
    not exist, or the file cannot be written, as on a full disk.
    """
    if not path.parent.is_dir():
        raise MechanismError(f"cannot write {path}: the folder {path.parent} does not exist; create it first")
    if path.is_dir():
        raise MechanismError(f"cannot write {path}: a folder has this name; move it")
    temporary = path.with_name(f".{path.stem[:100]}.{os.getpid()}-{secrets.token_hex(4)}{path.suffix}")
    outer = _UNFINISHED.get()
    try:
        with write_all_or_none() if outer is None else nullcontext(outer) as unfinished:
            unfinished[temporary] = path
            yield temporary
    except OSError as error:
        raise MechanismError(f"cannot write {path}: {error.strerror or error}") from error
