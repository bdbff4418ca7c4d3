"""The text of a scene file, or a sentence that says why there is none."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

from governor_mechanism.errors import MechanismError

MAX_SCENE_FILE_SIZE = 1_000_000
"""Bytes. A scene is a page of text; more is another kind of file."""


def read_scene_text(path: Path, source: str, known_names: Iterable[str]) -> str:
    """The text of the file, or a MechanismError that says why there is none."""
    try:
        if path.is_dir():
            raise MechanismError(_folder_message(path, source))
        with path.open("rb") as stream:
            content = stream.read(MAX_SCENE_FILE_SIZE + 1)
    except MechanismError:
        raise
    except FileNotFoundError as error:
        raise MechanismError(_missing_file_message(path, source, known_names)) from error
    except PermissionError as error:
        raise MechanismError(f"{source}: no permission to read this file; change its rights or copy it") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise MechanismError(f"{source}: this file cannot be read ({reason})") from error
    if len(content) > MAX_SCENE_FILE_SIZE:
        raise MechanismError(f"{source}: this file is larger than {MAX_SCENE_FILE_SIZE:,} bytes; a scene is a page of text")
    try:
        return content.decode("utf-8-sig")  # some editors of Windows put a mark in front
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise MechanismError(f"{source}: line {line} is not UTF-8 text; save the file as UTF-8") from error


def find_nearest_name(word: str, names: Iterable[str]) -> str:
    """The scene name that `word` is a slip of, capitals aside; '' where none is near enough to be meant."""
    names_by_lower_case = {name.lower(): name for name in names}
    close_matches = difflib.get_close_matches(word.lower(), list(names_by_lower_case), n=1, cutoff=0.75)
    return names_by_lower_case[close_matches[0]] if close_matches else ""


def _folder_message(path: Path, source: str) -> str:
    scenes = sorted(file.name for file in path.glob("*.toml"))
    content_text = f"it holds {', '.join(scenes)}" if scenes else "it holds no .toml files"
    return f"{source}: this is a folder, not a scene file; {content_text}"


def _missing_file_message(path: Path, source: str, known_names: Iterable[str]) -> str:
    """The sentence about a file that is not there, with the nearest name among its neighbours and the others."""
    candidates = {name: name for name in known_names}
    candidates |= {neighbour.stem: str(neighbour) for neighbour in path.parent.glob("*.toml")}
    nearest = find_nearest_name(path.stem, candidates)
    folder_text = "" if path.parent.is_dir() else f" (there is no folder {str(path.parent)!r} either)"
    return f"{source}: no such file{folder_text}." + (f" Did you mean {candidates[nearest]!r}?" if nearest else "")
