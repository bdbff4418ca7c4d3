"""Parser of scene files. All mistakes of a file are found before any is reported, each in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode
from governor_mechanism.scenes.source import read_document
from governor_mechanism.units.quantities import format_value


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
    try:
        document = read_document(Path(path), known_names)
    except MechanismError as error:
        raise MechanismError(*_with_source(error.problems, source)) from error
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
    if not isinstance(document, Mapping):
        text = f"a scene is a table of keys; found {format_value(document)}"
        raise MechanismError(*_with_source([Problem(text, ProblemCode.WRONG_TYPE)], source))
    from governor_mechanism.scenes.document import DocumentParser  # slow to import: pydantic

    parser = DocumentParser(document, source)
    scene = parser.parse()
    if scene is None:
        raise MechanismError(*_with_source(parser.collector.problems, source))
    return scene


def _with_source(problems: Iterable[str], source: str) -> Iterator[Problem]:
    """Yield the problems with their source, if there is one, at the start."""
    for text in map(Problem, problems):
        yield Problem(f"{source}: {text}" if source else str(text), text.code, text.key.replace(KEY, ""))
