"""The scenes that come with the package, and the one door to any scene: a path or a name."""

from __future__ import annotations

import os
import tomllib
from importlib import resources
from pathlib import Path

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.reading import read
from governor_mechanism.scene import Scene
from governor_mechanism.units import shown


def models_folder() -> Path:
    """The folder of the shipped scenes: inside an installed package, or beside `src` in a checkout."""
    package = Path(str(resources.files("governor_mechanism")))
    for folder in (package / "models", package.parents[1] / "models"):
        if folder.is_dir():
            return folder
    raise MechanismError(f"the shipped scenes are missing from {package}; install governor-mechanism again")


def shipped() -> dict[str, Path]:
    """The shipped scenes by name, sorted."""
    return {path.stem: path for path in sorted(models_folder().glob("*.toml"))}


def title_of(path: Path) -> str:
    """The title a scene file gives itself, without reading the rest of it; its stem where it has none."""
    return str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", path.stem))


def load(scene: str | Path) -> Scene:
    """The scene of a file, or the shipped scene of that name.

    Anything that is a file, ends in .toml or holds a separator is a path. Raises MechanismError as `reading.read`
    does, and for an unknown name.
    """
    if not isinstance(scene, str | Path):
        raise MechanismError(f"a scene is a path or a name; found {shown(scene)}")
    if isinstance(scene, Path) or _is_path(scene):
        return read(scene, others=shipped())
    known = shipped()
    if scene in known:
        return read(known[scene])
    raise MechanismError(
        f"no scene {shown(scene)}; shipped scenes are {', '.join(known)}, "
        f"and a path ends in .toml.{did_you_mean(scene, known)}"
    )


def _is_path(scene: str) -> bool:
    separators = {"/", os.sep, os.altsep or os.sep}
    return scene.endswith(".toml") or any(mark in scene for mark in separators) or os.path.isfile(scene)
