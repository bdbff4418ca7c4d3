"""Writing files: a file that is replaced when it is complete, several or none, and values as JSON and CSV know them."""

import csv
import json
import math
import os
import secrets
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from governor_mechanism.errors import MechanismError
from governor_mechanism.units.problems import PATH, check_arguments

_Unfinished = dict[Path, Path]
_UNFINISHED: ContextVar[_Unfinished | None] = ContextVar("unfinished", default=None)
"""Final names of temporary files, by their names, within `write_all_or_none`."""


@contextmanager
def write_all_or_none() -> Iterator[_Unfinished]:
    """Provide final names by temporary ones, and rename the files of `atomic_write` to them at the end, only if all are complete."""
    # On any exception, also on Ctrl-C, all temporary files are removed, and what has their final names
    # stays as it was.
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
    """Provide a temporary name beside a file and rename it at the end; MechanismError if there is no folder or it cannot be written."""
    # On any exception, also on Ctrl-C, the temporary file is removed and `path` stays as it was.
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


def plain_value(
    value: object,  # a number, text, path, array or dataclass, or a mapping or sequence of these
) -> Any:
    """Return a value in the types of JSON: mappings and dataclasses as dicts, sequences as lists, complex numbers as pairs."""
    if hasattr(value, "tolist"):  # an array, or a number of NumPy
        value = value.tolist()
    if isinstance(value, complex):
        value = (value.real, value.imag)
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {key: plain_value(one) for key, one in value.items()}
    if is_dataclass(value):
        return {field.name: plain_value(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [plain_value(one) for one in value]
    return value


def finite_or_none(value: float) -> float | None:
    """Return a number that may be infinite or missing (NaN), which JSON lacks, with None in its place."""
    return value if math.isfinite(value) else None


def number_or_text(value: float) -> float | str:
    """Return a number, or the text "inf" or "nan" that `float` reads in place of one that JSON lacks."""
    return value if math.isfinite(value) else str(float(value))


def save_text(text: str, path: Path) -> Path:
    """Write a text file."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


@check_arguments(path=PATH)
def save_scene_text(text: str, path: str | os.PathLike[str]) -> Path:
    """Write the text of a scene file; raise MechanismError unless its name ends in .toml."""
    target = Path(path)
    if target.suffix != ".toml":
        raise MechanismError(f"the name of a scene file ends in .toml, as my_scene.toml; found {str(path)!r}")
    return save_text(text, target)


def save_json(value: object, path: Path) -> Path:
    """Write a value as a JSON file."""
    return save_text(format_json(value) + "\n", path)


def save_table(
    header: Sequence[str],
    rows: Iterable[Iterable[object]],
    path: Path,
    *,
    comment: str = "",  # text of a first line that begins with "# "; none if empty
) -> Path:
    """Write a table as a CSV file; numbers have the digits that give the same float, and None is an empty cell."""
    with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
        if comment:
            stream.write(f"# {comment}\n")
        csv.writer(stream).writerows([header, *rows])
    return path


def format_json(value: object) -> str:
    """Return a value as indented JSON text; raise ValueError for a number that is not finite."""
    return json.dumps(plain_value(value), indent=2, allow_nan=False)
