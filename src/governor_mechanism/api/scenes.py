"""Scenes: the shipped ones, those of files, and scenes as arguments of public functions."""

from __future__ import annotations

from pathlib import Path

import governor_mechanism as gm


def list_models() -> dict[str, str]:
    """Return the shipped scenes.

    Returns
    -------
    dict
        Title by name.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> "porter" in gm.list_models()
    True
    """
    from governor_mechanism.scenes.library import read_scene_title, shipped_scenes

    return {name: read_scene_title(path) for name, path in shipped_scenes().items()}


def list_catalogue(family: str | None = None) -> dict[str, str]:
    """Return the classic mechanisms, each of which proves a law.

    Parameters
    ----------
    family
        "straight-lines", "curves", "walkers", "drives" or "valve-gears"; None for all.

    Returns
    -------
    dict
        Title by name; `load` and all functions that take a scene know the names.

    Raises
    ------
    MechanismError
        If there is no such family.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> gm.list_catalogue("walkers")["jansen"]
    "Theo Jansen's leg"
    >>> gm.crosscheck("peaucellier").passed
    True
    """
    from governor_mechanism.scenes.library import list_catalogue_entries

    return {name: entry.title for name, entry in list_catalogue_entries(family).items()}


def load(scene: str | Path) -> gm.Scene:
    """Read a scene and verify that it has a consistent initial state.

    Parameters
    ----------
    scene
        Path of a TOML file, or the name of a shipped scene.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    MechanismError
        If the file has mistakes; one sentence for each.

    Examples
    --------
    >>> import governor_mechanism as gm
    >>> gm.load("porter").run.duration
    10.0
    """
    from governor_mechanism.scenes.changed_document import check_start
    from governor_mechanism.scenes.library import load_scene

    return check_start(load_scene(scene))


def as_scene(scene: gm.SceneSource) -> gm.Scene:
    """Return a scene as it is, and load one that is given by name or path."""
    from governor_mechanism.model.scene import Scene

    return scene if isinstance(scene, Scene) else load(scene)


def as_rotating_part(scene: gm.SceneSource) -> gm.Scene:
    """Return a scene of the part that turns with a spindle, alone."""
    from governor_mechanism.engines.initial_state import rotating_part_alone

    return rotating_part_alone(as_scene(scene))
