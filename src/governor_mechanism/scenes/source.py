"""The text of a scene file, or a sentence that says why there is none."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

from governor_mechanism.errors import MechanismError

LARGEST_FILE = 1_000_000
"""Bytes. A scene is a page of text; more is another kind of file."""


def text_of(path: Path, source: str, others: Iterable[str]) -> str:
    """The text of the file, or a MechanismError that says why there is none."""
    try:
        if path.is_dir():
            raise MechanismError(_folder(path, source))
        with path.open("rb") as stream:
            content = stream.read(LARGEST_FILE + 1)
    except MechanismError:
        raise
    except FileNotFoundError as error:
        raise MechanismError(_missing(path, source, others)) from error
    except PermissionError as error:
        raise MechanismError(f"{source}: no permission to read this file; change its rights or copy it") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise MechanismError(f"{source}: this file cannot be read ({reason})") from error
    if len(content) > LARGEST_FILE:
        raise MechanismError(f"{source}: this file is larger than {LARGEST_FILE:,} bytes; a scene is a page of text")
    try:
        return content.decode("utf-8-sig")  # some editors of Windows put a mark in front
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise MechanismError(f"{source}: line {line} is not UTF-8 text; save the file as UTF-8") from error


def nearest_name(word: str, names: Iterable[str]) -> str:
    """The scene name that `word` is a slip of, capitals aside; '' where none is near enough to be meant."""
    lowered = {name.lower(): name for name in names}
    near = difflib.get_close_matches(word.lower(), list(lowered), n=1, cutoff=0.75)
    return lowered[near[0]] if near else ""


def _folder(path: Path, source: str) -> str:
    scenes = sorted(file.name for file in path.glob("*.toml"))
    holds = f"it holds {', '.join(scenes)}" if scenes else "it holds no .toml files"
    return f"{source}: this is a folder, not a scene file; {holds}"


def _missing(path: Path, source: str, others: Iterable[str]) -> str:
    """The sentence about a file that is not there, with the nearest name among its neighbours and the others."""
    known = {name: name for name in others}
    known |= {neighbour.stem: str(neighbour) for neighbour in path.parent.glob("*.toml")}
    near = nearest_name(path.stem, known)
    folder = "" if path.parent.is_dir() else f" (there is no folder {str(path.parent)!r} either)"
    return f"{source}: no such file{folder}." + (f" Did you mean {known[near]!r}?" if near else "")
