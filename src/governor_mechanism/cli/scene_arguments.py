"""The scene of a command, the option `--set` that changes values at its keys, and words that a shell completes.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene

TEMPLATES = (
    "custom",
    "flywheel_engine",
    "governed-engine",
    "hartnell",
    "hartung",
    "parabolic_governor",
    "pendulum_governor",
    "proell",
    "slide_valve",
    "slider_crank",
    "stephenson",
)
"""What `init` writes; a test compares it with the registry of machines, which is slow to import."""


def complete_scene(incomplete: str) -> list[str]:
    """Return the shipped scenes, and the scene files and folders of the file system, that begin with what is typed."""
    from governor_mechanism.scenes.library import catalogue_scenes, shipped_scenes

    names = [name for name in (*shipped_scenes(), *catalogue_scenes()) if name.startswith(incomplete)]
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") else typed.parent
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return names
    paths = [f"{entry}/" if entry.is_dir() else str(entry) for entry in entries if entry.is_dir() or entry.suffix == ".toml"]
    return names + [path for path in paths if path.startswith(incomplete)]


def complete_machine(incomplete: str) -> list[str]:
    """Return machines and classic mechanisms for which there is a scene file to begin with, and whose names begin with what is typed."""
    from governor_mechanism.scenes.library import catalogue_scenes

    return [name for name in (*TEMPLATES, *catalogue_scenes()) if name.startswith(incomplete)]


SceneName = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file (TOML), or the name of a shipped scene.", autocompletion=complete_scene)
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help='Another value of a key of the scene, as "dimensions.arm=320 mm"; nothing after = leaves the key out. Repeatable.',
    ),
]


def load_changed(
    scene: str,
    changes: Sequence[str] | None,  # texts "KEY=VALUE" with dotted keys; an empty value leaves the key out
    **values: Any,
) -> Scene:
    """Load a scene and put other values at some of its keys.

    Further arguments are values at keys that have options of their own, with "__" for the dot, as `run__duration`; None for no change.

    Result: the scene. It keeps the name of its file. Raises MechanismError if a text is no assignment, a key
    is given twice, or the changed scene has mistakes.
    """
    assigned = parse_changes(changes or ())
    assigned |= {name.replace("__", "."): value for name, value in values.items() if value is not None}
    loaded = gm.load(scene)
    return dataclasses.replace(loaded.replace(assigned), source=loaded.source) if assigned else loaded


def parse_changes(
    # texts "KEY=VALUE". A value is written as in a scene file; text needs no quotation marks
    changes: Sequence[str],
) -> dict[str, Any]:
    """Return the values of assignments by dotted key; None for an empty one."""
    from governor_mechanism.errors import MechanismError

    values: dict[str, Any] = {}
    for change in changes:
        key, equals, text = (word.strip() for word in change.partition("="))
        if not equals or not all(key.split(".")):
            raise MechanismError(f'--set {change!r} is not understood; write KEY=VALUE, as in --set "dimensions.arm=320 mm"')
        if key in values:
            raise MechanismError(f"--set {key} is given twice; give it once")
        values[key] = parse_value(text) if text else None
    return values


def parse_value(text: str) -> Any:
    """Return a value as a scene file has it, or the text itself where that is no value of TOML, as 320mm."""
    try:
        document: Mapping[str, Any] = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # text without quotation marks
        return text
    return document["value"] if len(document) == 1 else text


def parse_range(text: str) -> Mapping[str, tuple[float | str, float | str]]:
    """Return both values of a working range "READING=LOW:HIGH" by its reading; raise MechanismError for another text."""
    from governor_mechanism.errors import MechanismError
    from governor_mechanism.units.quantities import number_or_text

    name, equals, values = text.partition("=")
    low, colon, high = values.partition(":")
    if not (equals and colon and name.strip() and low.strip() and high.strip()) or ":" in high:
        raise MechanismError(f'--range {text!r} is not understood; write "READING=LOW:HIGH", as in "sleeve_lift=20 mm:60 mm"')
    return {name.strip(): (number_or_text(low), number_or_text(high))}


def stem_of(scene: Scene) -> str:
    """Return the start of the names of files about a scene."""
    return Path(scene.source).stem or "scene"
