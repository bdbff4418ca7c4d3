"""Results are written beside their final name and moved into place, so that an interrupted run leaves no half file."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from governor_mechanism.errors import MechanismError


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Give a temporary name in the folder of `path`, with its ending; rename it to `path` at the end.

    On any exception, Ctrl-C included, the temporary file is removed and `path` stays as it was.
    """
    if not path.parent.is_dir():
        raise MechanismError(f"cannot write {path}: the folder {path.parent} does not exist; create it first")
    temporary = path.with_name(f".{path.stem}.{os.getpid()}-{secrets.token_hex(4)}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
