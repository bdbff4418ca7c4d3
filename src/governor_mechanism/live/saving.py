"""What was made, as files: the scene as one would write it by hand, with the comments of the opened file; films, figures, tables."""

import tempfile
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import atomic_write
from governor_mechanism.live.quantities import find_quantities
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.scenes.changed_document import find_item, format_scene_toml
from governor_mechanism.scenes.library import models_folder
from governor_mechanism.units.quantities import format_value

SCENE_ENDING: Final = ".toml"
"""End of the name of a scene file."""

FORBIDDEN_LETTERS: Final = '/\\:\0<>|"?*'
"""Letters that lead out of a folder, or that names of files do not have on every system."""


class SceneFile:
    """The file, if any, that a scene was opened from: it is written only if nobody else has changed it, or if that is confirmed."""

    def __init__(self, source: str) -> None:
        path = Path(source) if source else None
        self.opened_text = _read_text(path) if path else None
        is_own = path is not None and self.opened_text is not None and not _is_shipped(path)
        self.folder = path.resolve().parent if path and is_own else Path.cwd()
        self.name = path.name if path and is_own else f"{Path(source).stem or 'scene'}{SCENE_ENDING}"
        self._known_text = self.opened_text if is_own else None

    def save(self, name: str, document: Mapping[str, Any], *, overwrites: bool) -> tuple[str, str]:
        """Write a document as a scene file beside the opened one; return what was written, or a question whether to overwrite it."""
        # Raises MechanismError if the name is no name of a scene file, or the file cannot be
        # written.
        path = self.folder / _check_name(name)
        if path.is_symlink():
            raise MechanismError(f"{path} is a link to another place; choose another name")
        found = _read_text(path)
        is_known = name == self.name and found is not None and found == self._known_text
        if path.exists() and not is_known and not overwrites:
            changed = "has changed on disk since it was read" if name == self.name and self._known_text is not None else "is already there"
            return "", f"{path} {changed}."
        text = write_scene(self.opened_text, document)
        try:
            with atomic_write(path) as temporary:
                temporary.write_text(text, encoding="utf-8")
        except OSError as error:
            raise MechanismError(f"cannot write {path}: {error.strerror or error}") from None
        self.name, self._known_text = name, text
        return f"Saved as {path}.", ""


def _check_name(name: str) -> str:
    """Return the name of a scene file; raise MechanismError for anything else, as a path."""
    has_forbidden = any(letter in FORBIDDEN_LETTERS or not letter.isprintable() for letter in name)
    if has_forbidden or name.startswith(".") or not name.endswith(SCENE_ENDING):
        raise MechanismError(f'the name of a scene file ends in {SCENE_ENDING} and is no path, as "mine.toml"; found {format_value(name)}')
    return name


def _is_shipped(path: Path) -> bool:
    """Return whether a file is one of those that come with the package."""
    return models_folder().resolve() in path.resolve().parents


def _read_text(path: Path) -> str | None:
    """Return the text of a file; None without one."""
    with suppress(OSError, ValueError):
        return path.read_text(encoding="utf-8")
    return None


def write_scene(
    text: str | None,  # the text of the opened file; None without one
    document: Mapping[str, Any],
) -> str:
    """Return the text of the opened file with the changed values alone changed, or a text without comments where that is not possible."""
    with suppress(ValueError, ImportError):  # tomlkit may be missing in a notebook
        changed = _change_text(text or "", document)
        if tomllib.loads(changed) == document:
            return changed
    return format_scene_toml(document)


def _change_text(text: str, document: Mapping[str, Any]) -> str:
    """Return a text of TOML with the quantities of a document."""
    import tomlkit  # with the extra

    written = tomlkit.parse(text)
    before = find_quantities(written.unwrap(), 1.0)
    for key, quantity in find_quantities(document, 1.0).items():
        if key in before and quantity.value != before[key].value:
            owner: Any = written
            *tables, last = key.split(".")
            for name in tables:
                owner = owner[_place_in(owner, name)]
            owner[_place_in(owner, last)] = quantity.write(quantity.value)
    return tomlkit.dumps(written)


def _place_in(owner: Any, name: str) -> str | int:
    """Return the key of a table, or the index in a list."""
    return name if isinstance(owner, Mapping) else find_item(owner, name, "")


def export_run(run: Trajectory, ending: str, theme: str) -> bytes:
    """Return a run as a film, a page, a table of its readings, or their figure."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"saved.{ending}"
        if ending == "csv":
            run.save_csv(path)
        elif ending in ("svg", "png"):
            run.plot().save(path, theme)
        else:
            run.film(path)
        return path.read_bytes()
