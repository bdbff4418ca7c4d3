"""Scenes written and changed in Python: the same documents, checks and messages as those of scene files."""

from collections.abc import Mapping
from typing import Any

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with, remove_document_key
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.scenes.toml_text import format_scene_toml
from governor_mechanism.units.quantities import format_value


def check_start(scene: Scene) -> Scene:
    """Return a scene whose mechanism can be assembled at its start, or raise MechanismError: a wrong start is a mistake of the scene."""
    try:
        initial_state(scene)
    except MechanismError as error:
        prefix = f"{scene.source}: " if scene.source else ""
        raise MechanismError(*(f"{prefix}{problem}" for problem in error.problems)) from None
    return scene


def make_scene(document: Mapping[str, Any]) -> Scene:
    """Return the scene of a document, checked like a file; see `Scene.from_dict`."""
    return check_start(parse_scene_document(document))


def replace_values(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return a copy of a scene with other values at dotted keys; see `Scene.replace`."""
    if not isinstance(values, Mapping) or not all(isinstance(key, str) and key for key in values):
        raise MechanismError(f'replace takes values by key, as {{"dimensions.arm": "320 mm"}}; found {format_value(values)}')
    document = document_of(scene, "replace")
    for key in [key for key, value in values.items() if value is None]:
        document = remove_document_key(document, key)
    return check_start(parse_scene_with(document, [(key, value) for key, value in values.items() if value is not None]))


def scene_to_toml(scene: Scene) -> str:
    """Return the text of the scene file of a scene; see `Scene.to_toml`."""
    return format_scene_toml(document_of(scene, "to_toml"))


def document_of(scene: Scene, user: str) -> Mapping[str, Any]:
    """Return the document of a scene; raise MechanismError if it describes another one. `user` is the method that needs it."""
    cure = "use Scene.from_dict, load or replace"
    if not scene.document:
        raise MechanismError(f"{user} needs the document of the scene, and this scene was composed of objects; {cure}")
    if parse_scene_document(scene.document) != scene:
        raise MechanismError(f"{user} needs the document of the scene, and this scene was changed without it, as by with_changes; {cure}")
    return scene.document
