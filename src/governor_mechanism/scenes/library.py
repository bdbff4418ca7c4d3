"""Access to scenes: a path, or the name of a shipped scene."""

import os
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.part import FAMILIES
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.kernel_library import PACKAGE_ROOT
from governor_mechanism.scenes.parser import read_scene_file, suggest_name
from governor_mechanism.units.quantities import format_value

SceneSource = Scene | str | Path
"""A scene, the path of a file, or the name of a shipped scene."""

CATALOGUE_FOLDER = "catalogue"
"""Folder of the scenes of classic mechanisms beside the shipped scenes."""

MAX_KEPT_SCENES = 64
"""Number of shipped scenes that are kept once they are read."""


def models_folder() -> Path:
    """Return the folder of the shipped scenes: in an installed package, or next to `src` in a checkout."""
    for folder in (PACKAGE_ROOT / "models", PACKAGE_ROOT.parents[1] / "models"):
        if folder.is_dir():
            return folder
    raise MechanismError(f"the shipped scenes are missing from {PACKAGE_ROOT}; install governor-mechanism again")


def shipped_scenes() -> dict[str, Path]:
    """Return the paths of the shipped scenes by name, sorted."""
    return {path.stem: path for path in sorted(models_folder().glob("*.toml"))}


def catalogue_scenes() -> dict[str, Path]:
    """Return the paths of the scenes of classic mechanisms by name, sorted."""
    return {path.stem: path for path in sorted((models_folder() / CATALOGUE_FOLDER).glob("*.toml"))}


@dataclass(frozen=True, kw_only=True)
class CatalogueEntry:
    """What the file of a classic mechanism says at a glance."""

    title: str  # title of the scene
    family: str  # family of the mechanism
    law: str  # the law that it proves, in words
    source: str  # where mechanism, dimensions and law are from
    dimensions: Mapping[str, Any]  # dimensions as the file writes them


def list_catalogue_entries(family: str | None = None) -> dict[str, CatalogueEntry]:
    """Return what the files of the classic mechanisms say at a glance, by name, family after family; of one family if it is given."""
    if family is not None and family not in FAMILIES:
        raise MechanismError(f"there is no family {family!r}; families are {', '.join(FAMILIES)}.{did_you_mean(family, FAMILIES)}")
    entries = {}
    for name, path in catalogue_scenes().items():
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        law = document["law"]
        title, dimensions = document["title"], document["dimensions"]
        entries[name] = CatalogueEntry(title=title, family=law["family"], law=law["statement"], source=law["source"], dimensions=dimensions)
    chosen = [name for one in FAMILIES for name, entry in entries.items() if entry.family == one and family in (None, one)]
    return {name: entries[name] for name in chosen}


def read_scene_title(path: Path) -> str:
    """Return the title of a scene file without parsing the rest, or the stem of the path without one."""
    return str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", path.stem))


SCENE_FAMILIES: Final = ("governors", "governed engines", "engines", "valve gears", "linkages")
"""Families of the shipped scenes, in the order of their list."""

_FAMILIES_OF_MACHINES: Final = {"flywheel_engine": "engines", "slide_valve": "valve gears", "stephenson": "valve gears"}
"""Families of machines that are neither governors nor linkages."""


@dataclass(frozen=True, kw_only=True)
class SceneContents:
    """What a scene file says at a glance."""

    title: str  # title, or the stem of the path without one
    machines: tuple[str, ...]  # names of the machines of its parts, each once
    dimensions: Mapping[str, Any]  # dimensions as the file writes them; with several parts, as "part.arm"
    effects: tuple[str, ...]  # keys of the effects that are switched on; with several parts, as "part.gravity"
    family: str  # one of SCENE_FAMILIES


def read_scene_contents(path: Path) -> SceneContents:
    """Return what a scene file says at a glance, without checking it."""
    document: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    parts = {f"{name}.": part for name, part in document["part"].items()} if "part" in document else {"": document}
    effects = {f"{prefix}{key}": value for prefix, part in parts.items() for key, value in part.get("effects", {}).items()}
    return SceneContents(
        title=str(document.get("title", path.stem)),
        machines=tuple(dict.fromkeys(part.get("machine", "") for part in parts.values())),
        dimensions={f"{prefix}{name}": value for prefix, part in parts.items() for name, value in part.get("dimensions", {}).items()},
        effects=tuple(key for key, value in effects.items() if value is not False),
        family=_find_family(list(parts.values())),
    )


def _find_family(parts: Sequence[Mapping[str, Any]]) -> str:
    """Return the family of a scene: what turns with a spindle is a governor, which governs what else there is."""
    governors = [one for one in parts if one.get("effects", {}).get("centrifugal")]
    if governors:
        return "governors" if len(governors) == len(parts) else "governed engines"
    families = [_FAMILIES_OF_MACHINES.get(one.get("machine", ""), "valve gears" if "valve" in one else "linkages") for one in parts]
    return next((family for family in families if family != "linkages"), "linkages")


def list_contents() -> dict[str, SceneContents]:
    """Return what the shipped scenes say at a glance, by name (sorted)."""
    return {name: read_scene_contents(path) for name, path in shipped_scenes().items()}


@lru_cache(maxsize=MAX_KEPT_SCENES)
def _read_once(path: Path, modified: int, size: int) -> Scene:
    """Return the scene of a file, which is read again only if it has changed; with the scene stays what is known of it."""
    return read_scene_file(path)


def load_scene(
    scene: str | Path,  # a path, or the name of a shipped scene. Text with a dot or a separator is a path
) -> Scene:
    """Return the scene of a file or the shipped scene of a name."""
    if not isinstance(scene, str | Path):
        raise MechanismError(f"a scene is a path or the name of a shipped scene, or what load returns; found {format_value(scene)}")
    if isinstance(scene, Path) or any(mark in scene for mark in (".", "/", os.sep)):
        return read_scene_file(scene, known_names=[*shipped_scenes(), *catalogue_scenes()])
    for path in (folder / f"{scene}.toml" for folder in (models_folder(), models_folder() / CATALOGUE_FOLDER)):
        state = None
        with suppress(OSError, ValueError):  # ValueError: a null character in the name
            state = path.stat()
        if state:
            return _read_once(path, state.st_mtime_ns, state.st_size)
    known = shipped_scenes()
    hint = suggest_name(scene, {name: name for name in (*known, *catalogue_scenes())})
    if os.path.isfile(scene):
        hint = f" To read the file of that name in this folder write {'./' + scene!r}."
    list_text = (
        f"{len(known)} scenes are shipped, such as porter and watt; `governor-mechanism models` or gm.list_models() lists them, and "
    )
    list_text += "`governor-mechanism catalogue` or gm.list_catalogue() the classic mechanisms"
    path_text = "A path has a suffix or a separator, as in my_scene.toml or ./my_scene"
    raise MechanismError(f"no scene {format_value(scene)}.{hint} {list_text}. {path_text}.")
