"""Atomic writing: a temporary file is renamed to the final name, so an interrupted run leaves no partial file."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from governor_mechanism.errors import MechanismError


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Provide a temporary file name and rename the file to its final name at the end.

    On any exception, also on Ctrl-C, the temporary file is removed and `path` stays as it was.

    Parameters
    ----------
    path
        Final name.

    Yields
    ------
    Path
        Temporary name in the same folder with the same suffix.

    Raises
    ------
    MechanismError
        If the folder does not exist.
    """
    if not path.parent.is_dir():
        raise MechanismError(f"cannot write {path}: the folder {path.parent} does not exist; create it first")
    temporary = path.with_name(f".{path.stem}.{os.getpid()}-{secrets.token_hex(4)}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
