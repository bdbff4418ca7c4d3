"""From which sources the pages that take minutes were made, so that `make docs` makes them again when these change, and only then."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from itertools import chain
from pathlib import Path

DOCS = Path(__file__).parents[1]
PACKAGE = DOCS.parent / "src" / "governor_mechanism"
DRAWING = (
    *(PACKAGE / folder for folder in ("render", "machines", "model")),
    DOCS / "pictures" / "gallery.py",
    DOCS / "questions" / "question_scenes.py",
    DOCS / "extensions" / "generated_pages.py",
)
"""Sources from which drawings follow, besides scenes: folders and files. A run is the same, within its error, however it is solved."""
MADE_FROM = DOCS / "_generated" / "made_from"
"""Digests of the sources from which pages were made, by name."""
EXAMPLES = "examples"
"""Name of the digest from which all examples were made."""


@cache
def digest_drawing() -> str:
    """Return the digest of the sources from which drawings follow."""
    files = chain.from_iterable(sorted(path.rglob("*.*")) if path.is_dir() else [path] for path in DRAWING)
    return digest_files(path for path in files if path.is_file() and path.suffix != ".pyc")


def digest_files(paths: Iterable[Path]) -> str:
    """Return the digest of the contents of files."""
    digest = sha256()
    for path in paths:
        digest.update(sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def is_made_from(name: str, digest: str) -> bool:
    """Return whether what has a name was made from the sources of a digest."""
    path = MADE_FROM / name
    return path.is_file() and path.read_text(encoding="utf-8") == digest


def keep_digest(name: str, digest: str) -> None:
    """Keep the digest of the sources from which what has a name was made."""
    MADE_FROM.mkdir(parents=True, exist_ok=True)
    (MADE_FROM / name).write_text(digest, encoding="utf-8")
