"""The scenes that come with the package, and the one door to any scene: a path or a name."""

from __future__ import annotations

import os
import tomllib
from importlib import resources
from pathlib import Path

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import find_nearest_name, read_scene_file
from governor_mechanism.units.quantities import format_value


def models_folder() -> Path:
    """The folder of the shipped scenes: inside an installed package, or beside `src` in a checkout."""
    package = Path(str(resources.files("governor_mechanism")))
    for folder in (package / "models", package.parents[1] / "models"):
        if folder.is_dir():
            return folder
    raise MechanismError(f"the shipped scenes are missing from {package}; install governor-mechanism again")


def shipped_scenes() -> dict[str, Path]:
    """The shipped scenes by name, sorted."""
    return {path.stem: path for path in sorted(models_folder().glob("*.toml"))}


def read_scene_title(path: Path) -> str:
    """The title a scene file gives itself, without reading the rest of it; its stem where it has none."""
    return str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", path.stem))


def load_scene(scene: str | Path) -> Scene:
    """The scene of a file, or the shipped scene of that name.

    Text with a dot or a separator is a path; a bare word is always a shipped scene's name. Raises MechanismError
    as `reading.read` does, and for an unknown name.
    """
    if not isinstance(scene, str | Path):
        raise MechanismError(f"a scene is a path or a name; found {format_value(scene)}")
    if isinstance(scene, Path) or _is_path(scene):
        return read_scene_file(scene, known_names=shipped_scenes())
    known = shipped_scenes()
    if scene in known:
        return read_scene_file(known[scene])
    nearest = find_nearest_name(scene, known)
    hint = f" Did you mean {nearest!r}?" if nearest else ""
    if os.path.isfile(scene):
        hint = f" To read the file of that name in this folder write {'./' + scene!r}."
    raise MechanismError(
        f"no scene {format_value(scene)}; shipped scenes are {', '.join(known)}, "
        f"and a path has a suffix or a separator, as in my_scene.toml or ./my_scene.{hint}"
    )


def _is_path(scene: str) -> bool:
    return any(mark in scene for mark in (".", "/", os.sep))
