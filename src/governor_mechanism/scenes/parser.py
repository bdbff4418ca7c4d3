"""Parser of scene files. All mistakes of a file are found before any is reported, each in one sentence."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.problems import Problem, ProblemCode, ProblemCollector, mistake
from governor_mechanism.scenes.source import MAX_SCENE_FILE_SIZE, find_nearest_name, read_scene_text
from governor_mechanism.units.quantities import format_value

__all__ = ["MAX_SCENE_FILE_SIZE", "find_nearest_name", "parse_scene_document", "read_scene_file"]


def read_scene_file(path: str | Path, *, known_names: Iterable[str] = ()) -> Scene:
    """Return the scene of a TOML file.

    Parameters
    ----------
    path
        Path of the file.
    known_names
        Names of scenes to suggest if there is no such file.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    MechanismError
        With a sentence for each mistake in the file, or why it cannot be read.
    """
    source = str(path)
    text = read_scene_text(Path(path), source, known_names)
    try:
        document = tomllib.loads(text)
    except RecursionError as error:
        raise mistake(ProblemCode.UNREADABLE, f"{source}: tables or lists are nested too deeply for a scene") from error
    except ValueError as error:  # also raised by Python for an integer of thousands of digits
        hint = 'text and quantities need quotes, as in arm = "300 mm"'
        raise mistake(ProblemCode.UNREADABLE, f"{source}: not valid TOML: {error}; {hint}") from error
    if not document:
        hint = "a scene needs at least machine = ... and a table [dimensions]"
        raise mistake(ProblemCode.UNREADABLE, f"{source}: the file is empty; {hint}")
    return parse_scene_document(document, source)


def parse_scene_document(document: Mapping[str, Any], source: str = "") -> Scene:
    """Return the scene of a document as read from TOML.

    Parameters
    ----------
    document
        Keys and tables; numbers without a unit are SI.
    source
        Start of every message, usually the path of the file.

    Returns
    -------
    Scene
        The scene, with a copy of the document.

    Raises
    ------
    MechanismError
        With all mistakes as `problems`.
    """
    collector = ProblemCollector()
    scene = None
    if isinstance(document, Mapping):
        from governor_mechanism.scenes.document import DocumentParser  # slow to import: pydantic

        scene = DocumentParser(document, source, collector).parse()
    else:
        collector.add(ProblemCode.WRONG_TYPE, f"a scene is a table of keys; found {format_value(document)}")
    if scene is None:
        messages = collector.problems
        raise MechanismError(*(Problem(f"{source}: {text}", text.code, text.key) for text in messages) if source else messages)
    return scene
