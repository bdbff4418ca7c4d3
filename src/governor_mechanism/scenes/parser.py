"""Parser of scene files: text, TOML document, scene. All mistakes of a file are found before any is reported, each in one sentence."""

import difflib
import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, mistake
from governor_mechanism.units.quantities import format_value

_unreadable = partial(mistake, ProblemCode.UNREADABLE)

_LONG_KEY = re.compile(r"""(?<![\w"'-])(?:[\w"'-]++\s*\.\s*){100}""")  # tomllib takes minutes for thousands of dots

MAX_UNKNOWN_KEYS = 10
"""Number of unknown keys of a table that have a sentence each."""

MAX_SCENE_FILE_SIZE = 1_000_000
"""Largest scene file, bytes; a scene is a page of text, and a larger file is not a scene."""


def read_scene_file(
    path: str | Path,
    *,
    known_names: Iterable[str] = (),  # names of scenes to suggest if there is no such file
) -> Scene:
    """Return the scene of a TOML file; raise MechanismError with a sentence for each mistake in the file, or why it cannot be read."""
    source = str(path)
    with _named(source):
        document = _read_document(Path(path), known_names)
    return parse_scene_document(document, source)


def parse_scene_document(
    document: Mapping[str, Any],  # keys and tables; numbers without a unit are SI
    source: str = "",  # start of every message, usually the path of the file
) -> Scene:
    """Return the scene of a document as read from TOML; raise MechanismError with all mistakes as `problems`."""
    with _named(source):
        if not isinstance(document, Mapping):
            raise mistake(ProblemCode.WRONG_TYPE, f"a scene is a table of keys; found {format_value(document)}")
        # imported late: what only lists scenes starts without numpy
        from governor_mechanism.scenes.document import parse_document

        return parse_document(document, source)


@contextmanager
def _named(source: str) -> Iterator[None]:
    """Put the source, if there is one, before the problems of an error."""
    try:
        yield
    except MechanismError as error:
        start = f"{source}: " if source else ""
        problems = _sum_up([*map(Problem, error.problems)])
        raise MechanismError(*(Problem(f"{start}{text}", text.code, text.key.replace(KEY, "")) for text in problems)) from error


def _sum_up(problems: list[Problem]) -> list[Problem]:
    """Return the problems with one sentence in the place of the unknown keys of a table beyond the first few."""
    summed: list[Problem] = []
    tables = [one.key.rpartition(".")[0] if one.code is ProblemCode.UNKNOWN_KEY else None for one in problems]
    counts = Counter(tables)
    for number, (problem, table) in enumerate(zip(problems, tables, strict=True)):
        n_before = 0 if table is None else tables[:number].count(table)
        if n_before < MAX_UNKNOWN_KEYS:
            summed.append(problem)
        elif n_before == MAX_UNKNOWN_KEYS:
            where = f" in {table}" if table else ""
            text = f"{counts[table] - n_before} more keys{where} are unknown"
            summed.append(Problem(text, ProblemCode.UNKNOWN_KEY, problem.key))
    return summed


def _read_document(path: Path, known_names: Iterable[str]) -> dict[str, Any]:
    """Return the TOML document of a file; raise MechanismError if it cannot be read."""
    text = _read_text(path, known_names)
    if _LONG_KEY.search(text):
        raise _unreadable("a key has 100 dots or more; the tables of a scene are a few levels deep")
    try:
        document = tomllib.loads(text)
    except RecursionError as error:
        raise _unreadable("tables or lists are nested too deeply for a scene") from error
    except ValueError as error:  # also raised by Python for an integer of thousands of digits
        raise _unreadable(f'not valid TOML: {error}; text and quantities need quotes, as in arm = "300 mm"') from error
    if not document:
        raise _unreadable("the file is empty; a scene needs at least machine = ... and a table [dimensions]")
    return document


def _read_text(path: Path, known_names: Iterable[str]) -> str:
    try:
        if path.is_dir():
            scenes = ", ".join(sorted(file.name for file in path.glob("*.toml")))
            raise _unreadable(f"this is a folder, not a scene file; it holds {scenes or 'no .toml files'}")
        if path.exists() and not path.is_file():
            raise _unreadable("this is not a file on disk but a pipe or a device; save the scene in a file")
        with path.open("rb") as stream:
            content = stream.read(MAX_SCENE_FILE_SIZE + 1)
    except MechanismError:
        raise
    except FileNotFoundError as error:
        raise _unreadable(_missing_file_message(path, known_names)) from error
    except PermissionError as error:
        raise _unreadable("no permission to read this file; change its rights or copy it") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise _unreadable(f"this file cannot be read ({reason})") from error
    if len(content) > MAX_SCENE_FILE_SIZE:
        raise _unreadable(f"this file is larger than {MAX_SCENE_FILE_SIZE:,} bytes; a scene is a page of text")
    try:
        return content.decode("utf-8-sig")  # some editors on Windows write a byte order mark
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise _unreadable(f"line {line} is not UTF-8 text; save the file as UTF-8") from error


def suggest_name(word: str, names: Mapping[str, str]) -> str:
    """Return a hint at what stands for the name nearest to a misspelt word, in either case; "" if none is near enough."""
    known = {name.lower(): known for name, known in names.items()}
    close_matches = difflib.get_close_matches(word.lower(), list(known), n=1, cutoff=0.75)
    return f" Did you mean {known[close_matches[0]]!r}?" if close_matches else ""


def _missing_file_message(path: Path, known_names: Iterable[str]) -> str:
    """Return the message about a missing file, with the nearest name among its neighbours and the known names."""
    candidates = {name: name for name in known_names} | {neighbour.stem: str(neighbour) for neighbour in path.parent.glob("*.toml")}
    folder_text = "" if path.parent.is_dir() else f" (there is no folder {str(path.parent)!r} either)"
    changes_text = " On the command line a value is changed by --set KEY=VALUE." if "=" in path.name else ""
    suggestion = suggest_name(path.stem, candidates) or f" `governor-mechanism init MACHINE > {path}` begins one."
    return f"no such file{folder_text}.{suggestion}{changes_text}"
